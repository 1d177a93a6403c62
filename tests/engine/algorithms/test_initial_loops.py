"""Initial values of units that feed one another: by groups, whatever the gains, and what is said where there are none."""

import numpy as np
import pytest
from cosimo.components.core.variables import input_, output, parameter
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.support import Linear

HERE = "cosimo.tests.engine.algorithms.test_initial_loops"
GAINS = np.array([[0.0, -7.0, 0.5], [2.0, 0.0, -3.0], [0.25, 4.0, 0.0]])
OFFSETS = np.array([1.0, -2.0, 0.5])


class Gain(Linear):
    """y = a u1 + b u2 + c, and nothing that moves."""

    a, b, c = parameter(0.0, "1", "gain"), parameter(0.0, "1", "gain"), parameter(0.0, "1", "offset")
    u1, u2 = input_(0.0, "1", "one input"), input_(0.0, "1", "another")
    y = output("1", "sum", feedthrough=("u1", "u2"))

    def matrices(self):
        p = self.parameters
        return np.zeros((1, 1)), np.zeros((1, 2)), np.array([[p["c"]]]), np.array([[p["a"], p["b"]]]), [1.0]


class Root(Linear):
    """y = a sqrt(|u1|) + c."""

    a, c = parameter(0.0, "1", "factor"), parameter(0.0, "1", "offset")
    u1 = input_(0.0, "1", "input")
    y = output("1", "root", feedthrough=("u1",))

    def matrices(self):
        return np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.zeros((1, 1)), np.zeros(0)

    def _outputs(self, t):
        p = self.parameters
        self.y[0] = p["a"] * np.sqrt(abs(self.u[0, 0])) + p["c"]


def circle(gains: np.ndarray, offsets: np.ndarray, order=(0, 1, 2)) -> dict:
    """Three units, each of which gets what the two others give."""
    units, connections = {}, []
    for i in order:
        others = [j for j in range(3) if j != i]
        values = {"a": gains[i, others[0]], "b": gains[i, others[1]], "c": offsets[i]}
        units[f"g{i}"] = {"component": f"{HERE}:Gain", "parameters": {k: float(v) for k, v in values.items()}}
        connections += [f"g{j}.y -> g{i}.u{k}" for k, j in enumerate(others, 1)]
    return {"stop_time": 0.1, "units": units, "connections": connections, "master": {"algorithm": "jacobi", "step": 0.1}}


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1), (1, 0, 2)])
@pytest.mark.parametrize("scale", [0.05, 1.0, 100.0])
def test_circles_of_any_gain_settle_at_the_solution_of_the_linear_system(scale, order):
    """Sweeps contract with the smallest gains only; with the largest they run away within a few."""
    result = run(read_scene(circle(scale * GAINS, OFFSETS, order)))
    exact = np.linalg.solve(np.eye(3) - scale * GAINS, OFFSETS)
    assert result.outcome == "done", result.message
    # the residual of 1e-12, relative to each output, over the smallest change that a change of an answer can bring
    np.testing.assert_allclose([result[f"g{i}.y"][0] for i in range(3)], exact, rtol=1e-9)
    (group,) = result.info.initial_values
    assert set(group.units) == {"g0", "g1", "g2"}
    assert group.residual <= 1e-9
    assert (group.secants == 0) == (scale == 0.05)
    # n + 1 answers span the space of n unknowns, one more is the solution; a rounded space may need a few more
    assert group.secants <= 8


def test_pantographs_on_each_others_heads_settle_where_both_hang_free():
    """Every sweep lifts both by the compression of a contact spring; the frame's spring holds the lift at 120 N / (50 N/m)."""
    units = {name: {"component": "Pantograph", "parameters": {"static_force": 120.0, "frame_stiffness": 50.0}} for name in "pq"}
    scene = read_scene(
        {
            "stop_time": 0.1,
            "units": units,
            "master": {"step": 0.1},
            "connections": ["p.head_height -> q.wire_height", "q.head_height -> p.wire_height"],
        }
    )
    result = run(scene, in_process=True)
    assert result["p.head_height"][0] == pytest.approx(120.0 / 50.0, rel=1e-9)
    assert result["p.contact_force"][0] == pytest.approx(0.0, abs=1e-6)  # a stiffness times what the sweeps leave of the height


def test_nonlinear_circles_settle_too():
    """x = 3 sqrt(|y|) + 1, y = 5 sqrt(|x|) - 2, a contraction in sweeps; the answer from bisection of one variable."""
    units = {n: {"component": f"{HERE}:Root", "parameters": {"a": a, "c": c}} for n, a, c in (("p", 3.0, 1.0), ("q", 5.0, -2.0))}
    result = run(
        read_scene(
            {
                "stop_time": 0.1,
                "units": units,
                "master": {"algorithm": "jacobi", "step": 0.1},
                "connections": ["p.y -> q.u1", "q.y -> p.u1"],
            }
        )
    )
    low, high = 1.0, 1e3
    for _ in range(200):
        x = 0.5 * (low + high)
        low, high = (x, high) if 3.0 * np.sqrt(abs(5.0 * np.sqrt(x) - 2.0)) + 1.0 > x else (low, x)
    assert result["p.y"][0] == pytest.approx(x, rel=1e-10)


def test_groups_settle_one_after_the_other_whatever_their_order_in_the_scene():
    """last <- (p <-> q) <- first: four units, three groups, and only the circle needs more than one sweep."""
    gain = f"{HERE}:Gain"
    units = {
        "last": {"component": gain, "parameters": {"a": 2.0}},
        "p": {"component": gain, "parameters": {"a": 0.5, "b": 1.0}},
        "q": {"component": gain, "parameters": {"a": 0.5}},
        "first": {"component": gain, "parameters": {"c": 3.0}},
    }
    result = run(
        read_scene(
            {
                "stop_time": 0.1,
                "units": units,
                "master": {"algorithm": "jacobi", "step": 0.1},
                "connections": ["q.y -> p.u1", "first.y -> p.u2", "p.y -> q.u1", "p.y -> last.u1"],
            }
        )
    )
    assert [set(group.units) for group in result.info.initial_values] == [{"first"}, {"p", "q"}, {"last"}]
    assert [group.sweeps for group in result.info.initial_values][::2] == [1, 1]
    assert result["last.y"][0] == pytest.approx(2.0 * 3.0 / (1.0 - 0.25), rel=1e-11)


@pytest.mark.parametrize(("gain", "offset"), [(1.0, 1.0), (1.0, 0.5)])
def test_a_circle_without_an_answer_names_its_signals(gain, offset):
    scene = circle(np.zeros((3, 3)), OFFSETS)
    scene["units"]["g0"]["parameters"] = {"a": gain, "c": offset}  # x0 = x1 + offset, x1 = x0
    scene["units"]["g1"]["parameters"] = {"a": 1.0}
    result = run(read_scene(scene))
    assert result.outcome == "failed"
    for part in ("g0", "g1", "did not converge", "y still changes by", "no common equilibrium, or many"):
        assert part in result.message
    assert result.info.initial_values[-1].residual > 1e-9


class Head(Linear):
    """A head of two contacts of `stiffness` k under a force: f1 - f2 = k (w2 - w1), neither below zero."""

    force, stiffness = parameter(100.0, "1", "force"), parameter(5e4, "1", "stiffness of a contact")
    w1, w2 = input_(0.0, "1", "height of one wire"), input_(0.0, "1", "height of the other")
    f1, f2 = output("1", "force on one", feedthrough=("w1", "w2")), output("1", "force on the other", feedthrough=("w1", "w2"))

    def matrices(self):
        return np.zeros((0, 0)), np.zeros((0, 2)), np.zeros((2, 0)), np.zeros((2, 2)), np.zeros(0)

    def _outputs(self, t):
        p = self.parameters
        self.y[0] = min(max(0.5 * (p["force"] + p["stiffness"] * (self.u[0, 1] - self.u[0, 0])), 0.0), p["force"])
        self.y[1] = p["force"] - self.y[0]


def test_contacts_that_open_and_close_settle_at_every_force():
    """Two wires that give way: answers of sweeps from before a contact has closed are of another piece, and foretell nothing."""
    wire, own, other, apart = f"{HERE}:Gain", 4e-4, 2.5e-4, 2e-3  # m/N, m/N, m
    units = {
        "one": {"component": wire, "parameters": {"a": own, "b": other}},
        "two": {"component": wire, "parameters": {"a": other, "b": own, "c": apart}},
        "head": {"component": f"{HERE}:Head"},
    }
    links = ["head.f1 -> one.u1", "head.f2 -> one.u2", "head.f1 -> two.u1", "head.f2 -> two.u2"]
    scene = read_scene(
        {
            "stop_time": 0.1,
            "units": units,
            "master": {"algorithm": "gauss-seidel", "step": 0.1},
            "connections": [*links, "one.y -> head.w1", "two.y -> head.w2"],
        }
    )
    for force in np.linspace(2.0, 250.0, 125):
        result = run(scene.with_changes({"head.force": float(force)}), in_process=True)
        assert result.outcome == "done", (force, result.message)
        parted = 5e4 * apart / (1.0 + 5e4 * (own - other))
        assert result["head.f1"][0] == pytest.approx(min(0.5 * (force + parted), force), rel=1e-8)
