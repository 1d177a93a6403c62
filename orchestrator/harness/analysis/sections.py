"""Sections of a motion: its signals each time an angle has advanced by the same amount, or a surface is passed.

Seen over the values of a parameter they make a bifurcation diagram.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ....components.core.component import Component
from ....components.core.errors import BadInput


def section(angle: np.ndarray, spacing: float, *signals: np.ndarray) -> list[np.ndarray]:
    """Each signal (n,) where the angle (n,), rad and possibly wrapped, passes multiples of `spacing` rad, (k,).

    Between samples by cubic splines over the angle: the speed may vary, its sign may not.
    """
    from scipy.interpolate import CubicSpline  # SciPy takes longer to load than most runs take: only where it is called

    turned = np.unwrap(angle)
    if turned.size and turned[-1] < turned[0]:
        turned = -turned
    if turned.size < 4 or not (np.diff(turned) > 0.0).all():
        raise BadInput(
            "section",
            "an angle that rests or turns back",
            "one that always turns the same way",
            "Leave out the part of the run in which it does not.",
        )
    if np.diff(turned).max() > 0.5 * np.pi:
        actual = f"steps of {np.diff(turned).max():.2g} rad"
        raise BadInput("section", actual, "four samples a turn or more", "Record more often.")
    at = spacing * np.arange(np.ceil(turned[0] / spacing), np.floor(turned[-1] / spacing) + 1)
    return [CubicSpline(turned, s)(at) for s in signals]


def crossings(time: np.ndarray, surface: np.ndarray, *signals: np.ndarray) -> list[np.ndarray]:
    """Each signal (n,) where `surface` (n,) rises through zero, (k,): a Poincaré section; between samples by cubic splines."""
    from scipy.interpolate import CubicSpline

    spline = CubicSpline(time, surface)
    roots = spline.roots(extrapolate=False)
    rising = roots[spline(roots, 1) > 0.0]
    return [CubicSpline(time, s)(rising) for s in signals]


def swing_frequency(time: np.ndarray, angle: np.ndarray) -> float:
    """Angular frequency of an angle (n,) that swings about zero, rad/s, from its first to its last crossing of zero."""
    k = np.flatnonzero(angle[:-1] * angle[1:] < 0.0)
    passed = time[k] + (time[k + 1] - time[k]) * angle[k] / (angle[k] - angle[k + 1])  # near a zero the angle is straight
    return math.pi * (passed.size - 1) / float(passed[-1] - passed[0])


def distinct(points: np.ndarray, tolerance: float) -> int:
    """Number of groups among points (k, d) that are linked by gaps of at most `tolerance`: the period, for a periodic motion."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    links = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    return int(connected_components(links, directed=False)[0])


def stroboscopic_points(
    component: Component, period: float, points: int, signals: Sequence[str], *, transient: int = 0
) -> np.ndarray:
    """Outputs at the end of each of `points` periods after `transient` more, (points, len(signals)).

    The component is initialized, and is left at the end of the run. Each period is one step of it, divided as its own
    accuracy asks for.
    """
    at, start, rows = component.output_positions(signals), component.t, np.empty((points, len(signals)))
    for k in range(transient + points):
        component.step(start + k * period, period)
        if k >= transient:
            rows[k - transient] = component.y[at]
    return rows
