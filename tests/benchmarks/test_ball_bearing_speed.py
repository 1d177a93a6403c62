"""Speed of the ball bearing with two degrees of freedom: accuracy over cost, beside SciPy in the same run.

Run with `pytest -n 0 tests/benchmarks --write-page`. 8 balls, 20 µm radial clearance, 3000 rpm: contacts open and close all the time.
SciPy gets a right-hand side that Numba has compiled, the same operations as the component's kernel, with the constants
compiled in; what is compared is the whole loop.
"""

import math
import time

import numpy as np
from cosimo.components.bearings.ball_bearing import BallBearing
from cosimo.components.bearings.dimensionless import scales
from cosimo.tests.support import initialized
from numba import njit
from scipy.integrate import solve_ivp

RPM, GAP, END, STEP = 3000.0, 20e-6, 0.5, 1e-3
SPEED = RPM * 2.0 * math.pi / 60.0
GRID = round(END / STEP)
WANTED = 1e-3  # largest error of x and y over the largest x


def bearing(substep):
    return initialized(BallBearing(["clearance"], {"clearance.radial_clearance": GAP, "speed": SPEED, "substep": substep}))


def motion(substep):
    """Displacements at every macro step, (2, GRID), and the stepping time, s per simulated second."""
    made, rows = bearing(substep), np.empty((GRID, 2))
    start = time.perf_counter()
    for k in range(GRID):
        made.step(k * STEP, STEP)
        rows[k] = made.y[:2]
    return rows.T, (time.perf_counter() - start) / END


def best(function, runs=5):
    """The result and the shortest of several times."""
    results = [function() for _ in range(runs)]
    return results[-1][0], min(seconds for _, seconds in results)


LOAD = 196.0


def right_hand_side():
    """x' of the bearing, compiled with its constants."""
    s = bearing(5e-5).arguments[0]
    p = s.constants
    (cosine, sine), k, m, damping, cage = s.balls[:2].copy(), p.stiffness, p.mass, p.damping, p.cage_ratio * SPEED

    @njit(error_model="numpy")
    def rates(t, x):
        c, s = math.cos(cage * t), math.sin(cage * t)
        along, across = c * x[0] + s * x[1], c * x[1] - s * x[0]
        fa, fb = 0.0, 0.0
        for j in range(cosine.size):
            delta = along * cosine[j] + across * sine[j] - GAP
            if delta > 0.0:
                q = k * delta * math.sqrt(delta)
                fa += q * cosine[j]
                fb += q * sine[j]
        dx = np.empty(4)
        dx[0], dx[1] = x[2], x[3]
        dx[2], dx[3] = (LOAD - damping * x[2] - c * fa + s * fb) / m, (-damping * x[3] - s * fa - c * fb) / m
        return dx

    rates(0.0, np.zeros(4))
    return rates


def scipy_motion(rates, method, rtol):
    """The same by SciPy, with an absolute tolerance for each state."""
    by = scales(bearing(5e-5))
    atol = rtol * by.length * np.array([1.0, 1.0, 1.0 / by.time, 1.0 / by.time])
    start, grid = bearing(5e-5).x[:4], STEP * np.arange(1, GRID + 1)
    before = time.perf_counter()
    found = solve_ivp(rates, (0.0, END), start, method, t_eval=grid, rtol=rtol, atol=atol)
    seconds = (time.perf_counter() - before) / END
    assert found.success
    return found.y[:2], seconds


def test_accuracy_costs_less_than_with_scipy(told):
    """At an error of 1e-3 at most 0.03 s per simulated second, and at least ten times faster than SciPy's best method."""
    exact, _ = motion(2e-7)
    rates = right_hand_side()

    def error(found):
        return float(np.abs(found - exact).max() / np.abs(exact[0]).max())

    own, theirs = [], []
    for substep in (2e-4, 1e-4, 1e-3 / 15, 5e-5, 2.5e-5, 1e-5):
        found, seconds = best(lambda h=substep: motion(h))
        own.append((error(found), seconds))
    for method in ("RK45", "DOP853", "LSODA", "Radau", "BDF"):
        for rtol in (1e-3, 1e-4, 1e-5, 1e-6, 1e-8):
            found, seconds = scipy_motion(rates, method, rtol)
            if method in ("RK45", "DOP853", "LSODA"):
                seconds = min(seconds, *(scipy_motion(rates, method, rtol)[1] for _ in range(2)))
            theirs.append((error(found), seconds, method))
    for wanted in (1e-2, WANTED, 1e-5):
        fastest = min(seconds for e, seconds in own if e <= wanted)
        rival, method = min((seconds, name) for e, seconds, name in theirs if e <= wanted)
        told(
            "ball bearing",
            f"{wanted:g}",
            cosimo_ms=1e3 * fastest,
            SciPy_ms=1e3 * rival,
            best_method=method,
            ratio=rival / fastest,
        )
    fastest = min(seconds for e, seconds in own if e <= WANTED)
    rival = min(seconds for e, seconds, _ in theirs if e <= WANTED)
    assert fastest <= 0.03
    assert rival >= 10.0 * fastest


def test_price_of_an_effect(told):
    """What is off costs nothing; what each effect adds to the bare bearing, printed."""

    def cost(effects, parameters):
        made = BallBearing(effects, parameters)
        made.initialize(0.0)
        made.step(0.0, 1e-3)

        def once():
            start = time.perf_counter()
            made.step(0.0, END)
            return None, (time.perf_counter() - start) / (4 * round(END / made["substep"]))

        return best(once)[1]

    bare = cost((), {})
    told("effects", "ball bearing without effects", ns_an_evaluation=1e9 * bare)
    assert bare < 1e-6
    for effect in BallBearing.effects:
        told("effects", f"`{effect}` more", ns_an_evaluation=1e9 * (cost((effect,), {}) - bare))
