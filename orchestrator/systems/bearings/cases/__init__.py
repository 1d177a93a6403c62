"""Validation cases of the system, each beside its table; what is listed here is run by `cosimo validate`."""

from __future__ import annotations

from . import (
    clearance,
    defect_frequencies,
    hertz_textbook,
    lyapunov_sum,
    paper_ball_bearing,
    paper_deep_groove,
    paper_thermal_resistance,
    recurrence,
    statics,
    thermal_scaling,
    varying_compliance,
)

CASES = (
    varying_compliance.CASE,
    lyapunov_sum.CASE,
    defect_frequencies.CASE,
    hertz_textbook.CASE,
    statics.ISO16281,
    statics.STRIBECK,
    clearance.CASE,
    recurrence.CASE,
    thermal_scaling.CASE,
    paper_ball_bearing.CASE,
    paper_deep_groove.CASE,
    paper_thermal_resistance.CASE,
)
