"""A measurement that the model cannot explain is not fitted: which test says so, and what cannot be told is said beforehand."""

from __future__ import annotations

import cosimo
import numpy as np
import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.estimation.suspects import Suspect
from cosimo.tests.estimation.oscillator import KICK, NOISE, SIGNAL, Oscillator

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
TRUTH = Oscillator(count=120)


def failed(found):
    return {c.name for c in found.verdict.checks if not c.holds}


def test_a_right_model_explains_nearly_all_of_its_measurements():
    assert sum(TRUTH.estimate(TRUTH.drawn(seed)[0]).explains for seed in range(3)) == 3


def test_a_wrong_damping_is_named_though_innovations_have_the_right_size():
    y, _ = Oscillator(count=400, damping=0.4).drawn(0)
    found = Oscillator(count=400, damping=2.0).estimate(y)
    assert not found.explains
    assert "size of innovations" not in failed(found)  # the kicks take the blame
    first = found.verdict.suspects[0]
    assert first.name == "spring.damping"
    assert first.at + first.change == pytest.approx(0.4, abs=3.0 * first.deviation)
    assert "spring.damping" in str(found.verdict)
    assert "instead of 2" in str(found.verdict)


def test_another_value_is_one_that_the_number_may_have():
    """A truth that swings up by itself would need a negative damping: the verdict names the limit, and what that explains."""
    swings = np.exp(0.1 * TRUTH.times) * 0.02 * np.sin(10.0 * TRUTH.times)
    found = TRUTH.estimate(swings, TRUTH.scene(**{"spring.damping": 1.0}), suspected=["spring.damping"], states={})
    first = next(s for s in found.verdict.suspects if s.name == "spring.damping")
    assert first.at + first.change < 0.0
    assert first.value == 0.0
    assert 2.0 < first.gain < 0.5 * (first.change / first.deviation) ** 2
    assert "spring.damping at its limit of 0 N.s/m instead of 1 explains it better" in str(found.verdict)


def test_the_gain_of_a_limit_is_that_of_the_parabola_there():
    free, held = Suspect("a.b", "N", 1.0, -2.0, 0.5), Suspect("a.b", "N", 1.0, -2.0, 0.5, low=0.0)
    assert free.gain == pytest.approx(8.0)  # of -0.5 (d + 2)² / 0.25: from d = 0 to d = -2
    assert held.gain == pytest.approx(8.0 - 2.0)  # and to d = -1
    assert Suspect("a.b", "N", 0.0, -2.0, 0.5, low=0.0).gain == 0.0


@pytest.mark.parametrize(
    ("wrong", "test"),
    [
        (lambda y: y + NOISE * 1.2 * np.random.default_rng(9).standard_normal(y.size), "size of innovations"),
        (lambda y: y + 0.02, "other values"),
        (lambda y: np.where(np.arange(y.size) == 70, y + 0.2, y), "outliers"),
        (lambda y: np.where(np.arange(y.size) > 90, 0.0, y), "size in windows"),
    ],
)
def test_what_the_model_cannot_explain_is_said(wrong, test):
    assert test in failed(TRUTH.estimate(wrong(TRUTH.drawn(1)[0])))


def test_an_offset_of_a_sensor_is_named():
    found = TRUTH.estimate(TRUTH.drawn(1)[0] + 0.02)
    offset = next(s for s in found.verdict.suspects if s.name == f"offset of {SIGNAL}")
    assert offset.change == pytest.approx(0.02, abs=3.0 * offset.deviation)
    assert offset.gain > 10.0


def test_a_stiffness_far_off_what_was_expected_is_said():
    y, _ = Oscillator(count=120, stiffness=180.0).drawn(1)
    more = TRUTH.plan()["estimated"] | {"spring.stiffness": {"deviation": "12 %"}}
    found = TRUTH.estimate(y, estimated=more)
    assert "expected values" in failed(found)


def test_noise_and_kicks_that_are_too_small_and_too_large():
    y, _ = TRUTH.drawn(3)
    measured = [{"signal": SIGNAL, "noise": NOISE * 3.0}]
    wide = TRUTH.estimate(y, measured=measured, states={"mass.base_velocity_x": {"walk": KICK * 3.0}})
    assert wide.explains
    assert any("too wide" in text for text in wide.verdict.remarks)
    narrow = TRUTH.estimate(y, states={"mass.base_velocity_x": {"walk": KICK / 3.0}})
    assert "size of innovations" in failed(narrow)


def test_noise_that_is_not_given_is_found():
    found = [TRUTH.estimate(TRUTH.drawn(seed)[0], measured=[{"signal": SIGNAL}], suspected=[]).noise[0] for seed in range(3)]
    assert np.mean(found) == pytest.approx(NOISE, rel=0.15)


def test_what_cannot_be_told_apart_is_said_before_it_is_estimated():
    said = []
    both = {"mass.mass": {"deviation": "10 %"}, "spring.stiffness": {"deviation": "10 %"}}
    TRUTH.estimate(TRUTH.drawn(1)[0], estimated=both, suspected=[], say=said.append)
    assert any("mass.mass" in text and "spring.stiffness" in text and "apart" in text for text in said)
    said.clear()
    TRUTH.estimate(TRUTH.drawn(1)[0], estimated={"mass.tip_force_y": {"deviation": "1 N"}}, suspected=[], say=said.append)
    assert said == ["the measurement says less of mass.tip_force_y than was known before it"]


def test_an_unknown_force_is_found_as_it_was():
    force = lambda t: np.where((t > 2.0) & (t < 4.0), 3.0, 0.0)  # noqa: E731 - a force in time
    scene = Oscillator(h=0.01).scene(**{"mass.start_velocity_x": 1.0, "stop_time": 6.0})
    times, y = [], []
    with cosimo.open(scene) as session:
        session.initialize()
        while not session.done:
            session["mass.tip_force_x"] = float(force(session.time))
            session.step()
            times.append(session.time)
            y.append(session[SIGNAL])
    y = np.array(y) + 1e-4 * np.random.default_rng(2).standard_normal(len(y))
    plan = {
        "measured": [{"signal": SIGNAL, "noise": "0.1 mm"}],
        "estimated": {"mass.tip_force_x": {"deviation": "1 N", "walk": "5 N"}},
    }
    found = cosimo.estimate(scene, plan | {"suspected": []}, data={SIGNAL: (times, y)}, halved=False)
    value, low, high = found.walk("mass.tip_force_x")
    assert value[(found.time > 2.4) & (found.time < 3.7)].mean() == pytest.approx(3.0, abs=0.3)
    assert value[found.time > 4.4].mean() == pytest.approx(0.0, abs=0.3)
    assert np.mean((low < force(found.time)) & (force(found.time) < high)) > 0.9


def test_a_parameter_stays_within_its_bounds():
    y, _ = Oscillator(count=60, stiffness=2.0).drawn(5)
    more = TRUTH.plan()["estimated"] | {"spring.stiffness": {"start": 10.0, "deviation": 20.0}}
    found = Oscillator(count=60).estimate(y, estimated=more, suspected=[])
    value, low, _ = found.walk("spring.stiffness")
    assert (low > 0.0).all()
    assert value[-1] == pytest.approx(2.0, abs=3.0 * found["spring.stiffness"].deviation)
    within = Oscillator(count=60).estimate(
        y, estimated=more | {"spring.stiffness": {"deviation": 20.0, "low": 90.0, "high": 110.0}}, suspected=[]
    )
    assert 90.0 < within["spring.stiffness"].low < within["spring.stiffness"].high < 110.0


def test_a_parameter_of_which_a_constant_follows_acts_from_then_on():
    """1/m and the like are computed by initialization: a wrong mass is found to its own value."""
    y, _ = TRUTH.drawn(7)
    more = TRUTH.plan()["estimated"] | {"mass.mass": {"deviation": "20 %"}}
    found = TRUTH.estimate(y, TRUTH.scene(**{"mass.mass": 0.8}), estimated=more, suspected=[])
    mass = found["mass.mass"]
    assert mass.value == pytest.approx(1.0, abs=3.0 * mass.deviation)
    assert mass.deviation < 0.06
