"""A small plot of a signal as SVG, without script, of a few hundred characters."""

from __future__ import annotations

import numpy as np

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
