"""The figures of a run in numbers: what a user of its system asks first."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any


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


def rows(unit: str, values: Mapping[str, float | None], texts: Mapping[str, tuple[str, str]]) -> Iterable[SummaryRow]:
    """Rows of a unit of a scene for the values that there are. texts: quantity -> (unit of measure, what it is)."""
    return (SummaryRow(f"{unit}.{name}", float(value), *texts[name]) for name, value in values.items() if value is not None)


def to_json(summary: Summary) -> dict[str, Any]:
    """The object of summary.json, by the rows' names."""
    return {row.name: row.to_json() for row in summary}
