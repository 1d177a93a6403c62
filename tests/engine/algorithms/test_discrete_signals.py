"""What changes at instants only: held over each step, handed on at its end; and texts."""

from dataclasses import replace

import numpy as np
import pytest
from cosimo.components.core.component import Component
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import DONE
from cosimo.components.core.variables import input_, output
from cosimo.orchestrator.engine.coupling import resolve, resolve_coupling
from cosimo.orchestrator.opened import open_scene
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units.component import ComponentSimulator
from cosimo.orchestrator.units.interface import ARRAY_THRESHOLD, Signal
from cosimo.tests.scene_runs import finished
from cosimo.tests.support import Integrals

HERE = "cosimo.tests.engine.algorithms.test_discrete_signals"
N = ARRAY_THRESHOLD + 3
STEP = 0.1


class Clocked(Component):
    """Gives the steps it has taken, and the time."""

    ticks = output("1", "steps")
    time = output("s", "time")

    def _initialize(self, t):
        self.x = np.zeros(1)
        return DONE

    def _step(self, t, h):
        self.x += 1.0
        self._outputs(t + h)
        return DONE

    def _outputs(self, t):
        self.y[:] = self.x[0], t


class Both(Integrals):
    """Integrates two inputs exactly, and hands on the first."""

    jumps = input_(0.0, "1", "an input")
    moves = input_(0.0, "s", "another")
    sums = output("1", "integrals", size=2)
    now = output("1", "the first input", feedthrough=("jumps",))

    def _outputs(self, t):
        self.y[:] = *self.x, self.u[0, 0]


class Many(Component):
    """Integrates many inputs exactly."""

    u_in = input_(0.0, "1", "inputs", size=N)
    sums = output("1", "integrals", size=N)

    def _initialize(self, t):
        self.x = np.zeros(N)
        return DONE

    _step = Both._step

    def _outputs(self, t):
        self.y[:] = self.x


@pytest.fixture
def described(monkeypatch):
    """A function that changes what the interfaces say of some signals: described(("c", "ticks"), kind="integer")."""
    original, changes = resolve.describe, {}

    def describe(name, settings):
        interface = original(name, settings)
        for side in ("inputs", "outputs"):
            signals = dict(getattr(interface, side))
            signals |= {n: replace(s, **changes[name, n]) for n, s in signals.items() if (name, n) in changes}
            interface = replace(interface, **{side: signals})
        return interface

    monkeypatch.setattr(resolve, "describe", describe)
    return lambda end, **what: changes.__setitem__(end, what)


def scene(algorithm: str, degree: int, order=("c", "b"), **master) -> dict:
    units = {"c": {"component": f"{HERE}:Clocked"}, "b": {"component": f"{HERE}:Both"}}
    return {
        "stop_time": 1.0,
        "units": {n: units[n] for n in order},
        "connections": ["c.ticks -> b.jumps", "c.time -> b.moves"],
        "master": {"algorithm": algorithm, "step": STEP, "extrapolation": degree, **master},
    }


@pytest.mark.parametrize("what", [{"discrete": True}, {"kind": "integer", "discrete": True}, {"kind": "enumeration"}], ids=str)
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
@pytest.mark.parametrize("degree", [0, 1, 2])
def test_discrete_signals_are_held_whatever_the_degree(degree, algorithm, what, described):
    """k steps, each with the number of those before it: 0 + 1 + ... + 9; the moving one beside it stays a polynomial."""
    described(("c", "ticks"), **what)
    described(("b", "jumps"), kind="real" if what.get("kind") != "enumeration" else "enumeration")
    result = run(read_scene(scene(algorithm, degree)))
    np.testing.assert_array_equal(result["b.now"], result["c.ticks"])  # at each instant the new value is there at once
    sums = run(read_scene({**scene(algorithm, degree), "record": {"signals": ["b.sums"]}}))
    k = np.arange(11)
    np.testing.assert_allclose(sums["b.sums[1]"], STEP * k * (k - 1) / 2.0, atol=1e-13)
    moved = sums["b.sums[2]"][-1]
    if degree == 0:  # held at the old or at the fresh value
        assert moved == pytest.approx({"jacobi": 0.45, "gauss-seidel": 0.55}[algorithm], rel=1e-12)
    else:  # t²/2, but for what Jacobi loses in its first step without a slope
        assert moved == pytest.approx({"jacobi": 0.5 - STEP**2 / 2.0, "gauss-seidel": 0.5}[algorithm], rel=1e-12)


@pytest.mark.parametrize("order", [("c", "passes", "sums"), ("sums", "passes", "c"), ("passes", "c", "sums")], ids="".join)
@pytest.mark.parametrize("taken", [0, 2])
@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel", "iterative"])
def test_what_jumps_at_the_end_of_a_step_acts_behind_it(algorithm, degree, taken, order, described, monkeypatch):
    """A unit in a circle passes a clock's count of steps on at once; another integrates that: 0 + 1 + 2 + ....

    taken: degree of the polynomials that the unit which passes it on says it takes.
    """
    described(("c", "ticks"), discrete=True)
    before = resolve.describe
    monkeypatch.setattr(
        resolve, "describe", lambda n, s: replace(before(n, s), **({"input_degree": taken} if n == "passes" else {}))
    )
    units = {n: {"component": f"{HERE}:{of}"} for n, of in (("c", "Clocked"), ("passes", "Both"), ("sums", "Both"))}
    links = [("c.ticks", "passes.jumps"), ("passes.now", "sums.moves"), ("sums.sums[2]", "passes.moves")]
    data = {
        "stop_time": 1.0,
        "units": {n: units[n] for n in order},
        "connections": [{"source": a, "target": b, "convert_units": False} for a, b in links],
        "record": {"signals": ["sums.sums"]},
        "master": {"algorithm": algorithm, "step": STEP, "extrapolation": degree},
    }
    k = np.arange(11)
    np.testing.assert_allclose(run(read_scene(data))["sums.sums[2]"], STEP * k * (k - 1) / 2.0, atol=1e-13)


def test_a_discrete_input_is_held_even_when_the_output_is_not(described):
    described(("b", "jumps"), discrete=True)
    result = run(read_scene({**scene("jacobi", 2), "record": {"signals": ["b.sums"]}}))
    assert result["b.sums[1]"][-1] == pytest.approx(STEP * 45.0, rel=1e-12)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_wide_ports_hold_their_discrete_inputs_too(algorithm, described):
    described(("c", "ticks"), discrete=True)
    connections = [f"c.{'ticks' if i % 2 else 'time'} -> m.u_in[{i}]" for i in range(1, N + 1)]
    connections = [{"source": c.split(" -> ")[0], "target": c.split(" -> ")[1], "convert_units": False} for c in connections]
    wide = {
        "stop_time": 1.0,
        "units": {"c": {"component": f"{HERE}:Clocked"}, "m": {"component": f"{HERE}:Many"}},
        "connections": connections,
        "record": {"signals": ["m.sums"]},
        "master": {"algorithm": algorithm, "step": STEP, "extrapolation": 1},
    }
    result = run(read_scene(wide))
    for i in range(1, N + 1):
        exact = STEP * 45.0 if i % 2 else {"jacobi": 0.5 - STEP**2 / 2.0, "gauss-seidel": 0.5}[algorithm]
        assert result[f"m.sums[{i}]"][-1] == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel"])
def test_discrete_outputs_of_a_slow_unit_are_held_between_its_steps(algorithm, described):
    """Steps of the clock at 0.2, 0.4, ... s: 0 0 1 1 2 2 3 3 4 4 over the ten macro steps."""
    described(("c", "ticks"), discrete=True)
    slow = scene(algorithm, 1)
    slow["units"]["c"]["every"] = 2
    result = run(read_scene({**slow, "record": {"signals": ["b.sums", "b.now", "c.ticks"]}}))
    assert result["b.sums[1]"][-1] == pytest.approx(STEP * 20.0, rel=1e-12)
    np.testing.assert_array_equal(result["b.now"], result["c.ticks"])


@pytest.mark.parametrize("feedthrough", ["immediate", "delayed"])
def test_a_discrete_algebraic_loop_is_refused_unless_its_values_may_be_stale(feedthrough, described):
    both = {"component": f"{HERE}:Both"}
    loop = {
        "stop_time": 1.0,
        "units": {"p": both, "q": both},
        "connections": ["p.now -> q.jumps", "q.now -> p.jumps"],
        "master": {"algorithm": "jacobi", "step": STEP, "feedthrough": feedthrough},
    }
    for unit in "pq":
        described((unit, "now"), discrete=True)
    if feedthrough == "delayed":
        assert run(read_scene(loop)).outcome == "done"
    else:
        with pytest.raises(BadInput, match=r"algebraic loop of p\.now, q\.now, where p\.now only jumps"):
            read_scene(loop)


class Speaker(ComponentSimulator):
    """A component with a text output that tells its last step, and a text input that it keeps."""

    heard = ()

    def wire_texts(self, inputs):
        self.text_inputs, self.heard = list(inputs), []

    def set_texts(self, values):
        self.heard.append((round(self.component.t, 9), *values))

    def text_reader(self, names):
        self.text_outputs = list(names)
        return lambda: [f"{name} of {self.name} at {self.component.t:.1f}" for name in names]


def test_texts_are_handed_over_at_the_start_of_each_step(monkeypatch):
    opened, original = {}, resolve.describe

    def describe(name, settings):
        interface = original(name, settings)
        text = {"kind": "string", "discrete": True, "feedthrough": ()}
        return replace(
            interface,
            inputs={**interface.inputs, "hears": Signal("hears", "", "nothing yet", **text)},
            outputs={**interface.outputs, "says": Signal("says", "", "", **text)},
        )

    open_unit = open_scene.open_unit

    def speaking(name, settings, **how):
        opened[name] = Speaker(name, open_unit(name, settings, **how).component)
        return opened[name]

    monkeypatch.setattr(resolve, "describe", describe)
    monkeypatch.setattr(open_scene, "open_unit", speaking)
    talk = {**scene("jacobi", 1), "stop_time": 0.3, "record": {"signals": ["b.now"]}}
    talk["connections"] = [*talk["connections"], "c.says -> b.hears", "b.says -> c.hears"]
    settled = read_scene(talk)
    assert resolve_coupling(settled).groups in ((("c", "b"),), (("b", "c"),))
    finished(settled)
    assert opened["b"].text_outputs == ["says"]
    for name, other in (("b", "c"), ("c", "b")):
        steps = [heard for heard in opened[name].heard if "nothing" not in heard[1]][-3:]
        assert steps == [(t, f"says of {other} at {t:.1f}") for t in (0.0, 0.1, 0.2)]
    assert opened["c"].heard[0][1] in ("nothing yet", "says of b at 0.0")
