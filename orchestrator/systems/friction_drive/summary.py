"""How the friction-wheel drives of a run move to their set points, and what it costs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...harness.summary import Summary, rows
from . import FrictionDriveKeys
from .records import AXES, Drive, drives, energies, moves

if TYPE_CHECKING:
    from ...run.results import Result

UNITS = {"feed": "m", "rotation": "rad"}
ENERGIES = {"motors": "energy into the motors", "wheels": "energy from the wheels into the contacts",
            "contacts": "energy taken up by the contacts", "sleeve": "energy gained by sleeve, weight, deflections"}  # fmt: skip
TEXTS = {f"{name}_energy": ("J", text) for name, text in ENERGIES.items()}
for _axis, _unit in UNITS.items():
    TEXTS |= {
        f"{_axis}_way": (_unit, f"way of the {_axis} over the record"),
        f"{_axis}_error_end": (_unit, f"error of the {_axis} at the end"),
        f"{_axis}_error_max": (_unit, f"largest error of the {_axis}"),
        f"{_axis}_overshoot": (_unit, f"largest overshoot of a move of the {_axis}"),
        f"{_axis}_settling_time": ("s", f"longest settling time of a move of the {_axis}; – where one does not settle"),
    }
HEADLINE = ("*_error_end", "*_overshoot", "*_settling_time")  # what a run is judged by


def summary(result: Result) -> Summary:
    """Of every drive whose feed and rotation were recorded."""
    keys = result.scene.analysis_as(FrictionDriveKeys)
    bands = {"feed": keys.feed_band, "rotation": keys.rotation_band}
    return tuple(row for d in drives(result) for row in rows(d.unit, _numbers(d, bands), TEXTS))


def _numbers(drive: Drive, bands: dict[str, float]) -> dict[str, float | None]:
    values: dict[str, float | None] = {}
    done = moves(drive, bands)
    for axis in AXES:
        if axis in drive.way:
            values[f"{axis}_way"] = float(drive.way[axis][-1] - drive.way[axis][0])
        if axis in drive.error:
            error = drive.error[axis]
            values |= {f"{axis}_error_end": float(error[-1]), f"{axis}_error_max": float(np.abs(error).max())}
        if mine := [m for m in done if m.axis == axis]:
            times = [float("nan") if m.settling_time is None else m.settling_time for m in mine]
            values |= {f"{axis}_overshoot": max(m.overshoot for m in mine), f"{axis}_settling_time": float(np.max(times))}
    return values | {f"{name}_energy": value for name, value in energies(drive).items()}
