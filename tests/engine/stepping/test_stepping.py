"""The stepping loop: which ticks are met, what happens there, and that the end is never passed."""

import numpy as np
import pytest
from cosimo.orchestrator.engine.stepping.clock import Clock
from cosimo.orchestrator.engine.stepping.loop import Stepping, lengths
from hypothesis import given
from hypothesis import strategies as st


class Log:
    """Stands for a master, and notes its steps."""

    def __init__(self):
        self.steps = []

    def step(self, t, h):
        self.steps.append((t, h))


def stepped(step, stop_time, stops=()):
    """Times of the steps, what was done at the stops, and what observers saw, with stops in seconds."""
    clock, log, seen = Clock.dividing(step, stop_time, *stops), Log(), []
    loop = Stepping(
        log,
        clock,
        clock.ticks(step),
        clock.ticks(stop_time),
        {clock.ticks(s): [lambda s=s: seen.append(("stop", s))] for s in stops},
    )
    loop.run([lambda tick, t: seen.append(t)])
    return log.steps, seen


@given(st.integers(0, 300), st.integers(1, 300), st.integers(1, 40), st.booleans())
def test_steps_between_two_stops_fill_the_time_and_are_never_short(tick, distance, stride, last):
    stop = tick + distance
    found = [length for length, count in lengths(tick, stop, stride, last) for _ in range(count)]
    assert sum(found) == distance
    assert 0 < min(found) <= max(found) <= stride
    inner = found[:-1] if last else found
    if distance >= stride:  # two that share a length may differ by a tick
        assert all(2 * length >= stride - 1 for length in inner)
    if len(found) > 1:  # from any place on the way the same steps follow
        rest = [length for length, count in lengths(tick + found[0], stop, stride, last) for _ in range(count)]
        assert rest == found[1:]
    ends = tick + np.cumsum(found)
    assert all(end % stride == 0 for end in ends[2:-2])  # two shared steps at either end


def test_stops_are_met_before_observers_see_them():
    steps, seen = stepped(0.1, 1.0, [0.22, 0.5])
    assert seen == [0.0, 0.1, 0.16, ("stop", 0.22), 0.22, 0.3, 0.4, ("stop", 0.5), 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]
    assert [t for t, _ in steps] == [s for s in seen[:-1] if not isinstance(s, tuple)]


@pytest.mark.parametrize(
    ("step", "stop_time", "steps"), [(1e-4, 3 * 1e-4, 3), (0.1, 0.1 + 0.2, 3), (0.3, 0.1 + 0.2, 1), (1 / 30, 2 / 3, 20)]
)
def test_the_rounding_of_a_computed_end_is_no_step(step, stop_time, steps):
    """3 * 1e-4 is 3.0000000000000003e-4: without care a fourth step of 5e-20 s."""
    taken, seen = stepped(step, stop_time)
    assert len(taken) == steps
    assert seen[-1] == stop_time


def test_stops_on_the_grid_change_no_step():
    assert stepped(0.1, 1.05, [0.2, 0.7])[0] == stepped(0.1, 1.05)[0]


def test_stops_at_the_start_and_the_end_and_none_beyond():
    calls = []
    clock = Clock.dividing(0.1)
    loop = Stepping(Log(), clock, 1, 3, {k: [lambda k=k: calls.append(k)] for k in (0, 3, 4)})
    loop.run([])
    assert calls == [0, 3]
    assert loop.tick == 3


def test_a_second_action_at_a_stop_follows_the_first():
    calls = []
    loop = Stepping(Log(), Clock.dividing(0.1), 1, 3, {2: [lambda: calls.append("one"), lambda: calls.append("two")]})
    loop.run([])
    assert calls == ["one", "two"]


@pytest.mark.parametrize("step", [0.3, 7e-4, 1.0 / 3.0, 0.1])
def test_the_end_is_never_passed(step):
    steps, seen = stepped(step, 1.0)
    assert seen[-1] == 1.0
    assert max(seen) == 1.0
    assert all(t < 1.0 for t, _ in steps)
