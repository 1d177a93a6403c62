"""Which thrusts give a wanted wrench: around thrusters that are not available, and within limits that differ ahead and astern.

Thrusts are the least squares of the wrench's errors, each axis weighed by its priority. With six thrusters in a regular
arrangement nothing is left over. Without one of them the matrix has rank 5: one combination of axes is lost, and the
priorities say which. Of more than six the smallest thrusts within the limits are taken: where some are at their limit the others
give more, as far as any can. A wrench beyond the limits is scaled as a whole, which keeps its direction: cutting single thrusts
off would turn a climb into a turn.
"""

from __future__ import annotations

import math

import numpy as np

from ..core.kernels import kernel

THRUSTERS = 6  # of a vehicle without further ones
NOTHING = 1e-10  # of the largest singular value: smaller ones count as zero
SWEEPS = 40  # at most; six or so are needed
TURNS = 4  # times a thruster reaches or leaves its limit in `share_out`, on average, at most
LEFT_OVER = 1e-9  # of a wrench: thrusters that leave so much of it do not give it
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
def share_out(wrench, priority, matrix, choice, forward_limit, reverse_limit, thrust, given, free_table, room, rows):
    """As `allocate`, with the smallest thrusts within the limits: scale, and thrust and given, which that one filled.

    wrench, priority: (6,).  free_table: (n, 6).  room: (4, n, n + 6).  rows: (6, n). On the way from no wrench to the whole one the
    smallest thrusts m_i l, with multipliers l of the six axes, are straight lines between events: a thruster reaches its limit and
    stays there while the others, whose pseudo-inverse is made anew, give the rest; or it leaves the limit, as m_i l is within it
    again. Where those that are free do not give the direction of the wrench, the multipliers grow along what is left over, until a
    thruster leaves its limit; if none does, no thrusts within the limits give more. So thrusts change continuously with the wrench.
    Source: parametric quadratic programmes with an active set (Best 1996, from memory); judged by linear programmes in the tests.
    """
    n = matrix.shape[1]
    held, way, whole, pull, turn, left = rows[0], rows[1], rows[2], rows[3], rows[4], rows[5]
    for i in range(n):
        held[i], thrust[i] = 0.0 if choice >> i & 1 else 2.0, 0.0
    for j in range(6):
        pull[j] = 0.0
    fill_allocation(free_table, matrix, priority, choice, room)
    times(free_table, wrench, way)
    wrench_of(matrix, way, whole)  # what thrusters without limits would give
    size, scale, free = math.sqrt(squares(whole)), 0.0, choice
    for _ in range(TURNS * n):
        wrench_of(matrix, way, given)
        for j in range(6):
            given[j] = whole[j] - given[j]
            left[j] = priority[j] * priority[j] * given[j]  # at right angles to every free thruster
        stuck = math.sqrt(squares(given)) > LEFT_OVER * size
        for j in range(6):
            turn[j] = left[j]
            if not stuck:
                turn[j] = 0.0
                for i in range(n):
                    turn[j] += free_table[i, j] * way[i]
        further, event = math.inf if stuck else 1.0 - scale, -1
        for i in range(n):
            end = forward_limit if held[i] > 0.0 else -reverse_limit
            if held[i] == 0.0 and not stuck and way[i] != 0.0:
                end = forward_limit if way[i] > 0.0 else -reverse_limit
                step = (end - thrust[i]) / way[i]
            elif abs(held[i]) == 1.0 and held[i] * column_product(matrix, i, turn) < 0.0:
                step = (end - column_product(matrix, i, pull)) / column_product(matrix, i, turn)
            else:
                continue
            if step < further:
                further, event = max(step, 0.0), i
        if further == math.inf:
            break
        for j in range(6):
            pull[j] += further * turn[j]
        if not stuck:
            scale += further
            for i in range(n):
                thrust[i] += further * way[i]
        if event < 0:
            scale = 1.0
            break
        if held[event] == 0.0:
            held[event] = 1.0 if way[event] > 0.0 else -1.0
            thrust[event] = forward_limit if way[event] > 0.0 else -reverse_limit
            free -= 1 << event
        else:
            held[event] = 0.0
            free += 1 << event
        fill_allocation(free_table, matrix, priority, free, room)
        times(free_table, whole, way)
    wrench_of(matrix, thrust, given)
    return scale


@kernel
def times(table, wrench, thrust):
    """Thrusts of a table, (n, 6), for a wrench, (6,), into thrust, (n,)."""
    for i in range(table.shape[0]):
        thrust[i] = 0.0
        for j in range(6):
            thrust[i] += table[i, j] * wrench[j]


@kernel
def wrench_of(matrix, thrust, wrench):
    """The wrench of thrusts, (n,), into wrench, (6,)."""
    for j in range(6):
        wrench[j] = 0.0
        for i in range(matrix.shape[1]):
            wrench[j] += matrix[j, i] * thrust[i]


@kernel
def column_product(matrix, i, numbers):
    """Scalar product of a thruster's column and the first six numbers."""
    total = 0.0
    for j in range(6):
        total += matrix[j, i] * numbers[j]
    return total


@kernel
def squares(wrench):
    """Sum of the squares of the first six numbers."""
    total = 0.0
    for j in range(6):
        total += wrench[j] * wrench[j]
    return total


@kernel
def chosen(available, first, count):
    """Bits of what is available: each of `count` thrusters whose number, from `first` on, is above 0.5."""
    choice = 0
    for i in range(count):
        if available[first + i] > 0.5:
            choice += 1 << i
    return choice
