"""A call of a scene as a function beside its macro steps alone, which no observer sees.

Run with `pytest -n 0 tests/benchmarks --write-page`.
CPU time of one thread, the median of 15 ratios, each of a call and of the steps before it.
"""

from statistics import median
from time import thread_time

import pytest
from cosimo import function, load_scene
from cosimo.orchestrator.session.session import Session

POINTS = [
    ("en50318-2002", "pantograph.static_force", "pantograph.contact_force, maximum", 1.15),
    ("en50318-2002", "pantograph.static_force", "pantograph.std", 1.3),  # with the filters of EN 50317
    ("double-pendulum", "chain.start_first_angle", "chain.tip_x, maximum", 1.15),
]


@pytest.mark.parametrize(("name", "parameter", "figure", "most"), POINTS)
def test_a_call_costs_little_more_than_its_steps(name, parameter, figure, most, told):
    scene = load_scene(name)
    if name == "double-pendulum":
        scene = scene.with_changes({"stop_time": 60.0})
    ratios = []
    with function(scene, [parameter], [figure], threads=1) as f, Session(scene) as sim:
        f(f.start)
        for _ in range(15):
            sim.reset()
            sim.initialize()
            began = thread_time()
            sim.until(scene.stop_time)
            steps, began = thread_time() - began, thread_time()
            f(f.start)
            ratios.append((thread_time() - began) / steps)
    told("functions", f"{name}, {figure}", over_its_steps=median(ratios))
    assert median(ratios) < most
