"""Exact dry friction with a level for each direction, against friction of equal levels and a constant force."""

import numpy as np
import pytest
from cosimo.components.core.friction import (
    directed_friction,
    directed_guard,
    directed_mode,
    directed_switch,
    stick_friction,
    stick_guard,
    stick_mode,
    stick_switch,
)

FORWARD, BACKWARD = 2.0, 8.0
LEVEL, PUSH = 0.5 * (FORWARD + BACKWARD), 0.5 * (BACKWARD - FORWARD)  # -F = -LEVEL sign(v) + PUSH
DRIVES = np.array([-20.0, -8.001, -7.9, -1.0, 0.0, 1.0, 1.99, 2.001, 20.0])


@pytest.mark.parametrize("drive", DRIVES)
@pytest.mark.parametrize("v", [-0.1, 0.0, 0.1])
def test_two_levels_are_one_level_and_a_push(v, drive):
    mode = directed_mode(v, drive, FORWARD, BACKWARD)
    assert mode == stick_mode(v, drive + PUSH, LEVEL)
    guard = directed_guard(mode, v, drive, FORWARD, BACKWARD)
    assert guard == pytest.approx(stick_guard(mode, v, drive + PUSH, LEVEL), abs=1e-8)  # HOLDS of other levels: 1e-9 of 8 N
    friction = directed_friction(mode, drive, FORWARD, BACKWARD)
    assert drive - friction == pytest.approx(drive + PUSH - stick_friction(mode, drive + PUSH, LEVEL), abs=1e-14)


@pytest.mark.parametrize(
    ("mode", "drive", "after"),
    [
        (0.0, 2.0 + 1e-6, 1.0),
        (0.0, -8.0 - 1e-6, -1.0),
        (1.0, 0.0, 0.0),
        (1.0, 2.0, 0.0),
        (-1.0, -8.0, 0.0),
        (1.0, -9.0, -1.0),
        (-1.0, 3.0, 1.0),
    ],
)
def test_what_follows_a_mode_that_has_ended(mode, drive, after):
    assert directed_switch(mode, drive, FORWARD, BACKWARD) == after
    assert stick_switch(mode, drive + PUSH, LEVEL) == after


@pytest.mark.parametrize("drive", [-1e-3, 1e-3])
def test_levels_that_vanish_hold_nothing(drive):
    assert directed_guard(0.0, 0.0, drive, 0.0, 0.0) < 0.0
    assert directed_switch(0.0, drive, 0.0, 0.0) == np.sign(drive)
    assert directed_friction(np.sign(drive), drive, 0.0, 0.0) == 0.0
    assert directed_switch(1.0, drive, 0.0, 0.0) == -1.0  # what has come to rest goes back
    assert directed_switch(-1.0, 0.0, 0.0, 0.0) == 1.0


def test_one_level_may_vanish_alone():
    assert directed_mode(0.0, 0.0, 0.0, 5.0) == 0.0
    assert directed_guard(0.0, 0.0, 0.0, 0.0, 5.0) == 0.0  # it may rest there
    assert directed_mode(0.0, 1e-300, 0.0, 5.0) == 1.0
    assert directed_mode(0.0, -4.9, 0.0, 5.0) == 0.0
