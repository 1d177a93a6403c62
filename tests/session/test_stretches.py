"""What judges a run from the states of an open scene: stretches of another step, units by themselves, pushed inputs."""

import cosimo
import numpy as np
import pytest
from cosimo.orchestrator.opened.open_scene import started
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


def test_a_unit_that_steps_alone_is_left_as_it_was(opened):
    open_scene, course = opened
    before = course.save()
    steps = open_scene.units["mass"].work()
    open_scene.alone("mass", 1e-3)
    assert open_scene.units["mass"].work() != steps
    assert course.save().saved.units == before.saved.units


def test_a_state_keeps_the_counters_of_step_control_as_they_were():
    control = {"method": "doubling", "relative": 1e-4, "absolute": 1e-6}
    with cosimo.open(cosimo.load_scene("mass-on-spring").with_changes({"master.control": control})) as sim:
        sim.initialize()
        sim.step(3)
        state = sim.save()
        before = bytes(state)
        sim.step(5)
        assert bytes(state) == before
        sim.restore(state)
        assert bytes(sim.save()) == before
