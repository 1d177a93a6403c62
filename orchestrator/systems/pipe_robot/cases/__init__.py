"""Validation cases of the system, each beside its table; what is listed here is run by `cosimo validate`."""

from __future__ import annotations

from . import balance, mean_speed, paper_pipe_robots, resonance

CASES = tuple(module.CASE for module in (mean_speed, balance, resonance, paper_pipe_robots))
