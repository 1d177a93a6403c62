"""Marks along the track that several figures share."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....harness.charts.style import label, vertical
from ..records import Track


def track_marks(track: Track, low: float, high: float) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """(lines at the supports, numbers of the spans) between two positions in m; empty without a span."""
    span = track.span
    if not span:
        return [], []
    supports = np.arange(np.ceil(low / span - 1e-9), np.floor(high / span + 1e-9) + 1) * span
    texts = [label(f"span {round(a / span) + 1}", a + 0.5 * span, 1.0, xref="x", yanchor="top") for a in supports[:-1]]
    return [vertical(x) for x in supports], texts
