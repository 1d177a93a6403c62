"""Eigenvalues of turning rotors: whirl frequencies, their direction, Campbell diagram, critical speeds.

Functions of the matrices of M q'' + (C + Omega G) q' + (K + Omega H) q = 0, dense, with the degrees of freedom of a node in
the order x, y, tilt_x, tilt_y. Sources: Friswell, Penny, Garvey & Lees (2010), sections 6.2, 6.4 and 6.8.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.linalg import eig, eigvals
from scipy.optimize import brentq

from .model import DOFS, Matrices

ROUND = 0.05  # of the larger one of an orbit's axes: a smaller axis is a straight line's, which has no direction
DOUBLE_ROOT = 10.0 * np.finfo(float).eps ** 0.5  # of the largest eigenvalue: the error that rounding gives a double root at zero
RIGID = 1e-13  # of the stiffness' diagonal: rigid motions show 1e-16, the softest mode of 150 elements 1e-7
SAME = 1e-6  # of an eigenvalue: rounding sets a degenerate pair of 150 elements 1e-9 apart, to either side of the real axis, too

AtSpeed = Callable[[float], Matrices]


class Modes(NamedTuple):
    """Modes of a rotor at one speed, in the order of their frequencies; one of each pair of conjugate eigenvalues."""

    frequency: np.ndarray  # (k,) rad/s, of the damped motion
    decay: np.ndarray  # (k,) 1/s, minus the real part of the eigenvalue; negative: unstable
    direction: np.ndarray  # (k,) int, 1 forward, -1 backward, 0 neither: straight, both along the shaft, or degenerate
    shape: np.ndarray  # (N, k) complex


def eigenvalues(matrices: Matrices, speed: float) -> np.ndarray:
    """All eigenvalues at a speed, (2 N,) complex, 1/s."""
    return eigvals(_first_order(matrices, speed))


def modes(matrices: Matrices, speed: float, count: int | None = None) -> Modes:
    """The lowest oscillating modes at a speed; all of them without `count`.

    A rigid motion without frequency is a double root at zero, which rounding splits into small frequencies. It is left out: no
    stiffness opposes it, as nothing opposes a free rotor's precession, but that one has a frequency beyond the rounding.
    """
    N = matrices.mass.shape[0]
    values, vectors = eig(_first_order(matrices, speed))
    shape = vectors[:N]
    elastic = np.abs((shape.conj() * (matrices.stiffness @ shape)).sum(axis=0))
    rigid = elastic <= RIGID * (np.diag(matrices.stiffness) @ np.abs(shape) ** 2)
    size = np.abs(values)
    oscillating = np.flatnonzero((values.imag > SAME * size) & ~(rigid & (size < DOUBLE_ROOT * size.max())))
    order = oscillating[np.argsort(values.imag[oscillating], kind="stable")]
    values, shape = values[order], shape[:, order]
    direction = _directions(shape)
    pairs = np.flatnonzero(np.abs(np.diff(values)) < SAME * np.abs(values[1:]))
    direction[pairs] = direction[pairs + 1] = 0  # any mixture of the two is a mode
    return Modes(values.imag[:count], -values.real[:count], direction[:count], shape[:, :count])


def campbell(matrices: Matrices | AtSpeed, speeds, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies, (len(speeds), count) rad/s, and directions of the lowest modes over the speed.

    matrices: a function of the speed where the supports follow it.  Where fewer modes oscillate, because others are overdamped,
    the rest is NaN, without direction.
    """
    at = matrices if callable(matrices) else lambda speed: matrices
    frequency = np.full((len(speeds), count), np.nan)
    direction = np.zeros((len(speeds), count), dtype=int)
    for k, speed in enumerate(speeds):
        solution = modes(at(speed), speed, count)
        frequency[k, : solution.frequency.size], direction[k, : solution.frequency.size] = solution.frequency, solution.direction
    return frequency, direction


def critical_speeds(matrices: Matrices, order: float = 1.0) -> np.ndarray:
    """Speeds at which an undamped frequency is `order` times the speed, rising, rad/s.

    With q = phi exp(i order Omega t) it is one eigenvalue problem, K phi = Omega² (order² M - i order G) phi. Neither matrix
    need be definite: a forward mode may never meet its line, and a free rotor's rigid motions meet theirs at Omega = 0. So
    Omega² is a ratio, of which both parts may be zero to rounding; scaled by the stiffness' diagonal to be of one size.
    """
    scale = 1.0 / np.sqrt(np.diag(matrices.stiffness))
    scale = scale[:, None] * scale
    inertia = (order**2 * matrices.mass - 1j * order * matrices.gyroscopic) * scale
    below, above = eig(inertia, matrices.stiffness * scale, right=False, homogeneous_eigvals=True)
    meeting = (np.abs(above) > RIGID) & (below != 0.0)
    squares = above[meeting] / below[meeting]
    return np.sort(np.sqrt(squares.real[(squares.real > 0.0) & (np.abs(squares.imag) < 1e-6 * squares.real)]))


def critical_speeds_of(at: AtSpeed, speeds: np.ndarray) -> np.ndarray:
    """Critical speeds of a rotor whose matrices follow the speed, between the first and the last of `speeds`, rad/s, which rise.

    With the supports of a speed held, there are critical speeds: the k-th of them is a function of that speed, and a critical
    speed of the rotor where the two are one. Searched between neighbouring speeds: two in one interval may be missed.
    """

    def ahead(speed: float, k: int) -> float:
        there = critical_speeds(at(speed))
        return float(there[k] - speed) if k < there.size else float("inf")

    held = [critical_speeds(at(speed)) for speed in speeds]
    meeting = []
    for (low, below), (high, above) in pairwise(zip(speeds, held, strict=True)):
        for k in range(min(below.size, above.size)):
            if below[k] - low >= 0.0 > above[k] - high or below[k] - low < 0.0 <= above[k] - high:
                meeting.append(brentq(ahead, low, high, args=(k,), xtol=1e-9, rtol=1e-12))
    return np.sort(meeting)


def _first_order(matrices: Matrices, speed: float) -> np.ndarray:
    """A of z' = A z with z = (q, q'), (2 N, 2 N)."""
    N = matrices.mass.shape[0]
    force = np.hstack((matrices.stiffness + speed * matrices.circulatory, matrices.damping + speed * matrices.gyroscopic))
    return np.vstack((np.hstack((np.zeros((N, N)), np.eye(N))), -np.linalg.solve(matrices.mass, force)))


def _directions(shape: np.ndarray) -> np.ndarray:
    """Direction of whirl of mode shapes, (k,): each node's orbit is a sum of a forward and a backward circle."""
    x, y = shape[0::DOFS], shape[1::DOFS]
    forward, backward = np.abs(x + 1j * y) ** 2, np.abs(x - 1j * y) ** 2
    difference, total = (forward - backward).sum(axis=0), (forward + backward).sum(axis=0)
    return np.where(np.abs(difference) > ROUND * total, np.sign(difference), 0.0).astype(int)
