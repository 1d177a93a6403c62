"""What rows leave of a figure: a largest value, a share of time, a count or a length of time misses what lies between two rows.

The rows are filled up with a smooth curve through them, and the figure is taken again. In a motion that forgets its past, a figure
is the mean over a stretch of one of many histories: there its error is that of this mean, from the parts of the run.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import cache
from math import sqrt
from typing import Any

import numpy as np

from ...components.core.errors import BadInput
from ..engine.coupling.graph import is_discrete
from ..run.key_results import KeyResults
from ..run.results import OnDemand, Result
from ..run.thresholds import BETWEEN, MOST_VALUES, PARTS, PARTS_SURE

Values = Callable[[Result], KeyResults]
Of = Callable[[str], np.ndarray]  # of a signal by its name: its rows


def denser(result: Result, times: int) -> Result | None:
    """A result with so many times the rows, on modified Akima curves, which do not swing beyond a jump; None where there is none.

    What is no curve (flags, counts, modes, held values, angles that begin anew, texts) keeps its value up to the next row.
    """
    t = result.time
    if t.size < 3 or not (np.diff(t) > 0.0).all() or times * t.size * (1 + len(result.columns)) > MOST_VALUES:
        return None
    share = np.arange(times) / times
    time = np.append((t[:-1, None] + np.diff(t)[:, None] * share).ravel(), t[-1])
    before = np.minimum(np.arange(time.size) // times, t.size - 1)

    def filled(name: str) -> np.ndarray:
        values = result.columns[name]
        smooth = _smooth(result, name, values)
        return np.append(curve(t, values, share).ravel(), values[-1]) if smooth else values[before]

    return _of_columns(result, time, filled, lambda name: result.texts[name][before])


def curve(t: np.ndarray, y: np.ndarray, share: np.ndarray) -> np.ndarray:
    """A modified Akima curve through at least three points, (n - 1, shares): at shares, 0 to 1, of each interval.

    Akima, Journal of the ACM 17 (1970); weights of MATLAB's makima. SciPy has it, too, and takes a third of the start of a process.
    """
    h = np.diff(t)
    m = np.diff(y) / h
    m = np.concatenate(([3.0 * m[0] - 2.0 * m[1], 2.0 * m[0] - m[1]], m, [2.0 * m[-1] - m[-2], 3.0 * m[-1] - 2.0 * m[-2]]))
    weights = np.abs(np.diff(m)) + 0.5 * np.abs(m[1:] + m[:-1])
    before, both = weights[:-2], weights[2:] + weights[:-2]
    defined = both > 1e-9 * both.max()
    left, right = m[1:-2], m[2:-1]
    slopes = np.where(defined, left + before / np.where(defined, both, 1.0) * (right - left), 0.5 * (m[3:] + m[:-3]))
    rise, begin, end = np.diff(y), slopes[:-1] * h, slopes[1:] * h
    square, cube = 3.0 * rise - 2.0 * begin - end, begin + end - 2.0 * rise
    points = np.empty((rise.size, share.size))
    for k, s in enumerate(share.tolist()):  # of few: whole columns take half the time of short rows
        points[:, k] = y[:-1] + s * (begin + s * (square + s * cube))
    return points


def _smooth(result: Result, name: str, values: np.ndarray) -> bool:
    """Whether a column is a curve that rows show points of."""
    unit, output = result.scene.split(name)
    interface = result.scene.coupling.interfaces.get(unit)
    signal: Any = interface.outputs.get(output) if interface is not None else None
    if values.dtype.kind != "f" or not np.isfinite(values).all() or (signal is not None and signal.kind != "real"):
        return False
    if np.array_equal(values, np.rint(values)) or (signal is not None and is_discrete(signal)):
        return False
    return signal is None or signal.unit != "rad" or bool(np.abs(np.diff(values)).max() < np.pi)


def between(result: Result, figures: KeyResults, values: Values) -> dict[str, float]:
    """How far the figures of the filled up rows are from those given, by name; none where rows cannot be filled up."""
    gaps: dict[str, float] = {}
    for filled in filter(None, (denser(result, times) for times in BETWEEN)):
        with suppress(BadInput):
            for name, gap in figures.finite_gaps(values(filled)).items():
                gaps[name] = max(gap, gaps.get(name, 0.0))
    return gaps


def of_parts(result: Result, values: Values) -> dict[str, float]:
    """Error of each figure as a mean over the run: `PARTS_SURE` deviations of the mean over `PARTS` parts of its rows.

    Each part stands behind the scene's transient, which figures leave out. None for a figure that a part does not have.
    """
    of_each: list[KeyResults] = []
    begin = int(np.searchsorted(result.time, result.time[0] + (getattr(result.scene.analysis, "transient", None) or 0.0)))
    for rows in np.array_split(np.arange(begin, result.rows), PARTS):
        if rows.size < 2:
            return {}
        part = rows_of(result, np.union1d(np.arange(begin), rows))
        time = np.append(result.time[:begin], result.time[rows] - (result.time[rows[0]] - result.time[begin]))
        try:
            of_each.append(values(replace(part, time=time)))
        except BadInput:
            return {}
    table = np.array([one.at(of_each[0]) for one in of_each])
    by_name = zip(of_each[0], table.T, strict=True)
    return {name: PARTS_SURE * float(x.std(ddof=1)) / sqrt(PARTS) for name, x in by_name if np.isfinite(x).all()}


def rows_of(result: Result, rows: np.ndarray | None) -> Result:
    """A result with some of its rows; all of them for None."""
    if rows is None or rows.size == result.rows:
        return result
    return _of_columns(result, result.time[rows], lambda name: result.columns[name][rows], lambda name: result.texts[name][rows])


def _of_columns(result: Result, time: np.ndarray, numbers: Of, texts: Of) -> Result:
    """A result with other rows, which are made where they are read: figures read few columns."""
    columns = OnDemand(result.columns, cache(numbers))
    return replace(result, time=time, columns=columns, texts=OnDemand(result.texts, cache(texts)))
