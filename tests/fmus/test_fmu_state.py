"""States: exact, also through bytes, in another instance, after a failure; reset."""

import numpy as np
import pytest
from cosimo.fmus.build import built
from cosimo.tests.fmus.driver import DISCARD, OK, Driven

OUTPUTS = ("contact_force", "contact_position", "head_height", "head_velocity", "frame_height")
EFFECTS = {"effects.lower_frame": True, "effects.contact_loss": True, "effects.frame_friction": True}


def advance(unit, first, steps=40):
    rows = []
    for k in range(first, first + steps):
        unit.set({"wire_height": 0.02 * np.sin(0.3 * k)})
        assert unit.step(k * 1e-3, 1e-3) == OK, unit.log
        rows.append(unit.reals(OUTPUTS))
    return np.array(rows).tobytes()


@pytest.fixture
def pantograph():
    unit = Driven(built("Pantograph"))
    yield unit
    unit.free()


def test_a_repeated_run_has_the_same_bits(pantograph):
    pantograph.start(EFFECTS)
    advance(pantograph, 0)
    state = pantograph.fmu.getFMUstate()
    first = advance(pantograph, 40)

    for _ in range(2):
        pantograph.fmu.setFMUstate(state)
        assert advance(pantograph, 40) == first
    pantograph.fmu.freeFMUstate(state)


def test_a_state_may_be_saved_right_after_initialization(pantograph):
    pantograph.start(EFFECTS)
    state = pantograph.fmu.getFMUstate()
    first = advance(pantograph, 0)
    pantograph.fmu.setFMUstate(state)

    assert advance(pantograph, 0) == first


def test_serialized_bytes_go_into_a_fresh_instance(pantograph):
    pantograph.start(EFFECTS | {"head_mass": 9.0})
    advance(pantograph, 0)
    state = pantograph.fmu.getFMUstate()
    data = pantograph.fmu.serializeFMUstate(state)
    first = advance(pantograph, 40)

    other = Driven(built("Pantograph"))
    other.fmu.setFMUstate(other.fmu.deSerializeFMUstate(data))
    assert other["head_mass"] == 9.0
    assert advance(other, 40) == first
    other.free()


def test_an_input_that_was_set_but_not_used_is_part_of_the_state(new_probe):
    unit = new_probe().start({"signal": 1.0})
    unit.set({"signal": 4.0, "der(signal)": 1.0})  # makes the outputs stale
    state = unit.fmu.getFMUstate()
    unit.set({"signal": 0.0})
    unit.step(0.0, 1.0)
    unit.fmu.setFMUstate(state)

    assert unit.reals(["level", "signal", "der(signal)"]) == [12.0, 4.0, 1.0]


def test_a_state_from_before_initialization(new_probe):
    unit = new_probe()
    unit.set({"gain": 5.0})
    state = unit.fmu.getFMUstate()
    unit.start({"gain": 3.0, "signal": 1.0})
    unit.fmu.setFMUstate(state)
    assert unit["gain"] == 5.0
    unit.start({"signal": 1.0})

    assert unit["level"] == 7.5


def test_after_a_failed_step_a_saved_state_goes_on(new_probe):
    unit = new_probe().start({"signal": 1.0})
    unit.step(0.0, 1.0)
    state = unit.fmu.getFMUstate()
    unit.set({"signal": 50.0})
    assert unit.step(1.0, 1.0) == DISCARD
    assert unit.step(1.0, 0.5) == DISCARD  # the state is lost; only a restore or a reset helps
    unit.fmu.setFMUstate(state)

    assert unit.step(1.0, 1.0) == OK
    assert unit["total"] == 2.0


@pytest.mark.parametrize("spoil", [lambda b: b[:40], lambda b: b[:-8], lambda b: b"\xff" * len(b), lambda b: b""])
def test_bytes_that_are_no_state_discard_the_next_step(new_probe, spoil):
    unit = new_probe().start({"signal": 1.0})
    data = unit.fmu.serializeFMUstate(unit.fmu.getFMUstate())
    unit.fmu.setFMUstate(unit.fmu.deSerializeFMUstate(spoil(data)))

    assert any("state cannot be restored" in text for _, text in unit.log)
    assert unit.step(0.0, 1.0) == DISCARD


def test_reset_gives_the_instance_as_new(new_probe):
    unit = new_probe().start({"signal": 1.0, "gain": 5.0, "effects.bias": True})
    unit.step(0.0, 1.0)
    unit.fmu.reset()
    assert (unit["gain"], unit["effects.bias"]) == (2.0, 0)
    unit.start({"signal": 1.0})

    assert unit.reals(["level", "total"]) == [3.0, 0.0]
