"""Small dense systems of linear equations in kernels, which allocate nothing and know no LAPACK."""

from __future__ import annotations

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
            if factor != 0.0:
                for j in range(k + 1, n):
                    A[i, j] -= factor * A[k, j]
                b[i] -= factor * b[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            b[k] -= A[k, j] * b[j]
        b[k] /= A[k, k]
    return DONE
