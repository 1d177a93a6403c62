"""The order in which Gauss-Seidel steps units: each group behind those that feed it."""

import itertools

import numpy as np
import pytest
from cosimo.orchestrator.engine.coupling import resolve_coupling
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene

MASS, OSCILLATOR, SPRING = (f"cosimo.tests.support:{name}" for name in ("Mass", "Oscillator", "SpringDamper"))
UNITS = {
    "push": {"component": MASS, "parameters": {"k": 5.0}},
    "near": {"component": OSCILLATOR, "parameters": {"v0": 0.0}},
    "mass": {"component": MASS, "parameters": {"v0": 0.0, "k": 20.0}},
    "far": {"component": SPRING},
}
# push -> (near <-> mass) -> far
CONNECTIONS = [
    "push.v_out -> near.velocity",
    "mass.x_out -> near.position",
    "near.force -> mass.force",
    "mass.x_out -> far.position",
    "mass.v_out -> far.velocity",
]


def scene(listed, **master) -> dict:
    return {
        "stop_time": 1.0,
        "units": {name: UNITS[name] for name in listed},
        "connections": CONNECTIONS,
        "master": {"algorithm": "gauss-seidel", "step": 0.01, **master},
    }


@pytest.mark.parametrize("order", list(itertools.permutations(UNITS)))
def test_sources_step_first_whatever_the_scene_says(order):
    """Inside the circle the order of the scene stands."""
    circle = tuple(name for name in order if name in ("near", "mass"))
    assert resolve_coupling(read_scene(scene(order))).order() == ("push", *circle, "far")


def test_only_the_order_inside_a_circle_changes_results():
    runs = {order: run(read_scene(scene(order))) for order in itertools.permutations(UNITS)}
    first = {}
    for order, result in runs.items():
        same = first.setdefault(order.index("near") < order.index("mass"), result)
        for name in same.columns:
            # whether an output is asked for once more where its inputs have moved by a rounding goes by the scene's order
            np.testing.assert_allclose(result[name], same[name], rtol=1e-12, atol=1e-12)
    assert np.abs(first[True]["mass.x_out"] - first[False]["mass.x_out"]).max() > 1e-8


def test_a_given_order_stands():
    usual, given = scene(UNITS), scene(UNITS, order=["far", "mass", "near", "push"])
    assert resolve_coupling(read_scene(given)).order(tuple(given["master"]["order"])) == ("far", "mass", "near", "push")
    assert (run(read_scene(usual))["near.x_out"] != run(read_scene(given))["near.x_out"]).any()
