"""What the scenes of the two-axis joint must show: the gyroscope's precession, standstill, closed forms."""

import math

import numpy as np
import pytest
from cosimo.components.two_axis_joint.chain import TwoLinkChain
from cosimo.components.two_axis_joint.closed_forms import small_motion
from cosimo.components.two_axis_joint.gimbal import GimbalBody
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.systems.two_axis_joint.summary import summary
from cosimo.tests.scene_runs import finished
from cosimo.tests.systems.two_axis_joint.exact_motions import quartic

pytestmark = pytest.mark.full


def test_the_damped_chain_decays_as_its_quartic_says():
    """Samples of the late, small motion follow one another by a matrix; its eigenvalues are those of the quartic."""
    scene = load_scene("damped-chain")
    small = {"start_first_angle": 1e-4, "start_second_angle": -5e-5}
    result = finished(scene.with_changes({"stop_time": 20.0, **{f"chain.{n}": v for n, v in small.items()}}))
    z = np.array([result[f"chain.{n}"] for n in ("first_angle", "second_angle", "first_rate", "second_rate")])
    following = np.linalg.lstsq(z[:, :-1].T, z[:, 1:].T, rcond=None)[0]
    eigenvalues = np.sort_complex(np.log(np.linalg.eigvals(following).astype(complex)) / scene.master.step)
    given = {"viscous.first": 0.1, "viscous.second": 0.05}
    chain = TwoLinkChain(["gravity", "viscous"], given, preset="equal point masses")
    # RK4 of 2 ms is off by (w h)^4 / 120 = 1e-10 w, the pendulum's equation by 1e-8 / 16
    np.testing.assert_allclose(eigenvalues, np.sort_complex(np.roots(quartic(small_motion(chain)))), rtol=1e-7)


def test_the_double_pendulum_keeps_its_energy_and_nothing_else():
    result = finished(load_scene("double-pendulum").with_changes({"stop_time": 60.0}))
    energy = result["chain.mechanical_energy"]
    assert np.abs(energy - energy[0]).max() < 1e-8 * energy[0]
    assert np.ptp(result["chain.second_angle"]) > 2.0 * math.pi  # it goes over the top


def test_two_double_pendulums_that_differ_by_rounding_part():
    """Exponential growth by some e-foldings a second: a hundred thousandth becomes a radian, and not at once."""
    scene = load_scene("double-pendulum").with_changes({"stop_time": 20.0})
    one = finished(scene)
    other = finished(scene.with_changes({"chain.start_first_angle": 1.9 + 1e-9}))
    apart = np.abs(one["chain.second_angle"] - other["chain.second_angle"])
    assert apart[one.time < 1.0].max() < 1e-7
    assert apart.max() > 1.0


def test_the_gyroscope_precesses_as_one_with_a_constant_momentum():
    """A rotor on its bearings against the gimbal's own effect of a spin momentum: what differs is that the bearings give way,
    by h² / (J k) = 2e-4 of the nutation's frequency, with a tilting stiffness k of 2 MN.m/rad.
    """
    scene = load_scene("gimbal-rotor")
    result = finished(scene.with_changes({"stop_time": 0.5}))
    shaft = 7810.0 * math.pi / 32.0 * 0.03**4 * 0.3
    given = scene.units["gimbal"].parameters
    gimbal = GimbalBody(["gravity", "rotor"], {**given, "rotor.spin_momentum": (0.03 + shaft) * 300.0, "substep": 1e-4})
    gimbal.initialize(0.0)
    expected = [gimbal.y[:2].copy()]
    h = 1e-3
    for k in range(500):
        gimbal.step(k * h, h)
        expected.append(gimbal.y[:2].copy())
    angles = np.stack([result["gimbal.outer_angle"], result["gimbal.inner_angle"]], axis=1)
    size = np.ptp(angles, axis=0).max()
    assert size > 0.1
    np.testing.assert_allclose(angles, np.array(expected), rtol=0.0, atol=1e-3 * size)


def test_the_bearings_carry_the_gyroscopic_moment():
    """Their forces make the couple that the gimbal feels; the tilt stiffness of the bearings carries the rest."""
    result = finished(load_scene("gimbal-rotor").with_changes({"stop_time": 0.2}))
    assert [row.name for row in summary(result) if row.name.endswith("_change")] == []  # partners change energy and momentum
    couple = 0.1 * (result["lower.force_x"] - result["upper.force_x"])
    moment = -result["rotor.frame_rotation.moment_y"]
    assert np.abs(moment).max() > 5.0
    np.testing.assert_allclose(couple, moment, rtol=0.0, atol=1e-3 * np.abs(moment).max())
    # the rotor turns with its momentum: moment = -w x H
    rate = result["gimbal.payload.rate_x"]
    momentum = 300.0 * (0.03 + 7810.0 * math.pi / 32.0 * 0.03**4 * 0.3)
    np.testing.assert_allclose(-moment, momentum * rate, rtol=0.0, atol=0.01 * np.abs(moment).max())


def test_what_sticks_stands_and_what_is_smoothed_creeps():
    result = finished(load_scene("joint-stiction").with_changes({"stop_time": 5.0}))
    late = result.time > 4.0
    for axis in ("outer", "inner"):
        assert not result[f"exact.{axis}_rate"][late].any()
        assert np.ptp(result[f"exact.{axis}_angle"][late]) == 0.0
        assert result[f"exact.stick_friction.{axis}_stuck"][late].all()
        assert np.abs(result[f"bristles.{axis}_rate"][late]).max() < 1e-6
        assert np.abs(result[f"smoothed.{axis}_rate"][late]).min() > 1e-5  # rad/s: towards the lowest place
    # standing beside the lowest place, within what friction holds: m g l sin(angle) below the static level
    assert 0.0 < abs(result["exact.outer_angle"][-1]) < math.asin(1.2 * 0.25 / (2.0 * 0.15 * 9.81))


def test_the_scan_follows_its_set_points():
    """After the start, below the motors' limits; the error is what the gain needs to ask for the voltage.

    Inner axis: 0.05 kg.m2 * 0.18 rad * (2 pi Hz)² and 0.09 N.m of weight and friction, at 20 V/N.m, over 400 V/rad.
    """
    needed = {"outer": (0.05 * 1.0 * (0.5 * math.pi) ** 2 + 0.05) * 20.0 / 640.0,
              "inner": (0.05 * 0.18 * (2.0 * math.pi) ** 2 + 0.09) * 20.0 / 400.0}  # fmt: skip
    result = finished(load_scene("gimbal-scan").with_changes({"stop_time": 3.0}))
    late = result.time > 2.0
    for axis, error in needed.items():
        largest = np.abs(result[f"controller.{axis}_error"][late]).max()
        assert largest < error + 0.01  # the integral still gives up what the start has left there, within a second
        assert np.abs(result[f"{axis}_motor.current"][late]).max() < 5.0
    for bond in result.info.energy.values():
        assert abs(bond.created) < 1e-3 * bond.exchanged
