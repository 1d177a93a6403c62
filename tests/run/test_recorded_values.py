"""What is recorded of a run, and how often, changes no number of it: rows at the same times are the same, to the last bit."""

import numpy as np
import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene, read_scene
from cosimo.tests.scene_runs import finished
from cosimo.tests.support import two_masses

SLOW = {"component": "cosimo.tests.support:Linear"}


def two(**master):
    data = two_masses("jacobi", 0.01, 1) | {"stop_time": 0.4}
    return read_scene(data | {"master": data["master"] | master})


def slow_unit():
    """A unit with a rate of its own, which is seen extrapolated between its steps."""
    data = two_masses("jacobi", 0.01, 1) | {"stop_time": 0.4}
    units = data["units"]
    return read_scene(data | {"units": units | {"b": units["b"] | {"every": 3}}})


def shipped(name, steps, **changes):
    scene = load_scene(name)
    return scene.with_changes({"stop_time": steps * scene.master.step, "faults": [], "record.interval": None, **changes})


SPRING = ["mass.base_x", "mass.base_velocity_x", "spring.second_force_x", "spring.second_x"]
CONTROL = {"method": "doubling", "relative": 1e-3, "absolute": 1e-4}
# by name: a scene, and outputs of which one after the other is recorded alone
CASES = {
    "jacobi": lambda: two(),
    "gauss-seidel": lambda: two(algorithm="gauss-seidel"),
    "iterative": lambda: two(algorithm="iterative"),
    "steps by doubling": lambda: two(control=CONTROL),
    "steps by the predictor's miss": lambda: two(control=CONTROL | {"method": "milne"}),
    "located events": lambda: two(events=["a.x_out"]),
    "energy account": lambda: two(bonds=["a.v_out * b.force"]),
    "a unit with a rate of its own": slow_unit,
    "currents follow voltages": lambda: shipped("friction-drive-preload", 20),
    "accelerations follow forces": lambda: shipped("rov-station-keeping", 20),
    "torques follow links": lambda: shipped("link-split", 20),
    "a spring alone": lambda: shipped("mass-on-spring", 40),
}


def same_rows(whole, other, what):
    """Rows of `other` stand in `whole`, with the same numbers."""
    rows = np.searchsorted(whole.time, other.time)
    np.testing.assert_array_equal(whole.time[np.minimum(rows, whole.rows - 1)], other.time, err_msg=what)
    for name in other.columns:
        np.testing.assert_array_equal(whole[name][rows], other[name], err_msg=f"{what}: {name}")


@pytest.mark.interpreted
@pytest.mark.parametrize("case", CASES)
def test_neither_the_interval_nor_the_choice_of_signals_changes_a_number(case):
    scene = CASES[case]()
    signals = [".".join(end) for end in scene.coupling.signals]
    whole = finished(scene)
    step = scene.master.step
    for interval in (step, 2 * step, 2.5 * step, 7 * step, scene.stop_time / 3):
        less = run(scene.with_changes({"record.interval": interval}), in_process=True)
        assert less.rows <= whole.rows
        same_rows(whole, less, f"interval {interval:g} s")
    chosen = dict.fromkeys([signals[0], signals[-1], *signals[:: max(len(signals) // 4, 1)]])
    for signal in chosen:
        alone = run(scene.with_changes({"record.signals": [signal]}), in_process=True)
        assert list(alone.columns) == [signal]
        same_rows(whole, alone, f"{signal} alone")
    nothing = run(scene.with_changes({"record.signals": [signals[0]], "record.interval": scene.stop_time}), in_process=True)
    same_rows(whole, nothing, "two rows")


@pytest.mark.interpreted
def test_snapshots_are_those_of_the_instant_whatever_else_is_recorded():
    scene = read_scene(
        {
            "stop_time": 1.0,
            "connections": ["m.x_out -> p.length"],
            "units": {
                "m": {"component": "cosimo.tests.support:Mass", "parameters": {"v0": 2.0}},
                "p": {"component": "cosimo.tests.support:Probe"},
            },
            "master": {"algorithm": "jacobi", "step": 0.1},
            "record": {"signals": ["m.x_out"], "snapshots": ["p.profile"], "snapshot_interval": 0.25},
        }
    )
    alone = run(scene, in_process=True).snapshots["p.profile"].values
    beside = run(scene.with_changes({"record.signals": ["m.x_out", "p.profile[1]"]}), in_process=True)
    np.testing.assert_array_equal(alone, beside.snapshots["p.profile"].values)
    rows = np.searchsorted(beside.time, beside.snapshots["p.profile"].time)
    np.testing.assert_array_equal(beside["p.profile[1]"][rows], alone[:, 0])


def test_rows_of_fmus_are_those_of_components():
    """As FMUs, whose outputs follow inputs where they are asked for."""
    scene = shipped("friction-drive-preload", 24)
    whole = run(scene)
    same_rows(run(scene, in_process=True), whole, "FMUs")
    for changes in ({"record.interval": 4 * scene.master.step}, {"record.signals": ["plain_first.current"]}):
        same_rows(whole, run(scene.with_changes(changes)), str(changes))
