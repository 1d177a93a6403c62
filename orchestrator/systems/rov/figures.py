"""Figures of underwater vehicles: track from above and from the side, attitude, thrusts with their limits, errors, constants.

Read from [analysis]: headings, s between marks of the heading on the track; transient, s, left out of the table of errors, which
a run that ends before it does not have.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...harness.charts.blocks import Block, Cells
from ...harness.charts.chart import Chart, Panel, Series, filled
from ...harness.charts.charts import draw_chart
from ...harness.charts.style import number
from . import RovKeys
from .records import ACCELERATIONS, ANGLES, ERRORS, RATES, SPEEDS, Vehicle, vehicles

if TYPE_CHECKING:
    from ...harness.validation.case import Row
    from ...run.results import Result

MARKS = 20  # of the heading on a track, where the scene does not say
DEGREES = 180.0 / np.pi
LENGTH = 0.06  # of a view's extent: a mark of the heading
VIEWS = (("from above", 1, 1.0, "east, m", 0, 1.0, "north, m"), ("from the south", 1, 1.0, "east, m", 2, -1.0, "−depth, m"))
AXES = ("north", "east", "down")


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures and tables of every vehicle whose position was recorded; several share the figures of their motion."""
    records = vehicles(result)
    if not records:
        return []
    interval = result.scene.analysis_as(RovKeys).headings or float(result.time[-1] - result.time[0]) / MARKS
    start = int(np.searchsorted(result.time, result.scene.analysis.transient))
    charts = [track_chart(records, interval), attitude_chart(records), motion_chart(records), current_chart(records)]
    content: list[Block] = [draw_chart(c) for c in charts if c is not None]
    for vehicle in records:
        who = f"{vehicle.unit}: " if len(records) > 1 else ""
        if vehicle.thrusts:
            content += [draw_chart(thrusts_chart(vehicle, who)), thrusts_table(vehicle, who)]
        if vehicle.errors:
            content.append(draw_chart(errors_chart(vehicle, who)))
            content += [errors_table(vehicle, start, who)] if start < result.time.size else []
        if vehicle.constants:
            content.append(draw_chart(constants_chart(vehicle, who)))
    return content


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
    angles = filled(
        (f"{n}, degrees", [Series(called(vehicles, v, n), v.time, unbroken(v.signals[n])) for v in vehicles if n in v.signals])
        for n in ANGLES
    )
    gaps = any(np.isnan(v.signals[n]).any() for v in vehicles for n in ("roll", "yaw") if n in v.signals)
    text = "Gaps in roll and yaw: the bow points up or down, where the two are ambiguous." if gaps else ""
    first = Panel("depth, m", depth, y_range=_downwards(max(ends), min(ends)))
    return Chart("Depth and attitude", "time, s", (first, *angles), text, height=150)


def _downwards(deep: float, shallow: float) -> tuple[float, float]:
    """Ends of an axis of depth, the deep one at the bottom."""
    margin = 0.06 * (deep - shallow) or 0.5
    return deep + margin, shallow - margin


def motion_chart(vehicles: Sequence[Vehicle]) -> Chart | None:
    """Speeds, rates and accelerations in body axes over time; None where none was recorded."""
    kinds = (("speed, m/s", SPEEDS, 1.0), ("rate, degrees/s", RATES, DEGREES), ("acceleration, m/s²", ACCELERATIONS, 1.0))

    def lines(names: Sequence[str], factor: float) -> Iterator[Series]:
        for v, n in ((v, n) for v in vehicles for n in names if n in v.signals):
            yield Series(called(vehicles, v, n.removeprefix("external.").replace("_", " ")), v.time, factor * v.signals[n])

    panels = filled((label, lines(names, factor)) for label, names, factor in kinds)
    return Chart("Motion in body axes", "time, s", panels, "Speeds and rates are over ground.", height=200) if panels else None


def current_chart(vehicles: Sequence[Vehicle]) -> Chart | None:
    """Velocity of the water over time; None where none was recorded."""
    water = tuple(Series(called(vehicles, v, axis), v.time, w) for v in vehicles for axis, w in v.water.items())
    text = "Velocity of the water at the vehicle, in axes of the world."
    return Chart("Current", "time, s", (Panel("velocity, m/s", water),), text, height=200) if water else None


def thrusts_chart(vehicle: Vehicle, who: str = "") -> Chart:
    """Thrust of every thruster, marked where its command is at the limit; the share of the wrench where limits keep some back."""
    series = [Series(f"thruster {k}", vehicle.time, F) for k, F in vehicle.thrusts.items()]
    times = [(vehicle.time[vehicle.at_limit(k)], F[vehicle.at_limit(k)]) for k, F in vehicle.thrusts.items()]
    at, what = (np.concatenate(parts) for parts in zip(*times, strict=True))
    series += [Series("at its limit", at, what, "dots")] if at.size else []
    panels = [Panel("thrust, N", tuple(series))]
    if vehicle.commands:
        commands = tuple(Series(f"thruster {k}", vehicle.time, c) for k, c in vehicle.commands.items())
        panels.append(Panel("command, 1", commands))
    text = "As the hull receives them."
    if vehicle.scale is not None and vehicle.scale.min() < 1.0:
        panels.append(
            Panel("share of wrench, 1", (Series("given of what is wanted", vehicle.time, vehicle.scale),), y_range=(-0.05, 1.1))
        )
    elif vehicle.scale is not None:
        text += " No thruster saturated."
    return Chart(f"{who}Thrusts", "time, s", tuple(panels), text, height=190)


def thrusts_table(vehicle: Vehicle, who: str = "") -> Cells:
    """Least, greatest and mean size of every thrust, and how long its command was at the limit."""
    whole = float(vehicle.time[-1] - vehicle.time[0]) or 1.0
    rows = []
    for k, F in vehicle.thrusts.items():
        limited = float(np.trapezoid(vehicle.at_limit(k).astype(float), vehicle.time)) / whole
        mean = float(np.trapezoid(np.abs(F), vehicle.time)) / whole
        share = f"{100.0 * limited:.3g} %" if k in vehicle.commands else "not recorded"
        rows.append((f"thruster {k}", number(float(F.min())), number(float(F.max())), number(mean), share))
    return Cells(
        f"{who}Thrusters",
        ("", "least, N", "greatest, N", "mean size, N", "time at its limit"),
        rows,
        right=frozenset({1, 2, 3, 4}),
    )


def errors_chart(vehicle: Vehicle, who: str = "") -> Chart:
    """Set point less pose over time."""
    kinds = (("error of the position, m", ERRORS[:3], 1.0), ("error of the attitude, degrees", ERRORS[3:], DEGREES))
    known = ((label, [n for n in names if n in vehicle.errors], factor) for label, names, factor in kinds)
    panels = filled(
        (label, (Series(n.removeprefix("error_"), vehicle.time, factor * vehicle.errors[n]) for n in names))
        for label, names, factor in known
    )
    text = "Set point less pose: position in north, east, down, attitude as the rotation vector in body axes."
    return Chart(f"{who}Errors against the set point", "time, s", panels, text, height=200)


def errors_table(vehicle: Vehicle, start: int, who: str = "") -> Cells:
    """Root mean square and largest error of every axis from the sample `start` on."""
    rows = []
    for name, values in vehicle.errors.items():
        angle = name in ERRORS[3:]
        kept = values[start:] * (DEGREES if angle else 1e3)
        unit = "degrees" if angle else "mm"
        rms = float(np.sqrt(np.mean(np.square(kept))))
        rows.append((name.removeprefix("error_"), unit, f"{rms:.3g}", f"{np.abs(kept).max():.3g}"))
    begin = float(vehicle.time[start])
    return Cells(
        f"{who}Errors",
        ("", "unit", "root mean square", "largest"),
        rows,
        f"From {begin:.4g} s on." if begin > vehicle.time[0] else "",
        right=frozenset({2, 3}),
    )


def constants_chart(vehicle: Vehicle, who: str = "") -> Chart:
    """Drift of each, relative to its size at the start."""
    panels, drifts = [], []
    for name, values in vehicle.constants.items():
        drift = (values - values[:, :1]) / (float(np.linalg.norm(values[:, 0])) or 1.0)
        lines = ("energy",) if len(values) == 1 else AXES
        panels.append(Panel(f"{name}, 1", tuple(Series(n, vehicle.time, d) for n, d in zip(lines, drift, strict=True))))
        drifts.append(f"{name} by {float(np.abs(drift).max()):.2g}")
    text = f"A body in a perfect fluid keeps them; the run drifts, relative to the value at the start: {', '.join(drifts)}."
    return Chart(f"{who}Drift of energy and impulse", "time, s", tuple(panels), text, height=150)
