"""Exact solutions of a servo motor with constant voltage and load: what simulations of it are compared with."""

import cmath
from typing import NamedTuple

import numpy as np
from cosimo.components.drives.servo_motor import ServoMotor


class Steady(NamedTuple):
    """The steady state of a motor: rate of the wheel, rad/s, and current, A."""

    rate: float
    current: float


def wheel_constants(motor: ServoMotor) -> tuple[float, float, float]:
    """(J, B, K): inertia, viscous damping and torque per current at the wheel, in kg.m², N.m.s/rad and N.m/A."""
    gear = motor["gear_ratio"]
    return gear**2 * motor["rotor_inertia"] + motor["wheel_inertia"], gear**2 * motor["damping"], gear * motor["constant"]


def poles(motor: ServoMotor) -> tuple[complex, complex]:
    """The two poles of rate and current with `inductance`, 1/s, the slower one first."""
    (J, B, K), R, L = wheel_constants(motor), motor["resistance"], motor["inductance.inductance"]
    half, product = 0.5 * (R / L + B / J), (K**2 + R * B) / (L * J)
    fast = -half - cmath.sqrt(half**2 - product)
    return product / fast, fast  # the slow one by Vieta: no difference of nearly equal numbers


def steady(motor: ServoMotor, voltage: float, load: float = 0.0) -> Steady:
    """Rate and current at last, without dry friction; load in N.m at the wheel, against the rate."""
    (_, B, K), R = wheel_constants(motor), motor["resistance"]
    rate = (K * voltage - R * load) / (K**2 + R * B)
    return Steady(rate, (voltage - K * rate) / R)


def step_response(motor: ServoMotor, t: np.ndarray, voltage: float, load: float = 0.0) -> np.ndarray:
    """Angle, rate and current of a motor with `inductance` at times t after a step from rest, (len(t), 3); its poles must differ.

    rate = w + c1 e^(p1 t) + c2 e^(p2 t) with rate(0) = 0 and J rate'(0) = -load; the current follows from J rate' and the angle
    by integration.
    """
    (J, B, K), (p1, p2), end = wheel_constants(motor), poles(motor), steady(motor, voltage, load)
    t = np.asarray(t, dtype=float)
    c1 = (-load / J + p2 * end.rate) / (p1 - p2)
    c2 = -end.rate - c1
    e1, e2 = np.exp(p1 * t), np.exp(p2 * t)
    rate = end.rate + c1 * e1 + c2 * e2
    current = (J * (c1 * p1 * e1 + c2 * p2 * e2) + B * rate + load) / K
    angle = end.rate * t + c1 / p1 * np.expm1(p1 * t) + c2 / p2 * np.expm1(p2 * t)
    return np.stack((angle.real, rate.real, current.real), axis=-1)
