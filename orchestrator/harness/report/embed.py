"""Figures as they stand in a page: no more points than the page has room for, and numbers as bytes instead of text.

Lines that are bands there keep their samples in a part of the page of its own, or a file beside it, from which they come where
one zooms in.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from textwrap import wrap
from types import NoneType
from typing import Any

import numpy as np

from ..charts.bands import band, fewer, is_history, samples_of
from ..charts.style import SAMPLES

ROOM = 170_000  # numbers of all figures of a page: about 0.9 MB
SAMPLES_BESIDE = 2_000_000  # numbers of the file beside a page: about 11 MB
SAMPLES_INSIDE = 1_000_000  # numbers of samples in a page, compressed: at most about 5 MB
LONG = 500  # points from which a line may become a band
FEWEST = 1700  # points of a band's outline
FLATTER, LETTER = 0.66, 6.6  # of a figure in print; px, about, of a letter of an axis' title
PACKED = 50  # numbers from which an array becomes bytes

Spec = dict[str, Any]  # a Plotly figure


def embedded(figures: Sequence[Spec]) -> tuple[list[Spec], int]:
    """(figures, points): copies of the figures for a page, and the most points that a line then has; 0 if none lost any."""
    lines = [len(trace["x"]) for figure in figures for trace in figure["data"] if _is_long_line(trace)]
    rest = sum(_size(a) for figure in figures for trace in figure["data"] for a in _arrays(trace).values()) - 2 * sum(lines)
    points = _fitting(lines, ROOM - rest)
    return [
        {**figure, "data": [_packed(fewer(t, points) if points and _is_long_line(t) else t) for t in figure["data"]]}
        for figure in figures
    ], points


def _wrapped(layout: Spec) -> Spec:
    """The layout with titles of y axes that are longer than their axis in several lines, also where a printed figure is flatter."""
    inner = layout.get("height", 0) - sum(layout.get("margin", {}).get(k, 0) for k in "tb")
    wrapped = {}
    for key, axis in layout.items():
        if not (key.startswith("yaxis") and isinstance(axis, Mapping) and (text := axis.get("title", {}).get("text", ""))):
            continue
        low, high = axis.get("domain", (0.0, 1.0))
        letters = max(int(FLATTER * inner * (high - low) / LETTER), 10)
        if len(text) > letters:
            lines = wrap(text, letters, break_long_words=False, break_on_hyphens=False)
            wrapped[key] = {**axis, "title": {**axis["title"], "text": "<br>".join(lines)}}
    return {**layout, **wrapped}


@dataclass(frozen=True)
class Samples:
    """What bands are of. content: {"arrays": packed numbers, "lines": figure -> trace -> places there of the columns of `band`},
    both counted from 0.  points: the most rows that a line has there, 0 where all of them have all samples.
    """

    content: dict[str, Any]
    points: int = 0


def lost_samples(figures: Sequence[Spec], points: int, room: int) -> Samples:
    """Samples of the lines that are bands in the page. points: the most that another line has there, see `embedded`."""
    lost = {
        (k, i): (x, y)
        for k, figure in enumerate(figures)
        for i, trace in enumerate(figure["data"])
        if SAMPLES in trace or (points and _is_long_line(trace) and len(trace["x"]) > points)
        for x, y in [samples_of(trace)]
        if is_history(x)
    }
    most = _fitting([x.size for x, _ in lost.values()], room)
    arrays: list[Any] = []
    places: dict[bytes, int] = {}  # most lines share their times
    lines: dict[str, dict[str, tuple[int, ...]]] = {}
    for (k, i), (x, y) in lost.items():
        columns = band(x, y, most // 2) if most else (x, y, y)
        keys = [sha256(values.tobytes()).digest() for values in columns]
        for key, values in zip(keys, columns, strict=True):
            if key not in places:
                places[key] = len(arrays)
                arrays.append(_bytes(values))
        lines.setdefault(str(k), {})[str(i)] = tuple(places[key] for key in keys)
    return Samples({"arrays": arrays, "lines": lines} if lines else {}, most // 2)


def _fitting(lines: Sequence[int], room: int) -> int:
    """Most points of a line with which all of them have room, 0 where they have it as they are."""
    if not lines or 2 * sum(lines) <= room:  # what fills a page without long lines is not made smaller
        return 0
    points = max(lines)
    while points > FEWEST and 2 * sum(min(n, points) for n in lines) > room:
        points = max(FEWEST, int(0.9 * points))
    return points


def _is_long_line(trace: Mapping[str, Any]) -> bool:
    """Whether it is a plain line of numbers whose points have nothing of their own."""
    if trace.get("type") != "scatter" or trace.get("mode") != "lines" or len(trace.get("x", ())) <= LONG:
        return False
    if trace.get("fill", "toself") != "toself":
        return False
    return len(_arrays(trace)) == 2 and not any(isinstance(trace.get(k), list) for k in ("text", "customdata", "hovertext"))


def _arrays(trace: Mapping[str, Any]) -> dict[str, Any]:
    """Those of x, y and z that are lists of numbers, or of such lists."""
    return {k: trace[k] for k in ("x", "y", "z") if isinstance(trace.get(k), list) and _is_numeric(trace[k])}


def _is_numeric(values: Sequence[Any]) -> bool:
    kinds = set(map(type, values))
    if list in kinds:
        kinds = (kinds - {list}).union(*(map(type, v) for v in values if isinstance(v, list)))
    return bool(values) and all(issubclass(kind, int | float | NoneType) for kind in kinds)


def _size(values: Sequence[Any]) -> int:
    return sum(len(v) if isinstance(v, list) else 1 for v in values) if list in set(map(type, values)) else len(values)


def _numbers(values: Sequence[Any]) -> np.ndarray:
    return np.array(values, dtype=float)  # None becomes NaN


def _packed(trace: Mapping[str, Any]) -> Spec:
    """Long arrays as bytes, in single precision where neighbours stay apart; a gap, None, is NaN there."""
    own = {k: v for k, v in trace.items() if k != SAMPLES}
    return {**own, **{k: _bytes(_numbers(v)) for k, v in _arrays(trace).items() if _size(v) > PACKED}}


def _bytes(values: np.ndarray) -> dict[str, str]:
    single = values.astype("<f4")
    merged = (np.diff(single.ravel()) == 0.0) & (np.diff(values.ravel()) != 0.0)
    data = values.astype("<f8") if merged.any() else single
    shape = {"shape": ", ".join(map(str, values.shape))} if values.ndim > 1 else {}
    return {"dtype": data.dtype.str[1:], "bdata": b64encode(data.tobytes()).decode("ascii"), **shape}
