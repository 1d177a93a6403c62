"""Algebraic loops: outputs of several units that depend on one another within an instant."""

from types import SimpleNamespace

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.components.core.variables import input_, output, parameter
from cosimo.orchestrator.engine.algorithms.loops import LoopSolver
from cosimo.orchestrator.engine.coupling import resolve_coupling
from cosimo.orchestrator.engine.coupling.graph import Link, Loop
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units.interface import Interface, Signal
from cosimo.tests.engine.algorithms.oscillators import Feedthrough
from cosimo.tests.scene_runs import finished
from cosimo.tests.short_run import full_but
from cosimo.tests.slopes import slope
from cosimo.tests.support import Linear
from cosimo.tests.units.native import native_fmu
from scipy.linalg import expm

HERE = "cosimo.tests.engine.algorithms.test_master_loops"


class Rising(Linear):
    """y = t u + 1."""

    u_in = input_(0.0, "1", "input")
    y_out = output("1", "output", feedthrough=("u_in",))

    def matrices(self):
        return np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.zeros((1, 1)), np.zeros(0)

    def _step(self, t, h):
        status = super()._step(t, h)
        self._outputs(t + h)
        return status

    def _outputs(self, t):
        self.y[0] = t * self.u[0, 0] + 1.0


class Bent(Rising):
    """y = 9 sin(10 t) + gain tanh(u)."""

    gain = parameter(1.0, "1", "largest value")

    def _outputs(self, t):
        self.y[0] = 9.0 * np.sin(10.0 * t) + self.parameters["gain"] * np.tanh(self.u[0, 0])


class Counted(Linear):
    """Gives how often its input has passed a whole number."""

    u_in = input_(0.0, "1", "input")
    y_out = output("1", "output", feedthrough=("u_in",))

    def matrices(self):
        return np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.ones((1, 1)), np.zeros(0)


def pair(d2: float, step: float, stop: float = 1.0, **master) -> dict:
    """The pair of PyFMI's tests of its master (tests/test_fmi_master.py): y1 = 3 x1 + u1, y2 = -31 x2 + d2 u2."""
    component = f"{Feedthrough.__module__}:Feedthrough"
    return {
        "stop_time": stop,
        "connections": ["one.y_out -> two.u_in", "two.y_out -> one.u_in"],
        "units": {
            "one": {"component": component, "parameters": {"a": -0.9, "b": 0.5, "c": 3.0, "d": 1.0}},
            "two": {"component": component, "parameters": {"a": -1.0, "b": 10.0, "c": -31.0, "d": d2}},
        },
        "master": {"step": step, "algorithm": "jacobi", **master},
    }


def exact_pair(d2: float, t: float) -> np.ndarray:
    """(x1, x2) at t: the outputs eliminated from y1 = 3 x1 + y2 and y2 = -31 x2 + d2 y1, then the matrix exponential."""
    outputs = np.linalg.solve([[1.0, -1.0], [-d2, 1.0]], np.diag([3.0, -31.0]))
    A = np.diag([-0.9, -1.0]) + np.diag([0.5, 10.0]) @ outputs[::-1]
    return expm(A * t) @ np.ones(2)


def states(result) -> np.ndarray:
    return np.array([result[f"{u}.x_out"][-1] for u in ("one", "two")])


@pytest.mark.parametrize("degree", full_but((1,), (0, 1)))
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize(("d2", "stop"), full_but(((1.1, 1e-3),), ((-0.9, 1.0), (1.1, 1e-3))))
def test_a_loop_of_any_gain_keeps_the_order_of_accuracy(d2, stop, algorithm, degree):
    """d2 = 1.1 grows like exp(3084 t), so the run is short; unsolved, the loop's values would grow in each macro step."""
    exact, errors = exact_pair(d2, stop), []
    for steps in (1000, 2000, 4000):
        result = finished(read_scene(pair(d2, stop / steps, stop, algorithm=algorithm, extrapolation=degree)))
        errors.append(np.abs(states(result) / exact - 1.0).max())
    assert abs(-slope([1.0, 2.0, 4.0], errors) - (degree + 1)) < 0.15
    assert errors[-1] < (2e-2, 1e-4)[degree]


def test_the_published_end_values_are_reached():
    result = run(read_scene(pair(-0.9, 2.5e-4, extrapolation=1)))
    # PyFMI's own digits; the error is 1e-7 of them at this step, by the order above
    np.testing.assert_allclose(states(result), [0.0859764038708439, 0.008392664839635064], rtol=1e-6)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_stale_is_stable_and_unstable_as_published():
    """One exchange a step without a solution: fine at 0.5 ms, lost at 5 ms, and with a gain above 1 lost at any step."""
    stale = {"extrapolation": 0, "feedthrough": "delayed"}
    fine = states(run(read_scene(pair(-0.9, 5e-4, **stale))))
    np.testing.assert_allclose(fine, [0.0859764, 0.00839266], rtol=0.02)
    assert run(read_scene(pair(-0.9, 5e-3, **stale))).outcome == "unstable"
    grown = run(read_scene(pair(1.1, 5e-4, 0.3, **stale)))
    assert grown.outcome == "unstable" or np.abs(states(grown)).max() > 100.0


def test_a_linear_loop_costs_one_jacobian_and_two_evaluations_an_instant():
    result = run(read_scene(pair(-0.9, 1e-3)))
    (loop,) = result.info.counters.master["algebraic_loops"].values()
    assert loop["points"] == 1001
    assert loop["jacobians"] == 1
    # two columns of the Jacobian; a first correction with differences may leave 1e-7, which needs a second one
    assert loop["evaluations"] <= 2 * loop["points"] + 2 + 10
    assert loop["residual"] <= 1e-9


def test_a_nonlinear_loop_with_a_chain_behind_it_holds_at_every_instant():
    """y = 9 sin(10 t) + 3 tanh(z), z = 9 sin(10 t) - 2 tanh(y), and three times y in millimetres behind it."""
    bent = f"{HERE}:Bent"
    scene = {
        "stop_time": 1.0,
        "master": {"algorithm": "jacobi", "step": 0.01},
        "units": {
            "after": {"component": f"{HERE}:Counted"},
            "p": {"component": bent, "parameters": {"gain": 3.0}},
            "q": {"component": bent, "parameters": {"gain": -2.0}},
        },
        "connections": ["p.y_out -> q.u_in", "q.y_out -> p.u_in", {"source": "p.y_out", "target": "after.u_in", "factor": 3.0}],
    }
    result = finished(read_scene(scene))
    y, z, wave = result["p.y_out"], result["q.y_out"], 9.0 * np.sin(10.0 * result.time)
    np.testing.assert_allclose(y, wave + 3.0 * np.tanh(z), atol=1e-9)
    np.testing.assert_allclose(z, wave - 2.0 * np.tanh(y), atol=1e-9)
    np.testing.assert_allclose(result["after.y_out"], 3.0 * y, rtol=1e-12, atol=1e-12)
    (loop,) = result.info.counters.master["algebraic_loops"].values()
    assert 1 < loop["jacobians"] < loop["points"]  # taken anew, but not at every instant


def test_a_gain_of_one_ends_the_run_and_is_said():
    """y = t u + 1 with u = y: y = 1 / (1 - t) has no value at t = 1."""
    scene = {
        "stop_time": 2.0,
        "master": {"algorithm": "jacobi", "step": 0.125},
        "units": {"p": {"component": f"{HERE}:Rising"}, "q": {"component": f"{HERE}:Counted"}},
        "connections": ["p.y_out -> q.u_in", "q.y_out -> p.u_in"],
    }
    result = run(read_scene(scene))
    np.testing.assert_allclose(result["p.y_out"], 1.0 / (1.0 - result.time), rtol=1e-10)
    assert result.time[-1] == 0.875
    for part in ("t = 1 s", "p.y_out, q.y_out", "no single solution", "gain is 1", "residual"):
        assert part in result.message


class Given:
    """A unit whose only output is k u + 1, or what `answer` makes of u, which knows its derivative or a wrong one."""

    def __init__(self, name: str, gain: float, told: float, answer=None):
        self.name, self.told, self.answer = name, told, answer or (lambda u: gain * u + 1.0)

    def jacobian(self):
        return np.array([[self.told]])


class Circle:
    """Network and machine of units with one input and one output each, in a circle; `perform` updates all and reads them."""

    def __init__(self, units: list[Given], links: list[Link], interface: Interface):
        self.coupling = SimpleNamespace(interfaces={unit.name: interface for unit in units})
        self.positions = {(unit.name, "y"): k for k, unit in enumerate(units)}
        self.signals = np.zeros(len(units))
        self.nodes = [
            SimpleNamespace(
                unit=unit, place=slice(k, k + 1), links=(link,), sources=(self.positions[link.source],), altered=False
            )
            for k, (unit, link) in enumerate(zip(units, links, strict=True))
        ]
        self.node_of = {node.unit.name: node for node in self.nodes}

    def rows(self, *acts):
        return acts

    def perform(self, rows, t, h):
        inputs = [n.links[0].factor * self.signals[n.sources[0]] + n.links[0].offset for n in self.nodes]
        self.signals[:] = [node.unit.answer(u) for node, u in zip(self.nodes, inputs, strict=True)]


def solver_of(units: list[Given], *connections: tuple[float, float], exact: bool = True) -> tuple[LoopSolver, Circle]:
    """The solver of units of which each gets the output of the next, and their circle; connections: factor, offset."""
    ends = [(unit.name, "y") for unit in units]
    links = [
        Link(source, (unit.name, "u"), *connection)
        for unit, source, connection in zip(units, (*ends[1:], ends[0]), connections, strict=True)
    ]
    interface = Interface("", {"u": Signal("u", "")}, {"y": Signal("y", "", feedthrough=("u",))}, {}, gives_jacobian=exact)
    loop = Loop(tuple(ends), tuple(unit.name for unit in units))
    circle = Circle(units, links, interface)
    return LoopSolver(loop, circle), circle


@pytest.mark.parametrize("wrong", [1.0, 1.02])
def test_derivatives_of_the_units_are_used_where_they_have_them(wrong):
    solver, units = solver_of([Given("p", 5.0, 5.0 * wrong), Given("q", 3.0, 3.0)], (-2.0, 0.5), (1.0, 0.0))
    solver.solve(units, 0.0)
    p = -6.5 / 31.0  # p = 5 (-2 q + 0.5) + 1 and q = 3 p + 1, so 31 p = 5 (-2 + 0.5) + 1
    np.testing.assert_allclose(units.signals, [p, 3.0 * p + 1.0], rtol=1e-11)
    assert solver.newton.jacobians == 1
    assert (solver.evaluations == 2) == (wrong == 1.0)  # one look, one correction that is right at once


def test_derivatives_of_the_units_are_not_used_where_a_fault_changes_an_input():
    solver, units = solver_of([Given("p", 5.0, np.nan), Given("q", 3.0, np.nan)], (-2.0, 0.5), (1.0, 0.0))
    solver.nodes[1].altered = True
    solver.solve(units, 0.0)
    np.testing.assert_allclose(units.signals, [-6.5 / 31.0, 1.0 - 19.5 / 31.0], rtol=1e-11)


def circle(answer) -> tuple[LoopSolver, Circle]:
    """The loop of one unit whose output, 0 at first, is `answer` of itself."""
    return solver_of([Given("p", 1.0, 0.0, answer)], (1.0, 0.0), exact=False)


def test_a_kept_jacobian_that_leads_astray_is_taken_anew():
    """The first correction leads from 0 to 1 and leaves a tenth, but behind it the slope has the other sign."""
    solver, units = circle(lambda x: 1.0 - 2.3 * x**2 + 2.4 * x**3)
    solver.solve(units, 0.0)
    roots = np.roots([2.4, -2.3, -1.0, 1.0])
    assert np.abs(roots - units.signals[0]).min() < 1e-10
    assert solver.newton.jacobians > 1


def test_an_output_near_zero_makes_no_loop_singular():
    """p = 1e9 (q - 1) + 1 and q = 1: no loop in truth, but I - dG/dx has entries of 1 and 1e9."""
    solver, units = solver_of([Given("p", 1e9, 1e9), Given("q", 0.0, 0.0)], (1.0, -1.0), (1.0, 0.0))
    solver.solve(units, 0.0)
    assert units.signals.tolist() == [1.0, 1.0]


def test_a_loop_that_cannot_be_solved_is_an_error_with_its_residual():
    """y = u + 1 where u = y + |y| + 1: always larger than what it started from."""
    solver, units = circle(lambda x: 2.0 + x + abs(x))
    with pytest.raises(StepFailed, match=r"loop of p\.y .*residual of"):
        solver.solve(units, 0.0)


def test_loops_of_units_with_rates_of_their_own_are_refused():
    scene = {
        "stop_time": 1.0,
        "master": {"algorithm": "jacobi", "step": 0.1},
        "units": {"p": {"component": f"{HERE}:Rising"}, "q": {"component": f"{HERE}:Counted", "every": 2}},
        "connections": ["p.y_out -> q.u_in", "q.y_out -> p.u_in"],
    }
    with pytest.raises(BadInput, match=r"units\.q\.every.*algebraic loop of p\.y_out, q\.y_out"):
        read_scene(scene)
    scene["units"]["q"]["every"] = 1
    assert [type(step) for step in resolve_coupling(read_scene(scene)).feedthrough_schedule] == [Loop]


@pytest.mark.parametrize("flag", ["", 'providesDirectionalDerivatives="true"'])
def test_loops_of_fmus_with_and_without_derivatives(flag):
    """x' = -x + u, y = x + d u on both sides, u the other's y; held inputs get the mean, so the order is 2 and the error 1e-6."""
    d, stop = (-3.0, 0.8), 1.0
    units = {
        name: {"fmu": native_fmu("state_space", 3, flag), "parameters": {"A[1,1]": -1.0, "D[1,1]": gain, "x0[1]": 1.0}}
        for name, gain in zip("pq", d, strict=True)
    }
    result = finished(
        read_scene(
            {
                "stop_time": stop,
                "units": units,
                "connections": ["p.y[1] -> q.u[1]", "q.y[1] -> p.u[1]"],
                "record": {"signals": ["p.y[1]", "q.y[1]"]},
                "master": {"algorithm": "jacobi", "step": 1e-3},
            }
        )
    )
    outputs = np.linalg.inv([[1.0, -d[0]], [-d[1], 1.0]])
    exact = outputs @ expm((-np.eye(2) + outputs[::-1]) * stop) @ np.ones(2)
    np.testing.assert_allclose([result[f"{name}.y[1]"][-1] for name in "pq"], exact, rtol=1e-5)
    (loop,) = result.info.counters.master["algebraic_loops"].values()
    assert loop["jacobians"] == 1
    # with its own derivatives a linear loop is solved by one correction, and found so by the look behind it
    assert loop["evaluations"] <= 2 * loop["points"] + (0 if flag else 12)


def test_a_run_with_a_loop_goes_on_from_a_checkpoint_to_the_same_bits(tmp_path):
    """The Jacobian that is kept from one instant to the next is part of what is saved."""
    bent = f"{HERE}:Bent"
    scene = read_scene(
        {
            "stop_time": 1.0,
            "connections": ["p.y_out -> q.u_in", "q.y_out -> p.u_in"],
            "units": {
                "p": {"component": bent, "parameters": {"gain": 3.0}},
                "q": {"component": bent, "parameters": {"gain": -2.0}},
            },
            "master": {"algorithm": "jacobi", "step": 0.01},
        }
    )
    whole = run(scene)
    run(scene, checkpoint_every=0.43, checkpoint_to=tmp_path / "file")
    resumed = run(scene, resume=tmp_path / "file")
    assert resumed.info.resumed.at == pytest.approx(0.86)
    for name in whole.columns:
        assert resumed[name].tobytes() == whole[name].tobytes()
