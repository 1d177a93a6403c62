"""Axes of a still picture: where numbers and categories stand in pixels, and the ticks that are named."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Spec = Mapping[str, Any]
WIDTH = 860.0  # px of a picture
TICKS = 6  # about as many on a linear axis
NICE = (1.0, 2.0, 2.5, 5.0, 10.0)
ROOM = 0.04  # of an axis beyond its numbers, where it is not along a line
DEFAULT_MARGIN = {"l": 66, "r": 20, "t": 34, "b": 48}


@dataclass
class Axis:
    """One axis. low, high: its ends, exponents of ten on a logarithmic one. start, end: their places, px."""

    low: float
    high: float
    start: float
    end: float
    logarithmic: bool = False
    categories: Sequence[str] = ()
    settings: Spec = field(default_factory=dict)

    def coordinate(self, value: Any) -> float:
        """A value in the units of the ends; NaN for a gap."""
        if value is None:
            return math.nan
        if isinstance(value, str):
            return float(self.categories.index(value)) if value in self.categories else math.nan
        number = float(value)
        if not self.logarithmic:
            return number
        return math.log10(number) if number > 0.0 else math.nan

    def pixel(self, value: Any, raw: bool = False) -> float:
        """The place of a value; raw: of one in the units of the ends."""
        at = float(value) if raw else self.coordinate(value)
        return self.start + (at - self.low) / (self.high - self.low) * (self.end - self.start)

    def pixels(self, values: Sequence[Any]) -> np.ndarray:
        """The places of values, (n,); NaN for gaps."""
        if has_text(values):
            return np.array([self.pixel(value) for value in values], dtype=float)
        at = np.array(values, dtype=float)  # None becomes NaN
        if self.logarithmic:
            at = np.log10(at, out=np.full(at.shape, np.nan), where=at > 0.0)
        return self.start + (at - self.low) / (self.high - self.low) * (self.end - self.start)  # type: ignore[no-any-return]

    def ticks(self) -> Iterator[tuple[float, str]]:
        """(place in px, text) of each tick within the axis."""
        for at, text in self._named():
            if min(self.low, self.high) - 1e-9 <= at <= max(self.low, self.high) + 1e-9:
                yield self.pixel(at, raw=True), text

    def _named(self) -> Iterator[tuple[float, str]]:
        low, high = sorted((self.low, self.high))
        if "tickvals" in self.settings:
            texts = self.settings.get("ticktext") or [f"{v:g}" for v in self.settings["tickvals"]]
            yield from ((self.coordinate(v), str(t)) for v, t in zip(self.settings["tickvals"], texts, strict=True))
        elif self.categories:
            yield from enumerate(self.categories)
        elif self.logarithmic:
            parts = (1,) if high - low > 1.5 else (1, 2, 5)
            every = max(1, math.ceil((high - low) / 8))
            for exponent in range(math.floor(low), math.ceil(high) + 1, every):
                yield from ((exponent + math.log10(part), f"{part * 10.0**exponent:g}") for part in parts)
        else:
            step = _nice_step(high - low)
            for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1):
                yield k * step, f"{k * step:.6g}".replace("-", "−")


def _nice_step(span: float) -> float:
    rough = span / TICKS
    scale = 10.0 ** math.floor(math.log10(rough))
    return next(scale * n for n in NICE if scale * n >= rough * (1.0 - 1e-9))


def layout_key(name: str) -> str:
    """The key of a layout for an axis: "x2" is "xaxis2"."""
    return f"{name[0]}axis{name[1:]}"


def axes_of(figure: Spec) -> dict[str, Axis]:
    """All axes of a figure by their names, "x", "y", "x2" ...; ranges as given, else from the data of those that match."""
    layout = figure["layout"]
    names = {"x", "y"} | {f"{k[0]}{k[5:]}" for k in layout if k[1:5] == "axis"}
    names |= {str(trace.get(which, which[0])) for trace in figure["data"] for which in ("xaxis", "yaxis")}
    ends = {name: _span(figure, name) for name in sorted(names)}
    settings = {name: layout.get(layout_key(name), {}) for name in ends}
    for name, of_it in settings.items():  # panels that share an axis
        if (shared := of_it.get("matches")) in ends:
            both = [e for e in (ends[name], ends[shared]) if e]
            if both:
                ends[name] = ends[shared] = min(e[0] for e in both), max(e[1] for e in both)
    ends = {name: ends[settings[name].get("matches", name)] or ends[name] for name in ends}
    axes = {name: _axis(figure, name, settings[name], ends[name]) for name in ends}
    for name, of_it in settings.items():
        if (partner := of_it.get("scaleanchor")) in axes:
            _make_equal(axes[partner], axes[name])
    return axes


def _axis(figure: Spec, name: str, settings: Spec, ends: tuple[float, float] | None) -> Axis:
    layout, along = figure["layout"], name[0] == "x"
    margin = layout["margin"]
    first, last = settings.get("domain", (0.0, 1.0))
    if along:
        inner = WIDTH - margin["l"] - margin["r"]
        start, end = margin["l"] + first * inner, margin["l"] + last * inner
    else:
        inner = layout["height"] - margin["t"] - margin["b"]
        start, end = margin["t"] + (1.0 - first) * inner, margin["t"] + (1.0 - last) * inner
    names = _categories(figure, name)
    if "range" in settings:
        low, high = (float(e) for e in settings["range"])
    elif names:
        low, high = -0.5, len(names) - 0.5
    else:
        low, high = _widened(*(ends or (0.0, 1.0)), beyond=ROOM if not along or _has_markers(figure, name) else 0.0)
        if settings.get("rangemode") == "tozero":
            low = min(low, 0.0) if low > 0.0 else low
    if settings.get("autorange") == "reversed":
        low, high = high, low
    if low == high:
        high = low + 1.0
    return Axis(low, high, start, end, settings.get("type") == "log", names, settings)


def _widened(low: float, high: float, beyond: float) -> tuple[float, float]:
    span = high - low or abs(high) or 1.0
    return (low - beyond * span, high + beyond * span) if high > low else (low - 0.5 * span, high + 0.5 * span)


def _has_markers(figure: Spec, name: str) -> bool:
    return any("markers" in trace.get("mode", "") for trace in figure["data"] if trace.get("xaxis", "x") == name)


def has_text(values: Sequence[Any]) -> bool:
    """Whether some of the values are names of categories."""
    return any(issubclass(kind, str) for kind in set(map(type, values)))


def _values(figure: Spec, name: str) -> Iterator[Sequence[Any]]:
    """What traces and shapes have along an axis, one after the other."""
    for shape in figure["layout"].get("shapes", ()):
        if shape.get(f"{name[0]}ref", name[0]) == name:
            if shape["type"] == "path":  # x and y in turn
                numbers = [float(n) for n in re.findall(r"[-+0-9.eE]*\d", shape["path"])]
                yield numbers["xy".index(name[0]) :: 2]
            else:
                yield shape[f"{name[0]}0"], shape[f"{name[0]}1"]
    for trace in figure["data"]:
        if trace.get(f"{name[0]}axis", name[0]) == name:
            yield trace.get(name[0], ())
            if trace.get("type") == "bar" and ("x" if trace.get("orientation") == "h" else "y") == name[0]:
                halves = trace.get(f"error_{name[0]}", {}).get("array", ())
                yield 0.0, *(v + d for v, d in zip(trace[name[0]], halves, strict=False) if v is not None)


def _categories(figure: Spec, name: str) -> list[str]:
    texts = (v for values in _values(figure, name) if has_text(values) for v in values if isinstance(v, str))
    return list(dict.fromkeys(texts))


def _span(figure: Spec, name: str) -> tuple[float, float] | None:
    """Least and largest number along an axis, exponents of ten on a logarithmic one; None without any."""
    logarithmic, ends = figure["layout"].get(layout_key(name), {}).get("type") == "log", list[float]()
    for values in _values(figure, name):
        numbers = np.array([v for v in values if not isinstance(v, str)] if has_text(values) else values, dtype=float)
        numbers = numbers[np.isfinite(numbers) & (numbers > 0.0 if logarithmic else True)]
        if numbers.size:
            ends += float(numbers.min()), float(numbers.max())
    if logarithmic:
        ends = [math.log10(end) for end in ends]
    return (min(ends), max(ends)) if ends else None


def _make_equal(x: Axis, y: Axis) -> None:
    """One length in both directions is the same length on the page: the longer domain shrinks to the left, or to the top."""
    scale = min((x.end - x.start) / abs(x.high - x.low), (y.start - y.end) / abs(y.high - y.low))
    x.end = x.start + scale * abs(x.high - x.low)
    y.start = y.end + scale * abs(y.high - y.low)
