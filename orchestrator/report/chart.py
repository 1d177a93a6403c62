"""A chart as plain data: what a study found, without saying how it is drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

Numbers = Sequence[float] | np.ndarray


@dataclass(frozen=True)
class Series:
    """One line or set of points. kind: "line", "points", "line+points". faint: context, drawn thin and pale.

    labels: a text per point, shown at the pointer.
    """

    name: str
    x: Numbers | Sequence[str]
    y: Numbers
    kind: str = "line"
    faint: bool = False
    labels: Sequence[str] = ()


@dataclass(frozen=True)
class Band:
    """A horizontal range of y, shaded; an end that is None is open. standing: of the range, "" for none."""

    name: str
    low: float | None
    high: float | None
    standing: str = ""


@dataclass(frozen=True)
class Panel:
    """One pair of axes. x_marks: thin vertical lines, (position, short text)."""

    y_label: str
    series: tuple[Series, ...]
    bands: tuple[Band, ...] = ()
    x_marks: tuple[tuple[float, str], ...] = ()
    title: str = ""


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
