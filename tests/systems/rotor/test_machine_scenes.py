"""What the scenes of bearings and rotors must show: couplings that converge, heat that closes the gap."""

import numpy as np
import pytest
from cosimo.components.bearings.deep_groove import DeepGrooveBearing
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.scene_runs import finished

pytestmark = pytest.mark.full

PORT = ("displacement_x", "displacement_y", "tilt_x", "tilt_y", "velocity_x", "velocity_y", "tilt_rate_x", "tilt_rate_y", "speed")


def test_the_coupling_of_rotor_and_bearings_converges_with_the_macro_step():
    """At least second order: the line a bearing gives is extrapolated linearly, and its law is smooth while balls stay loaded.

    The rotor's own steps are the same short ones in all runs, so that what differs is the coupling.
    """
    fine = {"stop_time": 0.05, "rotor.start_speed": 520.0, "rotor.substep": 1.25e-5}
    runs = {h: finished(load_scene("rotor-run-up").with_changes({**fine, "master.step": h})) for h in (1.25e-5, 1e-4, 2e-4)}
    reference = runs.pop(1.25e-5)
    exact = reference["rotor.displacement_x"]
    one, two = (
        np.abs(np.interp(r.time, reference.time, exact) - r["rotor.displacement_x"]).max() / np.ptp(exact) for r in runs.values()
    )
    assert two < 0.01
    assert one < 0.25 * two


def test_a_linearised_bearing_settles_under_the_weight():
    """The first instant is the static equilibrium: the bearings carry the weight, and nothing moves but what turns."""
    scene = load_scene("rotor-run-up")
    given = scene.units["rotor"].parameters
    result = finished(
        scene.with_changes(
            {
                "stop_time": 2e-3,
                "record.signals": ["left.force_y", "right.force_y"],
                "units.rotor.effects": ["gyroscopic", "disks", "gravity", "linear_supports", "bearing_a", "bearing_b"],
                "units.rotor.parameters": {k: v for k, v in given.items() if not k.startswith(("unbalance", "run_up"))},
            }
        )
    )
    shaft = 7810.0 * 0.25 * np.pi * 0.03**2 * 0.6
    weight = 9.81 * (8.0 + shaft)
    assert result["left.force_y"][0] + result["right.force_y"][0] == pytest.approx(weight, rel=1e-9)


def test_heat_closes_the_clearance_that_the_bearing_feels():
    """The bearing in the scene is one whose clearance is smaller by what the temperatures give; the balance of heat closes."""
    signals = [
        "left.force_x",
        "left.force_y",
        "left_heat.clearance_change",
        "left_heat.heat_supplied",
        "left_heat.heat_stored",
        "left_heat.heat_released",
        *(f"rotor.bearing_a.{n}" for n in PORT),
        "left.inner_angle",
        "left.cage_angle",
    ]
    result = finished(load_scene("rotor-bearings-heat").with_changes({"stop_time": 0.2, "record.signals": signals}))
    change = result["left_heat.clearance_change"]
    assert change[-1] < -1e-6  # m; 20 W into 0.4 J/K
    # the same quantity summed up in two ways, over 2000 steps
    supplied, stored, released = (result[f"left_heat.heat_{k}"] for k in ("supplied", "stored", "released"))
    np.testing.assert_allclose(supplied, stored + released, rtol=0.0, atol=1e-9 * supplied[-1])
    bearing = DeepGrooveBearing(
        ["damping"], {"diametral_clearance": 40e-6 + float(change[-1]), "first_ball": float(result["left.cage_angle"][-1])}
    )
    for name in PORT:
        bearing.set(name, float(result[f"rotor.bearing_a.{name}"][-1]))
    bearing.initialize(0.0)
    # the clearance reaches the geometry by another way: rounding of lengths of 25 mm against deformations of 1 um
    assert bearing["force_x"] == pytest.approx(result["left.force_x"][-1], rel=1e-5, abs=1e-5)
    assert bearing["force_y"] == pytest.approx(result["left.force_y"][-1], rel=1e-5)


def test_the_gyroscopic_scene_passes_its_critical_speeds():
    """Largest response where modal analysis has the critical speeds; a run-up of 28 rad/s² is late by some per cent."""
    result = finished(load_scene("gyroscopic-rotor"))
    amplitude, speed = np.hypot(result["rotor.displacement_x"], result["rotor.displacement_y"]), result["rotor.speed"]
    low, high = speed < 180.0, (speed > 180.0) & (speed < 339.0)
    assert 1.0 < speed[low][amplitude[low].argmax()] / 89.8 < 1.15
    assert 1.0 < speed[high][amplitude[high].argmax()] / 298.8 < 1.05
