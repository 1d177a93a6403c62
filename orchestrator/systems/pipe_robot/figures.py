"""Figures of pipe robots: way and mean speed, friction in detail, resonance, the pipe along the way, standstill and creep.

Read from [analysis]: transient, average, detail; see `PipeRobotKeys`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...harness.charts.blocks import Block, Cells, Text
from ...harness.charts.chart import Chart, Lines, Panel, Series
from ...harness.charts.charts import draw_chart
from ...harness.charts.style import number
from . import PipeRobotKeys
from .records import RobotRecord, amplitude, detail, energies, mean_speed, robots, shares, standing_since, steady_speed, switches

if TYPE_CHECKING:
    from ...harness.validation.case import Row
    from ...run.results import Result

SHORTEST_WAY = 1e-13  # m, of a way that is drawn on a logarithmic axis
TURNED = 0.02  # relative change of a frequency that is worth a panel
MOVING = {"body": "velocity", "inner mass": "inner_velocity"}
LONG = 0.05  # of the record, from which on a standstill is one for good
MILLI = 1e3
DEGREES = 180.0 / np.pi
SWING = 0.2  # of the largest frequency, from which on a stretch is a sweep, and not a motor that swings about its speed
PERCENT = 100.0
ENERGIES = {"exciter": "exciter gave, J", "lost": "lost, J", "lifted": "lifted its weight, J", "towed": "pulled a load, J"}


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures and tables of the robots whose position and velocity were recorded; none without one."""
    records = robots(result)
    if not records:
        return []
    transient = result.scene.analysis.transient
    kept = slice(int(np.searchsorted(result.time, transient)), None)
    part = result.scene.analysis_as(PipeRobotKeys).detail
    charts = [course_chart(records, transient), frequency_chart(records), pipe_chart(records), creep_chart(records),
              detail_chart(records, part)]  # fmt: skip
    content: list[Block] = [draw_chart(c) for c in charts if c is not None]
    if result.time[kept].size < 2:
        return [*content, Text([f"There are no tables: the run ends before its transient of {transient:g} s."], "note")]
    content.append(travel_table(records, kept))
    energy = energy_table(records, kept)
    return content if energy is None else [*content, energy]


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
        if distance.max() > SHORTEST_WAY:
            series.append(Series(r.unit, t[first:], np.where(distance > SHORTEST_WAY, distance, np.nan)))
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


def frequency_chart(records: Sequence[RobotRecord]) -> Chart | None:
    """Mean speed and amplitude over a frequency that changes, rising and falling; None where none does."""
    turning = [r for r in records if r.frequency is not None and changes(r.frequency)]
    if not turning:
        return None
    speeds, amplitudes = [], []
    low, high = np.inf, 0.0
    for r in turning:
        w = r.frequency
        if w is None:
            continue
        low, high = min(low, float(w.min())), max(high, float(w.max()))
        size = amplitude(r)
        for way, part in ways(w):
            name = f"{r.unit}, {way}"
            speeds.append(Series(name, w[part], mean_speed(r)[part]))
            if size is not None:
                amplitudes.append(Series(name, w[part], MILLI * size[part]))
    lines = resonance_lines(turning, low, high)
    panels = [Panel("mean speed, m/s", tuple(speeds), lines=lines)]
    if amplitudes:
        panels.append(Panel("amplitude of the inner mass against the body, mm", tuple(amplitudes), lines=lines))
    text = "The inner mass resonates against the free body, or against one that sticks; the robot is fastest where it does."
    return Chart("Against the exciter's frequency", "exciter, rad/s", tuple(panels), text, columns=2, height=320)


def ways(frequency: np.ndarray) -> list[tuple[str, slice]]:
    """("rising" or "falling", samples) of the stretches up to the largest frequency and after it; small ones are left out."""
    top = int(np.argmax(frequency))
    parts = [("rising", slice(0, top + 1)), ("falling", slice(top, frequency.size))]
    return [(way, p) for way, p in parts if np.ptp(frequency[p]) > SWING * frequency[top]]


def pipe_chart(records: Sequence[RobotRecord]) -> Chart | None:
    """Mean speed and slope over the place in the pipe; None where the slope was not recorded or is the same everywhere."""
    sloping = [r for r in records if "route.slope" in r.signals and np.ptp(r.signals["route.slope"]) > 0.0]
    if not sloping:
        return None
    speeds = [Series(r.unit, r.signals["position"], mean_speed(r)) for r in sloping]
    longest = max(sloping, key=lambda r: float(np.ptp(r.signals["position"])))
    order = np.argsort(longest.signals["position"], kind="stable")
    slope = Series("pipe", longest.signals["position"][order], DEGREES * longest.signals["route.slope"][order])
    panels = (Panel("mean speed, m/s", tuple(speeds)), Panel("slope of the pipe, degrees", (slope,)))
    text = "At a slope at which friction and weight forwards equal friction less weight backwards, a robot gets no further."
    return Chart("Along the pipe", "place, m", panels, text, columns=2, height=280)


def travel_table(records: Sequence[RobotRecord], kept: slice) -> Cells:
    """Way, mean speed and the modes of the friction after the transient."""
    rows = []
    for r in records:
        x = r.signals["position"][kept]
        share = shares(r, kept)
        numbers = (float(x[-1] - x[0]), steady_speed(r, kept), *(PERCENT * share[m] for m in (1, 0, -1)), switches(r, kept))
        rows.append((r.unit, *(number(v) for v in numbers)))
    header = ("robot", "way, m", "mean speed, m/s", "forwards, % of the time", "at rest, %", "backwards, %", "switches, 1/s")
    text = "After the transient. Modes and switches are those of the recorded samples; what happens in between is not counted."
    return Cells("Travel", header, rows, text, frozenset(range(1, len(header))))


def energy_table(records: Sequence[RobotRecord], kept: slice) -> Cells | None:
    """Energies after the transient, and what a metre costs; None where no power was recorded."""
    known = [(r, energies(r, kept)) for r in records]
    names = [n for n in ENERGIES if any(n in e for _, e in known)]
    if not names:
        return None
    rows = []
    for r, e in known:
        x = r.signals["position"][kept]
        way = float(x[-1] - x[0])
        cost = number(e["exciter"] / way) if "exciter" in e and way > 0.0 else ""
        rows.append((r.unit, *(number(e[n]) if n in e else "" for n in names), cost))
    header = ("robot", *(ENERGIES[n] for n in names), "exciter a metre, J/m")
    text = "Integrals of recorded powers after the transient. What is missing is in motion and springs, or between the samples."
    return Cells("Energy", header, rows, text, frozenset(range(1, len(header))))
