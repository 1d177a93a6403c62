"""A line or a set of points as plain data, such as a signal over time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

Numbers = Sequence[float] | np.ndarray


@dataclass(frozen=True)
class Series:
    """One line or set of points. kind: "line", "dashed", "points", "line+points", "dots" (small, for clouds of many).

    faint: context, drawn thin and pale.  labels: a text per point, shown at the pointer.
    shades: a number per point that is shown as its colour, with `shade_label` at the scale; zero is the neutral middle.
    """

    name: str
    x: Numbers | Sequence[str]
    y: Numbers
    kind: str = "line"
    faint: bool = False
    labels: Sequence[str] = ()
    shades: Numbers = ()
    shade_label: str = ""
