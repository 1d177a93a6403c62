"""Which thrusts give a wanted wrench: around thrusters that are not available, and within limits that differ ahead and astern.

Thrusts are the least squares of the wrench's errors, each axis weighed by its priority. With six thrusters in a regular
arrangement nothing is left over. Without one of them the matrix has rank 5: one combination of axes is lost, and the
priorities say which. Of more than six the smallest thrusts are taken. A wrench beyond the limits is scaled as a whole, which
keeps its direction: cutting single thrusts off would turn a climb into a turn.
"""

from __future__ import annotations

import math

import numpy as np

from ..core.kernels import kernel

THRUSTERS = 6  # of a vehicle without further ones
NOTHING = 1e-10  # of the largest singular value: smaller ones count as zero
SWEEPS = 40  # at most; six or so are needed
FINE = 2.0**40  # to so fine a part of its scale a guess is rounded


def allocation_of(matrix: np.ndarray, priority: np.ndarray, choice: int) -> np.ndarray:
    """Thrusts per wrench, (n, 6), of `fill_allocation`, for studies."""
    n = matrix.shape[1]
    table = np.zeros((n, 6))
    fill_allocation(table, matrix, priority, choice, np.zeros((4, n, n + 6)))
    return table


@kernel
def fill_allocation(table, matrix, priority, choice, room):
    """Thrusts per wrench into table, (n, 6), for the thrusters that are available: bit i of choice is thruster i.

    matrix: wrench per thrust, (6, n).  priority: weight of an axis's error, (6,).  room: (4, n, n + 6). Of thrusts that do as well,
    the smallest. It is the pseudo-inverse of the weighted matrix W: rotations J of its rows make them orthogonal to each other,
    G = J W (Jacobi's method of one side), and W⁺ is the sum of G_k' J_k / |G_k|² over the rows that are not zero.
    """
    n, work = matrix.shape[1], room[0]
    for j in range(6):
        for i in range(n):
            work[j, i] = priority[j] * matrix[j, i] if choice >> i & 1 else 0.0
        for k in range(6):
            work[j, n + k] = 1.0 if j == k else 0.0
    largest = 0.0
    for _ in range(SWEEPS):
        largest = 0.0
        for j in range(6):
            largest = max(largest, product(work, j, j, n))
        turned = False
        for j in range(5):
            for k in range(j + 1, 6):
                if turn_rows(work, j, k, n, 1e-28 * largest):
                    turned = True
        if not turned:
            break
    for i in range(n):
        for k in range(6):
            table[i, k] = 0.0
    for j in range(6):
        size = product(work, j, j, n)
        if size > NOTHING * NOTHING * largest:
            for i in range(n):
                for k in range(6):
                    table[i, k] += work[j, i] / size * work[j, n + k]
    for j in range(6):
        for i in range(n):
            room[1, j, i] = priority[j] * matrix[j, i] if choice >> i & 1 else 0.0
    polish_inverse(table, room[1], room[2], room[3])
    for i in range(n):
        for k in range(6):
            table[i, k] *= priority[k]


@kernel
def polish_inverse(inverse, matrix, left, right):
    """The pseudo-inverse P, (n, 6), of W, (6, n), from one that is nearly right: to rounding, and with its derivative.

    P + P (W P)' S - R R' P with S = 1 - W P and R = 1 - P W squares the error of P, and its derivative by W is that of the
    pseudo-inverse, whatever that of P is, as long as the rank is the same. The rotations have no derivative where singular values
    coincide, as they do in a regular arrangement; so P is rounded first, and has none.
    matrix, left, right: (n, n + 6), matrix with W in its first rows and columns, the rest is room.
    """
    n = inverse.shape[0]
    size = 0.0
    for j in range(6):
        for i in range(n):
            size += matrix[j, i] * matrix[j, i]
    if size == 0.0:
        return
    fine = FINE * math.sqrt(size)
    for i in range(n):
        for k in range(6):
            left[k, i] = inverse[i, k] = math.floor(fine * inverse[i, k] + 0.3) / fine  # 0.3: a zero is not at a jump
    for j in range(6):
        for k in range(6):
            matrix[j, n + k] = 1.0 if j == k else 0.0
            for i in range(n):
                matrix[j, n + k] -= matrix[j, i] * left[k, i]
    for j in range(6):
        for k in range(6):
            left[j, n + k] = matrix[j, n + k]
            for m in range(6):
                left[j, n + k] -= matrix[m, n + j] * matrix[m, n + k]
    for i in range(n):
        for m in range(n):
            right[i, m] = 1.0 if i == m else 0.0
            for j in range(6):
                right[i, m] -= left[j, i] * matrix[j, m]
    for i in range(n):
        for k in range(6):
            right[i, n + k] = 0.0
            for m in range(n):
                right[i, n + k] += right[m, i] * left[k, m]
    for i in range(n):
        for k in range(6):
            for j in range(6):
                inverse[i, k] += left[j, i] * left[j, n + k]
            for m in range(n):
                inverse[i, k] -= right[i, m] * right[m, n + k]


@kernel
def product(work, j, k, n):
    """Scalar product of the first n elements of two rows."""
    total = 0.0
    for i in range(n):
        total += work[j, i] * work[k, i]
    return total


@kernel
def turn_rows(work, j, k, n, least):
    """Turn two rows so that their first n elements are orthogonal, unless they are, or one of them has a square below `least`."""
    jj, kk, jk = product(work, j, j, n), product(work, k, k, n), product(work, j, k, n)
    if not min(jj, kk) > least or not abs(jk) > 1e-15 * math.sqrt(jj * kk):
        return False
    ratio = 0.5 * (kk - jj) / jk
    tangent = math.copysign(1.0, ratio) / (abs(ratio) + math.sqrt(1.0 + ratio * ratio))
    cosine = 1.0 / math.sqrt(1.0 + tangent * tangent)
    sine = cosine * tangent
    for i in range(work.shape[1]):
        a, b = work[j, i], work[k, i]
        work[j, i], work[k, i] = cosine * a - sine * b, sine * a + cosine * b
    return True


@kernel
def allocate(wrench, table, matrix, forward_limit, reverse_limit, thrust, given):
    """Scale of the wrench that the limits allow, in (0, 1]; fills thrust, (n,), N, and given, (6,), the wrench that comes of it.

    wrench: (6,).  table: thrusts per wrench, (n, 6), of `fill_allocation`.  matrix: wrench per thrust, (6, n).
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
    """Bits of what is available: each of `count` thrusters whose number, from `first` on, is above 0.5."""
    choice = 0
    for i in range(count):
        if available[first + i] > 0.5:
            choice += 1 << i
    return choice
