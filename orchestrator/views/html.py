"""A result in a notebook: what it is, how it ended, its warnings, its numbers, and small plots; some thousand characters."""

from __future__ import annotations

from collections import deque
from html import escape

import numpy as np

from ...components.core.errors import BadInput, counted, visible_in_page
from . import Recorded

WIDTH, HEIGHT = 150, 22  # px
BINS = 36  # of the width; of each, extremes are kept


def sparkline(time: np.ndarray, values: np.ndarray) -> str:
    """An SVG element of values over time, both (n,); gaps where they are not finite; empty for less than two of them."""
    finite = np.isfinite(values)
    if np.count_nonzero(finite) < 2 or time[-1] <= time[0]:
        return ""
    low, high = float(values[finite].min()), float(values[finite].max())
    scale = (HEIGHT - 2.0) / (high - low) if high > low else 0.0
    k = _kept(time, values)
    x = (time[k] - time[0]) * WIDTH / (time[-1] - time[0])
    with np.errstate(invalid="ignore"):
        y = HEIGHT - 1.0 - (values[k] - low) * scale if scale else np.full(k.size, HEIGHT / 2.0)
    path, move = "", True
    for px, py, shown in zip(x, y, finite[k], strict=True):
        if shown:
            path += f"{'M' if move else 'L'}{px:.0f} {py:.0f}"
        move = not shown
    return f'<svg width="{WIDTH}" height="{HEIGHT}"><path d="{path}" fill="none" stroke="#0072b2"/></svg>'


def _kept(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Indices of the samples that are drawn: of each bin of time the smallest and the largest value, and the ends of all."""
    if time.size <= 2 * BINS:
        return np.arange(time.size)
    edges = np.searchsorted(time, np.linspace(time[0], time[-1], BINS + 1)[1:-1])
    parts = [part for part in np.split(np.arange(time.size), edges) if part.size]
    extremes = [
        part[choose(np.where(np.isfinite(v := values[part]), v, other))]
        for part in parts
        for choose, other in ((np.argmin, np.inf), (np.argmax, -np.inf))
    ]
    return np.unique([0, *extremes, time.size - 1])


SIGNALS = 6  # with a plot
WARNINGS = 3
NUMBERS = 6  # of the summary
LONGEST = 160  # characters of a warning
COLOURS = {"done": "#007a5a"}
OTHER = "#b34700"


def result_html(result: Recorded) -> str:
    """An HTML fragment without script; colours of text are those of the page around it."""
    scene = result.scene
    rows = counted(result.rows, "row") + (f" to t = {result.end:g} s" if result.rows else "")
    parts = [
        f"<b>{escape(scene.title or scene.name)}</b><br>"
        f'<b style="color:{COLOURS.get(result.outcome, OTHER)}">{escape(result.outcome)}</b> · {rows}'
    ]
    if result.message:
        parts.append(escape(_short(result.message)))
    warnings = result.info.warnings
    parts += [f"<b>warning:</b> {escape(_short(w))}" for w in warnings[:WARNINGS]]
    if len(warnings) > WARNINGS:
        parts.append(f"{len(warnings) - WARNINGS} more warnings: <code>.info.warnings</code>")
    return visible_in_page(f"<div>{'<br>'.join(parts)}{_signals(result)}{_numbers(result)}</div>")


def _short(text: str) -> str:
    return text if len(text) <= LONGEST else text[: LONGEST - 2] + " …"


def _signals(result: Recorded) -> str:
    if result.rows < 2 or not result.held:
        return ""
    names = _spread(list(result.columns))
    rows = ""
    for name in names[:SIGNALS]:
        values = np.asarray(result.columns[name], dtype=float)
        low, high, last = result.extremes(name)
        rows += (
            f"<tr><td>{escape(name)}<td>{sparkline(result.time, values)}<td>{low:.4g} … {high:.4g}<td>{last:.4g}"
            f"<td>{escape(result.measures.get(name, ''))}"
        )
    if not rows:
        return ""
    more = f"<br>{len(names) - SIGNALS} more signals: <code>.plot()</code>" if len(names) > SIGNALS else ""
    return f"<table><tr><th>signal<th><th>range<th>end<th>unit{rows}</table>{more}"


def _spread(names: list[str]) -> list[str]:
    """Signals in turn from each unit, so that the first ones are of many."""
    units: dict[str, deque[str]] = {}
    for name in names:
        units.setdefault(name.rpartition(".")[0], deque()).append(name)
    turn, order = deque(units.values()), []
    while turn:
        signals = turn.popleft()
        order.append(signals.popleft())
        if signals:
            turn.append(signals)
    return order


def _numbers(result: Recorded) -> str:
    if not result.held or result.outcome != "done" or result.scene.views is None:
        return ""
    try:
        numbers = result.summary
    except BadInput as error:
        return f"<br>no summary: {escape(_short(str(error)))}"
    rows = "".join(f"<tr><td>{escape(r.name)}<td>{r.shown}<td>{escape(r.unit)}" for r in numbers[:NUMBERS])
    more = f"<br>{len(numbers) - NUMBERS} more: <code>.summary</code>" if len(numbers) > NUMBERS else ""
    unknown = "" if result.info.verification.done else "<br>errors of these numbers are not known"
    return f"<table><tr><th>in numbers<th>value<th>unit{rows}</table>{more}{unknown}" if rows else ""
