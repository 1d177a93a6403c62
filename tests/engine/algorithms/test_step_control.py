"""Macro steps that follow their error: estimates against true errors, orders, limits, failures, redundant integrators."""

from itertools import pairwise

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import DONE, NOT_FINITE
from cosimo.components.core.variables import input_, output, parameter
from cosimo.orchestrator.engine.algorithms import step_control
from cosimo.orchestrator.engine.algorithms.polynomials import end_of, extrapolation
from cosimo.orchestrator.engine.algorithms.step_control import Controller, shares
from cosimo.orchestrator.engine.coupling.checks import check_stepping
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.settings import MasterSettings
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units import Interface
from cosimo.orchestrator.units.interface import Signal
from cosimo.tests.engine.algorithms.bonded import bonded
from cosimo.tests.scene_runs import finished
from cosimo.tests.short_run import full_but
from cosimo.tests.slopes import slope
from cosimo.tests.support import Linear, exact_two_masses, two_masses
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

STATES = ("a.x_out", "a.v_out", "b.x_out", "b.v_out")


class Brittle(Linear):
    """A free mass that cannot complete steps above a limit."""

    limit = parameter(1.0, "s", "longest step that can be completed")
    force = input_(0.0, "N", "force")
    x_out = output("m", "position")
    v_out = output("m/s", "velocity")

    def matrices(self):
        return np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [1.0]]), np.eye(2), np.zeros((2, 1)), [0.0, 100.0]

    def _step(self, t, h):
        super()._step(t, h)
        return DONE if h <= self.parameters["limit"] * (1.0 + 1e-9) else NOT_FINITE


def controlled(method: str, tolerance: float, degree: int = 1, algorithm: str = "jacobi", step: float = 1e-3, **control) -> dict:
    scene = two_masses(algorithm, step, degree)
    scene["master"]["control"] = {"method": method, "relative": tolerance, "absolute": 100.0 * tolerance, **control}
    return scene


@pytest.mark.parametrize(("count", "extrapolated", "interpolated"), [(1, 1 / 2, 1 / 2), (2, 5 / 12, 1 / 12), (3, 3 / 8, 1 / 24)])
def test_shares_of_equal_steps_are_the_constants_of_adams(count, extrapolated, interpolated):
    assert shares(0.7, *[0.7] * (count - 1)) == pytest.approx((extrapolated, interpolated), rel=1e-12)


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_shares_of_uneven_steps_are_mean_errors_of_the_inputs(degree):
    """A polynomial one degree above the inputs has no other error than the one that is estimated."""
    signal, h, past = Polynomial([0.3, -1.1, 0.7, 2.3][: degree + 2]), 0.3, (0.5, 0.2)[:degree]
    samples = [signal(-sum(past[:k])) for k in range(degree + 1)]  # at 0, -0.5 and -0.7 s
    points, weights = np.polynomial.legendre.leggauss(4)
    at = h * (0.5 + 0.5 * points)

    def mean(of) -> float:
        return abs(weights / 2.0 @ (of(at) - signal(at)))

    terms = extrapolation(degree + 1, *[*samples, 0.0, 0.0][:3], *[*past, 1.0, 1.0][:2])
    missed = abs(end_of(*terms, degree, h) - signal(h))
    assert mean(Polynomial(terms)) / missed == pytest.approx(shares(h, *past)[0], rel=1e-9)
    times = [h, *(-sum(past[:k]) for k in range(degree))]  # with the new value in place of the oldest
    led = Polynomial.fit(times, signal(np.array(times)), degree)
    assert mean(led) / missed == pytest.approx(shares(h, *past)[1], rel=1e-9)


@pytest.mark.parametrize(
    ("method", "algorithm", "degree"),
    full_but(
        (("milne", "gauss-seidel", 1),),
        [(*method, n) for method in (("milne", "jacobi"), ("milne", "gauss-seidel"), ("doubling", "jacobi")) for n in range(3)],
    ),
)
def test_order_of_the_error_over_the_number_of_steps(method, algorithm, degree):
    """Twice the steps, 2^(degree + 1) times less error, as with equal steps."""
    rough = {0: (1e-2, 3e-3, 1e-3), 1: (1e-3, 1e-4, 1e-5), 2: (1e-4, 1e-5, 1e-6)}  # milne allows an error per time,
    fine = {0: (1e-4, 3e-5, 1e-5), 1: (1e-5, 1e-6, 1e-7), 2: (1e-7, 1e-8, 1e-9)}  # doubling one per step
    tolerances = (fine if method == "doubling" else rough)[degree]
    steps, errors = [], []
    for tolerance in tolerances:
        result = run(read_scene(controlled(method, tolerance, degree, algorithm)))
        reached = np.array([result[name][-1] for name in STATES])
        steps.append(result.info.counters.master["steps"])
        errors.append(np.abs(reached - exact_two_masses(1.0)).max())
    assert -slope(steps, errors) == pytest.approx(degree + 1, abs=0.15 if degree < 2 else 0.5)


@pytest.mark.full
@pytest.mark.parametrize("method", ["milne", "doubling"])
def test_a_looser_tolerance_takes_fewer_steps(method):
    steps = [len(run(read_scene(controlled(method, tolerance))).time) for tolerance in (1e-5, 1e-4, 1e-3)]
    assert all(fewer < 0.7 * more for more, fewer in pairwise(steps))


@pytest.mark.full
def test_steps_follow_a_motion_that_dies_out():
    """What a decaying oscillation leaves needs longer steps: far fewer than equal ones of the length at the start."""
    scene = two_masses("jacobi", 1e-3, 1)
    scene |= {"stop_time": 20.0}
    scene["units"]["a"]["parameters"] |= {"c": 2.0}
    scene["units"]["b"]["parameters"] = {"c": 2.0, "cc": 2.0}
    scene["master"]["control"] = {"method": "milne", "relative": 1e-4, "absolute": 1e-2}
    result = run(read_scene(scene))
    h = np.diff(result.time)
    assert h[-5:-1].min() > 10.0 * np.median(h[result.time[1:] < 1.0])
    assert result.info.counters.stepping.longest >= h.max() * (1.0 - 1e-9)


@settings(max_examples=25)
@given(st.floats(0.37, 1.3), st.sampled_from([1e-3, 2.5e-3, 0.01]), st.sampled_from(["milne", "doubling"]))
def test_steps_are_multiples_of_the_smallest_within_the_limits_and_end_at_the_end(stop, smallest, method):
    stop = round(stop, 4)
    scene = controlled(method, 1e-3, step=0.01, min_step=smallest, max_step=0.05) | {"stop_time": stop}
    result = finished(read_scene(scene))
    assert result.time[-1] == stop
    h = np.diff(result.time)
    multiples = h[:-1] / smallest
    assert np.abs(multiples - np.round(multiples)).max() < 1e-9  # roundings of times of about 1 s
    assert h[:-1].min() > smallest * (1.0 - 1e-9)
    assert h.max() < 0.05 * (1.0 + 1e-9)


def test_errors_that_stay_above_the_tolerance_at_the_smallest_step_are_said():
    result = run(read_scene(controlled("doubling", 1e-9, step=0.01, min_step=0.005)))
    counters = result.info.counters.stepping
    assert counters.inaccurate == counters.accepted
    assert "errors above what master.control allows, with the smallest step, 0.005 s, too" in result.info.warnings[0]


def test_a_failed_step_is_repeated_with_shorter_ones():
    scene = controlled("milne", 1e-2, step=0.01)
    scene["units"]["a"] = {"component": f"{__name__}:Brittle", "parameters": {"limit": 1e-3}}
    result = finished(read_scene(scene))
    assert result.info.counters.stepping.failed > 0
    assert np.diff(result.time).max() <= 1e-3 * (1.0 + 1e-9)


def test_a_failure_that_the_smallest_step_does_not_cure_ends_the_run():
    scene = controlled("milne", 1e-2, step=0.01, min_step=1e-3)
    scene["units"]["a"] = {"component": f"{__name__}:Brittle", "parameters": {"limit": 5e-4}}
    result = run(read_scene(scene))
    assert result.outcome == "failed"
    assert "so did shorter steps, down to 0.001 s" in result.message
    assert result.time.tolist() == [0.0]


def test_a_failure_without_control_ends_the_run():
    scene = two_masses("jacobi", 0.01, 1)
    scene["units"]["a"] = {"component": f"{__name__}:Brittle", "parameters": {"limit": 1e-3}}
    assert run(read_scene(scene)).outcome == "failed"


def redundant(held: bool, monkeypatch) -> tuple[float, float, float]:
    """A mass and a spring-damper that both integrate the velocity, m = c = k = 1, under a load: share of steps that differ from
    the one before, trend of the difference between the two lengths (m/s), and its value at the end (m)."""
    if not held:
        monkeypatch.setattr(step_control, "HOLD_BELOW", 1.0)
        monkeypatch.setattr(step_control, "HOLD_ABOVE", 1.0)
    control = {"method": "milne", "relative": 0.01, "absolute": 0.01}
    scene = bonded(
        "Link",
        "jacobi",
        0.05,
        1,
        stop=1000.0,
        a={"v0": 0.0, "load": 1.0, "frequency": 0.5, "bias": 3.0},
        b={"c": 1.0},
        bonds=[],
        control=control,
    )
    result = run(read_scene(scene))
    drift, late, h = result["a.x_out"] - result["b.x_out"], result.time > 500.0, np.diff(result.time)
    changed = np.abs(np.diff(h)) > 1e-6 * h[1:]
    return changed.mean(), abs(np.polyfit(result.time[late], drift[late], 1)[0]), abs(drift[-1])


@pytest.mark.full
def test_redundant_integrators_part_when_the_step_changes_all_the_time_and_stay_together_when_it_is_held(monkeypatch):
    changes, trend, end = redundant(True, monkeypatch)
    free_changes, free_trend, free_end = redundant(False, monkeypatch)
    assert changes < 0.01
    assert free_changes > 0.99
    assert trend < 0.02 * free_trend
    assert end < 0.1 * free_end


@pytest.mark.parametrize("order", [1, 2, 3])
def test_the_controller_settles_where_the_error_is_just_allowed(order):
    """Error = (length / 1000)^order: 0.9 of 1000 at most is aimed at, and the step changes a few times only."""
    control, changes = Controller(10, 1, 10**6), 0
    for _ in range(200):
        before = control.length
        error = (before / 1000.0) ** order
        (control.accept if error <= 1.0 else control.reject)(before, error, order)
        changes += control.length != before
    assert 0.9 / 1.5 <= control.length / 1000.0 <= 1.0
    assert changes < 20


def test_the_controller_stays_within_its_limits():
    control = Controller(100, 10, 455)
    for _ in range(50):
        control.accept(control.length, 0.0, 2)
    assert 450 / 1.5 <= control.length <= 450
    for _ in range(50):
        control.reject(control.length, 1e9, 2)
    assert control.length == 10


def fixed(**changes) -> dict[str, Interface]:
    """Interfaces of two units that feed each other, the first with other capabilities."""
    signals = {"inputs": {"u": Signal("u", "m")}, "outputs": {"y": Signal("y", "m")}, "effects": {}}
    return {"rigid": Interface("rigid", **signals, **changes), "free": Interface("free", **signals)}


@pytest.mark.parametrize(
    ("master", "capability", "message"),
    [
        (
            {"control": {"method": "milne"}},
            {"variable_step": False},
            "master.control.method: got 'milne', expected units that change the length of a step; rigid cannot",
        ),
        ({"control": {"method": "milne"}}, {"fixed_step": 1e-3}, "units that change the length of a step; rigid cannot"),
        (
            {"control": {"method": "doubling"}},
            {"saves_state": False},
            "master.control.method: got 'doubling', expected units that save their state; rigid cannot",
        ),
        ({"events": ["rigid.y"]}, {"saves_state": False}, "master.events: .* that save their state, .*; rigid cannot"),
        ({"events": ["rigid.y"]}, {"variable_step": False}, "units that change the length of a step; rigid cannot"),
        ({"control": {"method": "milne"}}, {}, "expected a connection whose value changes within a step"),
    ],
)
def test_units_that_cannot_are_named_before_the_run(master, capability, message):
    with pytest.raises(BadInput, match=message):
        check_stepping(MasterSettings.model_validate({"step": 0.01, **master}), fixed(**capability), [], (), ())


@pytest.mark.parametrize(
    ("control", "message"),
    [
        ({"min_step": 0.02}, "master.step: got 0.01 s, expected at least master.control.min_step, 0.02 s"),
        ({"max_step": 0.005}, "master.step: got 0.01 s, expected at most master.control.max_step, 0.005 s"),
        ({"min_step": 0.02, "max_step": 0.01}, "expected at least min_step, 0.02 s"),
    ],
)
def test_limits_that_do_not_fit_are_refused(control, message):
    with pytest.raises(BadInput, match=message):
        read_scene(controlled("milne", 1e-3, step=0.01, **control))
