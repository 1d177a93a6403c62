"""Shape of a hanging chain of elastic segments between two points, in kernels: where a tether starts.

Of a chain: the number of its segments; the length of one without tension, m; its tension per strain, N; the load on each node
along the third axis, N. Ways are from its first end on, m; a pull is that in its first segment, N.
"""

from __future__ import annotations

import math

from ..core.kernels import DONE, NOT_CONVERGED, kernel
from ..core.linear import solve_dense

ITERATIONS = 200
NEARLY = 0.99  # of the length: straighter ones are nearly straight
SHORTEST = 1e-9  # share of a Newton step
# rows of the workspace, three numbers each; the way from end to end is given there
PULL, WAY, STEP, TRIAL, MISS, FIRST, SLOPE = range(7)
ROWS = SLOPE + 3
LIMP, UNIT = 1e12, 1.0  # N: tension per strain and load for which a slack chain without a load takes the shape of a hanging one


@kernel
def catenary_pull(wx, wy, drop, length, weight):
    """Pull on the first end, N, of an inextensible cable of `length` that hangs with `weight` in N/m over the way (wx, wy, drop).

    sqrt(L² - h²) / D = sinh(m) / m for the horizontal distance D and the drop h; the horizontal pull is weight D / (2 m).
    """
    level = math.hypot(wx, wy)
    ratio = math.sqrt(length**2 - drop**2) / level
    m = math.sqrt(6.0 * (ratio - 1.0)) if ratio < 3.0 else math.log(2.0 * ratio) + math.log(math.log(2.0 * ratio))
    for _ in range(ITERATIONS):
        step = (math.sinh(m) / m - ratio) / (math.cosh(m) / m - math.sinh(m) / m**2)
        m -= step
        if abs(step) < 1e-14 * m:
            break
    pull = 0.5 * weight * level / m
    return pull * wx / level, pull * wy / level, 0.5 * weight * (drop / math.tanh(m) + length)


@kernel
def tension_of(i, pull, load):
    """Tension of segment i as a vector, for the pull in the first one, and its size, N."""
    x, y, z = pull[0], pull[1], pull[2] - i * load
    return x, y, z, math.sqrt(x * x + y * y + z * z)


@kernel
def energy_of(pull, way, segments, length, stiffness, load):
    """Complementary energy of a chain, J: a convex function of the pull, whose gradient is by how much it misses its end."""
    total = 0.0
    for i in range(segments):
        size = tension_of(i, pull, load)[3]
        total += size + 0.5 * size**2 / stiffness
    return length * total - (pull[0] * way[0] + pull[1] * way[1] + pull[2] * way[2])


@kernel
def miss_and_slope(pull, way, A, b, segments, length, stiffness, load):
    """By how much the end is missed into b, (3,), m, and its derivatives after the pull into A, (3, 3); False at no tension."""
    for j in range(3):
        b[j] = 0.0
        for k in range(3):
            A[j, k] = 0.0
    for i in range(segments):
        x, y, z, size = tension_of(i, pull, load)
        if not size > 0.0:
            return False
        x, y, z, long = x / size, y / size, z / size, length * (1.0 + size / stiffness)
        b[0] += long * x
        b[1] += long * y
        b[2] += long * z
        A[0, 0] += (1.0 - x * x) / size
        A[1, 1] += (1.0 - y * y) / size
        A[2, 2] += (1.0 - z * z) / size
        A[0, 1] -= x * y / size
        A[0, 2] -= x * z / size
        A[1, 2] -= y * z / size
    for j in range(3):
        b[j] -= way[j]
        A[j, j] = length * (1.0 / stiffness * segments + A[j, j])
        for k in range(j):
            A[k, j] *= length
            A[j, k] = A[k, j]
    return True


@kernel
def size_of(v):
    """Length of a vector."""
    return math.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])


@kernel
def lay(nodes, pull, segments, length, stiffness, load):
    """Nodes between the ends for a pull."""
    x = y = z = 0.0
    for i in range(segments - 1):
        a, b, c, size = tension_of(i, pull, load)
        long = length * (1.0 + size / stiffness)
        x, y, z = x + long * (a / size), y + long * (b / size), z + long * (c / size)
        nodes[3 * i], nodes[3 * i + 1], nodes[3 * i + 2] = x, y, z


@kernel
def leg(tension, length, stiffness):
    """Drop of a segment that hangs straight down from a node below it, m; the tension is negative where it hangs from above."""
    return length * ((1.0 if tension > 0.0 else -1.0 if tension < 0.0 else 0.0) + tension / stiffness)


@kernel
def lay_legs(nodes, way, segments, length, stiffness, load):
    """Nodes between the ends where two legs hang straight down, with a slack segment between them; False if it is too short."""
    for k in range(segments):
        rest = 0.0
        for i in range(segments):
            rest += leg(load * (k - i), length, stiffness)
        if math.sqrt(way[0] * way[0] + way[1] * way[1] + (way[2] - rest) * (way[2] - rest)) > length:
            continue
        z = 0.0
        for i in range(segments - 1):
            z += way[2] - rest if i == k else leg(load * (k - i), length, stiffness)
            nodes[3 * i], nodes[3 * i + 1], nodes[3 * i + 2] = way[0] if i >= k else 0.0, way[1] if i >= k else 0.0, z
        return True
    return False


@kernel
def first_pull(first, way, segments, length, stiffness, load):
    """A pull to begin with, into first, (3,): that of a straight line, of two legs, or of an inextensible cable."""
    whole, distance = segments * length, size_of(way)
    if distance > whole / NEARLY:  # a straight line, and half the weight
        for j in range(3):
            first[j] = stiffness * (distance / whole - 1.0) / distance * way[j]
        first[2] += (0.5 * segments + 0.25) * load
    elif math.hypot(way[0], way[1]) < 1e-3 * length:  # two legs without a slack segment between, of k + 1 and n - k - 1 segments
        nearest, best = 0, math.inf
        for k in range(segments):
            away = abs((2 * (k + 1) - segments) * math.copysign(1.0, load) - way[2] / length)
            if away < best:
                nearest, best = k, away
        first[0], first[1], first[2] = 0.0, 0.0, load * (0.5 + nearest)
    else:
        shorter, up = min(1.0, NEARLY * whole / distance), math.copysign(1.0, load)
        x, y, z = catenary_pull(shorter * way[0], shorter * way[1], shorter * way[2] * up, whole, abs(load) / length)
        first[0], first[1], first[2] = x, y, up * z


@kernel
def relax(work, segments, length, stiffness, load):
    """Newton's method for the pull, down the complementary energy, from the one that stands in work[PULL]; returns a status."""
    pull, way, step, trial, miss, A = work[PULL], work[WAY], work[STEP], work[TRIAL], work[MISS], work[SLOPE:]
    whole = segments * length
    for _ in range(ITERATIONS):
        if not miss_and_slope(pull, way, A, miss, segments, length, stiffness, load):
            return NOT_CONVERGED
        if size_of(miss) < 1e-13 * whole:
            return DONE
        for j in range(3):
            step[j] = miss[j]
        if solve_dense(A, step) != DONE:
            return NOT_CONVERGED
        fall = miss[0] * step[0] + miss[1] * step[1] + miss[2] * step[2]
        share, here = 1.0, energy_of(pull, way, segments, length, stiffness, load)
        while share > SHORTEST:
            for j in range(3):
                trial[j] = pull[j] - share * step[j]
            if not energy_of(trial, way, segments, length, stiffness, load) > here - 1e-4 * share * fall:
                break
            share *= 0.5
        if share <= SHORTEST:
            break  # rounding of the energy: as near as it gets
        for j in range(3):
            pull[j] = trial[j]
    return DONE if size_of(miss) < 1e-6 * whole else NOT_CONVERGED


@kernel
def hanging_chain(nodes, work, segments, length, stiffness, load):
    """Nodes between the ends of a chain at rest, into nodes, three numbers each, from its first end; returns a status.

    work: (9, 3), of which work[WAY] is the way from the first end to the last. A slack chain without load may lie anyhow: it
    takes the shape of a hanging one. Where one end is nearly above the other, two legs hang straight down, and the segment
    between them is slack.
    """
    way = work[WAY]
    if load == 0.0:
        if size_of(way) > segments * length * (1.0 - 1e-9):
            for i in range(segments - 1):
                for j in range(3):
                    nodes[3 * i + j] = (i + 1) / segments * way[j]
            return DONE
        stiffness, load = LIMP, UNIT
    if lay_legs(nodes, way, segments, length, stiffness, load):
        return DONE
    first, pull = work[FIRST], work[PULL]
    first_pull(first, way, segments, length, stiffness, load)
    widened = 1.0
    for _ in range(4):  # Newton may run into the kink of a segment without tension: then from farther off
        pull[0], pull[1], pull[2] = widened * first[0], widened * first[1], first[2]
        if relax(work, segments, length, stiffness, load) == DONE:
            lay(nodes, pull, segments, length, stiffness, load)
            return DONE
        widened = 3.0 if widened == 1.0 else 10.0 if widened == 3.0 else 100.0
    return NOT_CONVERGED
