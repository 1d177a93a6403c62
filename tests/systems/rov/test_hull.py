"""Hull against closed forms: terminal speed, start-up, roll and pitch, Kirchhoff's invariants, Munk's moment, moving water."""

import math

import numpy as np
import pytest
from cosimo.components.rov.hull import RovHull
from cosimo.components.rov.hull_equations import hull_derivatives
from cosimo.components.rov.vehicles import AXES, WATER
from cosimo.tests.slopes import orders
from cosimo.tests.support import initialized
from cosimo.tests.systems.energy import energy_rate
from scipy.linalg import expm
from scipy.spatial.transform import Rotation
from scipy.special import ellipk, lambertw

pytestmark = pytest.mark.interpreted
LEVEL = {"centre_of_gravity_z": 0.0}
WEIGHTLESS = {"restoring.weight": 0.0, "restoring.buoyancy": 0.0}
PUSHED = ("added_mass", "linear_drag", "quadratic_drag", "external")  # few sets of effects: each is compiled for itself
RIGHTED = ("added_mass", "linear_drag", "restoring")
FREE = ("added_mass", "coriolis", "restoring")


def started(effects, **parameters) -> RovHull:
    return initialized(RovHull(effects, parameters))


def push(hull: RovHull, *loads: float) -> RovHull:
    """Set the external force and moment, body axes."""
    for name, value in zip([n for n in hull.inputs if n.startswith("external.")], loads, strict=True):
        hull[name] = value
    return hull


def attitude(hull: RovHull) -> Rotation:
    return Rotation.from_quat([hull[f"quaternion_{n}"] for n in "xyzw"])


def values(hull: RovHull, *names: str) -> np.ndarray:
    return np.array([hull[n] for n in names])


def linear(hull: RovHull) -> np.ndarray:
    return values(hull, "surge", "sway", "heave")


def angular(hull: RovHull) -> np.ndarray:
    return values(hull, "roll_rate", "pitch_rate", "yaw_rate")


def position(hull: RovHull) -> np.ndarray:
    return values(hull, "position_north", "position_east", "depth")


# -- speed through the water -------------------------------------------------------------------------------------------


@pytest.mark.known_answers(RovHull="quadratic_drag")
@pytest.mark.first
@pytest.mark.parametrize(("force", "printed"), [(10.0, 0.6390570), (40.0, 1.3766130)])
def test_terminal_speed(force, printed):
    X, XX = 4.03, 18.18
    hull = push(started(PUSHED, **LEVEL), force, 0, 0, 0, 0, 0)
    hull.step(0.0, 60.0)
    closed = (-X + math.sqrt(X**2 + 4.0 * XX * force)) / (2.0 * XX)
    assert closed == pytest.approx(printed, abs=5e-8)
    assert hull["surge"] == pytest.approx(closed, rel=1e-12)  # 60 s are 100 time constants and more


@pytest.mark.known_answers(RovHull="added_mass")
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize(("X", "XX"), [(1, 0), (0, 1), (1, 1)])
def test_start_from_rest_follows_riccati(axis, X, XX):
    """u1 (1 - e^-kt) / (1 + (u1/u2) e^-kt); without linear drag u tanh, without quadratic an exponential."""
    X, XX = X * (4.03, 6.22, 5.18)[axis], XX * (18.18, 21.66, 36.99)[axis]
    mass, F, t = 11.5 + (5.5, 12.7, 14.57)[axis], 10.0, 1.3
    name = AXES[axis]
    hull = push(
        started(PUSHED, substep=2e-3, **LEVEL, **{f"linear_drag.{name}": X, f"quadratic_drag.{name}": XX}), *(np.eye(6)[axis] * F)
    )
    hull.step(0.0, t)
    if XX == 0.0:
        closed = F / X * (1.0 - math.exp(-X * t / mass))
    else:
        delta = math.sqrt(X**2 + 4.0 * XX * F)
        u1, u2, decay = (delta - X) / (2.0 * XX), (delta + X) / (2.0 * XX), math.exp(-delta / mass * t)
        closed = u1 * (1.0 - decay) / (1.0 + u1 / u2 * decay)
    assert linear(hull)[axis] == pytest.approx(closed, rel=1e-10)  # RK4: (k h)^4 / 120 at k = 2.1 1/s


@pytest.mark.first
@pytest.mark.parametrize("distance", [0.05, 2.0, 30.0])
def test_a_distance_is_covered_in_the_time_of_lamberts_function(distance):
    """Linear drag only, from rest: T (q + W(-e^-q)) with T = m / X, q = distance X / (F T) + 1."""
    X, F, mass = 4.03, 10.0, 17.0
    hull = push(started(PUSHED, substep=2e-3, **LEVEL, **{"quadratic_drag.surge": 0.0}), F, 0, 0, 0, 0, 0)
    q = distance * X / (F * mass / X) + 1.0
    hull.step(0.0, mass / X * (q + float(lambertw(-math.exp(-q)).real)))
    assert hull["position_north"] == pytest.approx(distance, rel=1e-9)


def test_order_in_the_substep_is_four():
    def speed(substep: float) -> float:
        hull = push(started(PUSHED, substep=substep, **LEVEL), 40, 0, 0, 0, 0, 0)
        hull.step(0.0, 0.8)
        return hull["surge"]

    exact = speed(1e-3)
    errors = [abs(speed(h) - exact) for h in (0.08, 0.04, 0.02)]
    slopes = orders(errors)
    assert ((slopes > 3.8) & (slopes < 4.3)).all()


def test_thrust_acts_in_its_place_and_direction():
    """Each thruster alone, from rest: M nu' = (e, r x e), and the speed along its axis grows by the power it puts in."""
    hull = started(PUSHED, **{f"{kind}_drag.{axis}": 0.0 for kind in ("linear", "quadratic") for axis in AXES})
    for i in range(1, 7):
        hull.initialize(0.0)
        hull[f"thrust[{i}]"] = 3.0
        hull.step(0.0, 1e-3)
        r, e = (np.array([hull[f"{n}_{a}[{i}]"] for a in "xyz"]) for n in ("thruster", "thruster_direction"))
        nu = np.concatenate((linear(hull), angular(hull)))
        momentum = sum(hull.masses()) @ nu
        np.testing.assert_allclose(momentum, 3e-3 * np.concatenate((e, np.cross(r, e))), atol=1e-12)
        assert hull[f"axial_speed[{i}]"] * 3.0 * 1e-3 / 2.0 == pytest.approx(hull.energy(), rel=1e-9)
        hull[f"thrust[{i}]"] = 0.0


# -- weight and buoyancy -----------------------------------------------------------------------------------------------


@pytest.mark.full
@pytest.mark.parametrize(("axis", "printed"), [("roll", 1.711926), ("pitch", 1.898724)])
def test_small_roll_and_pitch(axis, printed):
    """w² = (z_g W - z_b B) / (I + A); five and a quarter periods after the release the angle is 0."""
    numbers = RovHull.presets["von Benzon 2022, BlueROV2 Heavy"].parameters
    numbers = {n: v for n, v in numbers.items() if "drag" not in n} | {f"linear_drag.{a}": 0.0 for a in AXES}
    hull = started(RIGHTED, **numbers, **{f"start_{axis}": 1e-5, "substep": 1e-3})
    w = math.sqrt(0.01 * 1000.0 * 0.0134 * 9.82 / {"roll": 0.26 + 0.189, "pitch": 0.23 + 0.135}[axis])
    assert w == pytest.approx(printed, abs=1e-6)
    hull.step(0.0, 5.25 * 2.0 * math.pi / w)
    assert abs(hull[axis]) <= 1e-9 * 1e-5  # w t times (angle/4)² of a pendulum, 2e-10
    assert hull[f"{axis}_rate"] == pytest.approx(-w * 1e-5, rel=1e-9)


@pytest.mark.known_answers(RovHull="linear_drag")
def test_roll_is_damped_as_the_linear_drag_says():
    """Righting moment of Wu's vehicle from buoyancy, so that sway stays out of it: w = 2.838511 rad/s, zeta = 0.044037."""
    w, t = math.sqrt(0.02 * 112.8 / 0.28), 7.0
    zeta = 0.07 / (2.0 * 0.28 * w)
    assert (w, zeta) == (pytest.approx(2.838511, abs=5e-7), pytest.approx(0.044037, abs=5e-7))
    hull = started(RIGHTED, start_roll=1e-4, substep=1e-3, **LEVEL, **{"restoring.centre_of_buoyancy_z": -0.02 * 112.8 / 114.8})
    hull.step(0.0, t)
    damped = w * math.sqrt(1.0 - zeta**2)
    closed = 1e-4 * math.exp(-zeta * w * t) * (math.cos(damped * t) + zeta * w / damped * math.sin(damped * t))
    assert hull["roll"] == pytest.approx(closed, abs=1e-12)


@pytest.mark.full
def test_roll_with_the_weight_below_the_origin_takes_sway_along():
    """Wu's vehicle as published: the centre of gravity below the origin couples roll and sway; exponential of the linear set."""
    hull = started(RIGHTED, start_roll=1e-5, substep=1e-3)
    hull.step(0.0, 9.0)
    M = np.array([[24.2, -0.23, 0.0], [-0.23, 0.28, 0.0], [0.0, 0.0, 1.0]])
    K = np.array([[-6.22, 0.0, 112.8 - 114.8], [0.0, -0.07, -0.02 * 112.8], [0.0, 1.0, 0.0]])
    sway, rate, roll = expm(9.0 * np.linalg.solve(M, K)) @ [0.0, 0.0, 1e-5]
    assert values(hull, "sway", "roll_rate", "roll") == pytest.approx([sway, rate, roll], abs=1e-13)


@pytest.mark.known_answers(RovHull="restoring")
@pytest.mark.full
@pytest.mark.parametrize("degrees", [30.0, 90.0, 150.0])
def test_large_roll_has_the_period_of_a_pendulum(degrees):
    amplitude = math.radians(degrees)
    hull = started(
        FREE,
        start_roll=amplitude,
        substep=1e-3,
        **LEVEL,
        **{"restoring.buoyancy": 112.8, "restoring.centre_of_buoyancy_z": -0.02},
    )
    ratio = 2.0 / math.pi * ellipk(math.sin(0.5 * amplitude) ** 2)
    if degrees == 90.0:
        assert ratio == pytest.approx(1.18034, abs=5e-6)
    period = ratio * 2.0 * math.pi / math.sqrt(0.02 * 112.8 / 0.28)
    hull.step(0.0, 3.25 * period)
    assert abs(hull["roll"]) <= 1e-9
    hull.step(hull.t, 0.75 * period)
    assert hull["roll"] == pytest.approx(amplitude, rel=1e-9)
    np.testing.assert_allclose(linear(hull), 0.0, atol=1e-12)


# -- a body in a perfect fluid -----------------------------------------------------------------------------------------

TUMBLING = {
    "start_surge": 0.7,
    "start_sway": -0.4,
    "start_heave": 0.5,
    "start_roll_rate": 2.0,
    "start_pitch_rate": -1.0,
    "start_yaw_rate": 1.5,
    "start_roll": 0.3,
    "start_pitch": -0.6,
    "start_yaw": 2.0,
    "start_depth": 5.0,
}


def kirchhoff(hull: RovHull) -> tuple[float, np.ndarray, np.ndarray]:
    """(kinetic energy, impulse, impulsive moment about the world's origin) from the outputs."""
    nu = np.concatenate((linear(hull), angular(hull)))
    momentum = sum(hull.masses()) @ nu
    P, H = (attitude(hull).apply(part) for part in (momentum[:3], momentum[3:]))
    return 0.5 * nu @ momentum, P, H + np.cross(position(hull), P)


@pytest.mark.full
@pytest.mark.parametrize("centre", [(0.0, 0.0, 0.0), (0.03, -0.02, 0.04)])
def test_energy_and_impulse_of_a_tumbling_body_stay(centre):
    """Neutral, without drag: Kirchhoff's invariants through 30 s of tumbling; every sign of both Coriolis terms is in them."""
    place = {f"centre_of_gravity_{a}": c for a, c in zip("xyz", centre, strict=True)}
    drifts = []
    for substep in (4e-3, 2e-3):
        hull = started(FREE, substep=substep, **TUMBLING, **place, **WEIGHTLESS)
        before = kirchhoff(hull)
        hull.step(0.0, 30.0)
        after = kirchhoff(hull)
        drifts.append(max(np.abs(np.subtract(a, b)).max() for a, b in zip(after, before, strict=True)))
        assert hull.energy() == pytest.approx(after[0], rel=1e-13)
        assert np.linalg.norm(values(hull, *(f"quaternion_{n}" for n in "wxyz"))) == pytest.approx(1.0, abs=4e-16)
    assert np.ptp(angular(hull)) > 0.5  # it does tumble
    assert drifts[1] <= 1e-6  # of an energy of 8 J and moments of some 10
    assert 3.5 < orders(drifts)[0] < 5.5  # RK4: 4 in the state, 5 in what a quadratic invariant loses


@pytest.mark.known_answers(RovHull="coriolis")
def test_munk_moment_grows_at_its_rate():
    """Ahead at u, not along the axis of the largest added mass: a small pitch grows at u sqrt(m1 (m3 - m1) / (m3 I2))."""
    m1, m3, inertia, u = 17.0, 26.07, 0.28, 1.0
    rate = u * math.sqrt(m1 * (m3 - m1) / (m3 * inertia))
    assert rate == pytest.approx(4.595985, abs=5e-7)
    small = 1e-8
    hull = started(
        FREE, substep=1e-3, **LEVEL, **WEIGHTLESS, start_surge=u, start_pitch_rate=small, start_heave=small * m1 * u / (m3 * rate)
    )  # on the growing eigenvector
    hull.step(0.0, 2.0)
    assert math.log(hull["pitch_rate"] / small) / 2.0 == pytest.approx(rate, rel=1e-9)


# -- water that moves --------------------------------------------------------------------------------------------------


@pytest.mark.known_answers(RovHull="current")
@pytest.mark.full
@pytest.mark.parametrize("effects", [WATER, FREE])
def test_in_a_uniform_current_all_is_as_in_still_water(effects):
    """Galileo: the same motion seen from water that moves; the hull turns all the while, and thrusts act."""
    flow, t = np.array([0.4, -0.7, 0.2]), 3.0
    pose = {n: v for n, v in TUMBLING.items() if n in ("start_roll", "start_pitch", "start_yaw")}
    turn = Rotation.from_euler("ZYX", [pose["start_yaw"], pose["start_pitch"], pose["start_roll"]])
    drift = dict(zip(("start_surge", "start_sway", "start_heave"), turn.inv().apply(flow), strict=True))
    still, moved = (
        started((*effects, *more), substep=1e-3, start_yaw_rate=2.0, **pose, **start)
        for more, start in (((), {}), (("current",), drift))
    )
    for name, v in zip(("north", "east", "down"), flow, strict=True):
        moved[f"current.velocity_{name}"] = v
    for hull in (still, moved):
        for i, F in enumerate((6.0, -4.0, 9.0, 3.0, -7.0, 2.0), 1):
            hull[f"thrust[{i}]"] = F
        hull.step(0.0, t)
    # RK4 in another frame: both are exact to (w h)^4 t
    np.testing.assert_allclose(position(moved), position(still) + flow * t, atol=1e-8)
    np.testing.assert_allclose(linear(moved), linear(still) + attitude(still).inv().apply(flow), atol=1e-8)
    np.testing.assert_allclose(angular(moved), angular(still), atol=1e-8)
    axial = [f"axial_speed[{i}]" for i in range(1, 7)]
    np.testing.assert_allclose(values(moved, *axial), values(still, *axial), atol=1e-8)


@pytest.mark.full
@pytest.mark.parametrize("yaw", [0.0, 0.5 * math.pi])
def test_accelerating_water_takes_the_hull_along_by_its_added_mass(yaw):
    """nu' = m_A a / (m + m_A), surge's to the north, sway's after a quarter turn."""
    hull = started((*FREE, "current"), start_yaw=yaw, **LEVEL, **{"restoring.buoyancy": 112.8})
    hull["current.acceleration_north"] = 0.2
    hull.step(0.0, 3.0)
    share = (5.5 / 17.0, 12.7 / 24.2)[yaw > 0.0]
    assert hull["position_north"] == pytest.approx(0.5 * share * 0.2 * 9.0, rel=1e-12)


# -- energy ------------------------------------------------------------------------------------------------------------


@pytest.mark.known_answers(RovHull="tether")
def test_energy_changes_by_the_power_of_thrust_loads_and_drag():
    """At random states: d(energy)/dt = F . axial speed + force . velocity of the attachment + external power - drag's loss."""
    random = np.random.default_rng(7)
    hull = started(
        (*WATER, "tether", "external"),
        **{f"centre_of_gravity_{a}": c for a, c in zip("xyz", (0.02, -0.01, 0.02), strict=True)},
        **{"restoring.centre_of_buoyancy_x": 0.01, "restoring.centre_of_buoyancy_z": -0.02},
    )
    D, DD = (np.array([hull[f"{kind}_drag.{a}"] for a in AXES]) for kind in ("linear", "quadratic"))
    for _ in range(20):
        for name in hull.inputs:
            hull[name] = random.normal(scale=10.0)
        hull.x[:] = random.normal(size=hull.x.size)
        hull.x[3:7] /= np.linalg.norm(hull.x[3:7])
        hull.refresh()
        nu = hull.x[7:13].copy()
        power = sum(hull[f"thrust[{i}]"] * hull[f"axial_speed[{i}]"] for i in range(1, 7))
        power += sum(hull[f"tether.force_{w}"] * hull[f"tether.velocity_{w}"] for w in ("north", "east", "down"))
        power += hull.u[0, hull.input_positions(n for n in hull.inputs if n.startswith("external."))] @ nu
        power -= nu @ (D * nu + DD * np.abs(nu) * nu)
        rate, dx = energy_rate(hull, hull_derivatives, 1e-5)  # the energy is quadratic in most of the state: nearly exact
        assert rate == pytest.approx(power, rel=1e-6, abs=1e-5)
        np.testing.assert_allclose(hull.y[-6:], dx[7:13], rtol=1e-12)  # accelerations told are those that are integrated


@pytest.mark.full
def test_attachment_moves_as_a_point_of_the_hull():
    hull = started((*WATER, "tether", "external"), **TUMBLING, substep=1e-3)
    names = [f"tether.{what}_{way}" for what in ("position", "velocity") for way in ("north", "east", "down")]
    at = np.array([hull[f"tether.attachment_{a}"] for a in "xyz"])
    places = []
    for k in range(3):
        places.append(values(hull, *names))
        np.testing.assert_allclose(places[-1][:3], position(hull) + attitude(hull).apply(at), atol=1e-15)
        hull.step(k * 1e-3, 1e-3)
    np.testing.assert_allclose((places[2][:3] - places[0][:3]) / 2e-3, places[1][3:], atol=1e-5)  # (w h)²/6 of it
