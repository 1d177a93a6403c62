"""Figures of joints with two axes: motion, phase portraits and sections, where the axis points, what should stay constant.

Read from [analysis]: transient, s, left out of phase portraits, tracks and sections; section = { angle, turns }.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...harness.charts.blocks import Block
from ...harness.charts.chart import Chart, Panel, Series
from ...harness.charts.charts import draw_chart
from ...run.key_results import after_transient
from . import walkers
from .records import Axis, JointRecord, drawn, joints, poincare

if TYPE_CHECKING:
    from ...harness.validation.case import Row
    from ...run.results import Result

UNITS = {"energy": "J", "momentum": "kg·m²/s"}
NARROW = 0.01  # of the largest value: what changes by less is shown as its change
DEGREES = 180.0 / np.pi
FULL = 360.0
AT_REST = 1e-3  # of the largest rate
LEAST_RATE = 1e-9  # of the largest one, that is shown
FEWEST_POINTS = 8  # points of a section; fewer are no picture
CLOUD = 200  # from which on they are drawn small
AXES = ("x", "y", "z")
VIEWS = (  # title, horizontal and vertical axis of the picture with their signs, axis towards the viewer with its sign
    ("from below", (0, 1.0), (1, 1.0), (2, 1.0)),
    ("from the side, along y", (0, 1.0), (2, -1.0), (1, -1.0)),
    ("from the side, along x", (1, 1.0), (2, -1.0), (0, 1.0)),
)
WIDE = 0.5  # of its reach: a tip that goes less far is drawn without it
EDGE = 1.0001  # of the sphere's radius: rounding of its edge


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures of the joints and walkers of a run whose angles and rates were recorded; none without one. Several are compared first."""
    records = joints(result)
    begin = float(result.time[after_transient(result).start])
    single = len(records) == 1
    charts = [history_chart(records[0], begin)] if single else comparison_charts(records, begin)
    charts += [c for c in (walkers.chart(result, begin),) if c is not None]
    for record in records:
        charts += _of_one(result, record, begin, "" if single else f"{record.unit}: ")
    constants = constants_chart(records)
    return [draw_chart(c) for c in (charts if constants is None else [*charts, constants])]


def _of_one(result: Result, record: JointRecord, begin: float, who: str) -> list[Chart]:
    charts = []
    if record.pointing is not None and not who:  # of several that are compared, the tracks would all look alike
        charts.append(sphere_chart(record, begin))
    if record.tip is not None:
        charts.append(tip_chart(record, begin, who))
    further = (phase_chart(record, begin, who), section_chart(poincare(result, record, begin), who))
    return charts + [c for c in further if c is not None]


def constants_chart(records: Sequence[JointRecord]) -> Chart | None:
    """One panel a quantity, one line a joint; None where nothing was recorded. What all of them keep is shown as its drift."""
    panels, kept, drifts = [], [], []
    for name, unit in UNITS.items():
        having = [r for r in records if name in r.kept]
        if not having:
            continue
        sizes = [float(np.abs(r.kept[name]).max()) or 1.0 for r in having]
        changes = [r.kept[name] - r.kept[name][0] for r in having]
        called = [name if len(records) == 1 else r.unit for r in having]
        values, label = [r.kept[name] for r in having], f"{name}, {unit}"
        if all(name in r.constant for r in having):
            values, label = [c / size for c, size in zip(changes, sizes, strict=True)], f"drift of {name}, 1"
            kept.append(name)
            drifts.append(f"{name} by {max(float(np.abs(v).max()) for v in values):.2g}")
        elif all(np.abs(c).max() < NARROW * size for c, size in zip(changes, sizes, strict=True)):
            values, label = changes, f"change of {name}, {unit}"
        lines = (Series(n, r.time, v) for n, r, v in zip(called, having, values, strict=True))
        panels.append(Panel(label, tuple(lines)))
    if not panels:
        return None
    text = ""
    if drifts:
        text = f"The equations keep {' and '.join(kept)}; the run drifts, relative to the largest value: {', '.join(drifts)}. "
        text += "A shorter substep reduces it."
    return Chart("Energy and momentum", "time, s", tuple(panels), text, height=200)


def wrapped(angle: np.ndarray, gaps: bool = True) -> np.ndarray:
    """Degrees of an angle (n,) in rad, within -180 to 180 where it goes further round; with a gap, NaN, at each jump."""
    degrees = DEGREES * angle
    if np.abs(degrees).max(initial=0.0) <= 0.5 * FULL:
        return degrees
    turned = (degrees + 0.5 * FULL) % FULL - 0.5 * FULL
    if gaps:
        turned[np.flatnonzero(np.abs(np.diff(turned)) > 0.5 * FULL)] = np.nan
    return turned


def comparison_charts(records: Sequence[JointRecord], begin: float) -> list[Chart]:
    """Angles of several joints over the whole run, one panel an axis; those with the same axes are compared.

    Where one of them comes to rest, its rates, too: what stands, and what creeps, differs by powers of ten.
    """
    groups: dict[tuple[str, ...], list[JointRecord]] = {}
    for record in records:
        groups.setdefault(tuple(a.name for a in record.axes), []).append(record)
    charts = []
    for names, group in groups.items():
        mark = ((begin, ""),) if begin > group[0].time[0] else ()
        panels, text = [], "Angles side by side."
        for i, name in enumerate(names):
            angles = (Series(r.unit, r.time, DEGREES * r.axes[i].angle) for r in group)
            panels.append(Panel(f"{name}, degrees", tuple(angles), x_marks=mark))
        if any(abs(a.rate[-1]) < AT_REST * np.abs(a.rate).max() for r in group for a in r.axes):
            text += " Rates by their magnitude; what stands exactly has no line there."
            for i, name in enumerate(names):
                rates = [(r, DEGREES * np.abs(r.axes[i].rate)) for r in group]
                top = 2.0 * max(float(v.max()) for _, v in rates)
                shown = (Series(r.unit, r.time, np.where(v > top * LEAST_RATE, v, np.nan)) for r, v in rates)
                label = f"rate of the {name}, degrees/s"
                panels.append(Panel(label, tuple(shown), logarithmic=True, y_range=(top * LEAST_RATE, top), x_marks=mark))
        charts.append(Chart("Motion", "time, s", tuple(panels), text))
    return charts


def history_chart(record: JointRecord, begin: float) -> Chart:
    """Angles and rates over the whole run."""
    mark = ((begin, ""),) if begin > record.time[0] else ()
    panels = (
        Panel("angle, degrees", tuple(Series(a.name, record.time, DEGREES * a.angle) for a in record.axes), x_marks=mark),
        Panel("rate, degrees/s", tuple(Series(a.name, record.time, DEGREES * a.rate) for a in record.axes), x_marks=mark),
    )
    return Chart("Motion", "time, s", panels, "Thin vertical line: end of the transient." if mark else "")


def phase_chart(record: JointRecord, begin: float, who: str = "") -> Chart | None:
    """Rate over angle of each axis that moves after the transient, with where it begins and ends; None where all stand."""
    kept, shown = drawn(record, begin)
    panels = []
    for axis in record.moving:
        angle, rate = wrapped(axis.angle[kept]), DEGREES * axis.rate[kept]
        series = (
            Series("motion", angle, rate),
            Series("begin", angle[:1], rate[:1], "points"),
            Series("end", angle[-1:], rate[-1:], "points"),
        )
        panels.append(Panel(f"rate of the {axis.name}, degrees/s", series, title=axis.name, x_label="angle, degrees"))
    if not panels:
        return None
    text = f"Rate over angle. A closed line is a motion that repeats; one that spirals in loses energy.{shown}"
    standing = [a.name for a in record.axes if not any(a is m for m in record.moving)]
    text += f" Not shown, as it does not move: {', '.join(standing)}." if standing else ""
    return Chart(f"{who}Phase portraits", "", tuple(panels), text, columns=max(2, len(panels)), height=330)


def section_chart(sections: Sequence[tuple[str, Axis]], who: str = "") -> Chart | None:
    """Poincaré sections: an axis at the given instants; None where those are too few."""
    panels, counts = [], []
    for when, axis in sections:
        if axis.angle.size >= FEWEST_POINTS:
            kind = "dots" if axis.angle.size > CLOUD else "points"
            series = (Series("passages", wrapped(axis.angle, gaps=False), DEGREES * axis.rate, kind),)
            label = f"rate of the {axis.name}, degrees/s"
            panels.append(Panel(label, series, title=f"{axis.name} when {when}", x_label="angle, degrees"))
            counts.append(str(axis.angle.size))
    if not panels:
        return None
    text = (
        f"{' and '.join(counts)} passages in one direction. Points that lie on a line: the motion has two frequencies and is "
        "regular; points that fill an area: it is chaotic."
    )
    return Chart(f"{who}Poincaré sections", "", tuple(panels), text, columns=2, height=330)


def circle(radius: float) -> Series:
    """The edge of what can be reached."""
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    return Series("edge", radius * np.cos(turn), radius * np.sin(turn), faint=True)


def sphere_chart(record: JointRecord, begin: float) -> Chart:
    """The axis' track on the unit sphere from three sides; the part on the far side is another line."""
    assert record.pointing is not None
    window, shown = drawn(record, begin)
    kept = record.pointing[:, window]
    panels = []
    for title, (i, along), (j, up), (k, towards) in VIEWS:
        x, y, depth = along * kept[i], up * kept[j], towards * kept[k]
        near, far = (np.where(_widened(here), 1.0, np.nan) for here in (depth >= 0.0, depth < 0.0))
        series = [circle(EDGE), Series("near side", near * x, near * y), Series("far side", far * x, far * y)]
        series += [Series("begin", x[:1], y[:1], "points"), Series("end", x[-1:], y[-1:], "points")]
        signs = ["" if sign > 0.0 else "−" for sign in (along, up)]
        panels.append(Panel(f"{signs[1]}{AXES[j]}, 1", tuple(series), title=title, x_label=f"{signs[0]}{AXES[i]}, 1", equal=True))
    text = "Track of the body's axis on the unit sphere; x and y are horizontal, −z is up." + shown
    return Chart("Track of the axis", "", tuple(panels), text, columns=3, height=300)


def _widened(here: np.ndarray) -> np.ndarray:
    """Samples of a side and the one before each of them: so that the two sides' lines meet."""
    wide = here.copy()
    wide[:-1] |= here[1:]
    return wide


def tip_chart(record: JointRecord, begin: float, who: str = "") -> Chart:
    """Path of a chain's tip in its plane."""
    assert record.tip is not None
    window, shown = drawn(record, begin)
    x, y = record.tip[:, window]
    wide = max(float(np.ptp(x)), float(np.ptp(y))) > WIDE * record.reach > 0.0
    series = [circle(record.reach)] if wide else []
    series += [Series("tip", x, y), Series("begin", x[:1], y[:1], "points"), Series("end", x[-1:], y[-1:], "points")]
    text = "Path of the tip" + ("; pale: as far as it reaches." if wide else ".") + shown
    panel = Panel("y, m", tuple(series), x_label="x, m", equal=True)
    return Chart(f"{who}Path of the tip", "", (panel,), text, columns=2, height=360)
