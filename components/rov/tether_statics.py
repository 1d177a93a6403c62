"""Shape of a hanging chain of elastic segments between two points: where a tether starts."""

from __future__ import annotations

import math

import numpy as np

ITERATIONS = 200
NEARLY = 0.99  # of the length: straighter ones are nearly straight
SHORTEST = 1e-9  # share of a Newton step


def _catenary_pull(way: np.ndarray, length: float, weight: float) -> np.ndarray:
    """Pull on the first end, N, (3,), of an inextensible cable of `length` that hangs with `weight` in N/m along the third axis.

    sqrt(L² - h²) / D = sinh(m) / m for the horizontal distance D and the drop h; the horizontal pull is weight D / (2 m).
    """
    level, drop = float(np.hypot(way[0], way[1])), float(way[2])
    ratio = math.sqrt(length**2 - drop**2) / level
    m = math.sqrt(6.0 * (ratio - 1.0)) if ratio < 3.0 else math.log(2.0 * ratio) + math.log(math.log(2.0 * ratio))
    for _ in range(ITERATIONS):
        step = (math.sinh(m) / m - ratio) / (math.cosh(m) / m - math.sinh(m) / m**2)
        m -= step
        if abs(step) < 1e-14 * m:
            break
    pull = 0.5 * weight * level / m
    return np.array([pull * way[0] / level, pull * way[1] / level, 0.5 * weight * (drop / math.tanh(m) + length)])


def _tensions(pull: np.ndarray, segments: int, load: float) -> tuple[np.ndarray, np.ndarray]:
    """Tensions of the segments as vectors, (n, 3), from the pull in the first one on, and their sizes, (n,), N."""
    tension = pull - np.outer(np.arange(segments), [0.0, 0.0, load])
    return tension, np.linalg.norm(tension, axis=1)


def hanging_chain(way: np.ndarray, segments: int, length: float, stiffness: float, load: float) -> np.ndarray | None:
    """Nodes between the ends of a chain at rest, (n - 1, 3), from its first end; None where no shape was found.

    way: from the first end to the last, m, (3,).  length: of a segment without tension, m.  stiffness: tension per strain, N.
    load: force on each node along the third axis, N.  A slack chain without load may lie anyhow: it takes the shape of a
    hanging one. Where one end is nearly above the other, two legs hang straight down, and the segment between them is slack.
    """
    whole = segments * length
    distance = float(np.linalg.norm(way))
    if load == 0.0 and distance > whole * (1.0 - 1e-9):
        return np.outer(np.arange(1, segments) / segments, way)
    if load == 0.0:
        stiffness, load = 1e12, 1.0
    for k in range(segments) if load != 0.0 else ():
        tension = load * (k - np.arange(segments))
        vectors = np.outer(length * (np.sign(tension) + tension / stiffness), [0.0, 0.0, 1.0])
        vectors[k] = way - vectors.sum(axis=0)
        if np.linalg.norm(vectors[k]) <= length:
            return np.cumsum(vectors, axis=0)[:-1]
    steep = np.hypot(way[0], way[1]) < 1e-3 * length
    if distance > whole / NEARLY:  # a straight line, and half the weight
        pull = stiffness * (distance / whole - 1.0) / distance * way + np.array([0.0, 0.0, (0.5 * segments + 0.25) * load])
    elif steep:  # two legs without a slack segment between them, of k + 1 and n - k - 1 segments
        ways = np.array([2 * (k + 1) - segments for k in range(segments)])
        pull = np.array([0.0, 0.0, load * (0.5 + np.argmin(np.abs(ways * math.copysign(1.0, load) - way[2] / length)))])
    else:
        upside = np.array([1.0, 1.0, math.copysign(1.0, load)])
        sagging = way * min(1.0, NEARLY * whole / distance)
        pull = upside * _catenary_pull(upside * sagging, whole, abs(load) / length)
    for widened in (1.0, 3.0, 10.0, 100.0):  # Newton may run into the kink of a segment without tension: then from farther off
        nodes = _relaxed(pull * (widened, widened, 1.0), way, segments, length, stiffness, load)
        if nodes is not None:
            return nodes
    return None


def _relaxed(pull: np.ndarray, way: np.ndarray, segments: int, length: float, stiffness: float, load: float) -> np.ndarray | None:
    """Nodes of `hanging_chain` from a first pull on.

    The way of a chain is the gradient of a convex function of the pull, its complementary energy: Newton goes down on that.
    """
    def height(pull: np.ndarray) -> float:
        size = _tensions(pull, segments, load)[1]
        return float(length * (size + 0.5 * size**2 / stiffness).sum() - pull @ way)

    whole = segments * length
    for _ in range(ITERATIONS):
        tension, size = _tensions(pull, segments, load)
        along = tension / size[:, None]
        vectors = length * (1.0 + size / stiffness)[:, None] * along
        miss = vectors.sum(axis=0) - way
        if np.linalg.norm(miss) < 1e-13 * whole:
            break
        across = np.eye(3) - along[:, :, None] * along[:, None, :]
        slope = length * (np.eye(3) / stiffness * segments + (across / size[:, None, None]).sum(axis=0))
        step, share, here = np.linalg.solve(slope, miss), 1.0, height(pull)
        while share > SHORTEST and height(pull - share * step) > here - 1e-4 * share * float(miss @ step):
            share *= 0.5
        if share <= SHORTEST:
            break  # rounding of the energy: as near as it gets
        pull = pull - share * step
    return np.cumsum(vectors, axis=0)[:-1] if np.linalg.norm(miss) < 1e-6 * whole else None
