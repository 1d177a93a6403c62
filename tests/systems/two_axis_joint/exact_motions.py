"""Exact numbers of chain, pendulum and gimbal that tests compare simulations with, beside those of `closed_forms`."""

import math

import numpy as np
from cosimo.components.core.errors import BadInput
from cosimo.components.two_axis_joint.chain import TwoLinkChain
from cosimo.components.two_axis_joint.closed_forms import SmallMotion, small_motion
from scipy.special import ellipj, ellipk


def quartic(motion: SmallMotion) -> np.ndarray:
    """Coefficients of det(lambda² M + lambda D + K), the highest power first, (5,)."""
    M, D, K = motion
    return np.array([
        np.linalg.det(M),
        M[0, 0] * D[1, 1] + M[1, 1] * D[0, 0] - 2.0 * M[0, 1] * D[0, 1],
        M[0, 0] * K[1, 1] + M[1, 1] * K[0, 0] - 2.0 * M[0, 1] * K[0, 1] + np.linalg.det(D),
        D[0, 0] * K[1, 1] + D[1, 1] * K[0, 0] - 2.0 * D[0, 1] * K[0, 1],
        np.linalg.det(K),
    ])  # fmt: skip


def proportional_dampers(chain: TwoLinkChain, second: float) -> float:
    """Damping of the first joint, N.m.s/rad, with which the chain's damping is proportional, for that of the second.

    Dampers in the joints leave one free number, D = mu M + nu K with mu = -d2 / M12; a first damper below zero is refused.
    """
    M, _, K = small_motion(chain)
    if K[1, 1] == 0.0 or M[0, 1] == 0.0:
        raise BadInput("proportional damping", "a second link without weight", "gravity, and a second mass off its joint")
    mu = -second / M[0, 1]
    first = mu * M[0, 0] + (second - mu * M[1, 1]) / K[1, 1] * K[0, 0] - second
    if first < 0.0:
        raise BadInput(
            "proportional damping",
            f"a chain that needs a first damper of {first:g} N.m.s/rad",
            "one of at least 0",
            "Give the first link less inertia for its weight.",
        )
    return float(first)


def pendulum_period(frequency: float, amplitude: float) -> float:
    """Period of th'' + frequency² sin th = 0 for an amplitude below pi, s: 4 K(sin(amplitude / 2)) / frequency."""
    mean, other = 1.0, math.cos(0.5 * amplitude)
    while abs(mean - other) > 1e-15 * mean:  # K by the arithmetic-geometric mean
        mean, other = 0.5 * (mean + other), math.sqrt(mean * other)
    return 2.0 * math.pi / (frequency * mean)


def pendulum_motion(frequency: float, amplitude: float, t) -> tuple[np.ndarray, np.ndarray]:
    """Angle and rate at times t of th'' + frequency² sin th = 0, released at the amplitude at t = 0."""
    modulus = math.sin(0.5 * amplitude)
    sn, cn, *_ = ellipj(ellipk(modulus**2) - frequency * np.asarray(t, dtype=float), modulus**2)
    return 2.0 * np.arcsin(modulus * sn), -2.0 * frequency * modulus * cn


def inertial_period(
    momentum: float, amplitude: float, frame_inertia: float, inner_inertia: float, cross_inertia: float, axial_inertia: float
) -> float:
    """Period of the inner angle of a gimbal without torques, s; amplitude: rad below pi/2 from the stable position; 0: the limit.

    Momentum about the outer axis, p = J(b) a', and energy are constant, which leaves t = int db / sqrt((2 E - p² / J(b)) / A).
    The body oscillates about b = 0 where C > B, else about pi/2. With sin e = sin(amplitude) sin u, e counted from there, the
    integrand is smooth and periodic in u, and equal steps converge faster than any power.
    """  # fmt: skip
    near, far = max(cross_inertia, axial_inertia), min(cross_inertia, axial_inertia)
    if momentum == 0.0 or near == far or not 0.0 <= amplitude < 0.5 * math.pi:
        raise BadInput("the inertial period", f"p = {momentum:g} N.m.s, B = {cross_inertia:g}, C = {axial_inertia:g} kg.m2, "
                       f"amplitude {amplitude:g} rad", "a momentum, two different inertias, an amplitude below pi/2")  # fmt: skip

    def inertia(square):
        return frame_inertia + near - (near - far) * square

    top, last, n = math.sin(amplitude) ** 2, math.nan, 16
    while True:
        square = top * np.sin(2.0 * math.pi / n * np.arange(n)) ** 2
        period = 2.0 * math.pi * float(np.mean(np.sqrt(
            inner_inertia * inertia(square) * inertia(top) / (momentum**2 * (near - far) * (1.0 - square)))))  # fmt: skip
        if abs(period - last) <= 1e-14 * period or n >= 1 << 20:
            return period
        last, n = period, 2 * n


def nutation_frequency(spin_momentum: float, outer_inertia: float, inner_inertia: float) -> float:
    """Frequency of the small fast motion of a gimbal with a rotor across both axes, rad/s: h / sqrt(J_outer J_inner)."""
    return abs(spin_momentum) / math.sqrt(outer_inertia * inner_inertia)


def precession_rate(torque: float, spin_momentum: float, inclination: float) -> float:
    """Rate of the outer axis that holds a torque on the inner one, rad/s: torque / (h cos inclination); without end at pi/2."""
    return torque / (spin_momentum * math.cos(inclination))
