"""A session that is an estimate: the filter of `estimate`, step by step, and the session where its mean is."""

from __future__ import annotations

import cosimo
import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.estimation.oscillator import KICK, NOISE, SIGNAL, Oscillator

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
TRUTH = Oscillator(count=40)
VELOCITY = "mass.base_velocity_x"


def plan(**changes):
    more = TRUTH.plan()["estimated"] | {"spring.stiffness": {"deviation": "12 %"}}
    return TRUTH.plan(estimated=more, suspected=["spring.damping"]) | changes


def opened(**changes):
    return cosimo.open(TRUTH.scene(**({"stop_time": 10.0} | changes)))


def without_constants(**changes):
    """The same, with a stiffness that wanders: a record is gone through once."""
    start = {"mass.base_x": {"deviation": "20 mm"}, VELOCITY: {"deviation": 1.0, "walk": KICK}}
    return plan(estimated={"spring.stiffness": {"deviation": "12 %", "walk": "0.5 N/m"}}, states=start) | changes


def test_constants_of_a_record_are_gone_through_again():
    y, _ = TRUTH.drawn(1)
    record = TRUTH.estimate(y, **plan(smooth=False))
    with opened() as sim:
        sim.estimate(plan())
        for t, value in zip(TRUTH.times, y, strict=True):
            now = sim.assimilate(float(t), {SIGNAL: float(value)})
    for p in now.parameters:
        assert 0.0 < abs(p.value - record[p.name].value) < 0.3 * p.deviation


def test_step_by_step_is_the_whole_record_to_the_bit():
    y, _ = TRUTH.drawn(1)
    record = TRUTH.estimate(y, **without_constants(smooth=False))
    means, deviations = record.series(VELOCITY)
    with opened() as sim:
        sim.estimate(without_constants())
        for t, value in zip(TRUTH.times, y, strict=True):
            now = sim.assimilate(float(t), {SIGNAL: float(value)})
            k = int(np.argmin(np.abs(record.time - t)))
            assert now.time == pytest.approx(t)
            assert now.signal(VELOCITY) == (means[k], deviations[k])
            assert sim[VELOCITY] == means[k]  # the session stands there
        assert [(p.value, p.low, p.high) for p in now.parameters] == [(p.value, p.low, p.high) for p in record.parameters]
        assert [(c.name, c.p) for c in now.verdict.checks] == [(c.name, c.p) for c in record.verdict.checks]
        assert sim["spring.stiffness"] == now["spring.stiffness"].value


def test_instants_of_their_own_delays_and_gaps_are_those_of_a_record():
    y, states = TRUTH.drawn(2)
    rng = np.random.default_rng(0)
    times = TRUTH.times + 0.003 * rng.random(TRUTH.times.size)
    data = {SIGNAL: (times + 0.02, y), VELOCITY: (times, states[:, 1] + 0.05 * rng.standard_normal(times.size))}
    data[VELOCITY][1][7] = np.nan
    measured = [{"signal": SIGNAL, "noise": NOISE, "delay": "20 ms"}, {"signal": VELOCITY, "noise": "5 cm/s"}]
    record = cosimo.estimate(TRUTH.scene(), without_constants(measured=measured, smooth=False), data=data, halved=False)
    events = sorted((t, name, v) for name, (ts, vs) in data.items() for t, v in zip(ts.tolist(), vs.tolist(), strict=True))
    with opened() as sim:
        sim.estimate(without_constants(measured=measured))
        for t, name, value in events:
            now = sim.assimilate(t, {name: value})
            assert t - 0.02 - TRUTH.h < now.time <= t - 0.02 + 1e-9 or now.time == record.time[0]
        now = sim.assimilate(float(record.time[-1]) + 0.02 + 1e-6, {})
    assert now.time == record.time[-1]
    k = int(np.argmin(np.abs(record.time - now.time)))
    mean, deviation = record.series(VELOCITY)
    assert now.signal(VELOCITY) == pytest.approx((mean[k], deviation[k]), rel=1e-12)


def test_a_prediction_from_the_estimate_is_taken_back_by_the_next_measurement():
    y, _ = TRUTH.drawn(3)
    answers = []
    for predicts in (False, True):
        with opened() as sim:
            sim.estimate(plan(states={}))
            for t, value in zip(TRUTH.times, y, strict=True):
                now = sim.assimilate(float(t), {SIGNAL: float(value)})
                if predicts:
                    sim.step(7)
            answers.append((now.time, now.signal(VELOCITY), now["spring.stiffness"].value))
            if not predicts:  # steps are those of a filter without measurements
                sim.step(20)
                predicted = sim[VELOCITY]
                sim.assimilate(sim.time, {})
                assert sim[VELOCITY] == pytest.approx(predicted, rel=1e-9)
    assert answers[0] == answers[1]


def test_inputs_that_were_set_are_known_to_act():
    scene = TRUTH.scene(**{"mass.start_x": 0.0, "stop_time": 6.0})
    force = lambda t: 3.0 if t < 2.0 else -2.0  # noqa: E731
    rng = np.random.default_rng(1)
    told = {"measured": [{"signal": SIGNAL, "noise": 1e-3}], "estimated": {"spring.stiffness": {"deviation": "12 %"}}}
    with cosimo.open(scene.with_changes({"spring.stiffness": 108.0})) as real, cosimo.open(scene) as sim:
        real["mass.tip_force_x"] = sim["mass.tip_force_x"] = force(0.0)
        real.initialize()
        sim.estimate(told)
        while not real.done:
            real["mass.tip_force_x"] = sim["mass.tip_force_x"] = force(real.time)
            real.step(5)
            now = sim.assimilate(real.time, {SIGNAL: real[SIGNAL] + 1e-3 * rng.standard_normal()})
    assert now["spring.stiffness"].value == pytest.approx(108.0, abs=3.0 * now["spring.stiffness"].deviation)
    assert now["spring.stiffness"].deviation < 0.2
    assert now.explains


def test_a_model_that_is_wrong_is_said_live():
    y, _ = Oscillator(count=200, damping=0.4).drawn(0)
    wrong = Oscillator(count=200, damping=2.0)
    with cosimo.open(wrong.scene(stop_time=20.0)) as sim:
        sim.estimate(wrong.plan(suspected=["spring.damping"]))
        for t, value in zip(wrong.times, y, strict=True):
            now = sim.assimilate(float(t), {SIGNAL: float(value)})
        assert "spring.damping" in str(now.verdict)


def test_a_recording_has_the_estimate_and_a_reset_ends_it():
    y, _ = TRUTH.drawn(1)
    with opened() as sim:
        sim.estimate(plan())
        sim.record()
        for t, value in zip(TRUTH.times, y, strict=True):
            sim.assimilate(float(t), {SIGNAL: float(value)})
        result = sim.result()
        assert result.time[1:] == pytest.approx(TRUTH.times)
        stiffness = sim["spring.stiffness"]
        sim.reset()
        assert sim["spring.stiffness"] == stiffness != 100.0  # what was found stays, as what was set
        sim.initialize()
        with pytest.raises(BadInput, match=r"estimate\(plan\)"):
            sim.assimilate(1.0, {})


@pytest.mark.parametrize(
    ("t", "values", "words"),
    [
        (0.5, {"mass.base_velocity_x": 1.0}, "a measured signal"),
        (0.5, {SIGNAL: "1 kg"}, "kg"),
        (0.5, {SIGNAL: float("inf")}, "infinite"),
        (0.0, {SIGNAL: 0.0}, "a time behind"),
        (float("nan"), {SIGNAL: 0.0}, "a time behind"),
        (11.0, {SIGNAL: 0.0}, "stop_time"),
    ],
)
def test_each_fault_is_one_message(t, values, words):
    with opened() as sim:
        sim.estimate(plan())
        with pytest.raises(BadInput, match=words):
            sim.assimilate(t, values)


def test_a_plan_without_noise_and_a_session_under_way_are_refused():
    with opened() as sim:
        with pytest.raises(BadInput, match="no noise of"):
            sim.estimate(plan(measured=[{"signal": SIGNAL}]))
        sim.step()
        with pytest.raises(BadInput, match="reset"):
            sim.estimate(plan())


def test_a_reset_session_is_the_scene_again_and_an_estimate_is_no_state():
    with opened() as sim, opened() as fresh:
        state = (sim.initialize(), sim.save())[1]
        sim.reset()
        sim.estimate(plan())
        for k, t in enumerate(TRUTH.times[:8]):
            sim.assimilate(float(t), {SIGNAL: 0.3 * (-1) ** k})  # far from what the scene expects
        assert sim["spring.stiffness"] != 100.0
        with pytest.raises(BadInput, match="save: got a session that estimates, expected one without"):
            sim.save()
        with pytest.raises(BadInput, match="restore: got a session that estimates"):
            sim.restore(state)
        sim.reset()
        for session in (sim, fresh):
            for name in ("spring.stiffness", "mass.start_x", "mass.start_velocity_x"):
                session[name] = {"mass.start_x": 0.1}.get(name, fresh[name])
            session.initialize()
            session.until(1.0)
        assert sim[SIGNAL] == fresh[SIGNAL]
