"""Shape of a hanging chain of elastic segments between two points: where a tether starts."""

from __future__ import annotations

import math

import numpy as np

ITERATIONS = 100


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


def _links(pull: np.ndarray, segments: int, length: float, stiffness: float, load: float) -> tuple[np.ndarray, np.ndarray]:
    """Segments as vectors, (n, 3), from the pull in the first one on, and the slope of their sum over that pull, (3, 3)."""
    tension = pull - np.outer(np.arange(segments), [0.0, 0.0, load])
    size = np.linalg.norm(tension, axis=1)
    along = tension / size[:, None]
    vectors = length * (1.0 + size / stiffness)[:, None] * along
    across = np.eye(3) - along[:, :, None] * along[:, None, :]
    slope = length * (np.eye(3) / stiffness * segments + (across / size[:, None, None]).sum(axis=0))
    return vectors, slope


def hanging_chain(way: np.ndarray, segments: int, length: float, stiffness: float, load: float) -> np.ndarray | None:
    """Nodes between the ends of a chain at rest, (n - 1, 3), from its first end; None where no shape was found.

    way: from the first end to the last, m, (3,).  length: of a segment without tension, m.  stiffness: tension per strain, N.
    load: force on each node along the third axis, N.  A slack chain without load may lie anyhow: it takes the shape of a
    hanging one. Where the ends are one above the other, a thousandth of the length is put between them.
    """
    way = way.copy()
    whole = segments * length
    if np.hypot(way[0], way[1]) < 1e-3 * whole and abs(way[2]) < whole:
        way[0] += 1e-3 * whole
    distance = float(np.linalg.norm(way))
    slack = distance < whole * (1.0 - 1e-9)
    if slack and load == 0.0:
        stiffness, load = 1e12, 1.0
    if slack:
        upside = np.array([1.0, 1.0, math.copysign(1.0, load)])
        pull = upside * _catenary_pull(upside * way, whole, abs(load) / length)
    else:
        pull = stiffness * (distance / whole - 1.0 + 1e-9) / distance * way + np.array([0.0, 0.0, 0.5 * whole / length * load])
    for _ in range(ITERATIONS):
        vectors, slope = _links(pull, segments, length, stiffness, load)
        miss = vectors.sum(axis=0) - way
        size = float(np.linalg.norm(miss))
        if size < 1e-13 * whole:
            return np.cumsum(vectors, axis=0)[:-1]
        step, share = np.linalg.solve(slope, miss), 1.0
        while share > 1e-9 and np.linalg.norm(_links(pull - share * step, segments, length, stiffness, load)[0].sum(axis=0)
                                              - way) >= size:
            share *= 0.5
        if share <= 1e-9:
            break
        pull = pull - share * step
    return np.cumsum(vectors, axis=0)[:-1] if size < 1e-9 * whole else None
