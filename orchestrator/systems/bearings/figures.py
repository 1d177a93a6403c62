"""Figures and measures of the bearings of a run: motion, spectra with the lines of races, balls and cage, recurrence, heat.

Read from [analysis], beside what `bearings.records` says: section = { signal, angle, turns }, marks = ["outer", "inner",
"ball", "cage", "shaft"], highest_frequency, envelope_band = [from, to], recurrence = { threshold, theiler, interval }.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ....components.core.errors import BadInput, nearest
from ...harness.analysis.recurrence import Quantification, line_survival, quantify, recurrence_matrix, standardised
from ...harness.analysis.sections import crossings, distinct, section
from ...harness.analysis.signals import amplitude_spectrum
from ...harness.analysis.spectra import TURN, Family, envelope_spectrum, peak, resonance_band, turns_steadily
from ...harness.charts.blocks import Block, Cells
from ...harness.charts.chart import Chart, Lines, Panel, Picture, Series, filled
from ...harness.charts.charts import draw_chart
from ...harness.charts.style import number
from ...run.key_results import after_transient
from . import BearingKeys, RecurrenceKeys
from .records import BearingRecord, bearings, since

if TYPE_CHECKING:
    from ...harness.validation.case import Row
    from ...run.results import Result

HISTORY = ("displacement", "acceleration")  # drawn over the whole run
DRAWN_PASSINGS = 30  # of balls, in orbits: more only blacken the picture
SAME = 0.02  # of the range: points of a section nearer to one another count as one
NAMES = {
    "outer": "outer race (BPFO)",
    "inner": "inner race (BPFI)",
    "ball": "ball (2 BSF)",
    "cage": "cage (FTF)",
    "shaft": "shaft",
}
LOWEST_BAND = 5.0  # times the highest defect frequency: below, the impacts' own harmonics are counted as resonance
HIGHEST_BAND = 30.0  # above, a simulated signal is free of noise and impulsive, but carries next to nothing
UNFOLDED = 0.25  # of the rate of recording: what an unfiltered record folds back to below that was above three times it
SHOWN_HARMONICS = 10.0  # of the outer race's frequency, in the plain spectrum
SHOWN_ENVELOPE = 4.5  # of the highest defect frequency, in the envelope's
DECADES = 5.0  # shown below the highest line
PER_PASSING = 25  # samples between two balls' passings, where the scene does not say
STATES = 1200  # quantified
DRAWN = 500  # in the picture
ICE = 273.15  # K
SHOWN = {"m": (1e6, "µm"), "m/s": (1e3, "mm/s"), "m/s2": (1.0, "m/s²"), "N": (1.0, "N")}
OVER_TIME = {  # title -> groups of signals, of which the first has to be there: ending of the name, label, factor, offset; a text
    "Heat": (
        (
            ("temperature", "temperature, °C", 1.0, -ICE),
            ("clearance_change", "change of clearance, µm", 1e6, 0.0),
            ("power", "friction, W", 1.0, 0.0),
            ("conductance", "conductance, W/K", 1.0, 0.0),
        ),
        "Clearances are diametral; they fall where the shaft warms faster than the housing.",
    ),
    "Slip of the cage": (
        (
            ("cage_slip.slip", "slip of the cage, %", 100.0, 0.0),
            ("cage_slip.drive", "drive by the inner race, N.m", 1.0, 0.0),
            ("cage_slip.power", "heat of slip and drag, W", 1.0, 0.0),
        ),
        "Slip: the share by which the cage is slower than one whose balls roll on both races.",
    ),
}


@dataclass(frozen=True)
class Scales:
    """Factors and names of units; time and frequency of a dimensionless bearing are in its own unit of time."""

    record: BearingRecord

    @property
    def dimensional(self) -> bool:
        """Whether the displacement has a unit."""
        return self.record.measures.get("displacement_x", "") not in ("", "1")

    @property
    def time(self) -> str:
        """Label of the time axis."""
        return "time, s" if self.dimensional else "time, 1"

    @property
    def frequency(self) -> str:
        """Label of a frequency axis."""
        return "frequency, Hz" if self.dimensional else "frequency, 1"

    @property
    def hertz(self) -> str:
        """Unit of a frequency in a sentence."""
        return " Hz" if self.dimensional else ""

    def factor(self, signal: str) -> float:
        """Factor from a recorded signal's unit to the one that `unit` names."""
        return SHOWN.get(self.record.measures.get(signal, ""), (1.0, ""))[0]

    def unit(self, signal: str) -> str:
        """The unit in which a signal is shown."""
        measure = self.record.measures.get(signal, "")
        return SHOWN.get(measure, (1.0, measure or "1"))[1]


@dataclass(frozen=True)
class Recurrence:
    """A quantified recurrence matrix. interval: time between its states."""

    matrix: np.ndarray
    measures: Quantification
    interval: float
    begin: float
    threshold: float
    theiler: int
    coordinates: tuple[str, ...]


def blocks(result: Result, rows: Sequence[Row] = ()) -> list[Block]:
    """Figures and tables of every bearing of a run whose displacement was recorded; none without one."""
    records = bearings(result)
    content: list[Block] = []
    for record in records:
        content += _of_one(result, record, f"{record.unit}: " if len(records) > 1 else "")
    return [*content, *map(draw_chart, charts_over_time(result))]


def _of_one(result: Result, record: BearingRecord, who: str) -> list[Block]:
    analysis = result.scene.analysis_as(BearingKeys)
    begin = float(result.time[after_transient(result).start])
    points = section_points(result, record, begin)
    content: list[Block] = [draw_chart(history_chart(record, begin, who))]
    content.append(draw_chart(spectrum_chart(record, begin, analysis, who)))
    envelope = envelope_chart(record, begin, analysis, who)
    content += [draw_chart(envelope)] if envelope is not None else []
    content.append(draw_chart(orbit_chart(record, begin, points, who)))
    recurrence = quantified(record, begin, analysis)
    content.append(draw_chart(recurrence_chart(recurrence, record, who)))
    content += [recurrence_table(recurrence, record, who), motion_table(record, begin, points, who)]
    return content


def history_chart(record: BearingRecord, begin: float, who: str = "") -> Chart:
    """Displacement, velocity, acceleration and the largest ball load over the whole run."""
    scales = Scales(record)
    mark = ((begin, ""),) if begin > record.time[0] else ()
    panels = []
    for what in HISTORY:
        present = [n for n in (f"{what}_x", f"{what}_y") if n in record.signals]
        if present:
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
        text += f"; a ball passes a place of the outer race with {record.frequencies['outer']:.4g}{hertz}, {record.basis}"
    return text + "."


def section_points(result: Result, record: BearingRecord, begin: float) -> dict[str, np.ndarray]:
    """Signals (k,) at the instants of the section: the scene's, else each ball's passing, else each turn.

    Where no angle was recorded: where the velocity along x rises through zero, the turning points of x. Empty without it, too.
    """
    kept = since(record.time, begin)
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
    kept, columns = since(record.time, begin), []
    for kind in ("displacement", "velocity"):
        names = [n for n in points if n.startswith(kind)]
        reach = max((float(np.ptp(record.signals[n][kept])) for n in names), default=0.0) or 1.0
        columns += [points[n] / reach for n in names]
    return distinct(np.stack(columns, axis=1), SAME)


def orbit_chart(record: BearingRecord, begin: float, points: dict[str, np.ndarray], who: str = "") -> Chart:
    """Orbit and phase planes over the last passings, with the section's points of the whole steady part."""
    scales, kept = Scales(record), since(record.time, begin)
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
    scales, kept = Scales(record), since(record.time, begin)
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


def families(record: BearingRecord, keys: BearingKeys) -> list[Family]:
    """Lines to look for: those the scene marks, else of what has a defect, the passing of balls and the shaft; of others the first."""
    if not record.frequencies:
        return []
    whole: tuple[str, ...] = keys.marks or tuple(dict.fromkeys([*record.defects, "outer", "shaft"]))
    f, turn = record.frequencies, abs(record.rotation)
    known = {
        "outer": Family(NAMES["outer"], f["outer"], 5),
        "inner": Family(NAMES["inner"], f["inner"], 3, turn, 2),
        "ball": Family(NAMES["ball"], 2.0 * f["ball"], 3, f["cage"], 2),
        "cage": Family(NAMES["cage"], f["cage"], 2),
        "shaft": Family(NAMES["shaft"], turn, 3),
    }
    rest = [replace(one, harmonics=1, sidebands=0) for name, one in known.items() if name not in whole]
    return [*(known[name] for name in whole), *rest]


def marked(line_families: list[Family], highest: float) -> tuple[Lines, ...]:
    """The families as lines of a chart: the fundamental carries the short name, harmonics their order."""
    marks = []
    for family in line_families:
        short = family.name.partition("(")[2].rstrip(")") or family.name
        lines = family.lines(highest)
        at = tuple((x.frequency, "" if x.side else (short if x.order == 1 else f"{x.order}×")) for x in lines)
        if at:
            marks.append(Lines(family.name, at))
    return tuple(marks)


def spectrum_chart(record: BearingRecord, begin: float, keys: BearingKeys, who: str = "") -> Chart:
    """Amplitude spectra of displacement and acceleration after the transient."""
    scales, kept = Scales(record), since(record.time, begin)
    line_families = families(record, keys)
    highest = 0.5 * record.rate
    if record.frequencies:
        highest = min(highest, SHOWN_HARMONICS * record.frequencies["outer"])
    highest = min(0.5 * record.rate, keys.highest_frequency or highest)
    panels = []
    for what in ("displacement", "acceleration"):
        series, top = [], 0.0
        for n in (f"{what}_x", f"{what}_y"):
            if n in record.signals:
                f, a = amplitude_spectrum(scales.factor(n) * record.signals[n][kept], record.rate)
                shown = (f > 0.0) & (f <= highest)
                series.append(Series(n[-1], f[shown], a[shown]))
                top = max(top, float(a[shown].max(initial=0.0)))
        if series:
            ends = (top * 10.0**-DECADES, top * 10.0**0.7) if top > 0.0 else None
            label = f"{what}, {scales.unit(f'{what}_x')}"
            lines = marked(line_families, highest)
            panels.append(Panel(label, tuple(series), lines=lines, logarithmic=True, x_range=(0.0, highest), y_range=ends))
    text = "Amplitudes: mean removed, Hann window, single-sided, a sine of amplitude A reads A."
    return Chart(f"{who}Amplitude spectrum", scales.frequency, tuple(panels), text + _strongest(record, begin, line_families))


def _strongest(record: BearingRecord, begin: float, line_families: list[Family]) -> str:
    """The expected and the measured place of the first family's line, a sentence."""
    name = "acceleration_x" if "acceleration_x" in record.signals else "displacement_x"
    x = record.signals[name][since(record.time, begin)]
    f, a = amplitude_spectrum(x, record.rate)
    if not line_families or line_families[0].frequency >= 0.45 * record.rate or not a.any():
        return ""
    scales = Scales(record)
    expected = line_families[0].frequency
    at, height = peak(f, a, expected, max(0.02 * expected, 2.5 * f[1]))
    signal, unit = name.replace("_", " "), f" {scales.unit(name)}" if scales.dimensional else ""
    return (
        f" The {line_families[0].name} is expected at {expected:.5g}{scales.hertz}; the highest line of {signal} thereabouts "
        f"is at {at:.5g}{scales.hertz}, {scales.factor(name) * height:.3g}{unit}."
    )


def envelope_chart(record: BearingRecord, begin: float, keys: BearingKeys, who: str = "") -> Chart | None:
    """Spectrum of the envelope of the acceleration in a band of resonance; None where the record holds no such band."""
    name = next((n for n in ("acceleration_x", "displacement_x") if n in record.signals), "")
    if not name or not record.frequencies:
        return None
    scales, x = Scales(record), record.signals[name][since(record.time, begin)]
    top = max(record.frequencies["inner"], 2.0 * record.frequencies["ball"])
    band = keys.envelope_band
    if band is None:
        bounds = LOWEST_BAND * top, min(HIGHEST_BAND * top, UNFOLDED * record.rate)
        if bounds[0] > 0.5 * bounds[1] or not np.ptp(x) > 0.0:
            return None
        band = resonance_band(x, record.rate, *bounds)
    low, high = (float(v) for v in band)
    f, a = envelope_spectrum(scales.factor(name) * x, record.rate, low, high)
    highest = SHOWN_ENVELOPE * top
    shown = (f > 0.0) & (f <= highest)
    line_families = families(record, keys)
    series = (Series("envelope", f[shown], a[shown]),)
    panel = Panel(f"envelope of {name.replace('_', ' ')}, {scales.unit(name)}", series, lines=marked(line_families, highest),
                  x_range=(0.0, highest))  # fmt: skip
    chosen = "given" if keys.envelope_band is not None else "the most impulsive of the signal (kurtogram)"
    text = (
        f"Envelope of the band {low:.4g} to {high:.4g}{scales.hertz}, {chosen}. What hits a resonance again and again shows here "
        "with the frequency of its repetition; sidebands: how its strength varies as it turns through the loaded zone."
    )
    return Chart(f"{who}Envelope spectrum", scales.frequency, (panel,), text, height=300)


def quantified(record: BearingRecord, begin: float, keys: BearingKeys) -> Recurrence:
    """Recurrence of displacements and velocities, standardised, over the last states of the run."""
    settings = keys.recurrence or RecurrenceKeys()
    names = tuple(n for n in record.signals if n.startswith(("displacement", "velocity")))
    wished = 1.0 / (PER_PASSING * record.frequencies["outer"]) if record.frequencies else 0.0
    every = max(1, round((wished if settings.interval is None else settings.interval) * record.rate))
    states = np.stack([record.signals[n][since(record.time, begin)] for n in names], axis=1)
    states = states[::-every][:STATES][::-1]  # the last ones
    threshold, theiler = settings.threshold, settings.theiler
    matrix = recurrence_matrix(standardised(states), threshold)
    interval = every / record.rate
    start = float(record.time[-1]) - interval * (len(states) - 1)
    return Recurrence(matrix, quantify(matrix, theiler=theiler), interval, start, threshold, theiler, names)


def recurrence_chart(recurrence: Recurrence, record: BearingRecord, who: str = "") -> Chart:
    """The recurrence plot, and how many of its diagonal lines have at least a length."""
    scales, n = Scales(record), min(len(recurrence.matrix), DRAWN)
    t = recurrence.begin + recurrence.interval * np.arange(n)
    plot = Panel(scales.time, (), picture=Picture(t, t, recurrence.matrix[:n, :n], palette="binary"), title="Recurrence plot",
                 x_label=scales.time, equal=True)  # fmt: skip
    survival = line_survival(recurrence.matrix, recurrence.theiler)
    panels = [plot]
    if survival.size > 1:
        lengths = recurrence.interval * np.arange(1, survival.size + 1)
        unit = "s" if scales.dimensional else "1"
        line = Series("diagonal lines", lengths, survival)
        panels.append(Panel("number of at least that length", (line,), title="Lengths of the diagonal lines",
                            x_label=f"length, {unit}", logarithmic=True))  # fmt: skip
    coordinates = ", ".join(c.replace("_", " ") for c in recurrence.coordinates)
    text = (
        f"Dark: the states at the two times are at most {recurrence.threshold:g} σ apart ({coordinates}, each over its standard "
        f"deviation σ; Euclidean distance). The first {n} of {len(recurrence.matrix)} states. Long diagonals: the motion "
        "repeats; broken ones: it diverges. Their number falls exponentially, as a straight line here, where the motion is "
        "chaotic."
    )
    return Chart(f"{who}Recurrence", "", tuple(panels), text, columns=2, height=440)


def recurrence_table(recurrence: Recurrence, record: BearingRecord, who: str = "") -> Cells:
    """The measures with the settings they depend on."""
    q, dt = recurrence.measures, recurrence.interval
    unit = "s" if Scales(record).dimensional else "1"
    rows = [
        ("recurrence rate", "RR", number(100.0 * q.rate), "%"),
        ("determinism", "DET", number(100.0 * q.determinism), "%"),
        ("mean length of diagonal lines", "L", number(dt * q.mean_diagonal), unit),
        ("longest diagonal line", "Lmax", number(dt * q.longest_diagonal), unit),
        ("divergence, 1 / Lmax", "DIV", number(q.divergence / dt), f"1/{unit}" if unit != "1" else "1"),
        ("entropy of diagonal lines", "ENTR", number(q.entropy), "nat"),
        ("laminarity", "LAM", number(100.0 * q.laminarity), "%"),
        ("trapping time", "TT", number(dt * q.trapping_time), unit),
    ]
    text = (
        f"{len(recurrence.matrix)} states every {dt:.4g}{' s' if unit == 's' else ''}, threshold {recurrence.threshold:g} σ, "
        f"lines of two points or more, Theiler window {recurrence.theiler}. The measures depend on all of these: compare "
        "only what has the same."
    )
    return Cells(f"{who}Measures of recurrence", ("measure", "", "value", "unit"), rows, text, frozenset({2}))


def charts_over_time(result: Result) -> Iterator[Chart]:
    """Recorded temperatures with clearances and powers, and slip of cages with what drives them, over time."""
    for title, (groups, text) in OVER_TIME.items():
        panels = _over_time(result, groups)
        if panels and panels[0].y_label == groups[0][1]:
            yield Chart(title, "time, s", panels, text)


def _over_time(result: Result, groups: Sequence[tuple[str, str, float, float]]) -> tuple[Panel, ...]:
    """The recorded signals of each group, by the endings of their names."""
    named = ((label, [n for n in result.columns if n.endswith(ending)], by, plus) for ending, label, by, plus in groups)
    return filled(
        (label, [Series(n.replace("_", " "), result.time, by * np.asarray(result.columns[n], dtype=float) + plus) for n in names])
        for label, names, by, plus in named
    )
