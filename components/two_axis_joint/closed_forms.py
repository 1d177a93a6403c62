"""Exact solutions of the two-axis joint and the two-link chain: what a simulation of them is compared with.

Chain: its small motion, M a + D w + K th = 0 in the absolute angles, and its exact solution
where damping decouples in the modes of the undamped chain. By Caughey and O'Kelly (ASME J. Appl. Mech. 32, 1965, 583-588) that
is where D M^-1 K is symmetric; it includes proportional damping, D = mu M + nu K, and the chain without gravity, K = 0, whatever
its dampers. Akulenko, Bolotnik, Leshchenko, Palii (2020) announce an exact solution "in a partial case"; which one, the abstract,
all that was at hand, does not say: both candidates are here.
Gimbal: the governor. One axis: decay by dry friction.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..core.errors import BadInput
from .chain import TwoLinkChain

COMMUTES = 1e-10  # of the product of two matrices, up to which their difference in either order counts as rounding


class SmallMotion(NamedTuple):
    """M a + D w + K th = 0; th: the absolute angles of both links, small. Each (2, 2), in SI units."""

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray


def small_motion(chain: TwoLinkChain) -> SmallMotion:
    """Matrices of the hanging chain, or of the stretched one without gravity; with gravity and viscous damping as far as they are on."""
    m1, l1, a1, i1 = (chain[f"first_{n}"] for n in ("mass", "length", "centre", "inertia"))
    m2, a2, i2 = (chain[f"second_{n}"] for n in ("mass", "centre", "inertia"))
    g = chain["gravity.acceleration"] if "gravity" in chain.on else 0.0
    d1, d2 = (chain["viscous.first"], chain["viscous.second"]) if "viscous" in chain.on else (0.0, 0.0)
    coupling = m2 * l1 * a2
    return SmallMotion(
        np.array([[i1 + m1 * a1**2 + m2 * l1**2, coupling], [coupling, i2 + m2 * a2**2]]),
        np.array([[d1 + d2, -d2], [-d2, d2]]),
        g * np.diag([m1 * a1 + m2 * l1, m2 * a2]),
    )


def damped_motion(motion: SmallMotion, angles, rates, t) -> tuple[np.ndarray, np.ndarray]:
    """Angles and rates at times t, each (2, n): the exact solution from `angles` and `rates` (2,) at t = 0.

    Refuses damping that couples the modes, whose solution has no such form.
    """
    M, D, K = motion
    root = np.linalg.inv(np.linalg.cholesky(M))
    R, S = root @ D @ root.T, root @ K @ root.T
    r, s = np.linalg.norm(R), np.linalg.norm(S)
    if np.abs(R @ S - S @ R).max() > COMMUTES * r * s:
        raise BadInput(
            "the exact damped motion",
            "damping that couples the modes",
            "D M^-1 K symmetric",
            "Give dampers D = mu M + nu K, or leave gravity out.",
        )
    spread = [np.ptp(np.linalg.eigvalsh(A)) / n if n > 0.0 else 0.0 for A, n in ((R, r), (S, s))]
    modes = root.T @ np.linalg.eigh(R if spread[0] > spread[1] else S)[1]  # of both; M-orthonormal
    decay, square = (np.einsum("ik,ij,jk->k", modes, A, modes) for A in (0.5 * D, K))
    start, speed = modes.T @ M @ np.asarray(angles, dtype=float), modes.T @ M @ np.asarray(rates, dtype=float)
    times = np.atleast_1d(np.asarray(t, dtype=float))
    solutions = [_mode(*values, times) for values in zip(decay, square, start, speed, strict=True)]
    return modes @ np.array([q for q, _ in solutions]), modes @ np.array([v for _, v in solutions])


def _mode(decay: float, square: float, start: float, speed: float, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """q'' + 2 decay q' + square q = 0 from q = start, q' = speed."""
    root = np.emath.sqrt(decay**2 - square)  # imaginary where it oscillates
    slow, fast = -decay + root, -decay - root
    if decay > 0.0 and root.real > 0.0:
        slow = -square / (decay + root)  # of two nearly equal numbers no difference
    grown = np.exp(slow * t)
    # (exp(slow t) - exp(fast t)) / (slow - fast), also where both are one
    response = -grown * np.expm1(-2.0 * root * t) / (2.0 * root) if root != 0.0 else t * grown
    q = start * grown + (speed - slow * start) * response
    rate = start * slow * grown + (speed - slow * start) * (grown + fast * response)
    return np.real(q), np.real(rate)


def friction_turning_points(amplitude: float, friction: float, moment: float) -> list[float]:
    """Angles at which a pendulum with dry friction turns, rad, from its release on, signs alternating; it stays at the last.

    moment: m g l, N.m; friction: N.m, static and kinetic alike. Half a swing from a to b takes friction (a + b) from the height:
    moment (cos b - cos a) = friction (a + b).  Below pi; a spring instead of the weight loses 2 friction / stiffness each time.
    """
    turns = [amplitude]
    while moment * math.sin(abs(turns[-1])) > friction:
        a = abs(turns[-1])
        low, high = -a, a  # angle beyond the middle; at -a nothing has moved, at a more is lost than there was

        def left(b: float, a: float = a) -> float:
            return moment * (math.cos(b) - math.cos(a)) - friction * (a + b)

        low = -math.asin(friction / moment)  # where friction holds the weight: energy is left there
        for _ in range(200):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            low, high = (middle, high) if left(middle) > 0.0 else (low, middle)
        turns.append(math.copysign(1.0, -turns[-1]) * low)
    return turns


def governor_speed(moment: float, cross_inertia: float, axial_inertia: float) -> float:
    """Speed of the imposed outer axis above which the hanging body swings out, rad/s; moment: m g l, N.m."""
    if cross_inertia <= axial_inertia:
        raise BadInput(
            "the governor",
            f"cross and axial inertia of {cross_inertia:g} and {axial_inertia:g} kg.m2",
            "a cross inertia above the axial one",
        )
    return math.sqrt(moment / (cross_inertia - axial_inertia))


def governor(
    speed: float, moment: float, inner_inertia: float, cross_inertia: float, axial_inertia: float
) -> tuple[float, float]:
    """Inner angle at which the body stays, rad, and the frequency of small oscillation about it, rad/s.

    Of A b'' = (B - C) W² sin b cos b - m g l sin b. Hanging below the critical speed, swung out above it.
    """
    critical = governor_speed(moment, cross_inertia, axial_inertia)
    difference = cross_inertia - axial_inertia
    if abs(speed) <= critical:
        return 0.0, math.sqrt(difference * (critical**2 - speed**2) / inner_inertia)
    angle = math.acos((critical / speed) ** 2)
    return angle, math.sqrt(difference * speed**2 / inner_inertia) * math.sin(angle)
