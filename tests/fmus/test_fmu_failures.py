"""Nothing that goes wrong may reach pythonfmu as an exception; it is logged, and the step is discarded."""

import math

import pytest
from cosimo.tests.fmus.driver import DISCARD, OK, run_script

WARNING, ERROR = 1, 3


def messages(unit, status):
    return [text for s, text in unit.log if s == status]


@pytest.mark.filterwarnings("ignore:invalid value encountered in dot")
@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({"gain": -1.0}, "gain = -1.0, expected a value in [0, 10]"),
        ({"gain": math.nan}, "gain = nan, expected"),
        ({"count": 10}, "count = 10, expected a value in [1, 9]"),
        ({"mode": "planar"}, "mode = 'planar', expected one of plain, negative"),
        ({"effects.needy": True}, "'needy' needs 'bias'"),
        ({"gain": 7.0}, "gain 7 cannot be initialized"),
        ({"signal": math.nan}, "signal = nan"),
        ({"signal": math.inf}, "signal = inf"),
        ({"der(signal)": math.nan}, "der(signal) = nan"),
    ],
)
def test_a_bad_start_is_told_and_the_first_step_is_discarded(new_probe, values, reason):
    unit = new_probe().start(values)

    assert unit.step(0.0, 0.1) == DISCARD
    assert reason in messages(unit, DISCARD)[0]


def test_a_refused_value_is_not_taken_and_a_good_one_heals(new_probe):
    unit = new_probe()
    unit.set({"gain": 99.0})
    assert unit["gain"] == 2.0
    assert "gain = 99.0, expected a value in [0, 10]" in messages(unit, ERROR)[0]
    unit.set({"gain": 3.0})
    unit.start({"signal": 1.0})

    assert unit.step(0.0, 0.1) == OK
    assert unit["level"] == 4.5


def test_after_a_failed_initialization_there_are_no_results(new_probe):
    unit = new_probe().start({"gain": 7.0, "signal": 1.0})

    assert all(math.isnan(v) for v in unit.reals(["level", "total"]))
    assert "gain 7 cannot be initialized" in messages(unit, ERROR)[0]


def test_an_effect_that_needs_another_heals_when_that_comes(new_probe):
    unit = new_probe()
    unit.set({"effects.needy": True})
    assert math.isnan(unit["level"])  # nothing that could be mistaken for a result
    assert "needs 'bias'" in messages(unit, ERROR)[0]
    unit.set({"effects.bias": True})
    unit.start()

    assert unit["level"] == 4.0
    assert unit.step(0.0, 0.1) == OK


def test_parameters_are_fixed_after_initialization(new_probe):
    unit = new_probe().start({"signal": 1.0})
    unit.set({"gain": 5.0, "mode": "negative", "effects.bias": True, "count": 5})

    assert (unit["gain"], unit["mode"], unit["effects.bias"], unit["count"], unit["level"]) == (2.0, b"plain", 0, 3, 3.0)
    assert len(messages(unit, WARNING)) == 4
    assert "gain = 5.0 refused" in messages(unit, WARNING)[0]
    assert unit.step(0.0, 0.1) == OK


@pytest.mark.parametrize(
    ("signal", "reason"),
    [
        (30.0, "output total = nan"),
        (40.0, "forty"),
        (50.0, "unit failed at t = 1 s: the iteration inside the step did not converge"),
    ],
)
def test_a_failing_step_is_discarded_with_its_reason(new_probe, signal, reason):
    unit = new_probe().start()
    assert unit.step(0.0, 1.0) == OK
    unit.set({"signal": signal})

    assert unit.step(1.0, 1.0) == DISCARD
    assert "t = 1 s" in messages(unit, DISCARD)[0]
    assert reason in messages(unit, DISCARD)[0]


@pytest.mark.parametrize("h", [0.0, -1.0, math.nan, math.inf])
def test_a_step_of_no_size_is_discarded_and_harmless(new_probe, h):
    unit = new_probe().start({"signal": 1.0})

    assert unit.step(0.0, h) == DISCARD
    assert unit.step(0.0, 0.5) == OK
    assert unit["total"] == 0.5


def test_a_bad_input_is_discarded_and_a_good_one_heals(new_probe):
    unit = new_probe().start({"signal": 1.0})
    unit.set({"signal": math.nan})
    assert math.isnan(unit["level"])
    assert "signal = nan" in messages(unit, WARNING)[0]  # no NaN is handed out in silence
    assert unit.step(0.0, 1.0) == DISCARD
    unit.set({"signal": 2.0})

    assert unit.step(0.0, 1.0) == OK
    assert unit["total"] == 2.0


def test_huge_but_finite_values_are_no_error(new_probe):
    unit = new_probe().start({"signal": 1e200})  # its square is not finite

    assert unit.step(0.0, 1.0) == OK
    assert unit["total"] == 1e200


def test_unknown_references_and_wrong_types(new_probe):
    unit = new_probe().start()
    reference = {n: v.valueReference for n, v in unit.variables.items()}

    assert math.isnan(unit.fmu.getReal([reference["mode"]])[0])
    assert math.isnan(unit.fmu.getReal([10_000])[0])
    assert unit.fmu.getInteger([reference["gain"]]) == [0]
    assert unit.fmu.getString([reference["gain"]]) == [b""]
    unit.fmu.setReal([reference["level"], reference["signal"]], [5.0, 2.0])
    unit.fmu.setString([reference["count"]], ["five"])
    assert (unit["level"], unit["count"]) == (6.0, 3)
    assert len(messages(unit, ERROR)) == 6


def test_failures_do_not_hurt_the_process(probe):
    """Every failure, often, then reset or not, and free: the exit code tells."""
    run_script(
        """
import sys
from cosimo.tests.fmus.driver import Driven
for n in range(200):
    unit = Driven(*sys.argv[1:])
    unit.start({"gain": -1.0} if n % 2 else {"effects.needy": True})
    for _ in range(3):
        assert unit.step(0.0, 0.1) == 2
    if n % 3 == 0:
        unit.fmu.reset()
        unit.start()
        unit.set({"signal": 40.0})
        assert unit.step(0.0, 0.1) == 2
    unit["level"]
    unit.free()
""",
        *probe,
    )
