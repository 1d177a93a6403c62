"""Rigid bodies on two axes and two-link chains: what the harness knows of this system."""

from __future__ import annotations

from ...harness.system import System

SYSTEM = System("two_axis_joint", "Rigid bodies on two axes and two-link chains", __name__)
