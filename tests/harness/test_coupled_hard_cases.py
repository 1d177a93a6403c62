"""Hard cases of pantograph and catenary together: near the wave speed, past the coupling's limit, off the wire's end."""

import json

import numpy as np
import pytest
from cosimo.orchestrator.judgement.verification import run_verified
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.commands import exit_code
from cosimo.tests.scene_runs import finished

pytestmark = pytest.mark.full

EFFECTS = ["dropper_slackening", "gravity_sag", "damping", "wire_profile"]  # of the catenary in the scene


@pytest.fixture(scope="module")
def scene():
    return load_scene("en50318-2002").with_changes({"record.snapshot_interval": 0.5})


@pytest.fixture(scope="module")
def reference(scene):
    """The scene as shipped."""
    return run(scene, in_process=True)


def values(result) -> np.ndarray:
    """Every recorded number."""
    return np.array(list(result.columns.values()))


def test_near_the_wave_speed_the_run_ends_and_stays_bounded():
    result = finished(load_scene("critical-speed"))
    assert result.time[-1] == 7.0
    assert np.isfinite(values(result)).all()
    t, force, frame = result.time, result["pantograph.contact_force"], result["pantograph.frame_height"]
    assert force.min() >= 0.0
    # No growth: neither the spread of the force nor the wire's height rises once the wave in front of the pantograph has
    # formed. 5 % is the scatter between windows of 3.9 spans, which do not hold whole spans.
    early, late, height = (t >= 1.0) & (t < 3.0), t >= 5.0, np.abs(result["catenary.wire_height"])
    assert force[late].std() <= 1.05 * force[early].std()
    assert height[late].max() <= 1.05 * height[early].max()
    # Momentum of the pantograph: the impulse of the contact force is that of the static force and of the base spring and
    # damper (50 N/m, 90 N.s/m). 1 N of mean force is 7 N.s, what the pantograph's 22 kg take up at 0.3 m/s.
    lift = 120.0 - 50.0 * frame.mean() - 90.0 * (frame[-1] - frame[0]) / t[-1]
    assert force.mean() == pytest.approx(lift, abs=1.0)


@pytest.mark.parametrize(
    ("algorithm", "degree", "step"),
    [("jacobi", 0, 0.02), ("jacobi", 1, 0.02), ("jacobi", 2, 0.02), ("gauss-seidel", 0, 0.04), ("gauss-seidel", 1, 0.05)],
)
def test_past_the_couplings_limit_a_linear_contact_fails_with_a_message(scene, algorithm, degree, step):
    """Without contact loss the coupling is linear, so past its limit it grows without bound."""
    wild = scene.with_changes(
        {"master.algorithm": algorithm, "master.extrapolation": degree, "master.step": step, "units.pantograph.effects": []}
    )
    result = run(wild, in_process=True)
    assert result.outcome == "unstable"
    assert "Reduce the macro step" in result.message
    assert 0.0 < result.time[-1] < wild.stop_time
    assert len(result.time) == round(result.time[-1] / step) + 1
    assert np.isfinite(values(result)).all()


def test_past_the_limit_a_unilateral_contact_stays_finite_and_is_plainly_wrong(scene, reference):
    """Loss of contact limits the growth: the run ends, and says that the macro step was too long."""
    result = run_verified(scene.with_changes({"master.step": 0.05, "master.algorithm": "jacobi"}), in_process=True)
    assert np.isfinite(values(result)).all()
    assert result["pantograph.contact_force"].max() > 4.0 * reference["pantograph.contact_force"].max()
    assert result["pantograph.contact_force"].min() == 0.0 < reference["pantograph.contact_force"].min()
    said = " ".join((result.message, *result.info.warnings))
    assert "is unstable" in said or "too long" in said
    assert not reference.info.warnings


def test_exit_code_and_partial_files_of_a_failed_run(tmp_path, capsys):
    """Off the end of the wire: 10 spans are 600 m, reached after 8.2 s from 30 m at 69.4 m/s."""
    assert exit_code("run", "en50318-2002", "--in-process", "--stop", "9", "-o", str(tmp_path)) == 3
    message = capsys.readouterr().err
    assert "catenary failed at t = 8.2" in message
    assert "Traceback" not in message
    rows = (tmp_path / "result.csv").read_text().splitlines()
    last = float(rows[-1].split(",")[0])
    assert last == pytest.approx(8.2, abs=0.02)  # the last element is 0.5 m long and not for the contact: 7 ms
    info = json.loads((tmp_path / "run.json").read_text())
    assert (info["outcome"], info["timing"]["simulated"]) == ("failed", last)
    assert "left the range" in info["message"]


@pytest.mark.parametrize("way", [["--in-process"], []], ids=["in process", "FMU"])
def test_a_substep_beyond_the_limit_is_bad_input_on_either_way(way, capsys):
    assert exit_code("run", "en50318-2002", *way, "--stop", "0.1", "--set", "pantograph.head_mass=1e-6") == 2
    assert "at most 2.61141e-07 s" in capsys.readouterr().err


def test_at_zero_speed_the_static_equilibrium_is_kept(scene):
    result = finished(scene.with_changes({"pantograph.speed": 0.0, "stop_time": 1.0}))
    # Rounding of heights near 0.05 m (7e-18 each) through a contact spring of 5e4 N/m, 1000 steps of a damped system.
    assert np.ptp(result["pantograph.contact_force"]) < 1e-9
    assert np.ptp(result["catenary.wire_height"]) < 1e-13


def test_without_static_force_nothing_pulls_and_nothing_breaks(scene):
    result = finished(scene.with_changes({"pantograph.static_force": 0.0, "stop_time": 2.0}))
    assert np.isfinite(values(result)).all()
    assert result["pantograph.contact_force"].min() == 0.0
    # Only the wire's own sag (2 cm between droppers 6.5 m apart) touches the head that rests at dropper level.
    assert result["pantograph.contact_force"].mean() < 20.0


def test_the_error_of_a_moving_window_grows_as_it_shrinks(scene, reference):
    deviation = []
    for length in (120.0, 60.0, 30.0, 15.0):
        cut = scene.with_changes({"units.catenary.effects": [*EFFECTS, "moving_window"], "catenary.moving_window.behind": length})
        result = finished(cut)
        assert np.isfinite(values(result)).all()
        deviation.append(float(np.std(result["pantograph.contact_force"] - reference["pantograph.contact_force"])))
    assert deviation == sorted(deviation)
    # Waves run out through the edges; what the first reflection at supports further away would bring back is missing.
    spread = float(np.std(reference["pantograph.contact_force"]))
    assert deviation[0] < 0.03 * spread
    assert deviation[-1] > 0.3 * spread  # 0.41: of the rear alone, for the front follows the motion
