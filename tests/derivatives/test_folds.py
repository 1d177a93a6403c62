"""Folds that `cosimo orbit` locates against closed forms and harmonic balance, which know nothing of runs or shooting.

- A Jeffcott rotor in a ring: whirls in contact are circles, whose speed is a function of their radius. Exact.
- A robot on a stiffening spring, its friction so smooth that it is viscous, is Duffing's oscillator on a damped mass. Of its first
  harmonic alone folds have a closed form (Nayfeh and Mook, Nonlinear Oscillations, 1979, 4.1, by the force of the cubic spring on it,
  3/4 k3 A³), which leaves out the third harmonic; with the odd ones up to the ninth harmonic balance is exact to what is judged.
"""

from __future__ import annotations

import math

import cosimo
import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.systems import read_scene
from scipy.optimize import brentq, fsolve, minimize_scalar

if COMPILED:
    from cosimo.orchestrator.derivatives.continuation import COLLISION, FOLD, orbits
    from cosimo.orchestrator.derivatives.orbit import Forcing

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
STEP = 1e-3


def alone(component: str, *effects: str, **parameters):
    unit = {"component": component, "effects": list(effects), "parameters": parameters}
    return read_scene({"stop_time": 1.0, "units": {"unit": unit}, "master": {"step": STEP}})


def parameters_of(scene, *names: str) -> list[float]:
    with cosimo.open(scene) as session:
        session.initialize()
        return [session[f"unit.{name}"] for name in names]


# -- a rotor in a ring -------------------------------------------------------------------------------------------------
def test_folds_of_a_rotor_in_a_ring_are_those_of_the_closed_form():
    """(S - m w²)² + (c w)² = (m e w² / r)² with S = k + K (1 - clearance / r): a quadratic in w², whose root turns back over r.

    The other fold is a corner: where the rotor without contact just reaches the ring, whirls inside and outside lie above that speed.
    """
    scene = alone("cosimo.tests.derivatives.rubbing_rotor:RubbingRotor")
    m, k, c, e, ring, clearance = parameters_of(scene, "mass", "stiffness", "damping", "eccentricity", "ring", "clearance")

    def speed(r: float) -> float:
        s = k + ring * (1.0 - clearance / r)
        a, b = m * m * (1.0 - (e / r) ** 2), c * c - 2.0 * s * m
        return math.sqrt((-b + math.sqrt(b * b - 4.0 * a * s * s)) / (2.0 * a))

    turn = minimize_scalar(lambda r: -speed(r), (1.5 * clearance, 2.0 * clearance, 2.8 * clearance), tol=1e-9)
    study = orbits(scene, Forcing(angle="unit.angle"), ("unit.speed", np.linspace(60.0, 200.0, 15)), steps=200, doublings=0)
    corner, fold = study.marks
    assert (corner.kind, fold.kind) == (COLLISION, FOLD)
    assert fold.orbit.value == pytest.approx(-turn.fun, rel=1e-6)
    assert fold.orbit.high[0] == pytest.approx(turn.x, rel=2e-3)  # where the branch is steep
    assert corner.orbit.value == pytest.approx(speed(clearance), rel=1e-5)
    for point in study.branches[0].points:
        if point.high[0] > 1.01 * clearance and point.value > fold.orbit.value - 8.0:
            assert point.stable == (point.high[0] > fold.orbit.high[0])


# -- a robot on a stiffening spring --------------------------------------------------------------------------------------
FORCE, CUBIC, DRAG, SMOOTH = 20.0, 2e6, 5.0, 1e3  # N, N/m³, N s/m, m/s: tanh is straight to (4/1000)²/3


def robot():
    return alone(
        "PipeRobot", "harmonic_force", "smoothed_friction", "cubic_spring",
        **{"harmonic_force.amplitude": FORCE, "harmonic_force.frequency": 80.0, "cubic_spring.stiffness": CUBIC,
           "forward_friction": DRAG * SMOOTH, "backward_friction": DRAG * SMOOTH, "smoothed_friction.width": SMOOTH},
    )  # fmt: skip


class Balance:
    """Harmonic balance of the stretch s of the spring: Z s = k3 s³ + F, Z of both masses, the drag, spring and damper."""

    def __init__(self, body: float, inner: float, stiffness: float, damping: float):
        self.body, self.inner, self.stiffness, self.damping = body, inner, stiffness, damping

    def impedance(self, w: float) -> complex:
        """Force inside of the pair over its stretch, less that of the straight spring and the damper."""
        moved = 1.0 / (self.inner * w * w) - 1.0 / (-self.body * w * w + 1j * w * DRAG)
        return 1.0 / moved - self.stiffness - 1j * w * self.damping

    def of_one_harmonic(self, sign: float, near: float) -> float:
        """Frequency of a fold: with the stiffness a = 3/4 k3 A² that the cubic spring adds, 3 a² - 4 a Re Z + |Z|² = 0."""

        def left(w: float) -> float:
            z = self.impedance(w)
            a = (2.0 * z.real + sign * math.sqrt(z.real**2 - 3.0 * z.imag**2)) / 3.0
            return abs(z - a) ** 2 * a / (0.75 * CUBIC) - FORCE**2

        return brentq(left, near - 1.0, near + 1.0)

    def of_more(self, amplitude: float, w: float) -> float:
        """Frequency at which the first harmonic has an amplitude, m, near to w, by odd harmonics up to the ninth."""
        orders = np.arange(1, 10, 2)
        t = 2.0 * math.pi * np.arange(64) / 64

        def left(v: np.ndarray) -> np.ndarray:
            s = np.concatenate([[amplitude], amplitude * (v[2:6] + 1j * v[6:10])])
            cubed = np.fft.fft(np.real(np.exp(1j * np.outer(t, orders)) @ s) ** 3)[orders] / 32.0
            rest = np.array([self.impedance(n * v[0] * w) for n in orders]) * s - CUBIC * cubed
            rest[0] -= FORCE * np.exp(1j * v[1])
            return np.concatenate([rest.real, rest.imag]) / FORCE

        z = self.impedance(w)
        angle = np.angle((z - 0.75 * CUBIC * amplitude**2) * amplitude)
        found, _, told, text = fsolve(left, np.array([1.0, angle, *np.zeros(8)]), xtol=1e-12, full_output=True)
        assert told == 1, text
        return float(found[0]) * w

    def turn(self, amplitude: float, w: float, sign: float) -> float:
        """Frequency near to w at which the curve of amplitudes turns back."""
        near = (0.98 * amplitude, 1.01 * amplitude)
        return -sign * float(minimize_scalar(lambda a: -sign * self.of_more(a, w), bounds=near).fun)


def test_folds_of_a_robot_on_a_stiffening_spring_are_those_of_harmonic_balance():
    scene = robot()
    balance = Balance(*parameters_of(scene, "body_mass", "inner_mass", "stiffness", "damping"))
    over = ("unit.harmonic_force.frequency", np.linspace(60.0, 140.0, 9))
    study = orbits(scene, over=over, steps=400, doublings=0)
    folds = sorted((mark.orbit for mark in study.marks if mark.kind == FOLD), key=lambda orbit: orbit.value)
    for orbit, sign in zip(folds, (-1.0, 1.0), strict=True):
        alone = balance.of_one_harmonic(sign, orbit.value)
        z = balance.impedance(alone)
        amplitude = math.sqrt((2.0 * z.real + sign * math.sqrt(z.real**2 - 3.0 * z.imag**2)) / (2.25 * CUBIC))
        assert orbit.value == pytest.approx(alone, rel=3e-3)  # without the third harmonic
        assert orbit.value == pytest.approx(balance.turn(amplitude, alone, sign), rel=2e-6)
