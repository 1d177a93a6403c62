"""A macro step of scenes in process beside its physics: the kernels of all units, called in a compiled loop and nothing else.

Run with `pytest -n 0 tests/benchmarks --write-page`. CPU time, best of five, all in one run. The physics goes on from where the run has
ended, with the inputs of that instant. A run of 20 000 steps has its fixed costs in it, such as finding the units' addresses.
"""

from contextlib import ExitStack
from time import process_time

import numpy as np
import pytest
from cosimo.orchestrator.opened.open_scene import OpenScene
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.units.calls import call_entry
from numba import njit

STEPS = 20_000
SCENES = {  # largest ratios accepted: of the compiled loop, and of a run recorded at every 50th step with all that watches it
    "rov-station-keeping": (2.2, 4.0),
    "friction-drive-step": (1.5, 2.4),
    "gyroscopic-rotor": (1.3, 1.5),
    "wrist-motion": (1.6, 2.4),
    "gimbal-scan": (1.6, 3.2),
    "wind-pump-gusts": (1.7, 3.8),
}


@njit
def physics(functions, arguments, times, h):
    """Steps of all units from each of `times`; inputs are as they are."""
    for t in times:
        for k in range(functions.size):
            call_entry(functions[k], t, h, arguments[k])


def best(function) -> float:
    """Least CPU time of five calls, s."""
    spent = []
    for _ in range(5):
        begin = process_time()
        function()
        spent.append(process_time() - begin)
    return min(spent)


def measured(scene, steps: int) -> tuple[float, float]:
    """CPU time of a macro step in the compiled loop and of its physics, s."""
    h = scene.master.step
    with ExitStack() as stack:
        open_scene = OpenScene(scene, stack, in_process=True, watched=())
        units, master = open_scene.units, open_scene.master
        master.initialize(0.0)
        times = h * np.arange(steps)
        coupled = best(lambda: master.take_steps(times[:1000], h))
        components = [unit.component for unit in units.values()]
        functions, arguments = np.array([c.entry("step") for c in components]), np.array([c.block.address for c in components])
        physics(functions, arguments, times[:1], h)
        alone = best(lambda: physics(functions, arguments, times, h))
    return coupled / 1000, alone / steps


@pytest.mark.parametrize("name", SCENES)
def test_a_macro_step_costs_little_more_than_its_physics(name, told):
    scene = load_scene(name)
    h = scene.master.step
    loop, alone = measured(scene, STEPS)
    long = scene.with_changes({"stop_time": STEPS * h, "record.interval": 50 * h})
    run(long.with_changes({"stop_time": 100 * h}), in_process=True)
    whole = min(run(long, in_process=True).info.timing.cpu for _ in range(5)) / STEPS
    told("stepping", f"`{name}`", physics_µs=1e6 * alone, loop_over_physics=loop / alone, run_over_physics=whole / alone)
    if name in ("rov-station-keeping", "wind-pump-gusts", "gimbal-scan"):
        told.target(f"a macro step over its physics, `{name}`", loop / alone, 1.3, "×")
    of_loop, of_run = SCENES[name]
    assert loop < of_loop * alone
    assert whole < of_run * alone
