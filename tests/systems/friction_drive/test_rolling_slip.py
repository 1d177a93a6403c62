"""Creep of rolling contacts: slip over speed by the laws of Carter and Kalker, a standing wheel that holds, energy; the seal."""

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.friction_drive.monolith import FrictionDrive
from cosimo.components.friction_drive.wheels import FrictionWheels
from scipy.integrate import quad, solve_ivp

pytestmark = pytest.mark.interpreted
LEVEL, RADIUS, FULL, LENGTH = 6.0, 0.01, 0.05, 2e-3  # N, m, 1, m
STRAIGHT = {"angle": 0.0}  # both wheels roll along the sleeve


def rolled(rate: float, force: float, seconds: float = 0.3, **parameters) -> FrictionWheels:
    wheels = FrictionWheels(["rolling_slip"], STRAIGHT | parameters)
    wheels.u[0, :3] = rate, rate, force
    wheels.initialize(0.0)
    for k in range(round(seconds / 0.01)):
        wheels.step(0.01 * k, 0.01)
    return wheels


def carter_creepage(share: float) -> float:
    """Of rollers, over the full one: 1 - sqrt(1 - share), by the adhesion area's length c: c / a = sqrt(1 - share)."""
    return 1.0 - math.sqrt(1.0 - share)


@pytest.mark.known_answers(FrictionWheels="rolling_slip", FrictionDrive="rolling_slip")
@pytest.mark.parametrize(("rate", "share"), [(2.0, 0.5), (20.0, 0.5), (20.0, 0.9), (-10.0, 0.1)])
def test_slip_over_speed_is_carters_at_every_speed(rate, share):
    wheels = rolled(rate, -share * 2.0 * LEVEL, 2.0)
    creepage = wheels["first_slip_axial"] / abs(RADIUS * rate)
    assert creepage == pytest.approx(-FULL * carter_creepage(share), rel=1e-6)
    assert wheels["first_traction_axial"] == pytest.approx(share * LEVEL, rel=1e-9)


@pytest.mark.parametrize("share", [0.2, 0.7])
def test_points_of_contact_follow_the_cubic_law(share):
    """Q / (mu N) = t - t² / 3 + t³ / 27 with t = 3 creepage / full creepage, by its root."""
    wheels = rolled(10.0, -share * 2.0 * LEVEL, 1.0, **{"rolling_slip.power": 3.0})
    roots = np.roots([1.0 / 27.0, -1.0 / 3.0, 1.0, -share])
    t = roots[np.abs(roots.imag) < 1e-9].real.min()
    assert wheels["first_slip_axial"] == pytest.approx(-0.1 * FULL * t / 3.0, rel=1e-6)


def test_carters_law_is_that_of_the_strip_in_adhesion():
    """Rollers in line contact: traction mu p less that of an adhesion ellipse at the leading edge; its sum, and strain there alone."""
    half, radius, modulus, load, friction = 1e-3, 0.02, 4e6, 1.0, 0.4  # m, m, Pa, N/m as Hertz has it, 1
    load = math.pi * modulus * half**2 / (4.0 * radius)
    peak = 2.0 * load / (math.pi * half)
    for stick in (0.9, 0.5, 0.1):  # half-length of the adhesion over that of the contact
        c, d = stick * half, (1.0 - stick) * half

        def traction(x, c=c, d=d):
            inner = 1.0 - ((x + d) / c) ** 2
            return friction * peak * (math.sqrt(1.0 - (x / half) ** 2) - c / half * math.sqrt(max(inner, 0.0)))

        force = quad(traction, -half, half, limit=400, points=[-half + 2.0 * c])[0]
        creepage = friction * d / radius  # 2 mu p0 d / (E* a) with p0 = E* a / (2 R)
        full = friction * half / radius
        assert 1.0 - (1.0 - creepage / full) ** 2 == pytest.approx(force / (friction * load), rel=1e-6)


def test_a_wheel_that_stands_holds():
    """No creep at rest: the sleeve stands at the deflection that bears, below full slip; beyond it, it slides."""
    share = 0.75
    wheels = rolled(0.0, -share * 2.0 * LEVEL, 3.0, **{"rolling_slip.damping_time": 2e-3})
    assert wheels["feed_rate"] == pytest.approx(0.0, abs=1e-9)
    assert wheels["feed"] == pytest.approx(-FULL * LENGTH * carter_creepage(share), rel=1e-6)
    sliding = rolled(0.0, -1.05 * 2.0 * LEVEL, 0.2, **{"rolling_slip.damping_time": 0.0})
    before = sliding["feed_rate"]
    sliding.step(0.2, 0.1)
    assert sliding["feed_rate"] - before == pytest.approx(-0.05 * 2.0 * LEVEL / 0.15 * 0.1, rel=1e-6)


def test_full_slip_gives_the_whole_friction():
    wheels = rolled(10.0, -1.1 * 2.0 * LEVEL, 0.1, **{"rolling_slip.damping_time": 0.0})
    assert wheels["first_traction_axial"] == pytest.approx(LEVEL, rel=1e-9)


def test_the_deflection_decays_over_the_length_that_rolls_by():
    """A sleeve of much mass pushed off: slip s, z' = s - V z / L; DOP853 on the equations of one straight contact pair."""
    given = STRAIGHT | {"rolling_slip.damping_time": 0.0, "substep": 2e-5}
    wheels = FrictionWheels(["rolling_slip"], given)
    wheels.u[0, :3] = 10.0, 10.0, -4.0
    wheels.initialize(0.0)
    wheels.step(0.0, 0.03)
    full = FULL * LENGTH

    def right(t, x):
        v, z = x
        slip = v - 0.1
        bears = math.copysign(1.0 - (1.0 - min(abs(z) / full, 1.0)) ** 2, z)
        return [(-2.0 * LEVEL * bears - 4.0) / 0.15, slip - 0.1 * z / LENGTH - max(abs(z) - full, 0.0) * math.copysign(5e4, z)]

    exact = solve_ivp(right, (0.0, 0.03), [0.0, 0.0], method="Radau", rtol=1e-10, atol=1e-13).y[:, -1]
    assert wheels["feed_rate"] == pytest.approx(exact[0], rel=1e-4)


def test_energy_stored_in_the_contact_comes_back_but_for_what_slides():
    wheels = rolled(0.0, 0.0)
    before = wheels.energy()
    lost = 0.0
    wheels.u[0, 2] = -8.0
    for k in range(4000):
        power = wheels["contact_power"]
        wheels.step(5e-5 * k, 5e-5)
        lost += 0.5 * (power + wheels["contact_power"]) * 5e-5
    # contact_power holds what deflections store; work of the force is motion of the sleeve
    work = -8.0 * wheels["feed"]
    kinetic = 0.5 * 0.15 * wheels["feed_rate"] ** 2
    assert work == pytest.approx(kinetic + lost, rel=1e-3)
    assert before <= wheels.energy() <= work


def test_creep_has_no_part_beside_it():
    wheels = FrictionWheels(["rolling_slip"], {"creep": 100.0})
    with pytest.raises(BadInput, match="creep"):
        wheels.initialize(0.0)


def test_the_whole_drive_creeps_as_its_wheels_do():
    drive = FrictionDrive(["rolling_slip"], STRAIGHT | {"substep": 5e-5})
    drive.u[0, :3] = 3.0, 3.0, -6.0
    drive.initialize(0.0)
    for k in range(100):
        drive.step(0.01 * k, 0.01)
    creepage = drive["first_slip_axial"] / (RADIUS * drive["first_rate"])
    assert creepage == pytest.approx(-FULL * carter_creepage(0.5), rel=1e-5)


@pytest.mark.parametrize("way", ["along", "around"])
def test_the_seal_breaks_away_at_its_static_level_along_and_around(way):
    """A slow ramp without wheels that bear: the largest force held is the static level, as a torque that times the radius."""
    given = {"normal_force": 1e-9, "trocar_friction.level": 2.0, "trocar_friction.static_ratio": 1.3}
    wheels = FrictionWheels(["exact_slip", "trocar_friction"], given)
    wheels.initialize(0.0)
    place, arm = (2, 1.0) if way == "along" else (3, 0.005)
    k = 0
    while wheels["trocar_friction.stuck"]:
        wheels.u[0, place] = 4.0 * arm * 1e-3 * k
        wheels.step(1e-3 * k, 1e-3)
        k += 1
    assert wheels.u[0, place] / arm == pytest.approx(2.6, rel=0.01)
