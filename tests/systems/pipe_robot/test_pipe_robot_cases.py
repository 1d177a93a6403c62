"""The cases of the pipe robot pass, and would not if friction, masses or the integration were others."""

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.validation.case import Options, compare
from cosimo.orchestrator.harness.validation.reference import load_table
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import cases
from cosimo.orchestrator.systems.pipe_robot.cases import balance as balance
from cosimo.orchestrator.systems.pipe_robot.cases import mean_speed as mean_speed
from cosimo.orchestrator.systems.pipe_robot.cases import resonance as resonance
from cosimo.orchestrator.systems.pipe_robot.robots import TURN, component_at, last_speed, shaken, side_by_side


@pytest.mark.first(2)
@pytest.mark.parametrize("changed", [{"forward_friction": 2.002}, {"backward_friction": 8.01}, {"body_mass": 1.001},
                                     {"damping": 5.01}, {"substep": 5e-3}])  # fmt: skip
def test_a_tenth_of_a_percent_is_seen(changed):
    """So is an internal step of ten times the length, whose error is 1e-4."""
    scene = side_by_side(mean_speed.NAME, "changed", {"level": {**shaken(), **changed}}, TURN / 60.0, 100)
    speed = last_speed(run(scene, in_process=True), "level")
    rows = compare(load_table(mean_speed.NAME).rows, {"force.level": speed})
    (row,) = [r for r in rows if r.reference.measure == "force.level"]
    assert not row.inside
    assert row.simulated == pytest.approx(0.36017, rel=5e-3)


def test_the_closed_form_of_the_mean_speed_agrees_with_a_march_from_turn_to_turn():
    """b cos(w t) plus straight lines, marched from zero to zero of the velocity until the mean settles."""
    scale = 4.0
    forward, backward = (scale * v for v in mean_speed.WEAK.values())
    falls, rises = forward / mean_speed.MASS, backward / mean_speed.MASS
    b, w = mean_speed.B, mean_speed.FREQUENCY
    t, line, forwards = 0.0, 0.7, True
    turns, lines = [t], [line]
    for _ in range(200):
        slope = -falls if forwards else rises
        ahead = t + np.linspace(1e-6, 1.5 * TURN / w, 4001)
        values = (b * np.cos(w * ahead) + line + slope * (ahead - t)) * (1.0 if forwards else -1.0)
        k = int(np.flatnonzero(values < 0.0)[0])
        low, high = ahead[k - 1], ahead[k]
        for _ in range(60):
            middle = 0.5 * (low + high)
            value = (b * math.cos(w * middle) + line + slope * (middle - t)) * (1.0 if forwards else -1.0)
            low, high = (middle, high) if value > 0.0 else (low, middle)
        line, t, forwards = line + slope * (high - t), high, not forwards
        turns.append(t)
        lines.append(line)
    mean = np.average(0.5 * (np.array(lines[-3:-1]) + lines[-2:]), weights=np.diff(turns[-3:]))
    assert mean_speed.exact_speed(forward, backward) == pytest.approx(mean, rel=1e-9)


def test_the_zero_of_a_parabola_is_found_between_samples():
    t = np.array([-2.0, -1.0, 0.0])
    assert balance._until_zero(0.3 - 1.1 * t - 0.2 * t**2) == pytest.approx(np.roots([-0.2, -1.1, 0.3]).max(), rel=1e-12)


def test_a_component_at_a_frequency_is_read_off_a_known_motion():
    t = np.arange(24) * TURN / 7.0 / 8.0  # three periods of 7 rad/s
    c = component_at(t, 0.5 + 2.0 * np.cos(7.0 * t + 0.3) + np.cos(14.0 * t), 7.0)
    assert abs(c) == pytest.approx(2.0, rel=1e-12)
    assert np.angle(c) == pytest.approx(0.3, rel=1e-12)


@pytest.mark.parametrize(("module", "broken"), [(balance, {"FREQUENCY": 1e4}), (resonance, {"FREQUENCIES": (5e3,)})])
def test_a_run_that_fails_fails_the_case(module, broken, monkeypatch):
    """An excitation that turns by over a radian within a substep ends the run."""
    for name, value in broken.items():
        monkeypatch.setattr(module, name, value)
    findings = cases()[module.NAME].findings(Options(in_process=True))
    assert not findings.complete
    assert "radian" in findings.notes[0]


def test_a_negative_amplitude_is_no_run_at_all(monkeypatch):
    monkeypatch.setattr(mean_speed, "AMPLITUDE", -0.02)
    with pytest.raises(BadInput, match="amplitude"):
        cases()[mean_speed.NAME].findings(Options(in_process=True))
