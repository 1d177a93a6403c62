"""Sections through motions: where a trajectory is at given angles or on a surface, and what a set of such points shows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from components.core.errors import BadInput

from .spectra import TURN, unwrapped


def stroboscopic(angle: np.ndarray, states: np.ndarray, per_turn: float = 1.0, offset: float = 0.0) -> np.ndarray:
    """States (k, d) at the instants when the angle passes `offset` + m 2 pi / per_turn, of recorded ones (n, d).

    angle: (n,) rad, within one turn or not; states between the samples by cubic splines over the angle. With the cage's angle
    and the number of balls as `per_turn` the instants are a ball's passings of one place of the outer race.
    """
    theta = unwrapped(angle)
    if theta[-1] < theta[0]:
        theta, offset = -theta, -offset
    if not (np.diff(theta) > 0.0).all():
        raise BadInput("stroboscopic section", "an angle that stands or turns back", "one that always increases or decreases")
    spacing = TURN / per_turn
    first, last = np.ceil((theta[0] - offset) / spacing - 1e-9), np.floor((theta[-1] - offset) / spacing + 1e-9)
    at = np.clip(offset + spacing * np.arange(first, last + 1.0), theta[0], theta[-1])
    return CubicSpline(theta, states)(at)


def crossings(time: np.ndarray, surface: np.ndarray, states: np.ndarray) -> np.ndarray:
    """States (k, d) at the instants when `surface` (n,) rises through zero: the points of a Poincaré section."""
    spline = CubicSpline(time, surface)
    roots = spline.roots(extrapolate=False)
    rising = roots[spline(roots, 1) > 0.0]
    return CubicSpline(time, states)(rising).reshape(-1, *states.shape[1:])


def distinct(points: np.ndarray, tolerance: float) -> int:
    """Number of groups among points (k, d) that are linked by gaps of at most `tolerance`: the period, for a periodic motion."""
    pairs = cKDTree(points).query_pairs(tolerance, output_type="ndarray")
    links = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    return int(connected_components(links, directed=False)[0])


def bifurcation(parameter: Sequence[float], sections: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """(parameter (n,), value (n,)): points of a bifurcation diagram from one coordinate of a section per value of a parameter."""
    if len(parameter) != len(sections):
        raise BadInput("bifurcation diagram", f"{len(sections)} sections of {len(parameter)} values", "a section for each value")
    if not len(sections):
        return np.zeros(0), np.zeros(0)
    values = np.concatenate([s.ravel() for s in sections])
    return np.repeat(np.asarray(parameter, dtype=float), [s.size for s in sections]), values
