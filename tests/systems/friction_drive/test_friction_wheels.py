"""Wheels that slide on a sleeve: speed under load, limits of force and torque, power, and the linear contact exactly."""

import math

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.friction_drive.sleeve import DEFLECTIONS, FEED_RATE, MODES, ROTATION_RATE
from cosimo.components.friction_drive.wheels import FrictionWheels, wheels_derivatives
from cosimo.tests.slopes import orders
from cosimo.tests.support import initialized
from cosimo.tests.systems.energy import energy_rate
from cosimo.tests.systems.friction_drive.closed_forms import load_share, loaded_feed
from cosimo.tests.systems.friction_drive.drive_runs import FULL, NEUTRAL
from scipy.linalg import expm

pytestmark = pytest.mark.interpreted
MOST = 2.0 * 0.4 * 15.0  # N, friction of both contacts
LAWS = [("smoothed_slip",), ("lugre_slip",), ("exact_slip",)]
COULOMB = {
    "lugre_slip": {"lugre_slip.viscous": 0.0, "lugre_slip.static_ratio": 1.0},
    "exact_slip": {"exact_slip.static_ratio": 1.0},
}  # what makes a law that of Coulomb


def wheels_at(effects=(), first=0.0, second=0.0, force=0.0, torque=0.0, **parameters) -> FrictionWheels:
    """Initialized wheels with given rates and loads."""
    law = COULOMB.get(effects[0], {}) if effects else {}
    wheels = FrictionWheels(effects, law | parameters)
    wheels.u[0, :4] = first, second, force, torque
    return initialized(wheels)


# -- speed under load ---------------------------------------------------------------------------------------------------------
@pytest.mark.known_answers(FrictionWheels=("smoothed_slip", "lugre_slip", "exact_slip"))
@pytest.mark.parametrize("effects", [LAWS[0], *(pytest.param(law, marks=pytest.mark.full) for law in LAWS[1:])])
@pytest.mark.parametrize(("share", "speed"), [(0.0, 0.173205081), (0.25, 0.147385192), (0.5, 0.115470054), (-0.5, 0.230940108)])
def test_speed_under_load(effects, share, speed):
    """R w (cos a - sin a f / sqrt(1 - f²)) for R = 10 mm, w = 20 rad/s, a = 30 degrees, independently by a root finder."""
    wheels = wheels_at(effects, 20.0, 20.0, -share * MOST)
    wheels.step(0.0, 0.4)
    feed, power = loaded_feed(wheels, 20.0, share * MOST)
    assert feed == pytest.approx(speed, rel=1e-8)
    # the slip under load settles as exp(-t / 23 ms) at f = 0.5; smoothed friction lacks exp(-2 |s| / width) of its level, 1e-8
    assert wheels["feed_rate"] == pytest.approx(feed, rel=1e-6)
    assert wheels["rotation_rate"] == pytest.approx(0.0, abs=1e-9)
    assert wheels["contact_power"] == pytest.approx(power, rel=1e-6)
    assert 0.01 * (wheels["first_torque"] + wheels["second_torque"]) * 2000.0 == pytest.approx(
        power + share * MOST * feed, rel=1e-6, abs=1e-8
    )  # what wheels give is lost or lifts the load


@pytest.mark.first
@pytest.mark.parametrize("effects", LAWS)
def test_even_wheels_lose_what_they_slip(effects):
    """2 mu N R w sin a with plain wheels, nothing with free rollers; the sleeve bears nothing."""
    wheels = wheels_at(effects, 20.0, 20.0)
    wheels.step(0.0, 0.4)
    assert wheels["contact_power"] == pytest.approx(MOST * 0.2 * 0.5, rel=1e-6)
    assert wheels["first_torque"] == pytest.approx(0.01 * 0.5 * MOST * 0.5, rel=1e-6)  # R mu N sin a
    assert wheels["margin"] == pytest.approx(0.0, abs=1e-6)
    free = wheels_at(effects, 20.0, 20.0, layout="skewed_free_rollers")
    free.step(0.0, 0.4)
    assert free["contact_power"] == pytest.approx(0.0, abs=1e-9)
    assert free["margin"] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.first
@pytest.mark.parametrize("effects", LAWS)
@pytest.mark.parametrize(("share", "direction"), [(0.99, 1.0), (1.01, -1.0)])
def test_the_sleeve_stalls_where_the_load_is_the_cosine(effects, share, direction):
    wheels = wheels_at(effects, 20.0, 20.0, -share * math.cos(math.pi / 6.0) * MOST)
    wheels.step(0.0, 1.0)
    assert wheels["feed_rate"] * direction > 1e-4
    assert wheels["feed_rate"] == pytest.approx(loaded_feed(wheels, 20.0, -wheels["external_force"])[0], rel=1e-4)


@pytest.mark.full
def test_loads_beyond_the_contacts_are_refused_by_the_closed_form_and_accelerate_the_sleeve():
    wheels = wheels_at(("exact_slip",), 20.0, 20.0, -1.25 * MOST)
    with pytest.raises(BadInput, match="what both contacts bear"):
        loaded_feed(wheels, 20.0, 1.25 * MOST)
    with pytest.raises(BadInput, match="the layout 'skewed'"):
        loaded_feed(FrictionWheels((), {"layout": "orthogonal"}), 20.0, 1.0)
    wheels.step(0.0, 1.0)
    early = wheels["feed_rate"]
    wheels.step(1.0, 1.0)
    # slip is ever more along the axis: the whole friction against it, but for 1 - (slip around / slip)² / 2
    assert wheels["feed_rate"] - early == pytest.approx(-0.25 * MOST / 0.15, rel=1e-4)


@pytest.mark.first
@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_the_speed_holds_at_any_angle_and_friction(share):
    for angle, friction in ((0.1, 0.4), (1.0, 0.2), (1.4, 0.7)):
        wheels = wheels_at(("exact_slip",), 30.0, 30.0, -share * 30.0 * friction, angle=angle, friction=friction)
        wheels.step(0.0, 0.5)
        assert wheels["feed_rate"] == pytest.approx(loaded_feed(wheels, 30.0, share * 30.0 * friction)[0], rel=1e-6)


# -- what the contacts bear ---------------------------------------------------------------------------------------------------
@pytest.mark.first(3)
@pytest.mark.parametrize("layout", ["skewed", "skewed_free_rollers", "orthogonal"])
@pytest.mark.parametrize("angle", np.linspace(0.1, 6.2, 9))
def test_the_sleeve_stands_within_the_limits_of_force_and_torque_and_moves_beyond(layout, angle):
    """Wheels at rest: an ellipse of 2 mu N and 2 mu N r with plain wheels, a rhombus and a rectangle with free rollers."""
    unit = FrictionWheels((), {"layout": layout})
    reach = 1.0 / load_share(unit, math.cos(angle), 0.005 * math.sin(angle))
    for share, holds in ((0.98, True), (1.02, False)):
        wheels = wheels_at(("exact_slip",), 0.0, 0.0, layout=layout)
        ramp = 0.2  # s: no overshoot of a load that comes at once
        wheels.u[1, 2:4] = share * reach * math.cos(angle) / ramp, share * reach * 0.005 * math.sin(angle) / ramp
        wheels.step(0.0, ramp)
        wheels.step(ramp, 0.1)
        speed = math.hypot(wheels["feed_rate"], 0.005 * wheels["rotation_rate"])
        assert (speed < 1e-5) == holds, speed
        stuck = wheels["exact_slip.first_stuck"] + wheels["exact_slip.second_stuck"]
        assert stuck == 2.0 if holds else stuck < 2.0


def test_load_shares():
    plain, free = (FrictionWheels((), {"layout": n}) for n in ("skewed", "skewed_free_rollers"))
    assert load_share(plain, MOST) == pytest.approx(1.0)
    assert load_share(plain, 0.0, MOST * 0.005) == pytest.approx(1.0)
    assert load_share(plain, -0.6 * MOST, 0.8 * MOST * 0.005) == pytest.approx(1.0)
    assert load_share(free, MOST * math.cos(math.pi / 6.0)) == pytest.approx(1.0)
    assert load_share(free, 0.0, MOST * 0.005 * 0.5) == pytest.approx(1.0)
    assert load_share(FrictionWheels((), {"layout": "skewed_free_rollers", "angle": 0.0}), 1.0, 1e-9) == math.inf


# -- the same for both layouts, linear contacts, energy -----------------------------------------------------------------------
@pytest.mark.parametrize("effects", LAWS)
def test_layouts_are_the_same_as_the_angle_vanishes(effects):
    """Feed only; the rotation is another matter, which free rollers leave to itself.

    To second order in the angle, but for LuGre: there the slip across, R w sin a, lets the bristles relax along as well.
    """

    def feed_after(layout: str, angle: float) -> float:
        wheels = wheels_at(effects, 20.0, 20.0, -3.0, layout=layout, angle=angle)
        wheels.step(0.0, 0.05)
        return wheels["feed"]

    assert feed_after("skewed", 0.0) == pytest.approx(feed_after("skewed_free_rollers", 0.0), rel=1e-14)
    apart = [abs(feed_after("skewed", a) - feed_after("skewed_free_rollers", a)) for a in (2e-3, 1e-3)]
    assert apart[0] < 1e-4
    order = 1.0 if effects == ("lugre_slip",) else 2.0
    assert orders(apart)[0] == pytest.approx(order, abs=0.15)


@pytest.mark.parametrize("layout", ["skewed", "skewed_free_rollers", "orthogonal"])
def test_creeping_contacts_are_linear(layout):
    """Without an effect: v' = -A v + b, by the matrix exponential."""
    wheels = wheels_at((), 20.0, -8.0, -1.0, 0.003, layout=layout, substep=5e-6)
    masses, c = np.array([0.15, 1.875e-6 / 0.005**2]), 600.0
    half = math.pi / 6.0
    t = np.array(
        [[1.0, 0.0], [0.0, 1.0]]
        if layout == "orthogonal"
        else [[math.cos(half), math.sin(half)], [math.cos(half), -math.sin(half)]]
    )
    shares = [np.eye(2) if layout == "skewed" else np.outer(d, d) for d in t]
    A = c * sum(shares) / masses[:, None]
    b = (c * 0.01 * (20.0 * t[0] - 8.0 * t[1]) + np.array([-1.0, 0.003 / 0.005])) / masses
    steady = np.linalg.solve(A, b)
    for k in range(4):
        wheels.step(k * 2e-4, 2e-4)
        exact = steady - expm(-A * (k + 1) * 2e-4) @ steady
        assert [wheels["feed_rate"], 0.005 * wheels["rotation_rate"]] == pytest.approx(exact, rel=1e-6)


def test_bristles_and_elastic_contact_are_the_same_spring_before_they_slide():
    """Small forces: natural frequency sqrt(2 k / m), damping 2 c / 2 sqrt(2 k m), of both laws."""
    for effects, given in ((("lugre_slip",), {"lugre_slip.viscous": 0.0}), (("exact_slip",), {})):
        wheels = wheels_at(effects, 0.0, 0.0, 1e-3, substep=5e-5, **given)
        k, c, m = 2.0 * 6e4, 2.0 * 60.0, 0.15
        decay = c / (2.0 * m)
        frequency = math.sqrt(k / m - decay**2)
        for i in range(20):
            wheels.step(i * 1e-3, 1e-3)
            t = (i + 1) * 1e-3
            swing = math.cos(frequency * t) + decay / frequency * math.sin(frequency * t)
            exact = 1e-3 / k * (1.0 - math.exp(-decay * t) * swing)
            # bristles lose a little of their deflection at every reversal: |s| / z_max, 2.5e-5 here
            assert wheels["feed"] == pytest.approx(exact, rel=2e-4, abs=1e-12)


def test_relaxed_bristles_bear_what_dampers_do():
    """Before they bend: damping and viscous part against the slip, in both directions of the plane."""
    wheels = FrictionWheels(("lugre_slip",), {"lugre_slip.viscous": 50.0, "start_feed_rate": 0.02, "start_rotation_rate": -3.0})
    wheels.initialize(0.0)
    for wheel in ("first", "second"):
        found = [wheels[f"{wheel}_traction_{way}"] for way in ("axial", "around")]
        assert found == pytest.approx([-110.0 * 0.02, 110.0 * 0.005 * 3.0], rel=1e-12)


def contact_losses(wheels: FrictionWheels, r: np.ndarray) -> float:
    """Power that contacts and seal lose, by their own formulas; r: rate of the state."""
    *_, e = wheels.arguments
    lugre, exact, trocar, loss = e.lugre_slip, e.exact_slip, e.trocar_friction, e.preload_loss
    lost = wheels["contact_power"]
    k = lugre.stiffness if lugre is not None else 6.0 / exact.deflection if exact is not None else 0.0
    shares = [1.0, 1.0]
    if loss is not None:
        passed = (wheels.t - loss.start) / loss.duration
        shares = [1.0 - part * passed**2 * (3.0 - 2.0 * passed) for part in (loss.first, loss.second)]
        falling = [-part * 6.0 * passed * (1.0 - passed) / loss.duration for part in (loss.first, loss.second)]
    for i in range(2):
        z = slice(DEFLECTIONS + 2 * i, DEFLECTIONS + 2 * i + 2)
        if k:
            lost -= shares[i] * k * float(wheels.x[z] @ r[z])
            if loss is not None:
                lost -= 0.5 * falling[i] * k * float(wheels.x[z] @ wheels.x[z])
    if trocar is not None:
        place = wheels.x.size - 3
        z, dz = wheels.x[place : place + 2], r[place : place + 2]
        v = np.array([wheels.x[FEED_RATE], 0.005 * wheels.x[ROTATION_RATE]])
        bears = trocar.level / trocar.deflection * (z + trocar.damping_time * dz)
        lost += bears @ v - trocar.level / trocar.deflection * z @ dz
    return lost


@pytest.mark.parametrize("effects", [("smoothed_slip",), ("lugre_slip",), FULL], ids="+".join)
@pytest.mark.parametrize("layout", ["skewed", "skewed_free_rollers"])
def test_energy_changes_by_power_and_losses(effects, layout):
    """dE/dt = loads . rates + F z' + M phi' - losses at random states, and the losses are positive where the mode holds."""
    random = np.random.default_rng(3)
    given = {"preload_loss.start": 0.0, "preload_loss.duration": 1.0, "preload_loss.second": 0.3} if effects is FULL else {}
    wheels = wheels_at(effects, layout=layout, **given)
    wheels.t = 0.4
    t1, t2 = np.array([math.cos(math.pi / 6.0), 0.5]), np.array([math.cos(math.pi / 6.0), -0.5])
    for trial in range(40):
        wheels.x[:4] = random.normal(0.0, [0.1, 1.0, 0.2, 20.0])
        wheels.u[0, :4] = random.normal(0.0, [20.0, 20.0, 3.0, 0.01])
        wheels.x[DEFLECTIONS:] = 0.0
        if "exact_slip" in effects:
            wheels.x[MODES : MODES + 2] = trial % 2, trial // 2 % 2
        if wheels.x.size > 4 and ("lugre_slip" in effects or "exact_slip" in effects):
            for i, t in enumerate((t1, t2)):
                z = random.normal(0.0, 1.0, 2)
                if layout != "skewed":
                    z = (z @ t) * t
                if "exact_slip" in effects:
                    z *= 1e-4 / np.linalg.norm(z) if wheels.x[MODES + i] else 3e-5
                else:
                    z *= 3e-5
                wheels.x[DEFLECTIONS + 2 * i : DEFLECTIONS + 2 * i + 2] = z
        if "trocar_friction" in effects:
            wheels.x[-3:] = *random.normal(0.0, 1e-4, 2), 0.0
        wheels.refresh()
        change, rate = energy_rate(wheels, wheels_derivatives, 1e-7)
        power = (
            wheels["first_torque"] * wheels["first_rate"]
            + wheels["second_torque"] * wheels["second_rate"]
            + wheels["external_force"] * wheels["feed_rate"]
            + wheels["external_torque"] * wheels["rotation_rate"]
        )
        lost = contact_losses(wheels, rate)
        assert change == pytest.approx(power - lost, rel=1e-6, abs=1e-6)
        if "exact_slip" not in effects and "lugre_slip" not in effects:
            assert lost >= 0.0
        if effects[:1] == ("exact_slip",):
            slips = [[wheels[f"{n}_slip_axial"], wheels[f"{n}_slip_around"]] for n in ("first", "second")]
            slides = [
                wheels.x[MODES + i] and np.dot(slips[i], wheels.x[DEFLECTIONS + 2 * i : DEFLECTIONS + 2 * i + 2]) < 0.0
                for i in range(2)
            ]
            assert lost >= -1e-12 or any(slides)  # a deflection against the slip: the mode has ended


@pytest.mark.parametrize("effects", [("lugre_slip",), ("exact_slip",)])
def test_energy_over_a_run_with_slip_and_stick(effects):
    """Wheels swing, the sleeve is loaded: what goes into it is its kinetic energy, by a trapezium rule of 0.1 ms."""
    wheels = wheels_at(effects, 0.0, 0.0, -2.0, layout="skewed_free_rollers", friction=0.15)
    flows, h = [], 1e-4
    for k in range(4001):
        t = k * h
        for j, n in enumerate(("first_rate", "second_rate")):
            wheels.u[:2, wheels.inputs.index(n)] = 40.0 * math.sin(60.0 * t + j), 2400.0 * math.cos(60.0 * t + j)
        wheels.refresh()
        flows.append(
            wheels["first_torque"] * wheels["first_rate"]
            + wheels["second_torque"] * wheels["second_rate"]
            - 2.0 * wheels["feed_rate"]
            - wheels["contact_power"]
        )
        if k < 4000:
            wheels.step(t, h)
    sleeve = 0.5 * (0.15 * wheels["feed_rate"] ** 2 + 1.875e-6 * wheels["rotation_rate"] ** 2)
    # measured: 1e-5 and 1.4e-5 J of 0.1 J that pass; the rule misses a part of h² at every kink of the power
    assert sleeve == pytest.approx(np.trapezoid(flows, dx=h), abs=3e-5)
    if effects == ("exact_slip",):
        assert wheels.work["events"] > 10


# -- the other effects --------------------------------------------------------------------------------------------------------
@pytest.mark.known_answers(FrictionWheels="gravity")
def test_the_weight_slides_down_what_friction_does_not_hold():
    wheels = wheels_at(FULL, **NEUTRAL | {"gravity.acceleration": 9.81, "gravity.inclination": 1.2, "friction": 0.01})
    wheels.step(0.0, 0.1)
    early = wheels["feed_rate"]
    wheels.step(0.1, 0.4)
    excess = 0.15 * 9.81 * math.sin(1.2) - 2.0 * 0.01 * 15.0
    assert wheels["feed_rate"] - early == pytest.approx(-excess / 0.15 * 0.4, rel=1e-9)


@pytest.mark.known_answers(FrictionWheels="trocar_friction")
@pytest.mark.full
def test_the_seal_holds_a_small_load_and_slides_under_a_large_one():
    """Wheels without friction; the force grows by 5.4 N/s to 2.5 or 2.7 N, the seal breaks loose at 2.6 N and then bears 2 N."""
    for force, moves in ((2.5, False), (2.7, True)):
        wheels = wheels_at(FULL, **NEUTRAL | {"trocar_friction.level": 2.0, "friction": 1e-9})
        wheels.u[1, 2] = force / 0.5
        wheels.step(0.0, 0.5)
        early = wheels["feed_rate"]
        wheels.step(0.5, 0.5)
        assert wheels["trocar_friction.stuck"] == (0.0 if moves else 1.0)
        if moves:
            assert wheels["feed_rate"] - early == pytest.approx(0.7 / 0.15 * 0.5, rel=1e-6)
            assert np.hypot(*wheels.x[-3:-1]) == pytest.approx(5e-4, rel=1e-9)  # at the kinetic level it would hold again
            slid = 0.5 * (1.0 - 2.6 / 2.7)  # s, within which the force less 2 N is 0.65 N on average
            assert early == pytest.approx(0.65 / 0.15 * slid, rel=0.1)  # it swings on the seal before it slides
        else:
            assert wheels["feed"] == pytest.approx(5e-4 * 2.5 / 2.0, rel=1e-4)  # it still swings a little


@pytest.mark.known_answers(FrictionWheels="preload_loss")
def test_a_lost_wheel_bears_nothing_and_leaves_the_load_to_the_other():
    wheels = wheels_at(FULL, force=-3.0, **NEUTRAL | {"preload_loss.first": 1.0, "preload_loss.start": 0.1})
    wheels.step(0.0, 0.1)
    assert wheels["first_traction_axial"] == pytest.approx(1.5, rel=1e-6)
    wheels.step(0.1, 0.5)
    assert wheels["first_traction_axial"] == 0.0
    assert wheels["second_traction_axial"] == pytest.approx(3.0, rel=1e-6)
    assert wheels["margin"] == 0.0
    assert wheels["exact_slip.second_stuck"] == 1.0


# -- stable steps -------------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize("effects", [(), ("smoothed_slip",), ("lugre_slip",), FULL], ids="+".join)
@pytest.mark.parametrize("layout", ["skewed", "skewed_free_rollers"])
def test_the_stable_step_is_that_of_a_sleeve_at_rest(effects, layout):
    """2.61, RK4's limit, over the largest eigenvalue of the derivatives, by differences; a seal stiffer than by default."""
    wheels = wheels_at(effects, layout=layout, substep=1e-5, **({"trocar_friction.level": 100.0} if effects is FULL else {}))
    moving, d = [i for i in range(wheels.x.size) if effects is not FULL or i not in (8, 9, 12)], 1e-9
    columns = []
    for i in moving:
        ends = np.zeros((2, wheels.x.size))
        for end, sign in zip(ends, (1.0, -1.0), strict=True):
            wheels_derivatives(0.0, wheels.x + sign * d * np.eye(wheels.x.size)[i], wheels.u[0], end, *wheels.arguments)
        columns.append((ends[0] - ends[1])[moving] / (2.0 * d))
    assert wheels.stable_step() == pytest.approx(2.61 / np.abs(np.linalg.eigvals(np.array(columns))).max(), rel=5e-3)


def test_the_margin_is_that_of_the_wheel_that_has_less():
    """Orthogonal wheels: 1 N along of 6 N, and around 2 N of the half of 6 N that is left to the second."""
    wheels = wheels_at(
        FULL,
        force=-1.0,
        torque=0.01,
        layout="orthogonal",
        **NEUTRAL | {"preload_loss.second": 0.5, "preload_loss.start": 0.0, "preload_loss.duration": 1e-3},
    )
    wheels.step(0.0, 0.5)
    assert wheels["margin"] == pytest.approx(1.0 - 2.0 / 3.0, rel=1e-6)
