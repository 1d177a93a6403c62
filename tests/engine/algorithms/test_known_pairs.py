"""Published pairs with exact answers: the preCICE oscillator, the pair of PyFMI's tests, a quarter car, a mass in two parts."""

import numpy as np
import pytest
from cosimo.orchestrator.settings import IterationSettings
from cosimo.tests.engine.algorithms.oscillators import HERE, STATES, TwoMasses, give_past, open_master, radius
from cosimo.tests.short_run import full_but
from cosimo.tests.slopes import slope
from scipy.linalg import expm

ALGORITHMS = ["jacobi", "gauss-seidel", "iterative"]
BAND = (0.15, 0.15, 0.5)  # of the slope, by degree


# -- preCICE -----------------------------------------------------------------------------------------------------------


def precice_oscillator(t: float) -> np.ndarray:
    """(u1, v1, u2, v2) of the tutorial "oscillator" (Schüller, Rodenberg, Uekermann and Bungartz 2022): w = 2 pi and 6 pi."""
    w, z = 2.0 * np.pi, 6.0 * np.pi
    cw, cz, sw, sz = np.cos(w * t), np.cos(z * t), w * np.sin(w * t), z * np.sin(z * t)
    return 0.5 * np.array([cw + cz, -sw - sz, cw - cz, -sw + sz])


PRECICE = TwoMasses(k1=4.0 * np.pi**2, kc=16.0 * np.pi**2, k2=4.0 * np.pi**2, c1=0.0, cc=0.0, c2=0.0, start=(1.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize("degree", full_but((1,), (0, 1, 2)))
@pytest.mark.parametrize("split", full_but(("FD",), ("FF", "FD", "DD")))
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_orders_on_the_precice_oscillator(algorithm, split, degree):
    """At t = 1, the period, errors of odd order cancel in some schemes, so the largest error of the whole second counts."""
    steps = (4e-3, 2e-3)

    def signals(t: float) -> dict:
        x1, v1, x2, v2 = precice_oscillator(t)
        force = PRECICE.kc * (x2 - x1)
        return dict(zip(STATES, (x1, v1, x2, v2), strict=True)) | {("b", "force"): force, ("f", "force"): force}

    errors = []
    for step in steps:
        master = open_master(PRECICE.scene(split, step, algorithm=algorithm, extrapolation=degree))
        give_past(master, signals, step, degree)
        worst = 0.0
        for k in range(round(1.0 / step)):
            master.step(k * step, step)
            reached = np.array([master.signals[master.positions[end]] for end in STATES])
            worst = max(worst, np.abs(reached - precice_oscillator((k + 1) * step))[::2].max())
        errors.append(worst)
    assert errors[-1] < 0.1  # amplitudes are 1: no slope of something that has gone astray
    assert abs(slope(steps, errors) - (degree + 1)) < BAND[degree]


# -- PyFMI -------------------------------------------------------------------------------------------------------------


def pyfmi_pair(gain: float, step: float, **master) -> dict:
    """x1' = -0.9 x1 + 0.5 y2, y1 = 3 x1 + y2; x2' = -x2 + 10 y1, y2 = -31 x2 + gain y1; both 1 at the start."""
    one = {"component": f"{HERE}:Feedthrough"}
    two = {**one, "parameters": {"a": -1.0, "b": 10.0, "c": -31.0, "d": gain}}
    return {
        "stop_time": 1.0,
        "units": {"one": one, "two": two},
        "master": {"step": step, **master},
        "connections": ["one.y_out -> two.u_in", "two.y_out -> one.u_in"],
    }


def exact_pyfmi_pair(gain: float, t: float) -> np.ndarray:
    """(x1, x2): y1 = (3 x1 - 31 x2) / (1 - gain), y2 = y1 - 3 x1."""
    y1 = np.array([3.0, -31.0]) / (1.0 - gain)
    y2 = y1 - np.array([3.0, 0.0])
    return expm(np.array([[-0.9, 0.0] + 0.5 * y2, [0.0, -1.0] + 10.0 * y1]) * t) @ [1.0, 1.0]


def pyfmi_states(gain: float, step: float, stop: float = 1.0, **master) -> np.ndarray:
    found = open_master(pyfmi_pair(gain, step, **master), [("one", "x_out"), ("two", "x_out")])
    for k in range(round(stop / step)):
        found.step(k * step, step)
    return np.array([found.signals[found.positions[u, "x_out"]] for u in ("one", "two")])


def test_exact_answer_of_the_pyfmi_pair_is_the_published_one():
    """PyFMI's numbers are those of a solver; they agree with the matrix exponential to eight digits."""
    np.testing.assert_allclose(exact_pyfmi_pair(-0.9, 1.0), [0.0859764038708439, 0.008392664839635064], rtol=1e-8)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("gain", full_but((1.1,), (-0.9, 1.1, -3.0)))
def test_orders_on_a_pair_in_an_algebraic_loop(gain, algorithm):
    """A loop gain beyond 1 makes the plain exchange unstable for any step; solved loops do not mind."""
    stop = 1.0 if gain < 1.0 else 1e-3  # with 1.1 the solution itself grows, like e^(3100 t)
    for degree in (0, 1):
        steps = [stop / 800.0, stop / 1600.0]
        reached = [pyfmi_states(gain, h, stop, algorithm=algorithm, extrapolation=degree) for h in steps]
        errors = [np.abs(states - exact_pyfmi_pair(gain, stop)).max() for states in reached]
        assert abs(slope(steps, errors) - (degree + 1)) < BAND[degree], degree


def test_stale_outputs_of_the_pyfmi_pair_are_stable_and_unstable_where_pyfmi_says():
    stale = {"algorithm": "jacobi", "extrapolation": 0, "feedthrough": "delayed"}
    assert radius(pyfmi_pair(-0.9, 0.0005, **stale)) < 1.0 < radius(pyfmi_pair(-0.9, 0.005, **stale))
    for step in (1e-6, 1e-4, 1e-2):  # beyond a loop gain of 1 no step helps (Kübler and Schiehlen 2000)
        assert radius(pyfmi_pair(1.1, step, **stale)) > 1.0
        assert radius(pyfmi_pair(-3.0, step, **stale)) > 1.0
        assert radius(pyfmi_pair(-3.0, step, algorithm="iterative", extrapolation=1)) < 1.0  # the solution itself decays


# -- quarter car -------------------------------------------------------------------------------------------------------

# wheel (tyre to the road) and body (suspension to the wheel); FMITest's parameters; standing 0.1 m below where the road is now
CAR = TwoMasses(m1=15.0, m2=290.0, k1=191e3, c1=2500.0, kc=16.2e3, cc=1000.0, k2=0.0, c2=0.0, start=(-0.1, 0.0, -0.1, 0.0))


@pytest.mark.parametrize("degree", full_but((1,), (0, 1, 2)))
@pytest.mark.parametrize("split", full_but(("FD",), ("FF", "FD", "DD")))
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_orders_on_a_quarter_car_over_a_step_in_the_road(algorithm, split, degree):
    steps = (2e-4, 1e-4)

    def signals(t: float) -> dict:
        x1, v1, x2, v2 = CAR.exact(t)
        force = CAR.kc * (x2 - x1) + CAR.cc * (v2 - v1)
        return dict(zip(STATES, (x1, v1, x2, v2), strict=True)) | {("b", "force"): force, ("f", "force"): force}

    errors = []
    for step in steps:
        master = open_master(CAR.scene(split, step, algorithm=algorithm, extrapolation=degree))
        give_past(master, signals, step, degree)
        for k in range(round(0.05 / step)):
            master.step(k * step, step)
        reached = np.array([master.signals[master.positions[end]] for end in STATES])
        errors.append(np.abs(reached - CAR.exact(0.05)).max())
    assert errors[-1] < 0.02  # m/s, of some 2 m/s
    assert abs(slope(steps, errors) - (degree + 1)) < BAND[degree]


# -- one mass in two parts ---------------------------------------------------------------------------------------------


def test_a_mass_in_two_parts_needs_more_than_a_fixed_point():
    """m = k = 1, cut with shares 0.45 of the mass and 0.5 of the stiffness (Sicklinger et al. 2014): gain -0.55/0.45 a sweep."""
    errors, steps = [], (0.1, 0.05, 0.025)
    for step in steps:
        scene = {
            "stop_time": 1.0,
            "units": {"a": {"component": f"{HERE}:Accelerated"}, "b": {"component": f"{HERE}:Carried"}},
            "connections": ["b.force -> a.force", "a.x_out -> b.position", "a.a_out -> b.acceleration"],
            "master": {"algorithm": "iterative", "step": step, "extrapolation": 1},
        }
        master = open_master(scene, [("a", "x_out")], IterationSettings(tolerance=1e-8, max_iterations=6))
        for k in range(round(1.0 / step)):
            master.step(k * step, step)
        errors.append(abs(master.signals[master.positions["a", "x_out"]] - np.cos(1.0)))
        # a linear circle cut at one signal: one correction, and a first secant
        assert master.algorithm.iterations <= 2.2 * master.steps
    assert abs(slope(steps, errors) - 2.0) < 0.15
