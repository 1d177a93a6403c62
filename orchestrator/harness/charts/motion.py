"""A machine in motion as data of a page, and as a still picture of some of its instants."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from typing import Any

import numpy as np

from .blocks import Motion, Moving
from .style import number

FEWEST, MOST = 120, 600  # instants of a motion
A_SECOND = 30.0  # instants, of a motion that is neither short nor long
GHOSTS = 5  # instants of a still picture
WIDTH, HEIGHT = 760.0, 360.0  # px of a still picture
ROOM = 0.06  # of the picture's size, about the machine
WIDTHS = {"ground": 1.5, "part": 3.0, "second": 3.0, "load": 1.5, "trace": 1.0}


def instants(time: np.ndarray, longest: float = np.inf) -> np.ndarray:
    """Rows of a run that its motion shows, (k,), evenly over the time (n,), or over as many s as are shown at the longest."""
    time = time[: np.searchsorted(time, time[0] + longest, side="right")]
    span = float(time[-1] - time[0])
    count = int(np.clip(A_SECOND * span, FEWEST, MOST))
    rows = np.searchsorted(time, np.linspace(time[0], time[-1], count))
    return np.unique(np.minimum(rows, time.size - 1))


def polyline(*corners: tuple[Any, Any]) -> np.ndarray:
    """Points (k, m, 2) of a line from its m corners, (x, y), (k,) each or numbers."""
    arrays = np.broadcast_arrays(*(np.atleast_1d(np.asarray(c, dtype=float)) for corner in corners for c in corner))
    return np.stack([np.stack(arrays[k : k + 2], axis=-1) for k in range(0, len(arrays), 2)], axis=1)


def box(motion: Motion) -> list[float]:
    """Least and largest x, least and largest y of all lines, with room about them."""
    points = np.concatenate([line.points.reshape(-1, 2) for line in motion.lines])
    points = points[np.isfinite(points).all(axis=1)]
    low, high = points.min(axis=0), points.max(axis=0)
    room = ROOM * np.maximum(high - low, 0.1 * (high - low).max() or 1.0)
    return [float(low[0] - room[0]), float(high[0] + room[0]), float(low[1] - room[1]), float(high[1] + room[1])]


def motion_data(motion: Motion) -> dict[str, Any]:
    """What the page's script gets: numbers as bytes of 32-bit numbers."""
    return {
        "time": _packed(motion.time),
        "box": box(motion),
        "equal": motion.equal,
        "labels": list(motion.labels),
        "lines": [
            {"look": line.look, "joints": line.joints, "corners": line.points.shape[1], "points": _packed(line.points)}
            for line in motion.lines
        ],
    }


def _packed(values: np.ndarray) -> str:
    return b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode("ascii")


def still_motion(motion: Motion) -> str:
    """An SVG element with some instants over one another, the last ones darker: for pages whose scripts do not run."""
    x0, x1, y0, y1 = box(motion)
    sx, sy = WIDTH / (x1 - x0), HEIGHT / (y1 - y0)
    if motion.equal:
        sx = sy = min(sx, sy)
    middle = 0.5 * (x0 + x1), 0.5 * (y0 + y1)
    rows = np.linspace(0, motion.time.size - 1, GHOSTS).round().astype(int)
    parts = []
    for line in motion.lines:
        moves = line.points.shape[0] > 1
        for place, row in enumerate(rows if moves and line.look != "trace" else rows[:1]):
            corners = line.points[:, 0] if line.look == "trace" else line.points[row if moves else 0]
            known = corners[np.isfinite(corners).all(axis=1)]
            x, y = 0.5 * WIDTH + sx * (known[:, 0] - middle[0]), 0.5 * HEIGHT - sy * (known[:, 1] - middle[1])
            path = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
            opacity = 0.35 if line.look in ("ground", "trace") else 0.2 + 0.8 * (place + 1) / rows.size
            style = f'fill="none" stroke="currentColor" stroke-width="{WIDTHS[line.look]}" stroke-opacity="{opacity:.2f}"'
            parts.append(f'<polyline points="{path}" {style}/>')
    label = escape(
        f"{motion.title}: {rows.size} instants from {number(float(motion.time[0]))} to {number(float(motion.time[-1]))} s"
    )
    size = f'viewBox="0 0 {WIDTH:g} {HEIGHT:g}" width="100%"'
    return f'<svg role="img" aria-label="{label}" {size} xmlns="http://www.w3.org/2000/svg">{"".join(parts)}</svg>'


def trace(x: np.ndarray, y: np.ndarray) -> Moving:
    """The path of a point, (k,) each, drawn as far as it has come."""
    return Moving(polyline((x, y)), "trace")
