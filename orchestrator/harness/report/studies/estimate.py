"""The page of `cosimo estimate`: the verdict, parameters over time, measurements with bands, innovations."""

from __future__ import annotations

from math import isfinite
from pathlib import Path

import numpy as np

from ....estimation.answer import REACH, Estimate, Parameter, shown
from ...charts.blocks import Answer, Block, Cells, Figure, Text
from ...charts.chart import Band, Chart, Panel, Series
from ...charts.charts import draw_chart
from ..page import Page, Section, write_page

MOST = 12  # of states, and of suspected numbers, that are drawn or listed


def for_estimate(study: Estimate, directory: str | Path) -> Path:
    """`report.html` of an estimate."""
    verdict = study.verdict
    word = "explained" if verdict.explains else "not explained"
    numbers = [(word, "the measurement, by the model", "")]
    numbers += [
        (f"{shown(p.value, p.deviation)} {'' if p.unit == '1' else p.unit}".strip(), f"{p.name}, ± standard deviation", "")
        for p in study.parameters[:4]
    ]
    first: list[Block] = [Answer(numbers), Text([str(verdict)], "" if verdict.explains else "warning")]
    if notes := [*study.observability.texts, *verdict.remarks]:
        first.append(Text([f"{t[0].upper()}{t[1:]}." for t in notes], "note"))
    sections = [Section("Verdict", [*first, check_cells(study), *([suspect_cells(study)] if verdict.suspects else [])])]
    if study.parameters:
        sections.append(Section("Parameters", [parameter_cells(study), _walks(study)]))
    if study.figures:
        sections.append(Section("Key results", [figure_cells(study)]))
    sections.append(Section("Measurements", [_measured(study), _innovations(study)]))
    sections.append(Section("States", [_states(study)]))
    beside = "" if study.steps is None else " and, beyond, the numerical error"
    lead = f"{len(study.innovations.which)} measurements, {study.how}. Bands hold 95 %{beside}."
    return write_page(Page(study.scene.title or study.scene.name, lead, sections), Path(directory) / "report.html")


def parameter_cells(study: Estimate) -> Cells:
    """Parameters and inputs as a table."""
    header = ("parameter", "unit", "estimate ± standard deviation", "95 %", "numerical error", "expected before")

    def row(p: Parameter) -> tuple[str, ...]:
        numerical = f"{p.error:.2g}" if isfinite(p.error) else "–"
        before = f"{p.before:.6g} ± {p.before_deviation:.2g}"
        return p.name, p.unit, shown(p.value, p.deviation), f"{p.low:.5g} … {p.high:.5g}", numerical, before

    return Cells("Parameters at the end", header, [row(p) for p in study.parameters], right=frozenset({2, 3, 4, 5}))


def figure_cells(study: Estimate) -> Cells:
    """Figures of the scene with their bands as a table."""
    header = ("figure", "unit", "estimate ± standard deviation", "95 %", "numerical error")
    rows = [
        (
            f.name,
            f.unit,
            shown(f.value, f.deviation),
            f"{f.low:.5g} … {f.high:.5g}",
            f"{f.error:.2g}" if isfinite(f.error) else "–",
        )
        for f in study.figures
    ]
    text = (
        "Over the time that was measured, of paths that measurements leave possible: state, parameters and disturbances together."
    )
    return Cells("Key results", header, rows, text, right=frozenset({2, 3, 4}))


def check_cells(study: Estimate) -> Cells:
    """Tests of the innovations as a table."""
    rows = [(c.name, "holds" if c.holds else "DOES NOT HOLD", f"{c.p:.2g}", c.words) for c in study.verdict.checks]
    text = "Probability: that a model which is right is so far off. All tests together reject such a model in 1 % of cases."
    return Cells("Tests", ("test", "outcome", "probability", "largest deviation"), rows, text, right=frozenset({2}))


def suspect_cells(study: Estimate) -> Cells:
    """Numbers that were doubted, those first that would explain more."""
    header = ("number", "now", "estimate ± standard deviation", "unit", "better by, log units")
    rows = [(s.name, f"{s.at:.6g}", shown(s.value, s.deviation), s.unit, f"{s.gain:.3g}") for s in study.verdict.suspects[:MOST]]
    text = (
        "What the measurement says of numbers that were taken as known, one by one. An error that is small against its standard "
        "deviation here stays unnoticed. A number that would leave its limits stands at the limit."
    )
    return Cells("Would another value explain it better?", header, rows, text, right=frozenset({1, 2, 4}), folded=study.explains)


def _band(label: str, x: np.ndarray, value: np.ndarray, low: np.ndarray, high: np.ndarray, *more: Series) -> Panel:
    ends = (Series("95 %", x, low, faint=True), Series("95 %", x, high, faint=True))
    return Panel(label, (*more, Series("estimate", x, value), *ends))


def _walks(study: Estimate) -> Figure:
    panels = []
    for p in study.parameters:
        value, low, high = study.walk(p.name)
        panels.append(_band(f"{p.name}, {p.unit}", study.time, value, low, high))
    text = "A constant by the measurements up to each time; what walks by all of them, if smoothed."
    return draw_chart(Chart("Parameters over time", "time, s", tuple(panels), text))


def _measured(study: Estimate) -> Figure:
    i, panels = study.innovations, []
    which, time, values = np.array(i.which), np.array(i.time), np.array(i.measured)
    for k, (name, unit) in enumerate(zip(study.measured.signals, study.measured.units, strict=True)):
        dots = Series("measured", time[which == k], values[which == k], "dots")
        panels.append(_band(f"{name}, {unit}", study.time, *study.band(name), dots))
    noise = "; ".join(
        f"{n}: {s:.3g} {u}{' (estimated)' if np.isnan(g) else ''}"
        for n, s, u, g in zip(study.measured.signals, study.noise, study.measured.units, study.measured.noise, strict=True)
    )
    return draw_chart(
        Chart(
            "Measurements",
            "time, s",
            tuple(panels),
            f"Standard deviation of the noise: {noise}. The band is that of the signal, without noise.",
        )
    )


def _innovations(study: Estimate) -> Figure:
    i, panels = study.innovations, []
    which, time, e = np.array(i.which), np.array(i.time), np.array(i.normalised)
    for k, name in enumerate(study.measured.signals):
        dots = Series(name, time[which == k], e[which == k], "dots")
        panels.append(Panel(f"{name}, standard deviations", (dots,), bands=(Band("95 %", -REACH, REACH),)))
    text = (
        "Innovation: measurement less its prediction from what was measured before. A right model leaves white noise of size 1."
    )
    return draw_chart(Chart("Innovations", "time, s", tuple(panels), text))


def _states(study: Estimate) -> Figure:
    panels = []
    for name in [n for n in study.names if n not in study.measured.signals][:MOST]:
        if study.series(name)[1].any():
            unit = study.units[name]
            panels.append(_band(f"{name}, {unit}" if unit else name, study.time, *study.band(name)))
    return draw_chart(Chart("Signals and states that were not measured", "time, s", tuple(panels), "All of them: states.csv."))
