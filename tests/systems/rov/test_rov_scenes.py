"""What the scenes of the underwater vehicle must show: steady states in closed form, failures survived."""

import math

import numpy as np
import pytest
from cosimo.components.rov.arrangement import wrench_matrix, y_arrangement
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.systems.rov.records import vehicles
from cosimo.tests.scene_runs import assert_fmus_give_the_same_bits, finished
from scipy.spatial.transform import Rotation

MATRIX = wrench_matrix(*y_arrangement())
LINEAR, SQUARE = np.array([4.03, 6.22, 5.18]), np.array([18.18, 21.66, 36.99])  # drag of the default vehicle, N.s/m, N.s²/m²


@pytest.fixture(scope="module")
def kept():
    return finished(load_scene("rov-station-keeping"))


@pytest.fixture(scope="module")
def failed():
    return finished(load_scene("rov-thruster-failed").with_changes({"stop_time": 90.0}))


@pytest.mark.full
def test_a_fault_is_the_same_in_fmus_and_components():
    fault = {"signal": "thruster_4.thrust", "kind": "override", "value": 0.0, "begin": 0.2}
    assert_fmus_give_the_same_bits(load_scene("rov-thruster-failed").with_changes({"stop_time": 0.4, "faults": [fault]}))


def given_force(result, at: int = -1) -> np.ndarray:
    """Force of the thrusters in body axes, N, (3,)."""
    return (MATRIX @ [result[f"thruster_{k}.thrust"][at] for k in range(1, 7)])[:3]


def drag(velocity: np.ndarray) -> np.ndarray:
    """Force of still water on the level vehicle that moves through it, N, (3,)."""
    return -(LINEAR + SQUARE * np.abs(velocity)) * velocity


def test_station_keeping_ends_in_the_balance_of_thrust_and_drag(kept):
    """The vehicle stands level at its set point; thrusts carry the drag of 0.3 m/s and 2 N of buoyancy."""
    for name in ("error_north", "error_east", "error_down", "error_roll", "error_pitch", "error_yaw"):
        assert abs(kept[f"controller.{name}"][-1]) < 1e-3  # 20 s after the gust, of integrals with time constants of 4 s
    flow = Rotation.from_euler("Z", 0.6).inv().apply([0.3 * math.cos(0.5), 0.3 * math.sin(0.5), 0.0])
    np.testing.assert_allclose(given_force(kept), [0.0, 0.0, 2.0] - drag(-flow), atol=0.02)


def test_station_keeping_gives_way_to_current_and_gust_a_little(kept):
    settled = kept.time > 12.0
    assert np.hypot(kept["controller.error_north"], kept["controller.error_east"])[settled].max() < 0.1
    assert np.abs(kept["controller.error_down"])[settled].max() < 0.02
    # Munk's moment of at most 0.5 m/s, over the attitude gain alone, without the integral
    assert np.abs(kept["controller.error_yaw"])[settled].max() < (12.7 - 5.5) * 0.5 * 0.5**2 / 4.0
    assert kept["controller.scale"].min() == 1.0


@pytest.mark.full
def test_without_a_vertical_thruster_depth_heading_and_place_are_held_and_pitch_is_given_up(failed):
    t = failed.time
    before, unknown, after = (t > 10.0) & (t < 20.0), (t > 20.0) & (t < 30.0), t > 70.0
    assert np.abs(failed["hull.depth"] - 5.0)[unknown].max() > 0.05  # it shows before it is told
    for name in ("error_north", "error_east", "error_down"):
        assert np.abs(failed[f"controller.{name}"])[after].max() < 0.005
    assert np.abs(failed["controller.error_yaw"])[after].max() < math.radians(0.2)
    assert np.abs(failed["controller.error_pitch"])[before].max() < 0.01
    assert not failed["controller.command[4]"][after].any()


@pytest.mark.full
def test_the_pitch_that_is_given_up_is_the_moments_balance(failed):
    """Righting moment z_g W sin(pitch), the two thrusters behind, those at the sides, and Munk's moment of the flow."""
    pitch = failed["hull.pitch"][-1]
    thrust = np.array([failed[f"thruster_{k}.thrust"][-1] for k in range(1, 7)])
    thrust[3] = 0.0
    turn = Rotation.from_euler("ZYX", [failed["hull.yaw"][-1], pitch, failed["hull.roll"][-1]])
    u, _, w = -turn.inv().apply([0.3 * math.cos(0.5), 0.3 * math.sin(0.5), 0.0])
    munk = (14.57 - 5.5) * u * w
    assert (MATRIX @ thrust)[4] - 0.02 * 112.8 * math.sin(pitch) + munk == pytest.approx(0.0, abs=1e-3)
    assert math.radians(3.0) < pitch < math.radians(12.0)


@pytest.mark.first
@pytest.mark.parametrize("lost", [1, 2, 3, 4, 5, 6])
def test_depth_and_heading_survive_any_thruster(lost):
    """Told at once; which place can still be held depends on the thruster: without a horizontal one, not every place."""
    faults = [
        {"signal": f"thruster_{lost}.{what}", "kind": "override", "value": 0.0, "begin": 5.0}
        for what in ("thrust", "status.available")
    ]
    result = finished(load_scene("rov-thruster-failed").with_changes({"faults": faults, "stop_time": 40.0}))
    late = result.time > 30.0
    assert np.abs(result["hull.depth"] - 5.0)[late].max() < 0.02
    assert np.abs(result["hull.yaw"] - 0.6)[late].max() < math.radians(3.0)


@pytest.fixture(scope="module")
def moved():
    return finished(load_scene("rov-manoeuvre"))


@pytest.mark.full
def test_the_manoeuvre_is_followed_along_all_six_axes(moved):
    for name, far in (("north", 2.0), ("east", 2.0), ("down", 1.5)):
        assert np.abs(moved[f"controller.error_{name}"]).max() < 0.1 * far
    for name, far in (("yaw", 1.57), ("roll", 0.5), ("pitch", 0.5)):
        assert np.ptp(moved[f"hull.{name}"]) > 0.8 * far
        assert np.abs(moved[f"controller.error_{name}"]).max() < 0.35 * far
    for name in ("north", "east", "down"):
        assert abs(moved[f"controller.error_{name}"][-1]) < 0.02


@pytest.mark.full
def test_power_through_the_bonds_is_that_of_the_exchange(moved):
    """What the coupling creates at thrusters and tether is a small part of what goes through them."""
    accounts = moved.info.energy
    assert len(accounts) == 3
    for bond, account in accounts.items():
        assert account.exchanged > 0.1, bond
        assert abs(account.created) < 0.01 * account.exchanged, bond
    assert not moved.info.warnings


@pytest.mark.full
def test_the_tether_pulls_and_its_pull_is_small(moved):
    assert moved["tether.tension"].min() >= 0.0
    assert 0.1 < moved["tether.tension"].max() < 20.0


@pytest.mark.full
def test_a_shorter_macro_step_changes_little():
    """The controller samples at 50 Hz whatever the step; what is left is the thrust held over a step, first order."""
    scene = load_scene("rov-station-keeping").with_changes({"stop_time": 20.0})
    runs = [finished(scene.with_changes({"master.step": h})) for h in (0.02, 0.01, 0.0025)]
    exact = runs[2]
    errors = [
        max(
            np.abs(np.interp(exact.time, r.time, r[f"hull.{n}"]) - exact[f"hull.{n}"]).max()
            for n in ("position_north", "position_east")
        )
        for r in runs[:2]
    ]
    assert errors[0] < 5e-3
    assert errors[1] < 0.7 * errors[0]


def test_errors_behind_sensors_are_those_of_the_vehicle():
    """Position and attitude less the set point, whatever the controller sees."""
    result = finished(load_scene("rov-sensors").with_changes({"stop_time": 6.0}))
    (vehicle,) = vehicles(result)
    set_point = {"position_north": 0.0, "position_east": 0.0, "depth": 5.5}
    for error, name in zip(("error_north", "error_east", "error_down"), set_point, strict=True):
        np.testing.assert_allclose(vehicle.errors[error], set_point[name] - result[f"hull.{name}"], atol=1e-12)
        assert np.abs(vehicle.errors[error] - result[f"controller.{error}"]).max() > 5e-3
    seen = Rotation.from_quat(np.array([result[f"hull.quaternion_{a}"] for a in "xyzw"]).T)
    turn = (seen.inv() * Rotation.from_euler("Z", 0.6)).as_rotvec().T
    np.testing.assert_allclose([vehicle.errors[f"error_{a}"] for a in ("roll", "pitch", "yaw")], turn, atol=1e-12)
