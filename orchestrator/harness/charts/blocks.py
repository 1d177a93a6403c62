"""What a page is made of: figures, texts and tables as data."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Figure:
    """A Plotly figure as a dict of data, layout and possibly frames; `caption` says what to see in it."""

    title: str
    figure: dict[str, Any]
    caption: str = ""
    kind: str = "figure"


@dataclass(frozen=True)
class Sketch:
    """A drawing as the text of an SVG element, made here and not by whoever wrote the scene."""

    title: str
    svg: str
    kind: str = "sketch"


@dataclass(frozen=True)
class Moving:
    """A line of a machine. points: (k, m, 2), its m corners at k instants, or (1, m, 2) of one that stands still.

    look: "ground" (pale), "part", "second", "load" (thin, coloured), "trace" (the whole path so far, of one corner).
    joints: whether its corners are drawn as pins.
    """

    points: np.ndarray
    look: str = "part"
    joints: bool = False


@dataclass(frozen=True)
class Motion:
    """A machine in motion, with a slider over time. time: (k,) s.  labels: of the two axes.  equal: one length for both."""

    title: str
    time: np.ndarray
    lines: Sequence[Moving]
    labels: tuple[str, str] = ("m", "m")
    caption: str = ""
    equal: bool = True
    kind: str = "motion"


@dataclass(frozen=True)
class Text:
    """Paragraphs of plain text. tone: "", "note" or "warning"."""

    paragraphs: Sequence[str]
    tone: str = ""
    kind: str = "text"


@dataclass(frozen=True)
class Answer:
    """What was asked for, large: (value with its unit, what it is, what limits say: "in", "out", "undecided", "unconfirmed" or "")."""

    numbers: Sequence[tuple[str, str, str]]
    kind: str = "answer"


@dataclass(frozen=True)
class Facts:
    """Names and values in two columns; folded: hidden until asked for on a screen.  beside: short ones, two pairs in a line."""

    title: str
    rows: Sequence[tuple[str, str]]
    folded: bool = False
    beside: bool = False
    kind: str = "facts"


@dataclass(frozen=True)
class Cells:
    """A plain table; numbers are texts already. Columns named in `right` are set flush right.

    folded: hidden until asked for on a screen, and open on paper.
    """

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    caption: str = ""
    right: frozenset[int] = frozenset()
    folded: bool = False
    kind: str = "cells"


@dataclass(frozen=True)
class RangeRow:
    """The number of a run beside its range; `place` 0 at the low end, 1 at the high end."""

    quantity: str
    unit: str
    simulated: str
    range: str
    margin: str
    place: float | None
    open_low: bool
    open_high: bool
    inside: bool
    undecided: bool
    standing: str
    note: str
    source: str
    verdict: str
    condition: str = ""  # rows of one stand below a line with it; "" for none


@dataclass(frozen=True)
class Ranges:
    """Rows against a reference table. caption: the settings of the measured numbers."""

    title: str
    rows: Sequence[RangeRow]
    caption: str = ""
    kind: str = "ranges"


@dataclass(frozen=True)
class Signatures:
    """Lines to sign on: (role, name or "" for a line to write it on)."""

    roles: Sequence[tuple[str, str]]
    kind: str = "signatures"


Block = Figure | Sketch | Motion | Text | Answer | Facts | Cells | Ranges | Signatures
