"""Lines with more samples than a figure has pixels: a history as the band between its least and largest values, an orbit by its shape.

A band is one trace of Plotly, a closed outline that is filled, so that histories that oscillate show their envelope and others a line.
It keeps its samples, which a page shows where one zooms in.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .style import CYCLE, SAMPLES, drawn, line, tint

DRAWN_POINTS = 8_000  # of a line; of more, a history becomes a band
BAND_POINTS = 2_000  # of the outline of a band: a piece is about a pixel wide
SHADE = 0.4  # of what a band fills, so that one shows behind another

Rows = tuple[np.ndarray, np.ndarray, np.ndarray]


def band(x: np.ndarray, y: np.ndarray, pieces: int) -> Rows:
    """(x, least, largest) of the pieces of a history, x rising; NaN and NaN beside a piece with a gap, which an infinite value is, too.

    Neighbouring pieces share a sample, so that nothing of the line is between them. A history of few samples is its own band.
    """
    y = np.where(np.isfinite(y), y, np.nan)
    if x.size <= 2 * pieces:
        return x, y, y
    edges = np.linspace(0, x.size - 1, pieces + 1).astype(int)
    begin, end = edges[:-1], edges[1:]
    least, largest = (extreme(extreme.reduceat(y, begin), y[end]) for extreme in (np.fmin, np.fmax))
    at = 0.5 * (x[begin] + x[end])
    at[0], at[-1] = x[0], x[-1]
    broken = np.logical_or.reduceat(np.isnan(y), begin) | np.isnan(y[end])
    gaps = np.flatnonzero(broken) + ~np.isnan(y[begin[broken]])  # before a piece that begins in one, else behind it
    return np.insert(at, gaps, at[np.maximum(gaps, 1) - 1]), np.insert(least, gaps, np.nan), np.insert(largest, gaps, np.nan)


def outline(at: np.ndarray, least: np.ndarray, largest: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(x, y) around a band: there along the largest values, back along the least; one closed line for each part without gap."""
    known = np.isfinite(least)
    xs, ys = [], []
    for part in np.split(np.arange(at.size), np.flatnonzero(~known)):
        if (part := part[known[part]]).size:
            xs += [at[part], at[part][::-1], [np.nan]]
            ys += [largest[part], least[part][::-1], [np.nan]]
    return (np.concatenate(xs)[:-1], np.concatenate(ys)[:-1]) if xs else (at[:0], at[:0])


def banded(trace: Mapping[str, Any], x: np.ndarray, y: np.ndarray, points: int) -> dict[str, Any]:
    """A line's trace as the band of a history, with about so many points; its samples stay with it."""
    colour = trace.get("line", {}).get("color", CYCLE[0])
    filled = {"fill": "toself", "fillcolor": tint(colour, SHADE) if colour.startswith("#") else colour, "hoveron": "points"}
    xs, ys = outline(*band(x, y, points // 2))
    return {**trace, "x": drawn(xs, 7), "y": drawn(ys, 7), "mode": "lines", SAMPLES: (x, y), **filled}


def fewer(trace: Mapping[str, Any], points: int) -> Mapping[str, Any]:
    """A line's trace with at most about so many points: a history as its band, an orbit by its shape; as it is where it has no more."""
    if len(trace["x"]) <= points:
        return trace
    x, y = samples_of(trace)
    if is_history(x):
        return banded(trace, x, y, points)
    kept = simplified(x, y, points)
    return {**trace, "x": drawn(x[kept], 6), "y": drawn(y[kept])}


def samples_of(trace: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """(x, y) of all samples of a line, floats, NaN in its gaps."""
    x, y = trace[SAMPLES] if SAMPLES in trace else (trace["x"], trace["y"])
    return np.asarray(x, dtype=float), np.asarray(y, dtype=float)


def dense_line(
    x: np.ndarray, y: np.ndarray, name: str, colour: str, width: float = 1.8, **more: Any
) -> tuple[dict[str, Any], bool]:
    """(a `line`, whether it is a band): of more than `DRAWN_POINTS` samples."""
    if x.size <= DRAWN_POINTS:
        return line(x, y, name, colour, width, **more), False
    return banded(line((), (), name, colour, width, **more), x, y, BAND_POINTS), True


def is_history(x: np.ndarray) -> bool:
    """Whether x only rises; of others, orbits, extremes of y over x mean nothing."""
    return bool((np.diff(x) >= 0.0).all())


def simplified(x: np.ndarray, y: np.ndarray, points: int) -> np.ndarray:
    """Positions of at most about `points` samples of a path, an orbit say, that leave its shape: each sample that is left out is
    near the line through its neighbours. The distance, first 1/4000 of the extent, grows until there are few enough."""
    kept, near = np.arange(x.size), 1.0 / 4000.0
    scale = [float(np.nanmax(v) - np.nanmin(v)) or 1.0 if np.isfinite(v).any() else 1.0 for v in (x, y)]
    path = (np.asarray(x, dtype=float) / scale[0]) + 1j * (np.asarray(y, dtype=float) / scale[1])
    while kept.size > points and near < 1.0:
        before, here, behind = (path[kept[k : kept.size - 2 + k : 2]] for k in range(3))
        along = behind - before
        share = np.clip(((here - before) * along.conj()).real / np.maximum(np.abs(along) ** 2, 1e-300), 0.0, 1.0)
        gone = np.abs(here - before - share * along) < near  # False of a gap, NaN
        kept = np.delete(kept, 1 + 2 * np.flatnonzero(gone))
        near *= 1.0 if np.count_nonzero(gone) > 0.02 * gone.size else 1.4
    return kept
