"""Two-axis joint, and the motors that drive it."""

from __future__ import annotations

from . import Facts

FACTS: dict[str, Facts] = {}
