"""The search for the smallest set, on errors that are known for every set."""

import math
from itertools import chain, combinations

import pytest
from cosimo.orchestrator.harness.studies.effects import select

pytestmark = pytest.mark.uncompiled


def alone(names):
    return {name: frozenset({name}) for name in names}


def subsets(names):
    return map(frozenset, chain.from_iterable(combinations(names, n) for n in range(len(names) + 1)))


@pytest.mark.parametrize(("tolerance", "kept"), [(1e-9, "abcde"), (0.015, "bcde"), (0.031, "cde"), (0.3, "de"), (10.0, "")])
def test_errors_that_add_up(tolerance, kept):
    sizes = {"d": 0.5, "a": 0.01, "c": 0.2, "b": 0.02, "e": 1.0}
    found = select(sizes, alone(sizes), lambda dropped: sum(sizes[n] for n in dropped), tolerance)
    assert sorted(set(sizes) - found.dropped) == list(kept)
    assert found.error == pytest.approx(sum(sizes[n] for n in found.dropped))
    assert found.breaking == pytest.approx({n: found.error + sizes[n] for n in kept})


@pytest.mark.parametrize("seed", range(20))
def test_nothing_that_stays_can_go_whatever_the_errors(seed):
    """Errors at random for every set, with no rule that larger sets are worse."""
    names = "abcdef"
    errors = {
        s: 0.0 if not s else math.fmod(math.sin(seed + sum(ord(n) * (k + 1) for k, n in enumerate(sorted(s)))) * 1e4, 1.0)
        for s in subsets(names)
    }
    errors = {s: abs(e) for s, e in errors.items()}
    found = select({n: errors[frozenset(n)] for n in names}, alone(names), errors.__getitem__, 0.3)
    assert found.error <= 0.3
    assert set(found.breaking) == set(names) - found.dropped
    assert all(error > 0.3 for error in found.breaking.values())


def test_every_set_is_asked_for_once():
    asked = []

    def error(dropped):
        asked.append(dropped)
        return 0.02 * len(dropped)

    names = [f"n{k}" for k in range(16)]
    select(dict.fromkeys(names, 0.02), alone(names), error, 0.1)
    assert len(asked) == len(set(asked)) <= 4 + 16  # a bisection, and one run for each that stays


def test_what_needs_another_goes_with_it():
    """b needs a: a cannot go alone, and the two of them are too much; b can."""
    groups = {"a": frozenset("ab"), "b": frozenset("b")}
    errors = {frozenset("b"): 0.005, frozenset("ab"): 0.5}
    found = select({"a": 0.5, "b": 0.005}, groups, errors.__getitem__, 0.01)
    assert found.dropped == {"b"}
    assert found.breaking == {"a": 0.5}


def test_a_run_that_fails_is_no_set():
    errors = {frozenset("a"): math.inf}
    found = select({"a": math.inf}, alone("a"), errors.__getitem__, 1.0)
    assert found.dropped == frozenset()
    assert found.breaking == {"a": math.inf}


def test_errors_that_cancel_are_not_looked_for():
    """Both too large alone, nothing together: the search does not look for it, and says so by what breaks."""
    errors = {frozenset("a"): 0.5, frozenset("b"): 0.5, frozenset("ab"): 0.0}
    found = select({"a": 0.5, "b": 0.5}, alone("ab"), errors.__getitem__, 0.1)
    assert found.dropped == frozenset()
    assert found.breaking == {"a": 0.5, "b": 0.5}
