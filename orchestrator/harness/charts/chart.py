"""A chart as plain data: the results of a study, without how they are drawn."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...run.series import Numbers, Series
from ...settings.ranges import Range

__all__ = ["Band", "Chart", "Grid", "Lines", "Numbers", "Panel", "Picture", "Series", "filled"]


@dataclass(frozen=True)
class Lines:
    """Places on the x axis where something of one name is expected: vertical lines through the panel with an entry in the legend.

    at: (position, short text); the text is above the panel where there is room.
    """

    name: str
    at: tuple[tuple[float, str], ...]


@dataclass(frozen=True)
class Picture:
    """Values (len(y), len(x)) over a rectangle. palette: "binary" (0 paper, 1 ink), "rising" (from 0), "range" (from the least
    to the largest), "diverging" (about 0).  limits: values with a line through the places that have them.
    """

    x: Numbers
    y: Numbers
    values: np.ndarray
    label: str = ""  # of the scale
    palette: str = "rising"
    limits: tuple[float, ...] = ()


@dataclass(frozen=True)
class Band(Range):
    """A horizontal range of y, shaded; an end that is None is open. standing: of the range, "" for none."""

    name: str
    low: float | None
    high: float | None
    standing: str = ""

    @classmethod
    def of(cls, name: str, limit: Any) -> Band:
        """That of a range that has a standing."""
        return cls(name, limit.low, limit.high, limit.standing)


@dataclass(frozen=True)
class Panel:
    """One pair of axes. x_marks: thin vertical lines, (position, short text).

    x_label: of a panel with an x axis of its own; without it, the panel shares the chart's.  logarithmic: the y axis.
    equal: one length in both directions is the same length on the page, about a common middle: for orbits.
    y_range, x_range: ends of the axes; without them as the data has it.
    """

    y_label: str
    series: tuple[Series, ...]
    bands: tuple[Band, ...] = ()
    x_marks: tuple[tuple[float, str], ...] = ()
    title: str = ""
    lines: tuple[Lines, ...] = ()
    picture: Picture | None = None
    x_label: str = ""
    equal: bool = False
    logarithmic: bool = False
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None


@dataclass(frozen=True)
class Chart:
    """Panels over one x axis, with a title and the sentence that belongs under it. columns: panels side by side."""

    title: str
    x_label: str
    panels: tuple[Panel, ...]
    text: str = ""
    columns: int = 1
    height: int = 0  # px of one panel, 0: as usual


@dataclass(frozen=True)
class Grid:
    """A table of a study: one header with units, rows of text and numbers."""

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str | float, ...], ...]
    text: str = ""


def filled(parts: Iterable[tuple[str, Iterable[Series]]], **settings: Any) -> tuple[Panel, ...]:
    """Panels of the parts (label, series) that have any series, with the same settings of `Panel` for all."""
    listed = ((label, tuple(series)) for label, series in parts)
    return tuple(Panel(label, series, **settings) for label, series in listed if series)
