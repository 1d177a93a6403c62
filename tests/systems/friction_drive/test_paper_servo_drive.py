"""The new measures of the paper's case against independent answers."""

import math

import numpy as np
import pytest
from cosimo.components.friction_drive.monolith import FrictionDrive
from cosimo.orchestrator.systems.friction_drive.cases.paper_servo_drive import accuracy, contact, control, drive, power_loss
from scipy.integrate import solve_ivp

pytestmark = pytest.mark.interpreted


def test_the_numbers_are_those_of_the_components():
    p = FrictionDrive().parameters
    assert (p["wheel_radius"], p["sleeve_radius"], p["normal_force"], p["friction"], p["mass"]) == (
        drive.WHEEL,
        drive.SLEEVE,
        drive.NORMAL,
        drive.FRICTION,
        drive.MASS,
    )
    assert (p["gear_ratio"], p["resistance"], p["constant"]) == (drive.GEAR, drive.RESISTANCE, drive.CONSTANT)
    shaft = FrictionDrive(("shaft_friction", "trocar_friction")).parameters
    assert shaft["shaft_friction.level"] == drive.SHAFT
    assert shaft["shaft_friction.level"] * shaft["shaft_friction.static_ratio"] == pytest.approx(drive.SHAFT_STATIC, rel=1e-15)
    assert shaft["shaft_friction.gear_loss"] == drive.GEAR_LOSS
    assert shaft["trocar_friction.level"] == power_loss.SEAL
    assert shaft["trocar_friction.level"] * shaft["trocar_friction.static_ratio"] == pytest.approx(accuracy.SEAL_STATIC)


@pytest.mark.parametrize("way", control.SMALL)
def test_the_closed_form_solves_the_design_model(way):
    """T z'' + z' + K z = K from rest, by another integrator, half a period late."""
    T, K = control.time_constant(way), control.GAIN
    t = np.linspace(0.0, 0.4, 9)
    solution = solve_ivp(lambda _, z: [z[1], (K - K * z[0] - z[1]) / T], (0.0, 0.4), [0.0, 0.0], t_eval=t, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(control.closed_form(t + 0.5 * control.PERIOD, way), solution.y[0], atol=1e-8)


def test_the_inertia_at_a_wheel_is_that_of_the_energy():
    """Rotors, wheels and sleeve at one rate of the wheels, free rollers: t . v = R w."""
    rotor = 1e-6 * 19.0**2 + 1e-6
    feed, spin = 0.01 / math.cos(math.pi / 6.0), 0.01 / (0.005 * math.sin(math.pi / 6.0))
    assert 2.0 * drive.wheel_inertia("feed") == pytest.approx(2.0 * rotor + 0.15 * feed**2, rel=1e-14)
    assert 2.0 * drive.wheel_inertia("rotation") == pytest.approx(2.0 * rotor + 1.875e-6 * spin**2, rel=1e-14)


def test_slip_and_force_are_those_of_another_program():
    """Numbers printed to three digits."""
    assert [100.0 * contact.share_lost(F) for F in (1.0, 3.0, 5.0, 8.0)] == pytest.approx([4.8, 14.9, 26.5, 51.6], abs=0.05)
    assert pytest.approx(5.9, abs=0.05) == contact.TIP
    assert contact.BEARS == 12.0


def test_a_share_of_slip_is_a_length_for_a_metre():
    """At a third lost the wheels roll 1.5 m for a metre."""
    force = next(F for F in np.linspace(5.0, 7.0, 20001) if contact.share_lost(F) >= 1.0 / 3.0)
    assert contact.per_metre(force) == pytest.approx(500.0, rel=1e-3)


def test_a_response_time_is_the_last_time_outside_the_band():
    t = np.linspace(0.0, 1.0, 11)
    share = np.array([0.0, 0.5, 0.9, 1.06, 1.0, 0.96, 1.0, 1.0, 1.0, 1.0, 1.0])
    assert control.response_time(t, share) == pytest.approx(0.4)
    assert math.isnan(control.response_time(t, 0.0 * share))


def test_the_band_grows_with_friction_and_falls_with_the_gain():
    """Torque at a wheel through the gear as a voltage, a rate of the wheel, a rate of feed, an error; and one count."""
    volts = 2.3 * (0.015 + 0.005 * 2.6 / math.cos(math.pi / 6.0)) / 0.8 / (19.0 * 0.0234)
    assert accuracy.band() == pytest.approx(volts / (0.4446 + 0.4) * 0.01 / math.cos(math.pi / 6.0) / 20.0 + 1e-6, rel=1e-12)


def test_a_force_turns_back_the_shafts_at_their_torque():
    """Each wheel carries F / (2 cos a) along its direction."""
    force = power_loss.backdrive(0.01)
    assert drive.WHEEL * force / (2.0 * math.cos(math.pi / 6.0)) == pytest.approx(0.01, rel=1e-14)
