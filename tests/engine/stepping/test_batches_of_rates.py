"""Batches of steps with units that step at rates of their own: the bits of steps one by one, for every kind of unit."""

import numpy as np
import pytest
from cosimo.orchestrator.engine.algorithms.compiled_loop import CompiledLoop
from cosimo.orchestrator.run import run
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.engine.stepping.test_batch_stepping import ALGORITHMS, assert_alike, both_ways, whole_numbers
from cosimo.tests.short_run import full_but
from cosimo.tests.support import two_masses

LAST = 1  # step that is taken alone: it may be the end of a shorter one of a unit
RATES = full_but(({"a": 2, "b": 5},), ({"a": 3}, {"b": 4}, {"p": 3}, {"a": 2, "b": 5}))


def probed(algorithm, degree, rates, step=7e-3, **parameters):
    """Two masses, and an output that follows within the instant, with a unit of measure that is converted."""
    data = two_masses(algorithm, step, degree)
    data["units"]["p"] = {"component": "cosimo.tests.support:Probe", "parameters": parameters}
    data["connections"].append("a.x_out -> p.length")
    return with_rates(data, rates)


def with_rates(data, rates):
    for unit, every in rates.items():
        data["units"][unit]["every"] = every
    return data


@pytest.mark.parametrize("smoothing", [False, True])
@pytest.mark.parametrize("rates", RATES, ids=str)
@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_components_at_rates_of_their_own(algorithm, degree, rates, smoothing, monkeypatch):
    data = probed(algorithm, degree, rates)
    data["master"]["smoothing"] = smoothing and degree > 0
    together, apart, alone = both_ways(data, monkeypatch, CompiledLoop)
    assert_alike(together, apart)
    assert alone == LAST


def test_a_rate_changes_what_a_scene_gives():
    """So that nothing above compares a run without rates with itself."""
    plain, slow = (run(read_scene(probed("jacobi", 1, rates))) for rates in ({}, {"b": 4}))
    assert plain["a.x_out"].tobytes() != slow["a.x_out"].tobytes()
    assert np.all(slow["b.x_out"][1:4] == slow["b.x_out"][0])


@pytest.mark.first(2)
@pytest.mark.parametrize("slow", ["catenary", "pantograph"])
@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("native", [False, pytest.param(True, marks=pytest.mark.full)])
def test_fmus_at_rates_of_their_own(algorithm, degree, slow, native, monkeypatch):
    """FMUs of pythonfmu and native ones of the railway pair, which takes a fault in the middle of a step of the slow unit."""
    fault = {"signal": "pantograph.contact_position", "kind": "offset", "value": 0.5, "begin": 0.0573}
    scene = load_scene("lumped-catenary").with_changes({
        "stop_time": 0.1505, "master.algorithm": algorithm, "master.extrapolation": degree, f"units.{slow}.every": 4,
        "faults": [fault]})
    together, apart, alone = both_ways(scene, monkeypatch, CompiledLoop, native=native)
    assert_alike(together, apart)
    assert LAST < alone <= 10  # around the fault


@pytest.mark.full
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_wide_ports_at_rates_of_their_own(algorithm, monkeypatch):
    scene = load_scene("en50318-2002").with_changes({
        "stop_time": 0.05, "units.catenary.parameters.spans": 3, "record.snapshot_interval": 0.01, "units.catenary.every": 2,
        "master.algorithm": algorithm, "master.extrapolation": 2})
    assert_alike(*both_ways(scene, monkeypatch, CompiledLoop)[:2])


@pytest.mark.first(2)
@pytest.mark.parametrize("flags", ["", 'canInterpolateInputs="true"'])
@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_fmus_of_another_maker_at_rates_of_their_own(algorithm, degree, flags, foreign, monkeypatch):
    """Inputs as derivatives, or as the mean over the long step."""
    back = {"source": "g.x", "target": "f.u", "factor": -1.0, "offset": 0.1}
    data = {"stop_time": 10.0, "connections": ["f.x -> g.u", back], "units": {u: {"fmu": foreign(flags)} for u in "fg"},
            "master": {"algorithm": algorithm, "step": 0.01, "extrapolation": degree}}
    together, apart, alone = both_ways(with_rates(data, {"g": 4}), monkeypatch, CompiledLoop)
    assert_alike(together, apart)
    assert alone == LAST
    assert np.ptp(together["f.x"]) > 0.15


@pytest.mark.first(2)
@pytest.mark.parametrize("rates", [{"a": 3, "stair": 2}, {"integral": 4}, {"b": 3}], ids=str)
@pytest.mark.parametrize("degree", [0, 1, 2])
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_inputs_that_change_at_instants_at_rates_of_their_own(algorithm, degree, rates, monkeypatch):
    data = with_rates(whole_numbers(algorithm, degree), rates)
    together, apart, alone = both_ways(data, monkeypatch, CompiledLoop)
    assert_alike(together, apart)
    assert alone == LAST
    assert set(together["b.Int32_out"]) >= {1.0, 2.0, 3.0, 4.0}


@pytest.mark.parametrize("algorithm", ALGORITHMS)
@pytest.mark.parametrize("rates", [{"p": 4}, {"a": 2, "b": 4}], ids=str)
def test_a_failure_at_another_rate_ends_both_at_the_same_step(algorithm, rates, monkeypatch):
    together, apart, _ = both_ways(probed(algorithm, 1, rates, 0.01, fail_at=0.555), monkeypatch, CompiledLoop)
    assert_alike(together, apart)
    assert together.message.startswith("p failed at t = 0.5")


def test_a_failure_of_a_slow_fmu_ends_both_at_the_same_step(foreign, monkeypatch):
    loop = {"stop_time": 100.0, "connections": ["f.x -> g.u", {"source": "g.x", "target": "f.u", "offset": 1.0}],
            "units": {u: {"fmu": foreign(), "parameters": {"limit": 3.0}} for u in "fg"},
            "master": {"algorithm": "jacobi", "step": 0.01}}
    together, apart, _ = both_ways(with_rates(loop, {"f": 7}), monkeypatch, CompiledLoop)
    assert_alike(together, apart)
    assert "is above the limit" in together.message


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # it overflows, as it should
def test_growth_without_bound_at_other_rates_ends_both_at_the_same_step(monkeypatch):
    together, apart, _ = both_ways(with_rates(two_masses("jacobi", 0.1, 2) | {"stop_time": 200.0}, {"b": 2}), monkeypatch,
                                   CompiledLoop)
    assert_alike(together, apart)
    assert "has grown to" in together.message


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_batch_is_taken_back_with_the_polynomials_of_slow_units(algorithm, monkeypatch):
    """Up to the step at which the monitor would have ended the run."""
    scene = load_scene("mass-on-spring").with_changes({
        "master.step": 0.065, "stop_time": 200.0, "units.spring.every": 2, "master.algorithm": algorithm})
    restored, restore = [], CompiledLoop.restore
    monkeypatch.setattr(CompiledLoop, "restore", lambda self, saved: (restored.append(1), restore(self, saved)))
    together, apart, _ = both_ways(scene, monkeypatch, CompiledLoop, in_process=True)
    assert (together.outcome, len(restored)) == ("unstable", 1)
    assert_alike(together, apart)


@pytest.mark.parametrize("faults", [[{"signal": "b.force", "kind": "offset", "value": 50.0, "begin": 0.333, "end": 0.5}],
                                    [{"signal": "a.x_out", "kind": "freeze", "begin": 0.7}]])
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_faults_begin_within_steps_of_slow_units(algorithm, faults, monkeypatch):
    data = probed(algorithm, 2, {"a": 2, "b": 5}, 2.1e-3) | {"faults": faults}
    together, apart, alone = both_ways(data, monkeypatch, CompiledLoop)
    assert_alike(together, apart)
    assert LAST < alone <= 20  # at most one step of both for each of its ends


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_bond_beside_a_slow_unit_is_accounted_alike(algorithm, monkeypatch):
    data = probed(algorithm, 1, {"p": 3})
    data["master"]["bonds"] = ["a.v_out * b.force"]
    together, apart, _ = both_ways(data, monkeypatch, CompiledLoop)
    assert_alike(together, apart)
    assert together.info["energy"]


@pytest.mark.parametrize("at", [0.1701, 0.34])
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_run_goes_on_from_within_a_step_of_a_slow_unit(algorithm, at, tmp_path):
    scene = read_scene(probed(algorithm, 2, {"a": 3, "b": 4}, 1e-3))
    whole = run(scene)
    run(scene, checkpoint_every=at, checkpoint_to=tmp_path / "file")
    resumed = run(scene, resume=tmp_path / "file")
    for name in whole.columns:
        assert resumed[name].tobytes() == whole[name].tobytes()
