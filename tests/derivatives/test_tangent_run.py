"""A coupled run with tangents: its numbers are those of a run, bit by bit, its derivatives those of differences."""

from __future__ import annotations

from contextlib import ExitStack

import cosimo
import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED

if COMPILED:
    from cosimo.orchestrator.derivatives.tangent_block import TangentBlock
    from cosimo.orchestrator.derivatives.tangent_run import tangent_run

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")


def short(name, steps, changes=None):
    scene = cosimo.load_scene(name)
    pictures = {"record.snapshots": (), "record.snapshot_interval": None} if scene.record.snapshots else {}
    length = {"stop_time": scene.start_time + steps * scene.master.step, "record.interval": scene.master.step}
    return scene.with_changes({**length, **pictures, **(changes or {})})


def columns(result):
    return np.array(list(result.columns.values())).T


def recorded(block, result, values):
    """Of signals, (n, S), those that a run records, in its order."""
    places = {f"{unit}.{name}": k for k, (unit, name) in enumerate(block.signals)}
    return values[:, [places[name] for name in result.columns]]


@pytest.mark.parametrize(
    "name", ["mass-on-spring", "ball-bearing-clearance", pytest.param("en50318-2002", marks=pytest.mark.full)]
)
def test_numbers_beside_tangents_are_bit_identical_to_a_run(name):
    scene = short(name, 300)
    with ExitStack() as stack:
        block = TangentBlock(scene, stack, follow=False)
        rows = tangent_run(block, block.parameters()[:3])
        result = cosimo.run(scene, in_process=True, verify="no")
        np.testing.assert_array_equal(recorded(block, result, rows.values), columns(result))
        np.testing.assert_array_equal(rows.time, result.time)


@pytest.mark.parametrize(
    ("name", "parameter"),
    [("mass-on-spring", "mass.mass"), pytest.param("en50318-2002", "pantograph.static_force", marks=pytest.mark.full)],
)
def test_derivatives_of_a_coupled_run_are_those_of_differences(name, parameter):
    with ExitStack() as stack:
        block = TangentBlock(short(name, 200), stack)
        value, rows = block.value(parameter), tangent_run(block, [parameter])
    d = 1e-5 * value
    results = [cosimo.run(short(name, 200, {parameter: value + way}), in_process=True, verify="no") for way in (d, -d)]
    differences = (columns(results[0]) - columns(results[1])) / (2.0 * d)
    exact = recorded(block, results[0], rows.tangents[:, :, 0])
    size = np.max(np.abs(differences), axis=0)
    assert np.max(size) > 0.0
    rounding = 1e-14 * np.max(np.abs(columns(results[0]))) / d
    assert np.all(np.abs(exact - differences) <= 1e-5 * size + rounding)
