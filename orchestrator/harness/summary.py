"""The figures of a run in numbers: what a user of its system asks first."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from html import escape
from math import isfinite
from typing import Any

from ...components.core.errors import BadInput, nearest


@dataclass(frozen=True)
class SummaryRow:
    """One number of a run. name: "unit.quantity", unique in a run.  text: what it is, with how it was made where that matters."""

    name: str
    value: float
    unit: str
    text: str

    def to_json(self) -> dict[str, Any]:
        """The row of summary.json; a number that is not finite is null."""
        return {"value": self.value if isfinite(self.value) else None, "unit": self.unit, "text": self.text}


Summary = tuple[SummaryRow, ...]
PACING = {"duration": "duration of a step, without its wait", "lateness": "behind the clock at the end of a step"}


class SummaryTable(Summary):
    """The rows of a run, which a terminal and a notebook show as a table."""

    def value(self, name: str) -> float:
        """The number of that name; raises `BadInput` with the near names."""
        for row in self:
            if row.name == name:
                return row.value
        raise BadInput("summary", repr(name), "a quantity of the run", nearest(name, [row.name for row in self]))

    def __repr__(self) -> str:
        width = max((len(row.name) for row in self), default=0)
        return "\n".join(f"{row.name:{width}}  {row.value:.6g} {row.unit if row.unit != '1' else ''}".rstrip() for row in self)

    def _repr_html_(self) -> str:
        cells = "".join(f"<tr><td>{escape(r.name)}<td>{r.value:.6g}<td>{escape(r.unit)}<td>{escape(r.text)}" for r in self)
        return f"<table><tr><th>quantity<th>value<th>unit<th>{cells}</table>"


def rows(unit: str, values: Mapping[str, float | None], texts: Mapping[str, tuple[str, str]]) -> Iterable[SummaryRow]:
    """Rows of a unit of a scene for the values that there are. texts: quantity -> (unit of measure, what it is)."""
    return (SummaryRow(f"{unit}.{name}", float(value), *texts[name]) for name, value in values.items() if value is not None)


def pacing_rows(info: Mapping[str, Any]) -> Summary:
    """How punctual a run at the pace of the clock was; none of another run. info: of the result."""
    of = info.get("real_time")
    if not of:
        return ()
    counts = {"steps": "macro steps at the pace of the clock", "late": "of these ended behind the clock"}
    of_steps = [SummaryRow(f"real_time.{name}", float(of[name]), "1", text) for name, text in counts.items()]
    ends = (("50 %", "median", "median"), ("99 %", "p99", "99 % are below"), ("100 %", "max", "longest"))
    return (*of_steps, *(SummaryRow(f"real_time.{name}_{end}", 1e3 * of[name][p], "ms", f"{text}: {what}")
                         for name, text in PACING.items() for p, end, what in ends))


def to_json(summary: Summary) -> dict[str, Any]:
    """The object of summary.json, by the rows' names."""
    return {row.name: row.to_json() for row in summary}
