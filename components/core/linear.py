"""Systems of linear equations in kernels, which allocate nothing and know no LAPACK: small dense ones, and banded ones.

Banded systems are factored in place: hand loops beat LAPACK's column-wise solver for such narrow bands. Symmetric ones become
U' D⁻¹ U from their upper band, general ones L U from their whole band. Neither exchanges rows: the matrices must not need it,
as those of structures with inertia do not.
"""

from __future__ import annotations

import numpy as np

from .kernels import DONE, NOT_CONVERGED, kernel


@kernel
def solve_dense(A, b):
    """Solve A x = b by Gaussian elimination with partial pivoting, in place: A (n, n) is lost, b (n,) becomes x.

    Returns NOT_CONVERGED where A is singular.
    """
    n = b.size
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(A[i, k]) > abs(A[pivot, k]):
                pivot = i
        if not abs(A[pivot, k]) > 0.0:
            return NOT_CONVERGED
        if pivot != k:
            for j in range(k, n):
                A[k, j], A[pivot, j] = A[pivot, j], A[k, j]
            b[k], b[pivot] = b[pivot], b[k]
        for i in range(k + 1, n):
            factor = A[i, k] / A[k, k]
            for j in range(k + 1, n):  # where the factor is 0, too: its derivative may not be
                A[i, j] -= factor * A[k, j]
            b[i] -= factor * b[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            b[k] -= A[k, j] * b[j]
        b[k] /= A[k, k]
    return DONE


@kernel
def factor_band(band, start, first, end):
    """Factor the rows first <= i < end of the system made of the rows start <= i < end, in place.

    band: (N, w) upper band, band[i, k] = A[i, i + k]; afterwards band[i, 0] = 1 / D[i] and band[i, k] = U[i, k].
    Rows start <= i < first must hold the factors of the same matrix: after a change in row `first` only the rows from
    there on are factored again, and the result is bit-identical to a complete factorisation.
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


@kernel
def factor_general(band):
    """Factor a general banded matrix in place.

    band: (N, 2 w + 1), band[i, w + k] = A[i, i + k], zero beyond the matrix; afterwards L without its unit diagonal and U,
    with 1 / U[i, i] at band[i, w].
    """
    n, w = band.shape[0], band.shape[1] // 2
    for i in range(n):
        band[i, w] = 1.0 / band[i, w]
        pivot = band[i, w + 1 :]
        for m in range(1, min(w, n - 1 - i) + 1):
            row = band[i + m, w - m :]
            scale = row[0] * band[i, w]
            row[0] = scale
            for k in range(w):
                row[k + 1] -= scale * pivot[k]


@kernel
def solve_general(band, b):
    """Solve A x = b with the factors of `factor_general`; b becomes x."""
    n, w = band.shape[0], band.shape[1] // 2
    for i in range(n):
        value = b[i]
        for k in range(max(-w, -i), 0):
            value -= band[i, w + k] * b[i + k]
        b[i] = value
    for i in range(n - 1, -1, -1):
        value = b[i]
        for k in range(1, min(w, n - 1 - i) + 1):
            value -= band[i, w + k] * b[i + k]
        b[i] = value * band[i, w]


@kernel
def add_product(band, x, b):
    """b += A x for a general band."""
    n, w = band.shape[0], band.shape[1] // 2
    for i in range(n):
        value = 0.0
        for k in range(max(-w, -i), min(w, n - 1 - i) + 1):
            value += band[i, w + k] * x[i + k]
        b[i] += value
