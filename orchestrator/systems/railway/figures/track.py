"""Marks along the track that several figures share."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from ....harness.charts.style import label, vertical
from ..records import Track


def track_marks(track: Track, low: float, high: float) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """(lines at the supports, numbers of the spans) between two positions in m; empty without a span."""
    supports = track.supports_between(low, high)
    texts = [label(f"span {i + 1}", 0.5 * (a + b), 1.0, xref="x", yanchor="top") for (i, a), (_, b) in pairwise(supports)]
    return [vertical(x) for _, x in supports], texts
