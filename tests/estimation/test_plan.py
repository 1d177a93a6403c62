"""What a plan may say, and its measurements: units, gaps, delays, rates; each fault is one message."""

from __future__ import annotations

import json

import cosimo
import numpy as np
import pytest
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.estimation.beliefs import Extended
from cosimo.orchestrator.estimation.bounds import Bounds
from cosimo.tests.commands import exit_code
from cosimo.tests.estimation.oscillator import SIGNAL, Oscillator

pytestmark = pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
TRUTH = Oscillator(count=40)
PLAN = """
[[measured]]
signal = "mass.base_x"
file = "position.csv"
column = "position"
noise = "5 mm"

[estimated]
"spring.stiffness" = { deviation = "12 %" }
"mass.start_velocity_x" = { start = 0.0, deviation = "1 m/s" }
"mass.start_x" = { deviation = "20 mm" }

[states]
"mass.base_velocity_x" = { walk = "0.5 m/s" }
"""
SETTINGS = ["--set", "spring.damping=0.4", "--step", "0.01"]


@pytest.fixture
def folder(tmp_path):
    y, _ = TRUTH.drawn(1)
    rows = [f"{1e3 * t:.1f},{1e3 * v:.4f}" for t, v in zip(TRUTH.times, y, strict=True)]
    (tmp_path / "position.csv").write_text("time [ms],position [mm]\n" + "\n".join(rows) + "\n")
    (tmp_path / "plan.toml").write_text(PLAN)
    return tmp_path


def test_a_command_gives_state_parameters_bands_and_a_verdict(folder, capsys):
    out = folder / "out"
    assert exit_code("estimate", "mass-on-spring", "--plan", folder / "plan.toml", *SETTINGS, "-o", out) == 0
    assert "The model explains the measurement." in capsys.readouterr().out
    answer = json.loads((out / "estimate.json").read_text())
    k = answer["parameters"]["spring.stiffness"]
    assert k["low"] < 100.0 < k["high"]
    assert 0.0 < k["error"] < k["deviation"]  # numerical beside statistical
    lines = (out / "states.csv").read_text().splitlines()
    assert '"mass.base_velocity_x, low [m/s]"' in lines[0]
    assert len(lines) == 2 + 5 * TRUTH.count - 1
    assert "not explained" not in (out / "report.html").read_text()


def test_a_command_ends_with_1_where_the_model_does_not_explain(folder, capsys):
    plan = str(folder / "plan.toml")
    assert (
        exit_code(
            "estimate",
            "mass-on-spring",
            "--plan",
            plan,
            "--no-verify",
            "--set",
            "spring.damping=4.0",
            "--step",
            "0.01",
            "-o",
            folder / "out",
        )
        == 1
    )
    assert "spring.damping" in capsys.readouterr().err


def test_a_new_plan_runs_as_it_is(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exit_code("new", "plan", "plan.toml", "mass-on-spring", "--signal", "mass.base_x", "--unknown", "spring.stiffness")
    assert exit_code("estimate", "mass-on-spring", "--plan", "plan.toml", "--no-verify", "-o", "out") == 0
    assert "explains the measurement" in capsys.readouterr().out


def test_files_and_arrays_give_the_same(folder):
    by_file = cosimo.estimate(TRUTH.scene(), folder / "plan.toml", halved=False)
    y, _ = TRUTH.drawn(1)
    import tomllib

    plan = tomllib.loads(PLAN)
    by_array = cosimo.estimate(TRUTH.scene(), plan, data={SIGNAL: (TRUTH.times, y)}, halved=False)
    assert by_file["spring.stiffness"].value == pytest.approx(by_array["spring.stiffness"].value, rel=1e-4)


def test_instants_of_their_own_delays_gaps_and_several_rates():
    """The velocity is seen at other instants than the position, some are missing, and the position comes late."""
    fine = Oscillator(h=0.001, every=1, count=4000)
    _, states = fine.drawn(3)
    rng = np.random.default_rng(0)
    first = np.sort(rng.choice(np.arange(20, 3990), 150, replace=False))
    second = np.arange(37, 3990, 97)
    delay = 0.0123
    data = {
        SIGNAL: (fine.times[first] + delay, states[first, 0] + 5e-3 * rng.standard_normal(first.size)),
        "mass.base_velocity_x": (fine.times[second], states[second, 1] + 0.05 * rng.standard_normal(second.size)),
    }
    measured = [{"signal": SIGNAL, "noise": "5 mm", "delay": "12.3 ms"}, {"signal": "mass.base_velocity_x", "noise": "5 cm/s"}]
    truth = Oscillator(h=0.005)
    found = cosimo.estimate(truth.scene(), truth.plan(measured=measured), data=data, halved=False)
    assert found.explains
    mean, deviation = found.series("mass.base_velocity_x")
    off = (mean - np.interp(found.time, fine.times, states[:, 1])) / deviation
    assert np.mean(np.abs(off) < 1.96) > 0.9
    measured[0]["delay"] = 0.0
    late = cosimo.estimate(truth.scene(), truth.plan(measured=measured), data=data, halved=False)
    assert not late.explains
    first = next(s for s in late.verdict.suspects if s.name == f"delay of {SIGNAL}")
    assert first.change == pytest.approx(delay, abs=3.0 * first.deviation + 1e-3)


def test_what_the_length_of_steps_costs_is_said():
    truth = Oscillator(h=0.02, every=5, count=60, kick=0.0)
    found = truth.estimate(truth.drawn(3)[0], suspected=[], states={}, halved=True)
    assert any("reduce master.step" in text for text in found.verdict.remarks)
    assert found.errors["mass.base_velocity_x"] > found.series("mass.base_velocity_x")[1].mean()


def test_an_estimate_that_the_scene_cannot_go_on_from_is_one_message(monkeypatch):
    def fail(self):
        raise StepFailed("spring", 0.0, "no")

    monkeypatch.setattr(Extended, "carry", fail)
    y, _ = TRUTH.drawn(1)
    with pytest.raises(StepFailed, match=r"spring failed at t = 0\.01 s: the scene cannot go on from what is estimated"):
        TRUTH.estimate(y, suspected=[])


def test_bounds_are_kept_both_ways():
    for bounds in (Bounds(), Bounds(low=1.0), Bounds(high=3.0), Bounds(1.0, 3.0)):
        for p in (1.1, 2.0, 2.9):
            q = bounds.inner(p)
            assert bounds.outer(q) == pytest.approx(p)
            assert bounds.slope(q) == pytest.approx((bounds.outer(q + 1e-6) - bounds.outer(q - 1e-6)) / 2e-6, rel=1e-6)
            for far in (-1e4, 1e4):
                assert bounds.low <= bounds.outer(far) <= bounds.high


def changed(**tables):
    return TRUTH.plan() | tables


@pytest.mark.parametrize(
    ("plan", "words"),
    [
        (changed(measured=[]), "measured"),
        (changed(measured=[{"signal": "mass.base_z"}]), "Did you mean"),
        (changed(measured=[{"signal": "mass.tip_x"}]), "record.signals"),
        (changed(measured=[{"signal": SIGNAL}] * 2), "more than once"),
        (changed(measured=[{"signal": SIGNAL, "noise": "5 kg"}]), "noise"),
        (changed(measured=[{"signal": SIGNAL, "noise": 0.0}]), "a positive number"),
        (changed(measured=[{"signal": SIGNAL, "nois": 1.0}]), "Did you mean 'noise'"),
        (changed(estimated={"spring.stifness": {"deviation": 1.0}}), "spring.stiffness"),
        (changed(estimated={"spring.stiffness": {}}), "deviation"),
        (changed(estimated={"spring.stiffness": {"deviation": -1.0}}), "a positive number"),
        (changed(estimated={"spring.stiffness": {"deviation": "5 kg"}}), "kg"),
        (changed(estimated={"spring.first_x": {"deviation": "5 %"}}), "of 0"),
        (changed(estimated={"spring.stiffness": {"deviation": 1.0, "low": 200.0}}), "a start between"),
        (changed(estimated={"spring.stiffness": {"deviation": 1.0, "memory": 1.0}}), "a walk"),
        (changed(estimated={"mass.substep": {"deviation": 1.0}}), "numerical error"),
        (changed(estimated={}, states={}), "something that is not known"),
        (changed(states={"mass.base_velocity": {"walk": 1.0}}), "mass.base_velocity_x"),
        (changed(suspected=["rope.*"]), "rope.*"),
        (changed(filter="ensemble"), "soon agree"),
        (changed(filter="kalman"), "extended"),
    ],
)
def test_each_fault_of_a_plan_is_one_message(plan, words):
    y, _ = TRUTH.drawn(1)
    with pytest.raises(BadInput, match=words):
        cosimo.estimate(TRUTH.scene(), plan, data={m["signal"]: (TRUTH.times, y) for m in plan["measured"]}, halved=False)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ("time,position [mm]\n0.1,1\n0.2,x\n", "line 3, column 'position"),
        ("time,position [mm]\n0.2,1\n0.1,2\n", "line 3, column 'time'.*does not rise"),
        ("time,position [kg]\n0.1,1\n", "kg"),
        ("time,place\n0.1,1\n", "no column 'position'"),
        ("time,position\n0.1,1\n", "1 line of numbers"),
    ],
)
def test_each_fault_of_a_file_is_one_message(folder, rows, words):
    (folder / "position.csv").write_text(rows)
    with pytest.raises(BadInput, match=words):
        cosimo.estimate(TRUTH.scene(), folder / "plan.toml", halved=False)


def test_scenes_without_derivatives_and_measurements_before_the_start_are_refused():
    y, _ = TRUTH.drawn(1)
    faulty = TRUTH.scene(faults=[{"signal": SIGNAL, "kind": "override", "value": 0.0, "begin": 1.0}])
    with pytest.raises(BadInput, match="faults"):
        cosimo.estimate(faulty, TRUTH.plan(), data={SIGNAL: (TRUTH.times, y)})
    for shift, words in ((-100.0, "behind the start"), (1.7e9, "Give shift, or the unit of the times")):  # a clock since 1970
        with pytest.raises(BadInput, match=words):
            cosimo.estimate(TRUTH.scene(), TRUTH.plan(), data={SIGNAL: (TRUTH.times + shift, y)})
    y[3] = np.inf
    with pytest.raises(BadInput, match=r"inf at .* s, expected finite numbers, or NaN for a gap"):
        cosimo.estimate(TRUTH.scene(), TRUTH.plan(), data={SIGNAL: (TRUTH.times, y)})
