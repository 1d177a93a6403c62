"""Symmetric banded systems, U' D⁻¹ U in place: a hand loop beats LAPACK's column-wise solver for such narrow bands."""

from __future__ import annotations

import numpy as np

from .kernels import kernel


@kernel
def factor_band(band, start, first, end):
    """Factor the rows first <= i < end of the system made of the rows start <= i < end, in place.

    band: (N, w) upper band, band[i, k] = A[i, i + k]; afterwards band[i, 0] = 1 / D[i] and band[i, k] = U[i, k].
    Rows start <= i < first must hold the factors of the same matrix: after a change in row `first` only the rows from
    there on are factored again, and the result has the same bits as a complete factorisation.
    """
    width = band.shape[1]
    for i in range(first, end):
        for m in range(1, min(width, i - start + 1)):
            scale = band[i - m, m] * band[i - m, 0]
            for k in range(width - m):
                band[i, k] -= scale * band[i - m, m + k]
        band[i, 0] = 1.0 / band[i, 0]


@kernel
def solve_band(band, b, start, end):
    """Solve A x = b for the rows start <= i < end with the factors of `factor_band`; b becomes x."""
    width = band.shape[1]
    for i in range(start, end):
        value = b[i] * band[i, 0]
        for k in range(1, min(width, end - i)):
            b[i + k] -= band[i, k] * value
    for i in range(end - 1, start - 1, -1):
        value = b[i]
        for k in range(1, min(width, end - i)):
            value -= band[i, k] * b[i + k]
        b[i] = value * band[i, 0]


def banded_product(band: np.ndarray, x: np.ndarray) -> np.ndarray:
    """A x for the upper band of a symmetric matrix, (N,)."""
    y = band[:, 0] * x
    for k in range(1, band.shape[1]):
        y[:-k] += band[:-k, k] * x[k:]
        y[k:] += band[:-k, k] * x[:-k]
    return y
