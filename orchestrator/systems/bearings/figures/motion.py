"""Time history, orbit, phase planes and their section."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .....components.core.errors import BadInput, nearest
from ....harness.analysis.sections import crossings, distinct, section
from ....harness.analysis.spectra import TURN, turns_steadily
from ....harness.charts.blocks import Cells
from ....harness.charts.chart import Chart, Panel, Series
from ....harness.charts.style import number
from ..records import BearingRecord
from .scales import Scales

if TYPE_CHECKING:
    from ....results import Result

HISTORY = (
    ("displacement", "displacement_x", "displacement_y"),
    ("velocity", "velocity_x", "velocity_y"),
    ("acceleration", "acceleration_x", "acceleration_y"),
)
DRAWN_PASSINGS = 30  # of balls, in orbits: more only blacken the picture
SAME = 0.02  # of the range: points of a section nearer to one another count as one


def after(record: BearingRecord, begin: float) -> slice:
    """The samples of a record from a time on."""
    return slice(int(np.searchsorted(record.time, begin - 1e-12)), None)


def history_chart(record: BearingRecord, begin: float, who: str = "") -> Chart:
    """Displacement, velocity, acceleration and the largest ball load over the whole run."""
    scales = Scales(record)
    mark = ((begin, ""),) if begin > record.time[0] else ()
    panels = []
    for what, *names in HISTORY:
        present = [n for n in names if n in record.signals]
        if present and what != "velocity":
            series = tuple(Series(n[-1], record.time, scales.factor(n) * record.signals[n]) for n in present)
            panels.append(Panel(f"{what}, {scales.unit(present[0])}", series, x_marks=mark))
    if "max_ball_load" in record.signals:
        load = Series("most loaded ball", record.time, scales.factor("max_ball_load") * record.signals["max_ball_load"])
        panels.append(Panel(f"ball load, {scales.unit('max_ball_load')}", (load,), x_marks=mark))
    text = _turning(record) + (" Thin vertical line: end of the transient." if mark else "")
    return Chart(f"{who}Time history", scales.time, tuple(panels), text)


def _turning(record: BearingRecord) -> str:
    if not np.isfinite(record.rotation):
        return ""
    hertz = Scales(record).hertz
    text = f"Inner ring: {record.rotation:.4g}{hertz}"
    text += f" ({60.0 * record.rotation:.0f} rpm)" if hertz else ""
    if record.frequencies:
        text += f"; a ball passes a place of the outer race with {record.frequencies['outer']:.4g}{hertz}"
    return text + "."


def section_points(result: Result, record: BearingRecord, begin: float) -> dict[str, np.ndarray]:
    """Signals (k,) at the instants of the section: the scene's, else each ball's passing, else each turn.

    Where no angle was recorded: where the velocity along x rises through zero, the turning points of x. Empty without it, too.
    """
    kept = after(record, begin)
    wanted = result.scene.analysis.section
    angle, turns = record.signals.get("cage_angle"), float(record.balls or 1)
    if wanted is not None:
        name, turns = wanted.angle, wanted.turns
        if name not in result.columns:
            where = f"{result.scene.name}: analysis.section.angle"
            raise BadInput(where, repr(name), "a recorded signal", nearest(name, result.columns))
        angle = record.signals.get(name.removeprefix(f"{record.unit}."))
        if angle is None and result.time.size == record.time.size and turns_steadily(result.columns[name][kept]):
            angle = result.columns[name]
    elif angle is None:
        angle, turns = record.signals.get("inner_angle"), 1.0
    motion = {n: v[kept] for n, v in record.signals.items() if n.startswith(("displacement", "velocity"))}
    if angle is not None:
        sampled = section(angle[kept], TURN / turns, *motion.values())
    elif "velocity_x" in motion:
        sampled = crossings(record.time[kept], motion["velocity_x"], *motion.values())
    else:
        return {}
    return dict(zip(motion, sampled, strict=True))


def period_of(points: dict[str, np.ndarray], record: BearingRecord, begin: float) -> int:
    """Number of distinct points of a section: after how many passages the motion repeats; 0 without a section.

    At least so many where velocities were not recorded: orbits cross themselves.
    """
    if not points or not points["displacement_x"].size:
        return 0
    kept, columns = after(record, begin), []
    for kind in ("displacement", "velocity"):
        names = [n for n in points if n.startswith(kind)]
        reach = max((float(np.ptp(record.signals[n][kept])) for n in names), default=0.0) or 1.0
        columns += [points[n] / reach for n in names]
    return distinct(np.stack(columns, axis=1), SAME)


def orbit_chart(record: BearingRecord, begin: float, points: dict[str, np.ndarray], who: str = "") -> Chart:
    """Orbit and phase planes over the last passings, with the section's points of the whole steady part."""
    scales, kept = Scales(record), after(record, begin)
    period = 1.0 / record.frequencies["outer"] if record.frequencies else 0.0
    count = record.time[kept].size
    if period:
        count = min(count, int(DRAWN_PASSINGS * period * record.rate) + 1)
    window = slice(record.time.size - count, None)

    def curve(a: str, b: str) -> tuple[Series, ...]:
        x, y = scales.factor(a), scales.factor(b)
        motion = Series("motion", x * record.signals[a][window], y * record.signals[b][window], faint=True)
        return (motion, Series("section", x * points[a], y * points[b], "dots")) if points else (motion,)

    def title(n: str) -> str:
        return f"{n.replace('_', ' ')}, {scales.unit(n)}"

    x, y = "displacement_x", "displacement_y"
    panels = [Panel(title(y), curve(x, y), title="Orbit", x_label=title(x), equal=True)]
    for n, v in ((x, "velocity_x"), (y, "velocity_y")):
        if v in record.signals:
            panels.append(Panel(title(v), curve(n, v), title=f"Phase plane {n[-1]}", x_label=title(n)))
    text = f"Pale: the last {count / record.rate:.3g}{' s' if scales.dimensional else ''} of the run."
    if points:
        groups, size = period_of(points, record, begin), points[x].size
        text += f" Dots: section, {size} instants after the transient, "
        text += "all at one place." if groups == 1 else f"in {groups} groups."
    return Chart(f"{who}Orbit and phase planes", "", tuple(panels), text, columns=len(panels), height=330)


def motion_table(record: BearingRecord, begin: float, points: dict[str, np.ndarray], who: str = "") -> Cells:
    """Statistics of the signals after the transient."""
    scales, kept = Scales(record), after(record, begin)
    rows = []
    for n, values in record.signals.items():
        if n.endswith("_angle"):
            continue
        x = scales.factor(n) * values[kept]
        centred = x - x.mean()
        rms = float(np.sqrt(np.mean(centred**2)))
        shape = [float(np.abs(centred).max()) / rms, float(np.mean(centred**4)) / rms**4] if rms > 0.0 else [np.nan, np.nan]
        rows.append((n.replace("_", " "), scales.unit(n), *(number(v) for v in (float(x.mean()), rms, float(np.ptp(x)), *shape))))
    header = ("signal", "unit", "mean", "rms about the mean", "peak to peak", "crest factor", "kurtosis")
    period = period_of(points, record, begin)
    text = f"After the transient, {record.time[kept].size} samples at {record.rate:.5g}{scales.hertz}. A sine has kurtosis 1.5."
    if period:
        text += f" The section has {period} distinct point{'s' if period > 1 else ''} ({100 * SAME:g} % of the range apart)."
    return Cells(f"{who}Statistics of the motion", header, rows, text, frozenset(range(2, 7)))
