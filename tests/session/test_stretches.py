"""What judges a run from the states of an open scene: stretches of another step, units by themselves, pushed inputs."""

import numpy as np
import pytest
from cosimo.orchestrator.session.open_scene import started
from cosimo.orchestrator.systems import load_scene

SCENE = load_scene("mass-on-spring")
H = SCENE.master.step


@pytest.fixture
def opened():
    with started(SCENE) as course:
        yield course.open_scene, course


def test_a_stretch_has_the_bits_of_the_steps_and_moves_no_clock(opened):
    open_scene, course = opened
    course.stepping.run((), 10)
    state = course.save()
    stretched = course.stretch(H, range(5)).rows
    assert course.stepping.tick == state.tick
    course.restore(state)
    for row in stretched:
        course.stepping.run((), 1)
        assert open_scene.master.signals.tobytes() == row.tobytes()


def test_a_stretch_of_half_the_steps_is_a_run_with_them(opened):
    _, course = opened
    finer = course.stretch(0.5 * H, range(40)).rows
    with started(SCENE.with_changes({"master.step": 0.5 * H})) as other:
        assert other.stretch(0.5 * H, range(40)).rows.tobytes() == finer.tobytes()


def test_stretches_go_on_where_one_has_ended(opened):
    _, course = opened
    state = course.save()
    whole = course.stretch(H, range(8)).rows
    course.restore(state)
    assert np.concatenate([course.stretch(H, range(3)).rows, course.stretch(H, range(3, 8)).rows]).tobytes() == whole.tobytes()


def test_a_unit_alone_answers_and_is_left_as_it_was(opened):
    """A mass of 1 kg under so much force: half of h² more of the way."""
    open_scene, course = opened
    before, force = course.save(), open_scene.inputs("mass")["base_force_x"]
    calm, pulled = (open_scene.alone("mass", {"base_force_x": force + by}, 1e-3) for by in (0.0, 2.0))
    assert pulled["base_x"] - calm["base_x"] == pytest.approx(1e-6, rel=1e-6)
    springs = [open_scene.alone("spring", {"second_x": x})["second_force_x"] for x in (0.0, 0.1)]
    assert springs[1] - springs[0] == pytest.approx(-10.0)
    assert course.save().master.units == before.master.units


def test_what_is_pushed_arrives_behind_the_step_and_goes_when_nothing_is(opened):
    """The mass goes by the line through its last forces: over a step, by half of what was added to the newest."""
    open_scene, course = opened
    state = course.save()
    calm = course.stretch(H, range(2)).rows
    course.restore(state)
    open_scene.push({("mass", "base_force_x"): 1.0})
    assert course.stretch(H, range(1)).rows.tobytes() == calm[:1].tobytes()
    open_scene.push({})
    assert course.stretch(H, range(1, 2)).rows[0, 1] - calm[1, 1] == pytest.approx(1.5 * H)
    course.restore(state)
    assert course.stretch(H, range(2)).rows.tobytes() == calm.tobytes()
