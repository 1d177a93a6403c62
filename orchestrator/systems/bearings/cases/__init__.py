"""Validation cases of the system, each beside its table; what is listed here is run by `cosimo validate`."""

from __future__ import annotations

from . import (
    clearance,
    defect_frequencies,
    hertz_textbook,
    iso16281,
    lyapunov_sum,
    paper_ball_bearing,
    paper_deep_groove,
    paper_thermal_resistance,
    recurrence,
    stribeck,
    thermal_scaling,
    varying_compliance,
)

CASES = tuple(
    module.CASE
    for module in (
        varying_compliance,
        lyapunov_sum,
        defect_frequencies,
        hertz_textbook,
        iso16281,
        stribeck,
        clearance,
        recurrence,
        thermal_scaling,
        paper_ball_bearing,
        paper_deep_groove,
        paper_thermal_resistance,
    )
)
