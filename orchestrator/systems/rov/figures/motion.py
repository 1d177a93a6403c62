"""Where the vehicle goes and how it lies: track from above and from the side, angles, speeds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series
from ..records import ACCELERATIONS, ANGLES, RATES, SPEEDS, Vehicle

DEGREES = 180.0 / np.pi
LENGTH = 0.06  # of a view's extent: a mark of the heading
VIEWS = (("from above", 1, 1.0, "east, m", 0, 1.0, "north, m"), ("from the south", 1, 1.0, "east, m", 2, -1.0, "−depth, m"))


def called(vehicles: Sequence[Vehicle], vehicle: Vehicle, name: str) -> str:
    """Name of a line: with the unit's where there are several vehicles."""
    return name if len(vehicles) == 1 else f"{vehicle.unit} {name}"


def track_chart(vehicles: Sequence[Vehicle], interval: float) -> Chart | None:
    """Plan and elevation of the tracks with their set points, those with anything in them; strokes show where the bow points."""
    panels = []
    for title, i, along, x_label, j, up, y_label in VIEWS:
        if not any(np.ptp(v.position[[i, j]], axis=1).any() for v in vehicles):
            continue
        extent = max(float(np.ptp(v.position[[i, j]], axis=1).max()) for v in vehicles)
        series = []
        for v in vehicles:
            x, y = along * v.position[i], up * v.position[j]
            if v.wanted is not None:
                series.append(Series(called(vehicles, v, "set point"), along * v.wanted[i], up * v.wanted[j]))
            if (strokes := _strokes(v, interval, LENGTH * extent)) is not None:
                series.append(Series("heading", along * strokes[i], up * strokes[j]))
            series += [
                Series(called(vehicles, v, "track"), x, y),
                Series("begin", x[:1], y[:1], "points"),
                Series("end", x[-1:], y[-1:], "points"),
            ]
        panels.append(Panel(y_label, tuple(series), title=title, x_label=x_label, equal=True))
    if not panels:
        return None
    marks = f" Strokes: the bow's direction every {interval:.3g} s." if any(v.axes is not None for v in vehicles) else ""
    return Chart("Track", "", tuple(panels), "The same scale in both directions." + marks, columns=2, height=360)


def _strokes(vehicle: Vehicle, interval: float, length: float) -> np.ndarray | None:
    """Strokes from the position along the body's x axis at times `interval` apart, (3, 3 m), NaN between them."""
    if vehicle.axes is None:
        return None
    t = vehicle.time
    k = np.unique(np.searchsorted(t, np.arange(t[0], t[-1] + 0.5 * interval, interval)).clip(0, t.size - 1))
    begin = vehicle.position[:, k]
    end = begin + length * vehicle.axes[:, 0, k]
    return np.stack((begin, end, np.full_like(begin, np.nan)), axis=2).reshape(3, -1)


def unbroken(angle: np.ndarray) -> np.ndarray:
    """An angle in degrees with a gap wherever it wraps from one end of its range to the other."""
    shown = DEGREES * np.asarray(angle)
    shown[1:][np.abs(np.diff(shown)) > 180.0] = np.nan
    return shown


def attitude_chart(vehicles: Sequence[Vehicle]) -> Chart | None:
    """Depth with its set point, roll, pitch and yaw over time."""
    wanted = tuple(Series(called(vehicles, v, "set point"), v.time, v.wanted[2]) for v in vehicles if v.wanted is not None)
    depth = wanted + tuple(Series(called(vehicles, v, "depth"), v.time, v.position[2]) for v in vehicles)
    ends = [float(f(s.y)) for f in (np.nanmax, np.nanmin) for s in depth]
    panels = [Panel("depth, m", depth, y_range=_downwards(max(ends), min(ends)))]
    for name in ANGLES:
        having = [v for v in vehicles if name in v.signals]
        series = tuple(Series(called(vehicles, v, name), v.time, unbroken(v.signals[name])) for v in having)
        panels += [Panel(f"{name}, degrees", series)] if series else []
    gaps = any(np.isnan(v.signals[n]).any() for v in vehicles for n in ("roll", "yaw") if n in v.signals)
    text = "Gaps in roll and yaw: the bow points up or down, where the two are ambiguous." if gaps else ""
    return Chart("Depth and attitude", "time, s", tuple(panels), text, height=150)


def _downwards(deep: float, shallow: float) -> tuple[float, float]:
    """Ends of an axis of depth, the deep one at the bottom."""
    margin = 0.06 * (deep - shallow) or 0.5
    return deep + margin, shallow - margin


def motion_chart(vehicles: Sequence[Vehicle]) -> Chart | None:
    """Speeds, rates and accelerations in body axes over time; None where none was recorded."""
    panels = []
    for label, names, factor in (("speed, m/s", SPEEDS, 1.0), ("rate, degrees/s", RATES, DEGREES),
                                 ("acceleration, m/s²", ACCELERATIONS, 1.0)):  # fmt: skip
        series = tuple(
            Series(called(vehicles, v, n.removeprefix("external.").replace("_", " ")), v.time, factor * v.signals[n])
            for v in vehicles
            for n in names
            if n in v.signals
        )
        panels += [Panel(label, series)] if series else []
    text = "Speeds and rates are over ground."
    return Chart("Motion in body axes", "time, s", tuple(panels), text, height=200) if panels else None


def current_chart(vehicles: Sequence[Vehicle]) -> Chart | None:
    """Velocity of the water over time; None where none was recorded."""
    water = tuple(Series(called(vehicles, v, axis), v.time, w) for v in vehicles for axis, w in v.water.items())
    text = "Velocity of the water at the vehicle, in axes of the world."
    return Chart("Current", "time, s", (Panel("velocity, m/s", water),), text, height=200) if water else None
