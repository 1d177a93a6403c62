"""Iteration by circles: what is repeated and what is not, how often, and what is said where it does not converge."""

from dataclasses import replace

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.variables import input_, output, parameter
from cosimo.orchestrator.engine.coupling import resolve
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.engine.algorithms.oscillators import STATES, TwoMasses, open_master
from cosimo.tests.scene_runs import finished
from cosimo.tests.slopes import orders, slope
from cosimo.tests.support import Linear, exact_two_masses
from scipy.linalg import expm

LIM = TwoMasses()
HERE = "cosimo.tests.engine.algorithms.test_iterative"


class MeanOscillator(Linear):
    """The second mass of the LIM oscillator as many FMUs are: it takes one value of each input for a whole step."""

    position = input_(0.0, "m", "position of the coupling's end")
    velocity = input_(0.0, "m/s", "velocity of the coupling's end")
    force = output("N", "force on the coupling's end", feedthrough=("position", "velocity"))
    x_out = output("m", "position")
    v_out = output("m/s", "velocity")

    def matrices(self):
        A, B = np.array([[0.0, 1.0], [-1100.0, -0.02]]), np.array([[0.0, 0.0], [100.0, 0.01]])
        C, D = np.array([[100.0, 0.01], [1.0, 0.0], [0.0, 1.0]]), np.array([[-100.0, -0.01], [0.0, 0.0], [0.0, 0.0]])
        return A, B, C, D, [0.0, -100.0]

    def _step(self, t: float, h: float) -> int:
        self.u[0] += 0.5 * h * self.u[1] + h**2 / 3.0 * self.u[2]
        self.u[1:] = 0.0
        return super()._step(t, h)


class Ramp(Linear):
    """Its input, and a number that grows with time."""

    speed = parameter(1.0, "1/s", "growth")
    u_in = input_(0.0, "1", "input")
    y_out = output("1", "input plus speed times time", feedthrough=("u_in",))

    def matrices(self):
        A = np.array([[0.0, self.parameters["speed"]], [0.0, 0.0]])
        return A, np.zeros((2, 1)), np.array([[1.0, 0.0]]), np.ones((1, 1)), [0.0, 1.0]


@pytest.fixture
def interface_of(monkeypatch):
    """Call with a unit's name and changes: the unit has this interface from then on."""

    def change(unit: str, **changes) -> None:
        before = resolve.describe

        def described(name, settings):
            found = before(name, settings)
            return replace(found, **{k: v(found) if callable(v) else v for k, v in changes.items()}) if name == unit else found

        monkeypatch.setattr(resolve, "describe", described)

    return change


def counters(result):
    return result.info.counters


def test_only_circles_are_repeated():
    """A mass that drives two circles by its motion, one after the other, and one that listens at the end."""
    mass, oscillator = {"component": "cosimo.tests.support:Mass"}, {"component": "cosimo.tests.support:Oscillator"}
    between = {"component": "cosimo.tests.engine.algorithms.oscillators:Between"}
    still = {**mass, "parameters": {"v0": 0.0}}
    units = {"listener": mass, "f1": between, "a": still, "source": mass, "f2": between, "b": still, "idle": oscillator}
    connections = [
        "source.x_out -> f1.x2",
        "source.v_out -> f1.v2",
        "f1.force -> a.force",
        "a.x_out -> f1.x1",
        "a.v_out -> f1.v1",
        "a.x_out -> f2.x2",
        "a.v_out -> f2.v2",
        "f2.force -> b.force",
        "b.x_out -> f2.x1",
        "b.v_out -> f2.v1",
        "f2.force -> listener.force",
    ]
    scene = {"stop_time": 1.0, "units": units, "connections": connections, "master": {"algorithm": "iterative", "step": 0.01}}
    result = finished(read_scene(scene))
    work, master = counters(result).units, counters(result).master
    assert [work[name]["steps"] for name in ("source", "listener", "idle")] == [100, 100, 100]
    assert work["a"]["steps"] == work["f1"]["steps"] > 100
    assert work["b"]["steps"] == work["f2"]["steps"] > 100
    assert work["a"]["steps"] + work["b"]["steps"] == master["restores"] + 200
    # each circle is cut at one force: one correction a step, if the kept gain is as good as the linear circles allow
    assert master["restores"] <= 210
    # the chain, solved as one: source free, a on f1, b on f2 (kc = 100, cc = 0.01, unit masses)
    k, c = 100.0, 0.01
    A = np.zeros((6, 6))
    A[::2, 1::2] = np.eye(3)
    A[3], A[5] = [k, c, -k, -c, 0, 0], [0, 0, k, c, -k, -c]
    exact = expm(A) @ np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    finer = run(read_scene({**scene, "master": {**scene["master"], "step": 0.005}}))
    for name, place in (("a.x_out", 2), ("b.x_out", 4)):
        errors = [abs(r[name][-1] - exact[place]) for r in (result, finer)]
        assert abs(orders(errors)[0] - 2.0) < 0.15


def test_a_circle_is_cut_where_the_fewest_signals_are():
    scene = LIM.scene("FD", 1e-2, algorithm="iterative")
    for units in (scene["units"], dict(reversed(scene["units"].items()))):
        master = open_master({**scene, "units": units})
        ((chain, _),) = master.algorithm._groups
        assert [list(master.positions)[k] for k in chain.cut] == [("b", "force")]


@pytest.mark.parametrize("split", ["FF", "FD", "DD"])
def test_order_of_units_matters_no_more_than_the_tolerance(split):
    scene = LIM.scene(split, 1e-2, algorithm="iterative")
    swapped = {**scene, "units": dict(reversed(scene["units"].items())), "connections": scene["connections"][::-1]}
    one, other = run(read_scene(scene)), run(read_scene(swapped))
    for unit, name in STATES:
        column = one[f"{unit}.{name}"]
        # a step is 1e-8 wrong at most, and the coupling does not amplify: 100 of them
        np.testing.assert_allclose(other[f"{unit}.{name}"], column, rtol=0.0, atol=1e-6 * np.abs(column).max())


def test_what_does_not_settle_stops_the_run_and_says_what_is_missed():
    iteration = {"max_iterations": 2}
    result = run(read_scene(LIM.scene("DD", 1e-2, algorithm="iterative", iteration=iteration)))
    assert result.outcome == "failed"
    assert "did not converge in 2 iterations" in result.message
    assert "where 1e-08 is allowed" in result.message
    assert result.time.tolist() == [0.0]


def test_what_does_not_settle_is_counted_where_the_scene_allows_it():
    iteration = {"max_iterations": 2, "not_converged": "warn"}
    result = finished(read_scene(LIM.scene("DD", 1e-2, algorithm="iterative", iteration=iteration)))
    found = counters(result).master
    assert 0 < found["unconverged_steps"] <= 100
    assert found["worst_miss"] > 1e-8
    (warning,) = result.info.warnings
    assert f"{found['unconverged_steps']} of 100 steps did not converge in 2 iterations" in warning


def test_a_circle_that_gives_back_more_than_it_gets_is_said():
    """Two gains of 1 and a time in between: at the start anything fits, afterwards nothing does."""
    scene = {
        "stop_time": 1.0,
        "connections": ["one.y_out -> two.u_in", "two.y_out -> one.u_in"],
        "units": {"one": {"component": f"{HERE}:Ramp", "parameters": {"speed": 0.0}}, "two": {"component": f"{HERE}:Ramp"}},
        "master": {"algorithm": "iterative", "step": 0.1},
    }
    result = run(read_scene(scene))
    assert result.outcome == "failed"
    assert result.time.tolist() == [0.0]
    assert "did not converge" in result.message or "output equals its input" in result.message


def test_a_repeated_stretch_is_the_same_to_the_last_bit():
    """`save` holds what the methods have learned, too."""
    scene = LIM.scene("DD", 1e-2, algorithm="iterative", extrapolation=2)
    master = open_master(scene)
    for k in range(5):
        master.step(0.01 * k, 0.01)
    saved = master.save()
    ends = []
    for _ in range(2):
        for k in range(5, 20):
            master.step(0.01 * k, 0.01)
        ends.append(np.array(master.signals).tobytes())
        master.restore(saved)
    assert ends[0] == ends[1]


def test_a_resumed_run_is_the_same_to_the_last_bit(tmp_path):
    iteration = {"max_iterations": 3, "not_converged": "warn"}
    scene = read_scene(LIM.scene("DD", 1e-2, algorithm="iterative", iteration=iteration))
    whole = run(scene, checkpoint_every=0.4, checkpoint_to=tmp_path / "there")  # the last one is written at 0.8 s
    rest = run(scene, resume=tmp_path / "there")
    for name, column in whole.columns.items():
        assert rest[name].tobytes() == column.tobytes()
    for key in ("steps", "unconverged_steps", "worst_miss"):
        assert counters(rest).master[key] == counters(whole).master[key]


def test_tolerance_is_kept_and_costs_iterations():
    """What a looser tolerance gets wrong stays near it."""
    errors, work = [], []
    for tolerance in (1e-3, 1e-6, 1e-10):
        iteration = {"tolerance": tolerance, "max_iterations": 50}
        result = run(read_scene(LIM.scene("DD", 4e-2, algorithm="iterative", iteration=iteration)))
        errors.append(np.array([result[f"{u}.{n}"][-1] for u, n in STATES]))
        work.append(counters(result).master["iterations"])
    assert work[0] < work[1] < work[2]
    assert np.abs(errors[1] - errors[2]).max() < 100 * 1e-6 * 100.0  # a hundred steps of signals of size 100


def test_a_unit_that_holds_the_mean_of_its_inputs_answers_with_their_end(interface_of):
    """Second order with linear inputs all the same: the mean is right to second order, and the force belongs to the end."""
    interface_of("b", input_degree=0)
    errors, steps = [], (5e-3, 2.5e-3, 1.25e-3)
    for step in steps:
        scene = LIM.scene("FD", step, algorithm="iterative")
        scene["units"]["b"] = {"component": f"{HERE}:MeanOscillator"}
        result = run(read_scene(scene))
        errors.append(np.abs([result[f"{u}.{n}"][-1] for u, n in STATES] - exact_two_masses(1.0)).max())
    assert abs(slope(steps, errors) - 2.0) < 0.15


def test_outputs_fit_where_a_fault_makes_a_signal_jump():
    """An algebraic loop with 1 added to what one unit hands over: at every instant, those of the jumps too, both outputs fit."""
    ring = {"component": "cosimo.tests.engine.algorithms.oscillators:Feedthrough"}
    scene = {
        "stop_time": 1.0,
        "connections": ["one.y_out -> two.u_in", "two.y_out -> one.u_in"],
        "units": {"one": ring, "two": {**ring, "parameters": {"a": -1.0, "b": 10.0, "c": -31.0, "d": -3.0}}},
        "master": {"algorithm": "iterative", "step": 1e-2},
        "faults": [{"signal": "two.y_out", "kind": "offset", "value": 1.0, "begin": 0.3, "end": 0.5}],
    }
    result = run(read_scene(scene))
    y1, y2, x1, x2 = (result[name] for name in ("one.y_out", "two.y_out", "one.x_out", "two.x_out"))
    added = np.where((result.time >= 0.3) & (result.time < 0.5), 1.0, 0.0)
    # the iteration's tolerance, times the gain of the loop
    np.testing.assert_allclose(y1, 3.0 * x1 + y2 + added, rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(y2, -31.0 * x2 - 3.0 * y1, rtol=0.0, atol=1e-6)


# -- refused before the run --------------------------------------------------------------------------------------------


def refused(**master) -> str:
    with pytest.raises(BadInput) as caught:
        read_scene(LIM.scene("FD", 1e-2, **{"algorithm": "iterative", **master}))
    return str(caught.value)


def test_options_without_effect_are_refused():
    assert "master.feedthrough" in refused(feedthrough="delayed")
    assert "master.order" in refused(order=["a", "b"]) or "order" in refused(order=["a", "b"])
    assert "iteration" in refused(algorithm="jacobi", iteration={"tolerance": 1e-6})


def test_iteration_without_a_circle_is_refused(interface_of):
    chain = {
        "stop_time": 1.0,
        "connections": ["a.x_out -> b.position"],
        "master": {"algorithm": "iterative", "step": 0.1},
        "units": {"a": {"component": "cosimo.tests.support:Mass"}, "b": {"component": "cosimo.tests.support:Oscillator"}},
    }
    with pytest.raises(BadInput, match=r"master.algorithm: got 'iterative', expected units that feed one another in a circle"):
        read_scene(chain)
    interface_of("b", outputs=lambda i: {n: replace(s, discrete=True) for n, s in i.outputs.items()})
    assert "in a circle" in refused()  # the force jumps, so nothing inside a step goes round


def test_a_unit_of_a_circle_that_cannot_repeat_a_step_is_named(interface_of):
    interface_of("b", saves_state=False)
    assert "units that save their state, so that a step can be repeated; b cannot" in refused()


def test_a_unit_outside_circles_need_not_repeat_a_step(interface_of):
    interface_of("listener", saves_state=False)
    scene = LIM.scene("FD", 1e-2, algorithm="iterative")
    scene["units"]["listener"] = {"component": "cosimo.tests.support:Mass"}
    scene["connections"].append("b.force -> listener.force")
    assert run(read_scene(scene)).outcome == "done"
