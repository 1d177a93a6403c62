"""Which thrusts give a wanted wrench: around thrusters that are not available, and within limits that differ ahead and astern.

Thrusts are the least squares of the wrench's errors, each axis weighed by its priority. With six thrusters in a regular
arrangement nothing is left over. Without one of them the matrix has rank 5: one combination of axes is lost, and the
priorities say which. Of more than six the smallest thrusts are taken. A wrench beyond the limits is scaled as a whole, which
keeps its direction: cutting single thrusts off would turn a climb into a turn.
"""

from __future__ import annotations

import numpy as np

from ..core.kernels import kernel

THRUSTERS = 6  # of a vehicle without further ones


def allocations(matrix: np.ndarray, priority: np.ndarray) -> np.ndarray:
    """Thrusts per wrench, (2^n, n, 6), one for each set of available thrusters; bit i of the index: thruster i is available.

    matrix: wrench per thrust, (6, n).  priority: weight of an axis's error, (6,).  Of thrusts that do as well, the smallest.
    """
    weighted = priority[:, None] * matrix
    n = matrix.shape[1]
    tables = np.zeros((2**n, n, 6))
    for choice in range(2**n):
        there = [i for i in range(n) if choice >> i & 1]
        if there:
            tables[choice, there] = np.linalg.pinv(weighted[:, there], rcond=1e-10) * priority
    return tables


@kernel
def allocate(wrench, table, matrix, forward_limit, reverse_limit, thrust, given):
    """Scale of the wrench that the limits allow, in (0, 1]; fills thrust, (n,), N, and given, (6,), the wrench that comes of it.

    wrench: (6,).  table: thrusts per wrench, (n, 6), of `allocations`.  matrix: wrench per thrust, (6, n).
    """
    n = matrix.shape[1]
    scale = 1.0
    for i in range(n):
        thrust[i] = 0.0
        for j in range(6):
            thrust[i] += table[i, j] * wrench[j]
        limit = forward_limit if thrust[i] > 0.0 else reverse_limit
        if abs(thrust[i]) * scale > limit:
            scale = limit / abs(thrust[i])
    for i in range(n):
        thrust[i] *= scale
    for j in range(6):
        given[j] = 0.0
        for i in range(n):
            given[j] += matrix[j, i] * thrust[i]
    return scale


@kernel
def chosen(available, first, count):
    """Index into `allocations` of what is available: each of `count` thrusters whose number, from `first` on, is above 0.5."""
    choice = 0
    for i in range(count):
        if available[first + i] > 0.5:
            choice += 1 << i
    return choice
