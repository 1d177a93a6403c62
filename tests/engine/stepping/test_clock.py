"""Ticks against exact rational time."""

import math
from fractions import Fraction

import numpy as np
import pytest
from cosimo.orchestrator.engine.stepping.clock import Clock


def test_a_million_ticks_are_exact():
    clock = Clock.dividing(1e-4, 100.0)
    stride = clock.ticks(1e-4)
    assert clock.ticks(100.0) == 1_000_000 * stride
    for k in (1, 3, 7, 333_333, 999_999, 1_000_000):
        assert clock.seconds(k * stride) == float(Fraction(k, 10_000))  # correctly rounded, so no tolerance
    summed = 0.0
    for _ in range(1_000_000):
        summed += 1e-4
    assert summed != 100.0 == clock.seconds(1_000_000 * stride)


@pytest.mark.parametrize(("step", "stop", "strides", "rest"), [(0.3, 1.0, 3, 0.1), (7e-4, 1.0, 1428, 4e-4), (0.1, 0.3, 3, 0.0)])
def test_rest_of_a_run_that_the_step_does_not_divide(step, stop, strides, rest):
    clock = Clock.dividing(step, stop)
    assert divmod(clock.ticks(stop), clock.ticks(step))[0] == strides
    assert clock.seconds(clock.ticks(stop) % clock.ticks(step)) == rest
    assert clock.seconds(clock.ticks(stop)) == stop


def test_intervals_are_whole_numbers_of_ticks():
    clock = Clock.dividing(1e-3, 0.7, 0.02, 1.5e-3)
    assert [clock.ticks(d) for d in (1e-3, 0.7, 0.02, 1.5e-3)] == [2, 1400, 40, 3]


def test_binary_fractions_stand_for_what_was_written():
    """1/3 has no short decimal form; its ticks still meet a run of three of them only to rounding, and the end exactly."""
    clock = Clock.dividing(1.0 / 3.0, 1.0)
    assert clock.seconds(clock.ticks(1.0)) == 1.0
    assert clock.seconds(clock.ticks(1.0 / 3.0)) == 1.0 / 3.0


def test_a_finer_clock_shows_the_same_times():
    clock = Clock.dividing(1e-3, 0.7)
    fine = clock.finer(1_000_000)
    assert fine.ticks(0.7) == 1_000_000 * clock.ticks(0.7)
    assert all(fine.seconds(1_000_000 * k) == clock.seconds(k) for k in range(701))


@pytest.mark.parametrize("tick", [0, 1, 3, 700, 123_457])
def test_the_tick_not_before_a_time(tick):
    clock = Clock.dividing(1e-3).finer(7)
    t = clock.seconds(tick)
    assert clock.not_before(t) == tick
    assert clock.not_before(np.nextafter(t, np.inf)) == tick + 1
    assert clock.not_before(t + 0.4e-3 / 7.0) == tick + 1


@pytest.mark.parametrize("durations", [(1e-4, 100.0), (7e-4, 1.0), (1.0 / 3.0, 1.0), (0.1, 1e9), (1e-9, 86400.0)])
def test_times_of_many_ticks_are_those_of_each(durations):
    clock = Clock.dividing(*durations)
    ticks = range(clock.ticks(durations[1]) // 2, clock.ticks(durations[1]), max(clock.ticks(durations[1]) // 1000, 1))
    assert clock.times(ticks).tolist() == [clock.seconds(k) for k in ticks]


@pytest.mark.parametrize("frequency", [20.0, 30.0, 50.0, 77.46])
def test_an_interval_of_whole_steps_but_for_rounding_is_of_whole_steps(frequency):
    """Eight eighths of 2 pi / 50 s are a last digit more than the period: its rows would come a step late."""
    period = 2.0 * math.pi / frequency
    step = period / 8
    clock = Clock.dividing(step, 10 * period, period)
    assert clock.multiple(period, step) == 8 * clock.ticks(step)
    for part in (2.5, 1e-3):  # ticks of which there need not be a whole number
        assert clock.ticks(part * step) <= clock.multiple(part * step, step) < clock.ticks(part * step) + 1
