"""Batches of steps give what steps one by one give, to the last bit, and what watches a run sees the same in both."""

import numpy as np
import pytest
from cosimo.components.core.contract import KernelComponent, Kernels
from cosimo.components.core.kernels import DONE, kernel
from cosimo.components.core.stateless import nothing
from cosimo.components.core.variables import input_, output
from cosimo.orchestrator.engine.algorithms import Master
from cosimo.orchestrator.engine.algorithms.machine import Machine
from cosimo.orchestrator.engine.stepping.loop import Stepping
from cosimo.orchestrator.run.instability import LOOKS, InstabilityMonitor
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.support import two_masses
from cosimo.tests.units.native import native_fmu

ALGORITHMS = ("jacobi", "gauss-seidel")
BATCH = "cosimo.orchestrator.engine.stepping.loop"


def both_ways(data, monkeypatch, **options):
    """The same scene in batches, of which there must be some, and step by step; and the lengths of the batches in steps."""
    lengths, steps = [], Master.take_steps

    def noted(self, times, *arguments):
        lengths.append(times.size)
        return steps(self, times, *arguments)

    monkeypatch.setattr(Master, "take_steps", noted)
    scene = data if not isinstance(data, dict) else read_scene(data)
    together = run(scene, **options)
    batches = lengths.copy()
    lengths.clear()
    monkeypatch.setattr(f"{BATCH}.BATCH_STEPS", 1)
    apart = run(scene, **options)
    assert max(batches) > 1
    assert set(lengths) == {1}
    return together, apart, batches


def counted(function, calls):
    def call(self, *arguments):
        calls.append(1)
        return function(self, *arguments)

    return call


def assert_alike(one, other):
    assert (one.outcome, one.message) == (other.outcome, other.message)
    assert one.time.tobytes() == other.time.tobytes()
    for name in other.columns:
        assert one[name].tobytes() == other[name].tobytes(), name
    for name, snapshot in other.snapshots.items():
        assert one.snapshots[name].values.tobytes() == snapshot.values.tobytes()
    assert one.info.counters == other.info.counters
    assert one.info.energy == other.info.energy


@pytest.mark.parametrize("rates", [{}, {"a": 2, "b": 5}], ids=str)
@pytest.mark.parametrize(("algorithm", "degree"), [("jacobi", 1), ("gauss-seidel", 2)])
def test_components_give_the_same_bits(algorithm, degree, rates, monkeypatch):
    """With outputs that follow within the instant, a unit of measure that is converted, and a shorter step at the end."""
    data = two_masses(algorithm, 7e-3, degree)
    data["units"]["p"] = {"component": "cosimo.tests.support:Probe"}
    data["connections"].append("a.x_out -> p.length")
    for unit, every in rates.items():
        data["units"][unit]["every"] = every
    assert_alike(*both_ways(data, monkeypatch)[:2])


FAULTS = {
    "override": [{"signal": "b.position", "kind": "override", "value": 3.0, "begin": 0.3, "end": 0.51}],
    "offset": [{"signal": "a.x_out", "kind": "offset", "value": 30.0, "begin": 0.2}],
    "freeze and offset": [
        {"signal": "b.position", "kind": "freeze", "begin": 0.3},
        {"signal": "b.position", "kind": "offset", "value": 0.1, "begin": 0.4, "end": 0.8},
    ],
    "two offsets": [{"signal": "b.position", "kind": "offset", "value": value} for value in (0.1, 0.7)],
}


@pytest.mark.parametrize("name", FAULTS)
def test_inputs_with_faults_are_the_same_bits(name, monkeypatch):
    data = two_masses("gauss-seidel", 0.01, 1) | {"faults": FAULTS[name]}
    together, apart, _ = both_ways(data, monkeypatch)
    assert_alike(together, apart)
    assert together["b.x_out"].tobytes() != run(read_scene(data | {"faults": []}))["b.x_out"].tobytes()


def test_two_offsets_of_an_input_are_one_of_their_sum():
    two, one = (
        run(read_scene(two_masses("jacobi", 0.01, 1) | {"faults": faults}))
        for faults in (FAULTS["two offsets"], [{**FAULTS["two offsets"][0], "value": 0.1 + 0.7}])
    )
    assert_alike(two, one)


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_kernels_called_by_address_give_the_same_bits(algorithm, monkeypatch):
    """A motor with dry friction, a body with two axes and a controller with a period, and the energy account of their bonds."""
    scene = load_scene("gimbal-scan")
    scene = scene.with_changes({"stop_time": 150.5 * scene.master.step, "master.algorithm": algorithm})
    python, address = [], Machine.address

    def noted(machine):
        address(machine)
        python.extend(machine.in_python)

    monkeypatch.setattr(Machine, "address", noted)
    together, apart, _ = both_ways(scene, monkeypatch, in_process=True)
    assert_alike(together, apart)
    assert together.info.energy
    assert python == []


@pytest.mark.parametrize("degree", [0, 1, 2])
def test_bonds_of_units_with_python_in_their_steps_are_accounted_alike(degree, monkeypatch):
    """With a shorter step at the end, behind which the account's polynomials go through uneven instants."""
    data = two_masses("jacobi", 7e-3, degree)
    data["master"] |= {"bonds": ["a.v_out * b.force"]}
    together, apart, _ = both_ways(data, monkeypatch)
    assert_alike(together, apart)
    assert together.info.energy


FMUS = {
    "lumped-catenary": {"stop_time": 0.15},
    "en50318-2002": {"stop_time": 0.15, "catenary.spans": 3, "record.snapshot_interval": 0.05},
}


@pytest.mark.parametrize("name", FMUS)
def test_fmus_give_the_same_bits(name, monkeypatch):
    """Companion inputs, outputs that follow within the instant; the distributed catenary has wide ports."""
    assert_alike(*both_ways(load_scene(name).with_changes(FMUS[name]), monkeypatch)[:2])


@pytest.mark.parametrize("flags", ["", 'canInterpolateInputs="true"'])
def test_fmus_of_another_maker_give_the_same_bits(flags, foreign, monkeypatch):
    """x'' = -x in a circle of two integrators: inputs as derivatives, or as the mean over a step."""
    back = {"source": "g.x", "target": "f.u", "factor": -1.0, "offset": 0.1}
    data = {
        "stop_time": 10.0,
        "connections": ["f.x -> g.u", back],
        "units": {u: {"fmu": foreign(flags)} for u in "fg"},
        "master": {"algorithm": "gauss-seidel", "step": 0.01, "extrapolation": 2},
    }
    together, apart, _ = both_ways(data, monkeypatch)
    assert_alike(together, apart)
    assert np.ptp(together["f.x"]) > 0.15  # it swings about 0.1 with an amplitude of 0.1


def whole_numbers(algorithm: str, degree: int, **counter) -> dict:
    """Discrete reals, whole numbers, members of an enumeration and truth values beside moving ones, in a chain of FMUs."""
    kinds = ("Float64_continuous", "Float64_discrete")
    passed_on = [f"a.{kind}_output -> b.{kind}_input" for kind in kinds] + [
        f"a.{kind}_out -> b.{kind}_in" for kind in ("Boolean", "Int32", "Enumeration")
    ]
    start = {"Boolean_in": True, "Enumeration_in": "far", "Float64_fixed_parameter": 0.5}
    counter = {"source": "stair.counter", "target": "a.Int32_in", **counter}
    units = {
        "b": {"fmu": native_fmu("feedthrough", 2)},
        "a": {"fmu": native_fmu("feedthrough", 2), "parameters": start},
        "integral": {"fmu": native_fmu("integrator", 2)},
        "stair": {"fmu": native_fmu("stair", 2)},
    }
    return {
        "stop_time": 4.0,
        "units": units,
        "master": {"algorithm": algorithm, "step": 0.01, "extrapolation": degree},
        "connections": [
            *passed_on,
            "integral.x -> a.Float64_continuous_input",
            "integral.z -> a.Float64_discrete_input",
            "b.Float64_continuous_output -> integral.u",
            counter,
        ],
    }


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_inputs_of_fmus_that_change_at_instants_give_the_same_bits(algorithm, monkeypatch):
    together, apart, _ = both_ways(whole_numbers(algorithm, 1), monkeypatch)
    assert_alike(together, apart)
    assert set(together["b.Int32_out"]) >= {1.0, 2.0, 3.0, 4.0}
    assert (together["b.Boolean_out"][-1], together["b.Enumeration_out"][-1]) == (1.0, 7.0)
    assert together["b.Float64_discrete_output"][-1] == together["integral.z"][-1] != 0.0


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_number_that_an_input_cannot_hold_ends_both_at_the_same_step(algorithm, monkeypatch):
    together, apart, _ = both_ways(whole_numbers(algorithm, 1, factor=1e9), monkeypatch)
    assert_alike(together, apart)
    assert "a failed at t = 1.99 s" in together.message
    assert "input Int32_in cannot be 3e+09" in together.message


@pytest.mark.parametrize("interval", [0.01, 0.03, 0.035])
def test_records_at_intervals_are_the_same(interval, monkeypatch):
    data = two_masses("jacobi", 1e-2, 1) | {"record": {"signals": ["b.x_out"], "interval": interval}}
    assert_alike(*both_ways(data, monkeypatch)[:2])


@pytest.mark.parametrize(
    ("step", "changes"),
    [
        (0.13, {}),
        (0.13, {"master.bonds": ("spring.second_force_x * mass.base_velocity_x",)}),
        (0.065, {"units.spring.every": 2}),
        (0.065, {"units.spring.every": 2, "master.algorithm": "gauss-seidel"}),
    ],
)
def test_a_batch_in_which_a_coupling_has_grown_is_taken_back(step, changes, monkeypatch):
    """Up to the step at which the monitor would have ended the run, with all that was recorded and counted by then."""
    scene = load_scene("mass-on-spring").with_changes({"master.step": step, "stop_time": 200.0, **changes})
    restored = []
    monkeypatch.setattr(Stepping, "_restore", counted(Stepping._restore, restored))
    together, apart, _ = both_ways(scene, monkeypatch, in_process=True)
    assert (together.outcome, len(restored)) == ("unstable", 1)
    assert_alike(together, apart)


@kernel
def push_start(t, s, p, e):
    s.motion[1] = 1.0
    return DONE


@kernel
def push(t, h, s, p, e):
    s.motion[1] += h * s.u[0, 0]
    s.motion[0] += h * s.motion[1]
    return push_outputs(t + h, s, p, e)


@kernel
def push_outputs(t, s, p, e):
    s.y[0], s.y[1] = s.motion[0], s.motion[1]
    return DONE


@kernel
def pull(t, s, p, e):
    s.y[0] = -100.0 * s.u[0, 0] - 4.0 * s.u[0, 1]
    return DONE


@kernel
def pull_step(t, h, s, p, e):
    return pull(t + h, s, p, e)


class Pushed(KernelComponent):
    """1 kg whose motion stands in an array that `save` knows nothing of."""

    force = input_(0.0, "N", "force")
    x_out = output("m", "position")
    v_out = output("m/s", "velocity")
    kernels = Kernels(push_start, push, push_outputs)

    def shapes(self):
        return {"motion": 2}


class Pulling(KernelComponent):
    """Spring and damper."""

    position = input_(0.0, "m", "position of the end")
    velocity = input_(0.0, "m/s", "velocity of the end")
    force = output("N", "force")
    kernels = Kernels(nothing, pull_step, pull)


@pytest.mark.parametrize("step", [0.02, 0.036])  # spectral radius of a step: 0.980, 1.004
def test_all_that_kernels_of_a_users_component_write_is_taken_back(step, monkeypatch):
    data = {
        "stop_time": 6000 * step,
        "connections": ["s.force -> m.force", "m.x_out -> s.position", "m.v_out -> s.velocity"],
        "units": {"m": {"component": f"{__name__}:Pushed"}, "s": {"component": f"{__name__}:Pulling"}},
        "master": {"algorithm": "jacobi", "step": step},
    }
    restored = []
    monkeypatch.setattr(f"{BATCH}.BATCH_SECONDS", 1e3)
    monkeypatch.setattr(Stepping, "_restore", counted(Stepping._restore, restored))
    together, apart, batches = both_ways(data, monkeypatch)
    assert (together.outcome, len(restored)) == (("unstable", 1) if step > 0.03 else ("done", 0)), together.message
    assert_alike(together, apart)
    assert len(batches) <= 5


@pytest.mark.parametrize("interval", [0.007, 0.05])
def test_nothing_that_watches_a_run_cuts_its_batches(interval, monkeypatch):
    """Recorders and the monitor of instability look at steps within a batch: of 20 000 steps a few dozen ends are left."""
    batches = []
    data = two_masses("gauss-seidel", 1e-3, 1) | {"stop_time": 20.0, "record": {"signals": ["b.x_out"], "interval": interval}}
    monkeypatch.setattr(f"{BATCH}.BATCH_SECONDS", 1e3)
    monkeypatch.setattr(Master, "take_steps", counted(Master.take_steps, batches))
    assert run(read_scene(data), in_process=True).outcome == "done"
    assert len(batches) <= 2 + 20_000 // (LOOKS * InstabilityMonitor.EVERY * InstabilityMonitor.RARELY)


def test_batches_end_where_faults_begin_and_end(monkeypatch):
    """At 333 and 500 ms and behind 700 of 1000 steps; each ends with the steps that are left up to there."""
    faults = [
        {"signal": "b.force", "kind": "offset", "value": 50.0, "begin": 0.333, "end": 0.5},
        {"signal": "a.x_out", "kind": "freeze", "begin": 0.7},
    ]
    monkeypatch.setattr(f"{BATCH}.BATCH_SECONDS", 1e3)
    together, apart, batches = both_ways(two_masses("gauss-seidel", 1e-3, 1) | {"faults": faults}, monkeypatch)
    assert_alike(together, apart)
    assert {333, 500, 700, 1000} <= set(np.cumsum(batches).tolist())


def test_a_run_goes_on_from_a_checkpoint_as_it_would_have(tmp_path, monkeypatch):
    file = tmp_path / "run.checkpoint"
    scene = read_scene(two_masses("gauss-seidel", 1e-3, 2))
    whole = run(scene, checkpoint_every=0.4, checkpoint_to=file)
    again = run(scene, resume=file)
    for name in whole.columns:
        assert again[name].tobytes() == whole[name].tobytes()


@pytest.mark.parametrize(
    ("algorithm", "rates"), [("jacobi", {}), ("jacobi", {"p": 4}), ("gauss-seidel", {"a": 2, "b": 4})], ids=str
)
def test_a_failure_keeps_every_step_before_it(algorithm, rates, monkeypatch):
    data = two_masses(algorithm, 1e-2, 1)
    data["units"]["p"] = {"component": "cosimo.tests.support:Probe", "parameters": {"fail_at": 0.555}}
    data["connections"].append("a.x_out -> p.length")
    for unit, every in rates.items():
        data["units"][unit]["every"] = every
    together, apart, _ = both_ways(data, monkeypatch)
    assert_alike(together, apart)
    assert len(together.time) == 56
    assert together.message.startswith("p failed at t = 0.5")


def test_a_failure_of_an_fmu_keeps_every_step_before_it(foreign, monkeypatch):
    """x' = x of a circle of two grows over the limit."""
    limit = {"limit": 3.0}
    loop = {
        "stop_time": 100.0,
        "connections": ["f.x -> g.u", {"source": "g.x", "target": "f.u", "offset": 1.0}],
        "units": {u: {"fmu": foreign(), "parameters": limit} for u in "fg"},
        "master": {"algorithm": "jacobi", "step": 0.01},
    }
    together, apart, _ = both_ways(loop, monkeypatch)
    assert_alike(together, apart)
    assert "is above the limit" in together.message
    assert together["f.x"].max() <= 3.0


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # it overflows, as it should
def test_growth_without_bound_ends_both_at_the_same_step(monkeypatch):
    data = two_masses("jacobi", 0.2, 2) | {"stop_time": 200.0}
    together, apart, _ = both_ways(data, monkeypatch)
    assert_alike(together, apart)
    assert "has grown to" in together.message
