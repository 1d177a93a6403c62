"""What happens over time: way and mean speed, some periods in detail, and what moves where friction should hold."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....harness.charts.chart import Chart, Lines, Panel, Series
from ..records import RobotRecord, detail, mean_speed, standing_since

LEAST = 1e-13  # m, of a way that is drawn on a logarithmic axis
TURNED = 0.02  # relative change of a frequency that is worth a panel
MOVING = {"body": "velocity", "inner mass": "inner_velocity"}
LONG = 0.05  # of the record, from which on a standstill is one for good


def course_chart(records: Sequence[RobotRecord], begin: float) -> Chart:
    """Way, mean speed over a period, and the exciter's frequency where it changes, of all robots."""
    t = records[0].time
    mark = ((begin, ""),) if t[0] < begin < t[-1] else ()
    panels = [
        Panel("way of the body, m", tuple(Series(r.unit, t, r.signals["position"]) for r in records), x_marks=mark),
        Panel("mean speed, m/s", tuple(Series(r.unit, t, mean_speed(r)) for r in records), x_marks=mark),
    ]
    turning = [r for r in records if r.frequency is not None and changes(r.frequency)]
    if turning:
        series = [Series(r.unit, t, r.frequency) for r in turning if r.frequency is not None]
        for name, value in turning[0].resonances.items():
            series.append(Series(f"resonance, body {name}", t[[0, -1]], [value, value], faint=True))
        panels.append(Panel("exciter, rad/s", tuple(series), x_marks=mark))
    if any(np.ptp(r.signals["tow.force"]) > 0.0 for r in records if "tow.force" in r.signals):
        panels.append(
            Panel(
                "force in tow, N",
                tuple(Series(r.unit, t, r.signals["tow.force"]) for r in records if "tow.force" in r.signals),
                x_marks=mark,
            )
        )
    text = "Mean speed: way within a period of the exciter over the period."
    text += " Thin vertical line: end of the transient." if mark else ""
    return Chart("Way and speed", "time, s", tuple(panels), text, height=220)


def changes(values: np.ndarray) -> bool:
    """Whether a frequency changes noticeably over the record."""
    return bool(np.ptp(values) > TURNED * np.abs(values).max())


def detail_chart(records: Sequence[RobotRecord], part: tuple[float, float] | None) -> Chart:
    """Velocities, friction and mode of every robot over a few periods."""
    panels = []
    for r in records:
        kept = detail(r, part)
        t, s = r.time[kept], r.signals
        title = r.unit if len(records) > 1 else ""
        moving = tuple(Series(n, t, s[k][kept]) for n, k in MOVING.items() if k in s)
        panels.append(Panel("velocity, m/s", moving, title=title, x_label="time, s"))
        if "friction_force" in s:
            friction = (Series("friction", t, s["friction_force"][kept]),)
            panels.append(Panel("friction on the body, N", friction, title=title, x_label="time, s"))
    text = ("Friction is weaker against motion forwards than backwards; where the body rests, it is what the other forces "
            "leave.")  # fmt: skip
    return Chart("In detail", "", tuple(panels), text, columns=2, height=230)


def creep_chart(records: Sequence[RobotRecord]) -> Chart | None:
    """Way of every robot since one of them stands for good; None where none does, or it is alone."""
    t = records[0].time
    latest = t[-1] - LONG * (t[-1] - t[0])
    since = [at for r in records if (at := standing_since(r)) is not None and at <= latest]
    if not since or len(records) < 2:
        return None
    first = int(np.searchsorted(t, max(since)))
    series, standing = [], []
    for r in records:
        distance = np.abs(r.signals["position"][first:] - r.signals["position"][first])
        if distance.max() > LEAST:
            series.append(Series(r.unit, t[first:], np.where(distance > LEAST, distance, np.nan)))
        else:
            standing.append(r.unit)
    if not series:
        return None
    ends = ", ".join(f"{s.name} {float(np.asarray(s.y)[-1]):.3g} m" for s in series)
    text = f"Displacement after {t[first]:.4g} s: {ends} at the end."
    text += f" Not drawn, as it does not move at all: {', '.join(standing)}." if standing else ""
    panel = Panel("displacement since then, m", tuple(series), logarithmic=True)
    return Chart("What stands and what creeps", "time, s", (panel,), text, height=280)


def resonance_lines(records: Sequence[RobotRecord], low: float, high: float) -> tuple[Lines, ...]:
    """Natural frequencies of the first robot that lie within the range."""
    shown = [(n, v) for n, v in records[0].resonances.items() if low <= v <= high]
    return tuple(Lines(f"resonance, body {n}", ((v, f"{v:.1f}"),)) for n, v in shown)
