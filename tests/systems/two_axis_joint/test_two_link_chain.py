"""Two-link chain: small motion, invariants, two formulations of its dynamics, losses, dry friction, stops."""

import math

import numpy as np
import pytest
from cosimo.components.two_axis_joint.chain import TwoLinkChain
from cosimo.components.two_axis_joint.chain_equations import chain_derivatives, chain_energy
from cosimo.components.two_axis_joint.closed_forms import damped_motion, friction_turning_points, small_motion
from cosimo.tests.slopes import slope
from cosimo.tests.support import initialized
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

pytestmark = pytest.mark.interpreted

G = 9.81
GENERAL = {
    "first_mass": 1.3,
    "first_length": 0.8,
    "first_centre": 0.5,
    "first_inertia": 0.04,
    "second_mass": 0.6,
    "second_length": 0.7,
    "second_centre": 0.4,
    "second_inertia": 0.03,
}
# one pendulum: the second link has no mass, its inertia turns by itself
SINGLE = {"second_mass": 0.0, "second_inertia": 1.0}
SMOOTH = ("gravity", "viscous", "smoothed_friction", "stops", "reactions")


def started(effects=(), preset: str = "", **parameters) -> TwoLinkChain:
    return initialized(TwoLinkChain(effects, parameters, preset=preset))


def starting(angles, rates=(0.0, 0.0)) -> dict[str, float]:
    return {
        "start_first_angle": angles[0],
        "start_second_angle": angles[1],
        "start_first_rate": rates[0],
        "start_second_rate": rates[1],
    }


def absolute(chain: TwoLinkChain) -> np.ndarray:
    """(th1, th2, w1, w2)."""
    return chain.y[:4].copy()


@pytest.mark.known_answers(TwoLinkChain="gravity")
@pytest.mark.first
@pytest.mark.parametrize(("preset", "square", "shape"), [
    ("equal point masses", 2.0 - math.sqrt(2.0), (1.0, math.sqrt(2.0))),
    ("equal point masses", 2.0 + math.sqrt(2.0), (1.0, -math.sqrt(2.0))),
    ("equal rods", 3.0 - 6.0 / math.sqrt(7.0), None),
    ("equal rods", 3.0 + 6.0 / math.sqrt(7.0), None),
])  # fmt: skip
def test_small_motion_in_a_mode_keeps_its_shape_and_frequency(preset, square, shape):
    """From M, K by hand: a mode of amplitude 1e-5 after 10 s is amplitude * cos(w t), both angles."""
    w = math.sqrt(G * square)
    if shape is None:  # ((4/3, 1/2), (1/2, 1/3)) and g (3/2, 1/2): first row of K - w² M
        shape = (1.0, (1.5 * G - 4.0 / 3.0 * w * w) / (0.5 * w * w))
    angles = 1e-5 * np.array(shape)
    chain = started(preset=preset, **starting(angles))
    chain.step(0.0, 10.0)
    # square of the largest relative angle, 3.1e-5, times 72 rad: 7e-8 of the amplitude; RK4: (w h)^4 / 120 * 72 rad = 2e-9
    np.testing.assert_allclose(absolute(chain)[:2], angles * math.cos(10.0 * w), atol=7e-8 * 1e-5)


@pytest.mark.known_answers(TwoLinkChain="viscous")
@pytest.mark.parametrize(("effects", "dampers"), [
    (("gravity", "viscous"), (0.1, 0.1)), (("gravity", "viscous"), (3.0, 3.0)),
    (("viscous",), (0.1, 0.05)), (("viscous",), (0.0, 0.5)),
])  # fmt: skip
def test_damped_small_motion_is_the_exact_solution(effects, dampers):
    """Proportional damping, weak and strong, and any dampers without gravity; relative angles stay small in all."""
    parameters = {"viscous.first": dampers[0], "viscous.second": dampers[1], **starting((1e-4, -2e-4), (3e-5, 1e-4))}
    chain = started(effects, **parameters)
    for t in (0.5, 2.0, 5.0):
        chain.step(chain.t, t - chain.t)
        angles, rates = damped_motion(small_motion(chain), (1e-4, -2e-4), (3e-5, 1e-4), t)
        np.testing.assert_allclose(absolute(chain), [*angles[:, 0], *rates[:, 0]], atol=1e-10)  # angle³ of 1e-4, some 100 times


def test_damped_chain_of_the_quartic():
    """m = l = 1, d = 0.1, 0.05: four runs give the propagator of small motion, and its eigenvalues are the quartic's roots."""
    t = 0.25  # both frequencies below half a turn, so that the logarithm is unique
    columns = []
    for k in range(4):
        x = 1e-5 * np.eye(4)[k]
        chain = started(
            ("gravity", "viscous"), **{"viscous.first": 0.1, "viscous.second": 0.05, "substep": 1e-4}, **starting(x[:2], x[2:])
        )
        chain.step(0.0, t)
        columns.append(absolute(chain) / 1e-5)
    values = np.sort_complex(np.log(np.linalg.eigvals(np.array(columns).T).astype(complex)) / t)
    slow, quick = -0.00795021 + 2.39719971j, -0.16704979 + 5.78490729j
    exact = np.sort_complex([slow, slow.conjugate(), quick, quick.conjugate()])
    np.testing.assert_allclose(values, exact, atol=2e-8)


def random_states(n: int = 12):
    random = np.random.default_rng(5)
    for _ in range(n):
        yield random.uniform(-3.0, 3.0, 4) * [1.0, 1.0, 2.0, 2.0], random.uniform(-5.0, 5.0, 2)


def touched(relative: float) -> float:
    """Which of the default stops is."""
    return float(relative > math.pi / 2.0) - float(relative < -math.pi / 2.0)


def newton_euler(chain: TwoLinkChain, joint_torques) -> tuple[np.ndarray, np.ndarray]:
    """Accelerations of both angles and the forces in both joints: two free bodies and four conditions, ten unknowns.

    No minimal coordinates, no Lagrangian: independent of what the component does.
    """
    p = {n: chain.parameters[n] for n in GENERAL}
    th, w = (chain.y[0], chain.y[1]), (chain.y[2], chain.y[3])
    m, i = (p["first_mass"], p["second_mass"]), (p["first_inertia"], p["second_inertia"])
    a, l1, t1, t2 = (p["first_centre"], p["second_centre"]), p["first_length"], *joint_torques
    s, c = np.sin(th), np.cos(th)
    A, b = np.zeros((10, 10)), np.zeros(10)  # unknown: x1'', y1'', th1'', x2'', y2'', th2'', F1x, F1y, F2x, F2y
    A[0, [0, 6, 8]], A[1, [1, 7, 9]], b[1] = (m[0], -1.0, 1.0), (m[0], -1.0, 1.0), -m[0] * G
    A[2, [2, 6, 7, 8, 9]] = i[0], a[0] * c[0], a[0] * s[0], (l1 - a[0]) * c[0], (l1 - a[0]) * s[0]
    b[2] = t1 - t2
    A[3, [3, 8]], A[4, [4, 9]], b[4] = (m[1], -1.0), (m[1], -1.0), -m[1] * G
    A[5, [5, 8, 9]], b[5] = (i[1], a[1] * c[1], a[1] * s[1]), t2
    A[6, [0, 2]], b[6] = (1.0, -a[0] * c[0]), -a[0] * w[0] ** 2 * s[0]  # link 1's centre turns about the ground's joint
    A[7, [1, 2]], b[7] = (1.0, -a[0] * s[0]), a[0] * w[0] ** 2 * c[0]
    A[8, [3, 2, 5]], b[8] = (1.0, -l1 * c[0], -a[1] * c[1]), -l1 * w[0] ** 2 * s[0] - a[1] * w[1] ** 2 * s[1]
    A[9, [4, 2, 5]], b[9] = (1.0, -l1 * s[0], -a[1] * s[1]), l1 * w[0] ** 2 * c[0] + a[1] * w[1] ** 2 * c[1]
    values = np.linalg.solve(A, b)
    return values[[2, 5]], values[6:]


@pytest.mark.known_answers(TwoLinkChain=("smoothed_friction", "reactions"))
def test_lagrange_is_newton_and_euler_at_random_states():
    """Accelerations, joint forces and joint torques, with damping, friction and stops as torques in the joints."""
    for state, torques in random_states():
        chain = started(SMOOTH, **GENERAL)
        chain.x[:], chain.u[0] = [*state, touched(state[1])], torques
        chain.refresh()
        r, (lower, upper) = state[2:], (-math.pi / 2.0, math.pi / 2.0)
        depth = max(state[1] - upper, 0.0) + min(state[1] - lower, 0.0)
        stop = 1000.0 * depth * max(0.0, 1.0 + 0.1 * math.copysign(r[1], depth * r[1]))
        joints = torques - [0.1, 0.05] * r - 0.1 * np.tanh(r / 0.01) - [0.0, stop]
        accelerations, forces = newton_euler(chain, joints)
        dx = np.empty(chain.x.size)
        chain_derivatives(0.0, chain.x, chain.u[0], dx, *chain.arguments)
        scale = max(1.0, np.abs(accelerations).max())
        np.testing.assert_allclose([dx[2], dx[2] + dx[3]], accelerations, atol=1e-12 * scale)
        values = [chain[f"reactions.{n}"] for n in ("first_x", "first_y", "second_x", "second_y")]
        np.testing.assert_allclose(values, forces, atol=1e-12 * scale)
        moments = [chain["reactions.first_moment"], chain["reactions.second_moment"]]
        np.testing.assert_allclose(moments, joints, atol=1e-12 * scale)


@pytest.mark.parametrize("effects", [(), SMOOTH, ("gravity", "lugre_friction"), ("gravity", "stick_friction")])
def test_energy_changes_by_what_motors_give_and_losses_take(effects):
    """d(energy)/dt along the equations of motion, against the power in each joint, at random states."""
    for state, torques in random_states():
        chain = started(effects, **GENERAL)
        chain.x[:4], chain.u[0] = state, torques
        if "stops" in effects:
            chain.x[4] = touched(state[1])
        loss, r, (s, p, e) = 0.0, state[2:], chain.arguments
        dx = np.zeros(chain.x.size)
        if "stick_friction" in effects:
            chain.x[4:] = np.sign(r)
            loss += 0.1 * np.abs(r).sum()
        if "lugre_friction" in effects:
            chain.x[4:] = [2e-5, -5e-5]
        chain_derivatives(0.0, chain.x, chain.u[0], dx, s, p, e)
        if "lugre_friction" in effects:
            loss += float((1000.0 * chain.x[4:] + 2.0 * dx[4:]) @ r) - float(1000.0 * chain.x[4:] @ dx[4:])
        if "viscous" in effects:
            depth = max(state[1] - math.pi / 2.0, -math.pi / 2.0 - state[1], 0.0) * math.copysign(1.0, state[1])
            spring, stop = 1000.0 * depth, 1000.0 * depth * max(0.0, 1.0 + 0.1 * math.copysign(r[1], depth * r[1]))
            loss += 0.1 * r[0] ** 2 + 0.05 * r[1] ** 2 + 0.1 * np.tanh(r / 0.01) @ r + (stop - spring) * r[1]

        def energy(step, chain=chain, dx=dx, p=p, e=e):
            return chain_energy(chain.x + step * dx, p, e)

        h = 1e-6 / max(1.0, np.abs(dx[:4]).max())
        rate = (energy(h) - energy(-h)) / (2.0 * h)
        power = float(torques @ r) - loss
        assert rate == pytest.approx(power, abs=1e-7 * (abs(power) + np.abs(dx[:4]).max() + energy(0.0) / h * 1e-9))


@pytest.mark.full
def test_without_gravity_and_friction_energy_and_angular_momentum_stay():
    chain = started(**GENERAL, **starting((0.3, 2.0), (5.0, -7.0)), substep=1e-4)
    energy, momentum = chain.energy(), chain["angular_momentum"]
    chain.step(0.0, 10.0)
    # RK4 at 20 rad/s: (w h)^5 / 100 a step, 1e5 steps: 3e-11
    assert chain.energy() == pytest.approx(energy, rel=1e-9)
    assert chain["angular_momentum"] == pytest.approx(momentum, rel=1e-9)
    assert chain["mechanical_energy"] == chain.energy()


def test_angular_momentum_changes_by_outer_torques_only():
    """A motor in the second joint and a friction there cannot change it; one in the first does, at once."""
    chain = started(("stick_friction",), **GENERAL, **{"stick_friction.first_level": 0.0}, **starting((0.3, 1.0), (2.0, -3.0)))
    chain.set("second_torque", 0.7)
    before = chain["angular_momentum"]
    chain.step(0.0, 2.0)
    assert chain["angular_momentum"] == pytest.approx(before, abs=1e-9)
    chain.set("first_torque", 0.5)
    chain.step(2.0, 1.0)
    assert chain["angular_momentum"] == pytest.approx(before + 0.5, abs=1e-9)


def test_order_in_time():
    """Against DOP853 at 1e-12 on the equations in absolute angles, written from the textbook."""

    def right(t, x):
        d = x[0] - x[1]
        M = np.array([[2.0, math.cos(d)], [math.cos(d), 1.0]])
        b = [-math.sin(d) * x[3] ** 2 - 2.0 * G * math.sin(x[0]), math.sin(d) * x[2] ** 2 - G * math.sin(x[1])]
        return [x[2], x[3], *np.linalg.solve(M, b)]

    start = starting((1.0, 1.5), (0.5, -0.2))
    exact = solve_ivp(right, (0.0, 2.0), list(start.values()), method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    steps = np.array([0.02, 0.01, 0.005])
    errors = []
    for h in steps:
        chain = started(("gravity",), **start, substep=h)
        chain.step(0.0, 2.0)
        errors.append(np.abs(absolute(chain) - exact).max())
    assert slope(steps, errors) == pytest.approx(4.0, abs=0.2)


@pytest.mark.known_answers(TwoLinkChain="stick_friction")
@pytest.mark.full
def test_dry_friction_takes_a_pendulum_from_turn_to_turn_and_holds_it():
    """Turning points of the arc-decay in closed form; at the last the pendulum rests, for good and to the last bit."""
    turns = friction_turning_points(1.0, 0.8, G)
    assert len(turns) > 4
    chain = started(
        ("gravity", "stick_friction"),
        **SINGLE,
        **starting((1.0, 0.0)),
        **{"stick_friction.first_level": 0.8, "stick_friction.second_level": 0.0},
    )
    chain.step(0.0, 12.0)
    assert chain["first_rate"] == 0.0
    assert chain["first_angle"] == pytest.approx(turns[-1], abs=1e-9)
    assert chain.work["events"] == len(turns) - 1
    rested = chain["first_angle"]
    chain.step(12.0, 100.0)
    assert chain["first_angle"] == rested


@pytest.mark.known_answers(TwoLinkChain="lugre_friction")
@pytest.mark.full
def test_bristles_decay_as_exact_standstill_does():
    """Stiff bristles without the static excess: at rest within twice the bristles' bending of the exact place."""
    turns = friction_turning_points(1.0, 0.8, G)
    stiffness = 2e4
    chain = started(
        ("gravity", "lugre_friction"),
        **SINGLE,
        **starting((1.0, 0.0)),
        substep=2e-4,
        **{
            "lugre_friction.first_level": 0.8,
            "lugre_friction.second_level": 0.0,
            "lugre_friction.static_ratio": 1.0,
            "lugre_friction.stiffness": stiffness,
            "lugre_friction.damping": 100.0,
        },
    )
    chain.step(0.0, 20.0)
    assert abs(chain["first_rate"]) < 1e-6
    assert chain["first_angle"] == pytest.approx(turns[-1], abs=2.0 * len(turns) * 0.8 / stiffness)


def test_a_joint_breaks_loose_at_its_static_level_and_gains_what_the_levels_differ():
    """Torque r t on a single inertia J: rest until static / r, then J w = r s² / 2 + (static - kinetic) s."""
    chain = started(
        ("stick_friction",),
        **SINGLE,
        **{"stick_friction.first_level": 0.5, "stick_friction.static_ratio": 1.4, "stick_friction.second_level": 5.0},
    )
    chain.u[1, 0] = 0.35
    chain.step(0.0, 1.9996)  # 0.7 N.m at 2 s
    assert chain["first_rate"] == 0.0
    assert chain["first_angle"] == 0.0
    chain.u[1, 0] = 0.35
    chain.step(1.9996, 0.6004)
    # the second joint holds, so that both links turn as one: J = m l² + I2 = 2
    assert chain["relative_rate"] == 0.0
    assert chain["first_rate"] == pytest.approx((0.35 * 0.6**2 / 2.0 + 0.2 * 0.6) / 2.0, rel=1e-7)
    assert chain.work["events"] == 1


def test_friction_of_the_second_joint_makes_one_body_of_both_links():
    """Without outer torque angular momentum stays, so that the common rate afterwards is known: momentum over inertia."""
    chain = started(("stick_friction",), **GENERAL, **{"stick_friction.first_level": 0.0}, **starting((0.0, 0.7), (2.0, 0.5)))
    momentum = chain["angular_momentum"]
    chain.step(0.0, 30.0)
    assert chain["relative_rate"] == 0.0
    assert chain["first_rate"] == chain["second_rate"]
    assert chain["first_rate"] == pytest.approx(momentum / inertia_by_hand(chain["relative_angle"]), rel=1e-9)


def inertia_by_hand(relative: float) -> float:
    """Inertia of both links about the ground's joint as one body, kg.m2."""
    g = GENERAL
    x, z = g["first_length"] + g["second_centre"] * math.cos(relative), g["second_centre"] * math.sin(relative)
    first = g["first_inertia"] + g["first_mass"] * g["first_centre"] ** 2
    return first + g["second_inertia"] + g["second_mass"] * (x * x + z * z)


@pytest.mark.known_answers(TwoLinkChain="stops")
@pytest.mark.parametrize("dissipation", [0.0, 0.05, 0.5])
def test_restitution_of_the_stops(dissipation):
    """One inertia against spring and losses kd(1 + c d'): v / (1 + c v) dv = -k/J d dd, in closed form c v - ln(1 + c v)."""
    chain = started(
        ("stops",),
        first_inertia=1e9,
        second_centre=0.0,
        second_inertia=1.0,
        substep=1e-4,
        **{"stops.upper": 0.5, "stops.dissipation": dissipation},
        **starting((0.0, 0.4), (0.0, 2.0)),
    )
    chain.step(0.0, 0.05 + 1.2 * math.pi / math.sqrt(1000.0) + 0.05)
    exact = 2.0
    if dissipation:

        def potential(v):
            return dissipation * v - math.log1p(dissipation * v)

        exact = -brentq(lambda v: potential(v) - potential(2.0), -min(2.0, (1.0 - 1e-9) / dissipation), -1e-9, xtol=1e-14)
    assert chain["relative_rate"] == pytest.approx(-exact, rel=1e-9)
    assert chain["relative_angle"] < 0.5
    assert chain.work["events"] == 2


def test_order_in_time_through_a_stop():
    """Both instants are located, so that the kinks cost no order; the finest of the series is taken as exact."""
    steps, ends = [0.001, 0.0005, 0.00025, 0.00003125], []
    for h in steps:
        chain = started(("gravity", "stops"), **GENERAL, substep=h, **{"stops.upper": 0.5}, **starting((0.0, 0.3), (-2.0, 1.0)))
        chain.step(0.0, 0.4)
        assert chain.work["events"] == 2
        ends.append(absolute(chain))
    errors = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    assert slope(steps[:-1], errors) == pytest.approx(4.0, abs=0.3)


@pytest.mark.parametrize("stiffness", [1e3, 1e5])
def test_lossless_stops_reverse_the_relative_rate(stiffness):
    """Energy and momentum stay, and the inertia at the stop's angle is the same before and after: only the sign is left."""
    chain = started(
        ("stops",),
        **GENERAL,
        substep=1e-5,
        **starting((0.0, 0.9 - 1e-12), (-1.0, 1.0)),
        **{"stops.stiffness": stiffness, "stops.dissipation": 0.0, "stops.upper": 0.9},
    )
    energy, momentum = chain.energy(), chain["angular_momentum"]
    while chain.work["events"] < 2:
        chain.step(chain.t, 1e-5)
    assert chain.energy() == pytest.approx(energy, rel=1e-9)
    assert chain["angular_momentum"] == pytest.approx(momentum, abs=1e-9)
    assert chain["relative_rate"] == pytest.approx(-2.0, abs=1e-4)  # of the free motion behind the stop, at most 10 us


def test_start_and_outputs_agree():
    """Absolute and relative angles, tip from both links, and rates of the tip as derivatives of its place."""
    chain = started(**GENERAL, **starting((0.4, -0.9), (1.5, -0.5)), substep=1e-5)
    assert absolute(chain) == pytest.approx([0.4, -0.9, 1.5, -0.5], rel=1e-15)
    assert chain["relative_angle"] == chain["second_angle"] - chain["first_angle"]
    place = [0.8 * math.sin(0.4) + 0.7 * math.sin(-0.9), -0.8 * math.cos(0.4) - 0.7 * math.cos(-0.9)]
    assert [chain["tip_x"], chain["tip_y"]] == pytest.approx(place, rel=1e-14)
    chain.step(0.0, 1e-5)
    first, velocity = [chain["tip_x"], chain["tip_y"]], [chain["tip_velocity_x"], chain["tip_velocity_y"]]
    chain.step(1e-5, 1e-5)
    moved = (np.array([chain["tip_x"], chain["tip_y"]]) - place) / 2e-5
    assert velocity == pytest.approx(moved, rel=1e-8)
    assert first != place


@pytest.mark.known_answers(TwoLinkChain="springs")
def test_a_spring_throws_a_link_out_with_the_energy_of_its_preload():
    """One inertia on a spring, relaxed at pi: pi (1 - cos w t); and with dry friction the rate of the energies' difference."""
    fixed = {
        "first_inertia": 1e12,
        "second_inertia": 0.5,
        "second_centre": 0.0,
        "springs.second_stiffness": 0.8,
        "springs.second_rest": math.pi,
    }
    chain = started(("springs",), **fixed)
    chain.step(0.0, 1.0)
    w = math.sqrt(0.8 / 0.5)
    assert chain["relative_angle"] == pytest.approx(math.pi * (1.0 - math.cos(w)), rel=1e-10)
    assert chain.energy() == pytest.approx(0.4 * math.pi**2, rel=1e-10)
    rubbed = started(("springs", "stick_friction"), **fixed, **{"stick_friction.second_level": 0.3})
    rubbed.step(0.0, 0.7)
    angle = rubbed["relative_angle"]
    gained = 0.8 * (math.pi * angle - 0.5 * angle**2) - 0.3 * angle
    assert rubbed["relative_rate"] == pytest.approx(math.sqrt(2.0 * gained / 0.5), rel=1e-9)
    first = started(
        ("springs",),
        first_inertia=2.0,
        first_mass=0.0,
        second_mass=0.0,
        second_inertia=1e-3,
        **{"springs.first_stiffness": 3.0, "springs.first_rest": 0.2, "springs.second_stiffness": 0.0},
    )
    first.step(0.0, 1.0)
    assert first["first_angle"] == pytest.approx(0.2 * (1.0 - math.cos(math.sqrt(3.0 / 2.0))), rel=1e-9)


def test_links_with_a_mass_in_series_move_as_free_bodies():
    """A hub that floats and its panel: Newton's equations of two bodies in the plane, against the links of the preset."""
    hub, panel, inertia, arm, centre, own = 100.0, 5.0, 10.0, 0.5, 0.4, 5.0 * 0.64 / 12.0
    chain = started(preset="satellite panel", **{"viscous.second": 0.0, "stick_friction.second_level": 0.0})

    def rates(t, x):  # hub's angle, panel's angle, rates; the hinge's force from equal accelerations of both its sides
        a, b, wa, wb = x
        torque = -0.25 * (b - a)
        ea, na = np.array([math.sin(a), -math.cos(a)]), np.array([math.cos(a), math.sin(a)])
        eb, nb = np.array([math.sin(b), -math.cos(b)]), np.array([math.cos(b), math.sin(b)])
        # unknown: force F on the panel at the hinge (2), both angular accelerations
        matrix = np.zeros((4, 4))
        matrix[:2, :2] = (1.0 / hub + 1.0 / panel) * np.eye(2)
        matrix[:2, 2], matrix[:2, 3] = -arm * na, -centre * nb
        matrix[2, :2], matrix[2, 2] = arm * na, inertia
        matrix[3, :2], matrix[3, 3] = centre * nb, own
        right = np.concatenate((-arm * wa**2 * ea - centre * wb**2 * eb, [-torque, torque]))
        solved = np.linalg.solve(matrix, right)
        return [wa, wb, solved[2], solved[3]]

    end = solve_ivp(rates, (0.0, 1.5), [0.0, math.pi, 0.0, 0.0], rtol=1e-11, atol=1e-13).y[:, -1]
    chain.step(0.0, 1.5)
    assert chain["relative_angle"] > math.pi / 2.0
    np.testing.assert_allclose(absolute(chain), end, rtol=1e-7, atol=1e-9)
