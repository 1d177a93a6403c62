"""The update of a belief by measurements, in square root form.

A belief about n numbers x is its mean m and columns T, (n, c): x = m + T a, where a has the standard normal distribution. Its covariance
is T Tᵀ. Measurements y = H x + noise R change what is known of a: with Z = R^(-1/2) H T = U s Vᵀ and the innovation v,

    a | y  ~  N(w, W W),   w = V s / (1 + s²) Uᵀ R^(-1/2) v,   W = I + V (1 / sqrt(1 + s²) - 1) Vᵀ,

so the mean moves by T w, and the columns become T W. This is the form of an ensemble transform filter (Bishop, Etherton, Majumdar 2001;
recalled), which is exact for columns of any origin: no covariance is formed, none loses its symmetry or its positive eigenvalues.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log, pi

import numpy as np


@dataclass(frozen=True)
class Update:
    """w: (c,), W: (c, c).  normalised: (m,) innovations with the covariance 1, if the model is right.  log_density: of them.

    whiten: (m, m), whose product with an innovation is the normalised one.  gain: (c, m), whose product with it is w.
    """

    w: np.ndarray
    W: np.ndarray
    normalised: np.ndarray
    log_density: float
    whiten: np.ndarray
    gain: np.ndarray


def update(columns: np.ndarray, innovation: np.ndarray, noise: np.ndarray) -> Update:
    """By measurements whose predictions have columns (m, c); innovation, noise (standard deviations): (m,)."""
    U, s, V = np.linalg.svd(columns / noise[:, None], full_matrices=False)
    known = 1.0 / np.sqrt(1.0 + s**2)
    whiten = (np.eye(noise.size) + U * (known - 1.0) @ U.T) / noise
    gain = (V.T * (s * known**2)) @ U.T / noise
    normalised = whiten @ innovation
    size = noise.size * log(2.0 * pi) + 2.0 * np.log(noise).sum() + np.log1p(s**2).sum()
    density = -0.5 * float(normalised @ normalised + size)
    return Update(gain @ innovation, np.eye(columns.shape[1]) + V.T * (known - 1.0) @ V, normalised, density, whiten, gain)


def fewer(rows: np.ndarray) -> np.ndarray | None:
    """An orthonormal (c, n) whose product with columns (n, c), more of them than rows, leaves their covariance; None for no more."""
    return np.linalg.qr(rows.T)[0] if rows.shape[1] > rows.shape[0] else None
