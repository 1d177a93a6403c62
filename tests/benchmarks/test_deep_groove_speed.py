"""Speed of the deep groove bearing: one evaluation inside compiled code and from Python, and a static equilibrium.

Run with `pytest -n 0 tests/benchmarks --write-page`. Nothing here is a statement about another machine.
"""

import time

import numpy as np
import pytest
from cosimo.components.bearings.deep_groove import DeepGrooveBearing
from cosimo.components.bearings.geometry import BallGeometry
from cosimo.components.bearings.hertz import effective_modulus
from cosimo.components.bearings.loads import static_loads
from cosimo.components.bearings.motion import DISPLACEMENT
from cosimo.components.bearings.six_dof import bearing_outputs
from cosimo.tests.support import initialized
from cosimo.tests.systems.bearings.ring_contacts import ball_contacts

njit = pytest.importorskip("numba").njit

RACES = ("inner_waviness", "outer_waviness")
FULL = {f"{race}.amplitude[{i}]": 1e-7 for race in RACES for i in range(1, 9)}
SETTINGS = {
    "contacts alone": ((), {}),
    "film, one wave in each race": (("film", *RACES), {}),
    "film, eight waves in each race": (("film", *RACES), FULL),
    "the same with tangent and dampers": (("film", "damping", *RACES, "linearisation"), FULL),
    "all effects": (tuple(DeepGrooveBearing.effects), FULL),
}


@njit
def many(n, s, p, e):
    """Evaluations with a moving inner ring, as in a rotor's loop."""
    for _ in range(n):
        s.u[0, 0] += 1e-12
        s.x[1] += 1e-6
        bearing_outputs(0.0, s, p, e)


def turning(effects, parameters):
    """A loaded bearing with nine balls at 3000 rpm."""
    bearing = DeepGrooveBearing(effects, parameters)
    for name, value in zip((*DISPLACEMENT, "speed"), (8e-6, -6e-6, 2e-5, 2e-4, 1e-4, 314.0), strict=True):
        bearing.set(name, value)
    return initialized(bearing)


def shortest(call, runs=7):
    """Least time of several runs, s."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times)


def test_evaluation_takes_under_three_microseconds(told):
    n, measured = 20000, {}
    for label, (effects, parameters) in SETTINGS.items():
        bearing = turning(effects, parameters)
        many(1, *bearing.arguments)
        measured[label] = 1e6 * shortest(lambda b=bearing: many(n, *b.arguments)) / n
        bearing.step(0.0, 1e-6)
        python = 1e6 * shortest(lambda b=bearing: [b.step(0.0, 1e-7) for _ in range(1000)]) / 1000
        told("deep groove bearing", label, µs_compiled=measured[label], µs_a_step_from_Python=python)
    assert measured["film, eight waves in each race"] < 3.0


def test_equilibrium_takes_under_five_milliseconds(told):
    """All five loads, with clearance, one ball, axial at contact angle 0, and a small load, which comes down from a large one."""
    geometry = BallGeometry(9, 0.0111, 0.0535)
    K = geometry.stiffness(effective_modulus(2.06e11, 0.3, 2.06e11, 0.3))
    loads = {
        "radial, 1 kN": [1000.0, 0, 0, 0, 0],
        "all five": [600.0, -900.0, 300.0, 4.0, -5.0],
        "axial, contact angle 0": [0, 0, 1000.0, 0, 0],
        "1 mN": [1e-3, 2e-3, 1e-3, 0, 0],
    }
    for clearance in (0.0, 20e-6, -5e-6):
        contacts = ball_contacts(geometry, K, clearance)
        for label, forces in loads.items():
            load = np.array(forces, dtype=float)
            static_loads(contacts, load)
            seconds = shortest(lambda c=contacts, f=load: [static_loads(c, f) for _ in range(20)]) / 20
            if clearance > 0.0:
                told("equilibrium", label, ms=1e3 * seconds)
            assert seconds < 5e-3
