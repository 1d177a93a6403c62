"""Runs beside one another: which settings, figures and signals differ, by how much, and whether that is more than their errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np

from ...components.core.errors import BadInput
from ..judgement.warnings import doubts_of
from ..run.comparison import differences
from ..run.results import Result
from ..run.run_info import flattened
from ..run.run_record import RunRecord
from .charts.blocks import Answer, Block, Cells, Text
from .charts.chart import Chart, Panel, Series
from .charts.charts import draw_chart
from .charts.style import number
from .preferred_units import preferred
from .report.page import Page, Section, write_page
from .summary import SummaryTable, with_error

MOST_PANELS = 8  # signals that are drawn: those that differ most
MOST_NUMBERS = 4  # of the answer at the top
NOT_SETTINGS = ("name", "title", "sweep", "study", "explore")
ABSENT = "–"
UNSET = ("None", "none")  # texts of a setting that is not given


@dataclass(frozen=True)
class FigureDifference:
    """A figure of several runs. values, errors: (n,) in its unit, NaN where a run does not have it, or the error is not known."""

    name: str
    unit: str
    text: str
    values: np.ndarray
    errors: np.ndarray
    part: bool = False  # of what is judged as a whole only: no answer

    @property
    def difference(self) -> float:
        """The largest difference from the first run; NaN where only one has the figure."""
        gaps = np.abs(self.values[1:] - self.values[0])
        return float(np.nanmax(gaps)) if np.isfinite(gaps).any() else nan

    @property
    def share(self) -> float:
        """The same over the largest size of the figure; 0 where all are 0."""
        size = float(np.abs(self.values[np.isfinite(self.values)]).max(initial=0.0))
        return self.difference / size if size else 0.0 * self.difference

    @property
    def within_errors(self) -> bool:
        """Whether the numerical errors of the runs, those that are known, are as large as their differences."""
        known = np.nan_to_num(self.errors)
        return bool(np.all(np.abs(self.values[1:] - self.values[0]) <= known[1:] + known[0]))

    @property
    def measure(self) -> str:
        """The unit in which a person reads the numbers."""
        return self._for_reader()[0]

    def _for_reader(self) -> tuple[str, float]:
        return preferred(self.unit, float(np.abs(self.values[np.isfinite(self.values)]).max(initial=0.0)), self.name)

    def shown(self, k: int) -> str:
        """The number of a run with its error, in `measure`."""
        factor = self._for_reader()[1]
        return with_error(factor * float(self.values[k]), factor * float(self.errors[k])) if isfinite(self.values[k]) else ABSENT

    def to_json(self) -> dict[str, Any]:
        """A row of compare.json; numbers that are not known are null."""
        numbers = {"values": self.values.tolist(), "errors": self.errors.tolist()}
        known = {key: [v if isfinite(v) else None for v in values] for key, values in numbers.items()}
        ends = {"difference": self.difference, "share": self.share}
        return (
            {"unit": self.unit, "text": self.text}
            | known
            | {k: v if isfinite(v) else None for k, v in ends.items()}
            | {"within errors": self.within_errors}
        )


@dataclass(frozen=True)
class SignalDifference:
    """A recorded signal of several runs: differences from the first, (n - 1,) each, in parts of the signal's deviation."""

    name: str
    unit: str
    rms: np.ndarray
    largest: np.ndarray

    @property
    def share(self) -> float:
        """The largest rms difference."""
        return float(self.rms.max())

    def to_json(self) -> dict[str, Any]:
        """A row of compare.json."""
        return {"unit": self.unit, "rms": self.rms.tolist(), "max": self.largest.tolist()}


@dataclass(frozen=True)
class Comparison:
    """Several runs beside the first.

    names: of the runs, all different.  figures, signals: those that differ most first; signals are those that all runs have, over
    the time that all have.  settings: name -> its text in each run, of settings and parameters that are not the same.
    missing: signals that some run has not.  seconds: CPU time for stepping of each run, s.
    """

    names: tuple[str, ...]
    results: tuple[Result, ...]
    figures: tuple[FigureDifference, ...]
    signals: tuple[SignalDifference, ...]
    settings: Mapping[str, tuple[str, ...]]
    missing: tuple[str, ...]
    seconds: tuple[float, ...]

    def beyond(self, within: float, signals: Sequence[str] = ()) -> list[str]:
        """What differs by more than this share, as sentences: figures, and these signals; without figures all signals. Figures
        that only some of the runs have, and runs that did not come to their end, count as different. Raises `BadInput`."""
        known = {signal.name: signal for signal in self.signals}
        for name in signals:
            if name not in known:
                raise BadInput("--signal", repr(name), "a recorded signal of all runs: " + (", ".join(known) or "there is none"))
        texts = [f"{n}: {r.outcome}" for n, r in zip(self.names, self.results, strict=True) if r.outcome != "done"]
        for one in self.figures:
            if not isfinite(one.share) or np.isnan(one.values).any():
                texts.append(f"{one.name}: only some runs have it")
            elif one.share > within:
                texts.append(f"{one.name} by {100.0 * one.share:.2g} %")
        wanted = [known[name] for name in signals] if signals or self.figures else self.signals
        return texts + [f"{s.name} by {100.0 * s.share:.2g} % of its deviation" for s in wanted if not s.share <= within]

    def undecided(self, within: float) -> list[str]:
        """Figures of which the numerical errors, those that are known, leave open whether they differ by more than this share."""
        return [
            one.name
            for one in self.figures
            if abs(one.difference - within * float(np.nanmax(np.abs(one.values)))) < np.sort(np.nan_to_num(one.errors))[-2:].sum()
        ]

    def to_json(self) -> dict[str, Any]:
        """What compare.json holds."""
        return {
            "runs": [
                {"name": n, "outcome": r.outcome, "cpu": s, "warnings": doubts_of(r.info)}
                for n, r, s in zip(self.names, self.results, self.seconds, strict=True)
            ],
            "settings": {place: list(texts) for place, texts in self.settings.items()},
            "figures": {one.name: one.to_json() for one in self.figures},
            "signals": {one.name: one.to_json() for one in self.signals},
            "missing signals": list(self.missing),
        }

    def warnings(self) -> list[str]:
        """What keeps a run from being a sure result, as sentences: runs that are not done, or not verified, and what they warn of."""
        return [f"{n}: {text}" for n, r in zip(self.names, self.results, strict=True) for text in doubts_of(r.info)]

    def different_signals(self) -> list[SignalDifference]:
        """Signals that are not the same in all runs."""
        return [one for one in self.signals if one.share]

    def setting_cells(self) -> Cells:
        """Settings and parameters that are not the same in all runs."""
        rows = [(name, *own_lines(texts)) for name, texts in self.settings.items()]
        return Cells("Changed settings", ("setting", *self.names), rows, "" if rows else "All settings are the same.")

    def figure_cells(self) -> Cells:
        """All key results."""
        count = len(self.names)
        rows = [
            (
                one.name,
                one.measure,
                *(one.shown(k) for k in range(count)),
                f"{number(100.0 * one.share)} %" if isfinite(one.share) else ABSENT,
                "the errors are as large" if one.within_errors and one.share else "",
            )
            for one in self.figures
        ]
        caption = "The difference is the largest from the first run, as a share of the result's size; ± are the numerical errors."
        header = ("name", "unit", *self.names, "difference", "")
        return Cells("All key results", header, rows, caption, frozenset(range(2, count + 3)))

    def signal_cells(self, most: int | None = None) -> Cells:
        """Signals that differ, or so many of those that differ most."""
        different = self.different_signals()
        others = self.names[1:]
        rows = [
            (one.name, *(f"{number(100.0 * x)} %" for pair in zip(one.rms, one.largest, strict=True) for x in pair))
            for one in different[:most]
        ]
        header = ("signal", *(f"{name}, {kind}" for name in others for kind in ("rms", "largest")))
        caption = f"Difference from {self.names[0]}, as a share of the signal's standard deviation, over the common time span."
        if not rows:
            caption = "All signals are the same."
        elif left := len(different) - len(rows):
            caption += f" {left} more signals differ."
        elif same := len(self.signals) - len(different):
            caption += f" {same} signals are the same."
        if self.missing:
            caption += f" Recorded by some runs only: {', '.join(self.missing)}."
        return Cells("Differences of signals", header, rows, caption, frozenset(range(1, 2 * len(others) + 1)))

    def costs(self) -> str:
        """CPU time for stepping, as a sentence; "" where no run has it."""
        costs = "; ".join(f"{n}: {number(s)} s" for n, s in zip(self.names, self.seconds, strict=True) if isfinite(s))
        return f"CPU time of the steps: {costs}." if costs else ""

    def report(self, directory: str | Path) -> Path:
        """Write report.html to the directory; returns its path."""
        return _write(self, Path(directory))

    def __repr__(self) -> str:
        return "\n".join(
            [f"<Comparison of {', '.join(self.names)}>"]
            + [f"{place}: {' | '.join(texts)}" for place, texts in self.settings.items()]
            + [
                f"{one.name}: {' | '.join(one.shown(k) for k in range(len(self.names)))} {one.measure}".rstrip()
                for one in self.figures
            ]
            + [f"warning: {text}" for text in self.warnings()]
        )


def compared(results: Sequence[Result], names: Sequence[str]) -> Comparison:
    """The runs beside the first; raises `BadInput` for fewer than two, or for runs that have nothing in common."""
    if len(results) < 2:
        raise BadInput("compare", f"{len(results)} run", "at least two")
    common = [n for n in results[0].columns if all(n in other.columns for other in results[1:])]
    every = dict.fromkeys(n for result in results for n in result.columns)
    tables = [result.summary if result.rows > 1 else SummaryTable() for result in results]
    figures = _figures(tables)
    if not common and not any(isfinite(one.share) for one in figures):
        raise BadInput(
            "compare", "The runs have no common signal and no common key result. Compare runs of the same or a similar scene.", ""
        )
    return Comparison(
        _different(names),
        tuple(results),
        tuple(sorted(figures, key=lambda one: (one.part, -one.share if isfinite(one.share) else -1.0))),
        _signals(results, common),
        _settings(results),
        tuple(n for n in every if n not in common),
        tuple(float(result.info.timing.cpu if result.info.timing else nan) for result in results),
    )


def _different(names: Sequence[str]) -> tuple[str, ...]:
    """Names of which none is twice."""
    return tuple(n if names.count(n) == 1 else f"{n} ({names[: k + 1].count(n)})" for k, n in enumerate(names))


def _figures(tables: Sequence[SummaryTable]) -> list[FigureDifference]:
    """Figures of any of the runs, in the order of the first."""
    rows = [{row.name: row for row in table} for table in tables]
    first = {name: row for of_run in reversed(rows) for name, row in of_run.items()}
    order = dict.fromkeys(name for of_run in rows for name in of_run)
    return [
        FigureDifference(
            name,
            first[name].unit,
            first[name].text,
            np.array([of_run[name].value if name in of_run else nan for of_run in rows]),
            np.array([of_run[name].error if name in of_run else nan for of_run in rows]),
            first[name].part,
        )
        for name in order
    ]


def _signals(results: Sequence[Result], names: Sequence[str]) -> tuple[SignalDifference, ...]:
    """Differences of these signals from the first run, over the time that both have."""
    if not names or any(result.rows < 2 for result in results):
        return ()
    first, parts = results[0], []
    for other in results[1:]:
        kept = _shared(first, other)
        if not kept.any():
            return ()
        here = replace(first, time=first.time[kept], columns={n: first.columns[n][kept] for n in names}, texts={})
        parts.append(differences(here, replace(other, columns={n: other.columns[n] for n in names}, texts={})))
    rows = [
        SignalDifference(
            name,
            first.measures.get(name, ""),
            np.array([part[name].rms for part in parts]),
            np.array([part[name].largest for part in parts]),
        )
        for name in names
    ]
    return tuple(sorted(rows, key=lambda row: -row.share))


def _shared(first: Result, other: Result) -> np.ndarray:
    """Rows of the first run at whose times the other one has been, (n,) truth values."""
    near = 1e-12 * float(np.abs(other.time[[0, -1]]).max())
    return (first.time >= other.time[0] - near) & (first.time <= other.time[-1] + near)


def own_lines(texts: Sequence[str]) -> tuple[str, ...]:
    """Texts as they are; of tables, which have several lines, the lines that are not in all of them."""
    if not any("\n" in text for text in texts):
        return tuple(texts)
    lines = [text.splitlines() for text in texts]
    common = set.intersection(*map(set, lines))
    return tuple(" / ".join(line for line in each if line not in common) or "nothing else" for each in lines)


def _settings(results: Sequence[Result]) -> dict[str, tuple[str, ...]]:
    """Settings of the scenes, and parameters of the units, that are not the same in all runs."""
    tables = [_flat(result.info) for result in results]
    places = dict.fromkeys(place for table in tables for place in table)
    texts = {place: tuple(table.get(place, ABSENT) for table in tables) for place in places}
    return {place: values for place, values in texts.items() if len(set(values)) > 1 and not set(values) <= {ABSENT, *UNSET}}


def _flat(info: RunRecord) -> dict[str, str]:
    """Settings by their names: those of the scene, effects that are on, and of every unit the parameters that the run had."""
    scene = {key: value for key, value in info.scene.items() if key not in (*NOT_SETTINGS, "units")}
    units, parameters = {}, {}
    for name, unit in info.scene.get("units", {}).items():
        units[name] = {key: value for key, value in unit.items() if key not in ("parameters", "effects", "preset") and value}
        units[name]["effects"] = sorted(info.effects[name].on if name in info.effects else unit.get("effects", ()))
        parameters[name] = info.units[name].parameters if name in info.units else unit.get("parameters", {})
    return dict(flattened(scene)) | dict(flattened({"units": units})) | dict(flattened(parameters))


def _write(comparison: Comparison, directory: Path) -> Path:
    """report.html of a comparison."""
    names = comparison.names
    sections = [Section("Answer", [*_answer(comparison), comparison.setting_cells()])]
    if comparison.figures:
        sections.append(Section("Figures", [comparison.figure_cells()]))
    if comparison.signals:
        sections.append(Section("Signals", [*_charts(comparison), comparison.signal_cells()]))
    title = f"{names[0]} beside {', '.join(names[1:])}"
    return write_page(Page(title, comparison.costs(), sections), directory / "report.html")


def _answer(comparison: Comparison) -> list[Block]:
    """The figures that differ most beyond their errors, and what keeps runs from being sure results."""
    doubts = comparison.warnings()
    blocks: list[Block] = [Text(doubts, "warning")] if doubts else []
    apart = [one for one in comparison.figures if isfinite(one.share) and one.share and not (one.within_errors or one.part)][
        :MOST_NUMBERS
    ]
    if apart:
        return [*blocks, Answer([(f"{number(100.0 * one.share)} %", f"{_what(one)}: {_ends(one)}", "") for one in apart])]
    if comparison.figures:
        return [*blocks, Text(["No figure differs by more than its numerical error."], "note")]
    return blocks


def _what(one: FigureDifference) -> str:
    return one.text or one.name


def _ends(one: FigureDifference) -> str:
    """The first number and the one that is farthest from it."""
    k = 1 + int(np.nanargmax(np.abs(one.values[1:] - one.values[0])))
    return f"{one.shown(0)} and {one.shown(k)} {one.measure}".rstrip()


def _charts(comparison: Comparison) -> list[Block]:
    """Signals over one another, and their differences from the first run."""
    different = comparison.different_signals()
    if not (shown := different[:MOST_PANELS]):
        return []
    runs = list(zip(comparison.names, comparison.results, strict=True))
    first = runs[0][1]
    over, apart = [], []
    for one in shown:
        label = f"{one.name.rpartition('.')[2].replace('_', ' ')}{f', {one.unit}' if one.unit not in ('', '1') else ''}"
        lines = tuple(Series(name, run.time, np.asarray(run.columns[one.name], dtype=float)) for name, run in runs)
        gaps = []
        for name, run in runs[1:]:
            kept = _shared(first, run)
            t = first.time[kept]
            gaps.append(Series(name, t, np.interp(t, run.time, run.columns[one.name]) - first.columns[one.name][kept]))
        over.append(Panel(label, lines, title=one.name))
        apart.append(Panel(label, tuple(gaps), title=one.name))
    left = len(different) - len(shown)
    text = f"The {len(shown)} signals that differ most; {left} more are in the table." if left > 0 else ""
    charts = (
        Chart("Signals over one another", "time, s", tuple(over), text),
        Chart(f"Differences from {comparison.names[0]}", "time, s", tuple(apart)),
    )
    return [draw_chart(chart) for chart in charts]
