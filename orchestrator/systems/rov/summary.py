"""How well the vehicles of a run keep their set points, what their thrusters do, and how constants drift."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.summary import Summary, SummaryRow, rows
from ...run.key_results import after_transient
from .records import ERRORS, Vehicle, vehicles

if TYPE_CHECKING:
    from ...run.results import Result

TEXTS = {
    "way": ("m", "distance travelled, through the water or over ground, as recorded"),
    "position_error_rms": ("m", "root mean square of the position's error, after the transient"),
    "position_error_max": ("m", "largest error of the position, after the transient"),
    "attitude_error_rms": ("rad", "root mean square of the attitude's error, after the transient"),
    "attitude_error_max": ("rad", "largest error of the attitude, after the transient"),
    "thrust_max": ("N", "largest thrust of any thruster"),
    "limited_share": ("%", "share of the time in which a thruster is at its limit"),
}
HEADLINE = ("position_error_max", "attitude_error_max", "thrust_max", "limited_share", "drift_of_*")  # what a run is judged by
INPUTS = ("set_*", "speed", "direction", "gust.*", "waves.*", "mass", "start_depth")


def summary(result: Result) -> Summary:
    """Of every vehicle whose position was recorded."""
    kept = after_transient(result)
    return tuple(row for v in vehicles(result) for row in (*rows(v.unit, _numbers(v, kept), TEXTS), *_drifts(v)))


def _numbers(v: Vehicle, kept: slice) -> dict[str, float | None]:
    values: dict[str, float | None] = {"way": float(np.linalg.norm(np.diff(v.position, axis=1), axis=0).sum())}
    for name, axes in (("position", ERRORS[:3]), ("attitude", ERRORS[3:])):
        if set(axes) <= v.errors.keys():
            size = np.linalg.norm([v.errors[a][kept] for a in axes], axis=0)
            values |= {f"{name}_error_rms": float(np.sqrt(np.mean(size**2))), f"{name}_error_max": float(size.max())}
    if v.thrusts:
        values["thrust_max"] = max(float(np.abs(F).max()) for F in v.thrusts.values())
    if v.commands:
        limited = np.any([v.at_limit(k) for k in v.commands], axis=0)
        values["limited_share"] = 100.0 * float(np.trapezoid(limited.astype(float), v.time) / (v.time[-1] - v.time[0]))
    return values


def _drifts(v: Vehicle) -> list[SummaryRow]:
    """Of what a body in a perfect fluid keeps."""
    numbers = []
    for name, values in v.constants.items():
        change = float(np.linalg.norm(values - values[:, :1], axis=0).max())
        scale = float(np.linalg.norm(values, axis=0).max()) or 1.0
        key = f"{v.unit}.drift_of_{name.replace(' ', '_')}"
        numbers.append(SummaryRow(key, change / scale, "1", f"largest change of the {name}, over its size"))
    return numbers
