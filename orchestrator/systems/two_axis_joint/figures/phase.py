"""Angles and rates over time, against each other, and in sections."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....harness.charts.chart import Chart, Panel, Series
from ..records import Axis, JointRecord, drawn

DEGREES = 180.0 / np.pi
FULL = 360.0
AT_REST = 1e-3  # of the largest rate
LEAST_RATE = 1e-9  # of the largest one, that is shown
LEAST = 8  # points of a section; fewer are no picture
CLOUD = 200  # from which on they are drawn small


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
        if axis.angle.size >= LEAST:
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
