"""Eigenvalues of turning rotors: whirl frequencies, their direction, Campbell diagram, critical speeds, onset of instability.

Functions of the matrices of M q'' + (C + Omega G) q' + (K + Omega H) q = 0, dense, with the degrees of freedom of a node in
the order x, y, tilt_x, tilt_y. Sources: Friswell, Penny, Garvey & Lees (2010), sections 6.2, 6.4 and 6.8.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import eig, eigvals
from scipy.optimize import brentq

from .model import DOFS, Matrices

ROUND = 0.05  # of the larger one of an orbit's axes: a smaller axis is a straight line's, which has no direction


class Modes(NamedTuple):
    """Modes of a rotor at one speed, in the order of their frequencies; one of each pair of conjugate eigenvalues."""

    frequency: np.ndarray  # (k,) rad/s, of the damped motion
    decay: np.ndarray  # (k,) 1/s, minus the real part of the eigenvalue; negative: unstable
    direction: np.ndarray  # (k,) int, 1 forward, -1 backward, 0 neither (straight, or both along the shaft)
    shape: np.ndarray  # (N, k) complex


def eigenvalues(matrices: Matrices, speed: float) -> np.ndarray:
    """All eigenvalues at a speed, (2 N,) complex, 1/s."""
    return eigvals(_first_order(matrices, speed))


def modes(matrices: Matrices, speed: float, count: int | None = None) -> Modes:
    """The lowest oscillating modes at a speed; all of them without `count`."""
    N = matrices.mass.shape[0]
    values, vectors = eig(_first_order(matrices, speed))
    oscillating = np.flatnonzero(values.imag > 1e-6 * np.abs(values).max() ** 0.5)
    order = oscillating[np.argsort(values.imag[oscillating], kind="stable")][:count]
    shape = vectors[:N, order]
    return Modes(values.imag[order], -values.real[order], _directions(shape), shape)


def campbell(matrices: Matrices, speeds, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies, (len(speeds), count) rad/s, and directions of the lowest modes over the speed."""
    found = [modes(matrices, speed, count) for speed in speeds]
    return np.array([m.frequency for m in found]), np.array([m.direction for m in found])


def critical_speeds(matrices: Matrices, order: float = 1.0) -> np.ndarray:
    """Speeds at which an undamped frequency is `order` times the speed, rising, rad/s.

    With q = phi exp(i order Omega t) it is one eigenvalue problem, K phi = Omega² (order² M - i order G) phi, solved for
    1 / Omega² because the matrix on the right need not be definite: a forward mode may never meet its line.
    """
    inertia = order**2 * matrices.mass - 1j * order * matrices.gyroscopic
    values = eigvals(inertia, matrices.stiffness)
    positive = values.real[(values.real > 1e-12 * np.abs(values).max()) & (np.abs(values.imag) < 1e-6 * np.abs(values.real))]
    return np.sort(1.0 / np.sqrt(positive))


def onset_speed(matrices: Matrices, low: float, high: float) -> float:
    """Speed between `low` (stable) and `high` (unstable) at which the first mode loses its damping, rad/s."""
    return float(brentq(lambda speed: eigenvalues(matrices, speed).real.max(), low, high, xtol=1e-9, rtol=1e-13))


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
