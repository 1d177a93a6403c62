"""Scenes whose components run as native FMUs give every bit of the run in process; each component alone: test_native_bits.py."""

import zipfile

import numpy as np
import pytest
from cosimo import BadInput, load_scene, read_scene
from cosimo.fmus.native.build import own_target
from cosimo.orchestrator.opened.native import native_fmus, with_native_fmus
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.ssp.write import write
from cosimo.tests.fmus.native.test_native_bits import ALONE
from cosimo.tests.fmus.native.test_native_refusals import Allocating, Weighed
from cosimo.tests.scene_runs import finished
from cosimo.tests.short_run import covering_scenes

pytestmark = pytest.mark.skipif(not own_target(), reason="no target of native FMUs")
STEPS = 500  # macro steps: what takes the time is to build the FMUs


def assert_same_bits(scene):
    ours, theirs = finished(scene), run(scene, native=True)
    assert theirs.outcome == "done", theirs.message
    units, expected = theirs.info.units, ours.info.units
    tables = {name for name, unit in scene.units.items() if unit.signals}  # they are in process in every run
    assert {unit.kind for name, unit in units.items() if name not in tables} <= {
        "native FMU",
        "native FMU in a worker process",
        "contact",
    }
    assert [unit.parameters for unit in units.values()] == [unit.parameters for unit in expected.values()]
    np.testing.assert_array_equal(theirs.time, ours.time)
    assert theirs.columns.keys() == ours.columns.keys()
    for column, values in ours.columns.items():
        np.testing.assert_array_equal(theirs.columns[column], values, err_msg=column)


@pytest.mark.full
@pytest.mark.parametrize("name", covering_scenes(frozenset(ALONE)))
def test_scenes_with_every_algorithm_and_component_that_is_not_compared_alone(name):
    scene = load_scene(name)
    latest = max((fault.begin for fault in scene.faults), default=0.0)
    assert_same_bits(scene.with_changes({"stop_time": min(scene.stop_time, latest + STEPS * scene.master.step)}))


def pair(degree=1, **changes):
    """A mass and a spring, units of their own, for a second."""
    return load_scene("mass-on-spring").with_changes({"stop_time": 1.0, "master.extrapolation": degree, **changes})


def test_two_units_one_in_a_process_of_its_own(tmp_path):
    scene = pair()
    assert_same_bits(scene)
    scene = scene.with_changes({"units.spring.isolation": "process"})
    assert_same_bits(scene)
    whole = run(scene, native=True, checkpoint_every=0.5, checkpoint_to=tmp_path / "c")
    rest = run(scene, native=True, resume=tmp_path / "c")
    for column, values in whole.columns.items():
        np.testing.assert_array_equal(rest.columns[column], values, err_msg=column)


def test_an_own_component_and_faults_from_the_start():
    scene = read_scene(
        {
            "stop_time": 0.1,
            "connections": ["one.total -> two.first"],
            "master": {"step": 0.01},
            "units": {
                "one": {"component": f"{Weighed.__module__}:Weighed", "parameters": {"first": 0.5}},
                "two": {"component": f"{Weighed.__module__}:Weighed", "parameters": {"second": -3.5}},
            },
            "faults": [{"signal": "two.first", "kind": "offset", "value": 0.5, "begin": 0.0}],
        }
    )
    assert_same_bits(scene)


@pytest.mark.full
def test_the_second_run_takes_the_fmus_of_the_first():
    first = native_fmus(pair())
    assert native_fmus(pair()) == first
    other = native_fmus(pair(**{"mass.mass": 3.5}))
    assert other["spring"].path == first["spring"].path
    assert other["mass"].path != first["mass"].path


def test_a_unit_without_native_form_is_refused_with_the_scene_and_the_unit():
    units = {"one": {"component": f"{Allocating.__module__}:Allocating"}}
    scene = read_scene({"stop_time": 0.1, "master": {"step": 0.1}, "units": units}, "small")
    with pytest.raises(BadInput, match=r"small: units\.one, Allocating: .*, line \d+") as caught:
        native_fmus(scene)
    assert "\n" not in str(caught.value)


def test_a_package_of_native_fmus_runs_like_the_scene(tmp_path):
    scene = pair(degree=0)
    path = write(with_native_fmus(scene), tmp_path / "masses.ssp")
    with zipfile.ZipFile(path) as file:
        fmus = sorted(n for n in file.namelist() if n.endswith(".fmu"))
    assert fmus == ["resources/CompliantJoint.fmu", "resources/PlanarLink.fmu"]
    ours, theirs = finished(scene), run(load_scene(path))
    assert theirs.outcome == "done", theirs.message
    for column, values in ours.columns.items():
        np.testing.assert_array_equal(theirs.columns[column], values, err_msg=column)
