"""Charts from their description as data, see `settings.chart`: the signals of runs, and numbers by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from string import Formatter
from typing import TYPE_CHECKING, Any

import numpy as np

from ....components.core.errors import BadInput, nearest, pick
from ...settings.chart import ChartSettings, LineSettings, PanelSettings, SeriesSettings
from .chart import Band, Chart, Grid, Lines, Panel, Picture, Series

if TYPE_CHECKING:
    from ...run.results import Result
    from ..validation.reference import TableRow

LINE = frozenset(LineSettings.model_fields)


class _Names(Formatter):
    """Texts with {name:.2f}, whose names may have points and brackets."""

    def get_field(self, field_name: str, args: Sequence[Any], kwargs: Mapping[str, Any]) -> tuple[Any, str]:
        return pick(field_name, kwargs, "text of a case", "a number that the case measures"), field_name


def with_numbers(text: str, numbers: Mapping[str, Any]) -> str:
    """A text with numbers in place of {name}, {name:.2f}; raises `BadInput` for a name that is not measured."""
    return _Names().vformat(text, (), numbers) if "{" in text else text


class Described:
    """What charts are drawn of. numbers: name -> what a case measures.  runs: by label.  rows: gives ranges by name."""

    def __init__(
        self, where: str, numbers: Mapping[str, Any], runs: Mapping[str, Result], rows: Callable[[], Mapping[str, TableRow]]
    ):
        self.where, self.numbers, self.runs, self.rows = where, numbers, runs, rows

    def chart(self, chart: ChartSettings) -> Chart | Grid:
        """The chart, or the table; raises `BadInput` for a run, a signal or a name that there is not."""
        title, text = with_numbers(chart.title, self.numbers), with_numbers(chart.text, self.numbers)
        if chart.header:
            rows = self._named(chart.rows) if isinstance(chart.rows, str) else [tuple(map(self._cell, r)) for r in chart.rows]
            return Grid(title, chart.header, tuple(map(tuple, rows)), text)
        panels = tuple(self._panel(panel, _line_settings(chart)) for panel in chart.panels)
        return Chart(title, with_numbers(chart.x_label, self.numbers), panels, text, chart.columns, chart.height)

    def _panel(self, panel: PanelSettings, outer: dict[str, Any]) -> Panel:
        outer = outer | _line_settings(panel)
        bands = (*(Band(b.name, b.low, b.high) for b in panel.bands), *self._limits(panel.limits))
        return Panel(
            panel.label,
            tuple(s for series in panel.series for s in self._series(series.model_copy(update=outer | _line_settings(series)))),
            bands,
            self._places(panel.marks),
            with_numbers(panel.title, self.numbers),
            tuple(Lines(n, self._places(at)) for n, at in panel.lines.items()),
            self._picture(panel),
            panel.x_label,
            panel.equal,
            panel.logarithmic,
            panel.x_range,
            panel.y_range,
        )

    def _series(self, s: SeriesSettings) -> Iterator[Series]:
        name = with_numbers(s.name, self.numbers)
        if s.signal:
            several = not s.run or any(c in s.run for c in "*?[")
            labels = [n for n in self.runs if fnmatchcase(n, s.run or "*")]
            if not labels:
                raise BadInput(self.where, f"run {s.run!r}", "the label of a run", nearest(s.run, self.runs))
            for label in labels:
                shown = name or (label if several and len(labels) > 1 else "")
                yield self.runs[label].series(
                    s.signal,
                    shown,
                    over=s.over,
                    scale=s.scale,
                    over_scale=s.x_scale,
                    since=s.since,
                    until=s.until,
                    every=s.every,
                    kind=s.kind,
                    faint=s.faint,
                )
        elif s.each:
            for name, values in self._named(s.each).items():
                x, y = values if isinstance(values, tuple) else (self._values(s.x), values)
                yield self._points(s, name, x, y)
        else:
            yield self._points(s, name, self._values(s.x), self._values(s.y))

    def _points(self, s: SeriesSettings, name: str, x: Any, y: Any) -> Series:
        x, y = (v if by == 1.0 else by * np.asarray(v) for v, by in ((x, s.x_scale), (y, s.scale)))
        labels = self._named(s.labels) if isinstance(s.labels, str) and s.labels else s.labels
        shades = self._named(s.shades) if s.shades else ()
        return Series(name, x[:: s.every], y[:: s.every], s.kind, s.faint, labels, shades, s.shade_label)

    def _values(self, names: Any) -> Any:
        """What a name stands for, or a list of numbers and names; a pattern stands for all names that it fits."""
        if not isinstance(names, str):
            if all(isinstance(n, str) and n not in self.numbers for n in names):
                return names
            return [self.numbers.get(n, n) if isinstance(n, str) else n for n in names]
        if names not in self.numbers and any(c in names for c in "*?"):
            return [v for n, v in self.numbers.items() if fnmatchcase(n, names)]
        return self._named(names)

    def _cell(self, cell: Any) -> Any:
        """A number by its name, "name:.2f" for its text; else the text itself."""
        if not isinstance(cell, str):
            return cell
        name, _, form = cell.partition(":")
        return format(self.numbers[name], form) if form and name in self.numbers else self.numbers.get(cell, cell)

    def _named(self, name: str) -> Any:
        return pick(name, self.numbers, self.where, "the name of something that the case measures")

    def _limits(self, limits: Mapping[str, str] | tuple[str, ...]) -> Iterator[Band]:
        for name, measure in limits.items() if isinstance(limits, Mapping) else (("", m) for m in limits):
            row = pick(
                measure, self.rows(), self.where, 'the measure of a row, "condition: measure" or "table: condition: measure"'
            )
            yield Band.of(name, row)

    def _places(self, places: str | tuple[tuple[float, str], ...]) -> tuple[tuple[float, str], ...]:
        return tuple(self._named(places) if isinstance(places, str) else places)

    def _picture(self, panel: PanelSettings) -> Picture | None:
        if (p := panel.picture) is None:
            return None
        x, y, values = self._named(p.values)
        return Picture(x, y, values, p.label, p.palette, p.limits)


def _line_settings(settings: LineSettings) -> dict[str, Any]:
    """What the file says of lines, and no default."""
    return {key: getattr(settings, key) for key in settings.model_fields_set & LINE}
