"""Times: confirmed by a second measurement or refused."""

import math

import pytest
from cosimo.orchestrator.harness.studies.accuracy import Point, front_of
from cosimo.orchestrator.harness.studies.trial import ATTEMPTS, Timing, repeated


def measuring(*times):
    """A measurement that gives one time after the other, the last one for ever."""
    left = list(times)
    return lambda: left.pop(0) if len(left) > 1 else left[0]


def test_two_times_that_agree_are_enough():
    timing = repeated(measuring(1.0, 1.1, 5.0), repeats=2)
    assert (timing.seconds, timing.confirmed) == (1.0, True)
    assert timing.scatter == pytest.approx(0.1)
    assert timing.spread == pytest.approx(0.1)


def test_times_that_differ_are_repeated_until_two_agree():
    timing = repeated(measuring(1.0, 1.9, 1.5, 1.05, 9.0), repeats=2)
    assert timing.confirmed
    assert timing.seconds == 1.0
    assert timing.spread == pytest.approx(0.9)


def test_times_that_never_agree_are_refused():
    calls = []

    def slower():
        calls.append(1.5 ** len(calls))
        return calls[-1]

    timing = repeated(slower, repeats=3)
    assert len(calls) == ATTEMPTS
    assert not timing.confirmed
    point = Point("a", "coupling", 1.0, {}, "done", error=1e-3, error_with_finer=1e-3, work={"calls": 5}).timed(timing)
    assert math.isnan(point.seconds)
    assert "differ by 50 %" in point.reason
    assert front_of([point], "seconds") == []
    assert front_of([point], "calls") == [point]  # counted work is as it was


def test_patience_ends_repetition_but_not_confirmation():
    assert repeated(measuring(1.0, 1.0), repeats=9, patience=0.5).scatter == 0.0
    assert math.isnan(repeated(measuring(1.0, 1.0), repeats=9, patience=0.5, confirm=False).scatter)
    assert not Timing((1.0,)).confirmed
