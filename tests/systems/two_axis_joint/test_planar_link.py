"""Planar link and compliant joint: free flight, pendulum, work of the ends, and a chain put together of them."""

import math

import numpy as np
import pytest
from cosimo.components.two_axis_joint.chain import TwoLinkChain
from cosimo.components.two_axis_joint.compliant_joint import CompliantJoint
from cosimo.components.two_axis_joint.link import LOADS, PlanarLink, link_derivatives
from cosimo.tests.support import initialized
from cosimo.tests.systems.energy import energy_rate
from cosimo.tests.systems.two_axis_joint.exact_motions import pendulum_motion
from scipy.integrate import solve_ivp

pytestmark = pytest.mark.interpreted

G = 9.81
ROD = {"mass": 0.8, "length": 1.2, "centre": 0.5, "inertia": 0.09}


def started(effects=(), **parameters) -> PlanarLink:
    return initialized(PlanarLink(effects, parameters))


@pytest.mark.known_answers(PlanarLink="gravity")
def test_a_thrown_link_flies_along_a_parabola_and_turns_evenly():
    link = started(
        ("gravity",), **ROD, start_x=0.1, start_y=2.0, start_angle=0.4, start_velocity_x=1.0, start_velocity_y=3.0, start_rate=6.0
    )
    assert (link["base_x"], link["base_y"]) == pytest.approx((0.1, 2.0), rel=1e-15)
    assert (link["base_velocity_x"], link["base_velocity_y"]) == pytest.approx((1.0, 3.0), rel=1e-14)
    link.step(0.0, 0.9)
    centre = [
        0.1 + 0.5 * math.sin(0.4) + (1.0 + 0.5 * math.cos(0.4) * 6.0) * 0.9,
        2.0 - 0.5 * math.cos(0.4) + (3.0 + 0.5 * math.sin(0.4) * 6.0) * 0.9 - 0.5 * G * 0.81,
    ]
    angle = 0.4 + 6.0 * 0.9
    along = np.array([math.sin(angle), -math.cos(angle)])
    assert link["angle"] == pytest.approx(angle, rel=1e-12)
    assert [link["base_x"], link["base_y"]] == pytest.approx(centre - 0.5 * along, rel=1e-12)
    assert [link["tip_x"], link["tip_y"]] == pytest.approx(centre + 0.7 * along, rel=1e-12)


@pytest.mark.known_answers(PlanarLink="pinned")
@pytest.mark.parametrize("amplitude", [0.3, 2.5])
def test_a_pinned_link_is_a_pendulum(amplitude):
    link = started(("pinned", "gravity"), **ROD, start_angle=amplitude)
    frequency = math.sqrt(0.8 * G * 0.5 / (0.09 + 0.8 * 0.25))
    for t in (0.5, 3.0):
        link.step(link.t, t - link.t)
        angle, rate = pendulum_motion(frequency, amplitude, t)
        assert (link["angle"], link["rate"]) == pytest.approx((angle, rate), abs=1e-9)


def random_link(effects, random) -> PlanarLink:
    link = started(effects, **ROD)
    link.x[:], link.u[0] = random.uniform(-2.0, 2.0, link.x.size), random.uniform(-5.0, 5.0, len(LOADS))
    link.refresh()
    return link


@pytest.mark.parametrize("effects", [(), ("gravity",), ("pinned",), ("pinned", "gravity")])
def test_energy_grows_by_the_work_at_the_ends(effects):
    """d(energy)/dt along the equations of motion = forces times velocities and torques times rate, at random states."""
    random = np.random.default_rng(2)
    for _ in range(10):
        link = random_link(effects, random)
        power = sum(link[f"{end}_force_{a}"] * link[f"{end}_velocity_{a}"] for end in ("base", "tip") for a in "xy")
        power += (link["base_torque"] + link["tip_torque"]) * link["rate"]
        assert energy_rate(link, link_derivatives)[0] == pytest.approx(power, abs=1e-6)


def test_the_pin_s_reaction_moves_a_free_link_as_the_pin_does():
    """Newton and Euler for the free body with the reaction at its base: the same acceleration, and a base that stays."""
    random = np.random.default_rng(3)
    for _ in range(10):
        pinned = random_link(("pinned", "gravity"), random)
        angle, rate = pinned["angle"], pinned["rate"]
        free = started(("gravity",), **ROD, start_angle=angle, start_rate=rate)
        free.u[0] = pinned.u[0]
        free.u[0, :2] += [pinned["pinned.reaction_x"], pinned["pinned.reaction_y"]]
        dx, free_dx = np.empty(2), np.empty(6)
        link_derivatives(0.0, pinned.x, pinned.u[0], dx, *pinned.arguments)
        link_derivatives(0.0, free.x, free.u[0], free_dx, *free.arguments)
        assert free_dx[1] == pytest.approx(dx[1], abs=1e-11)
        centre = 0.5 * (
            dx[1] * np.array([math.cos(angle), math.sin(angle)]) + rate**2 * np.array([-math.sin(angle), math.cos(angle)])
        )
        np.testing.assert_allclose(free_dx[4:], centre, atol=1e-11)


def joint_at(random, effects=()) -> CompliantJoint:
    joint = CompliantJoint(effects)
    joint.initialize(0.0)
    joint.u[0] = random.uniform(-1.0, 1.0, len(joint.inputs))
    joint.refresh()
    return joint


@pytest.mark.known_answers(CompliantJoint="rotation")
@pytest.mark.parametrize("effects", [(), ("rotation",), ("clearance",)])
def test_a_compliant_joint_gives_back_what_it_takes_less_its_losses(effects):
    """Forces of both ends cancel; power put into the ends = -d(spring energy)/dt - losses, and the losses are never negative."""
    random = np.random.default_rng(4)
    for _ in range(10):
        joint = joint_at(random, effects)
        v = {f"{e}_{a}": joint[f"{e}_velocity_{a}"] for e in ("first", "second") for a in "xy"}
        power = sum(joint[f"{e}_force_{a}"] * v[f"{e}_{a}"] for e in ("first", "second") for a in "xy")
        assert [joint["first_force_x"], joint["first_force_y"]] == [-joint["second_force_x"], -joint["second_force_y"]]
        losses = 100.0 * ((v["second_x"] - v["first_x"]) ** 2 + (v["second_y"] - v["first_y"]) ** 2)
        if "clearance" in effects:
            losses *= 1.0 - 1e-4 / joint["opening"]
        if "rotation" in effects:
            first, second = joint["rotation.first_rate"], joint["rotation.second_rate"]
            power += joint["rotation.first_torque"] * first + joint["rotation.second_torque"] * second
            losses += 0.05 * (second - first) ** 2 - joint["rotation.motor_torque"] * (second - first)
        h, energies = 1e-7, []
        for sign in (1.0, -1.0):
            moved = joint.u[0].copy()
            joint.u[0, [0, 1, 4, 5]] += sign * h * joint.u[0, [2, 3, 6, 7]]
            energies.append(joint.energy())
            joint.u[0] = moved
        assert (energies[0] - energies[1]) / (2.0 * h) == pytest.approx(-power - losses, rel=1e-6, abs=1e-2)


@pytest.mark.known_answers(CompliantJoint="clearance")
def test_a_joint_with_play_is_free_inside_it():
    joint = CompliantJoint(("clearance",), {"clearance.radius": 1e-3})
    joint.initialize(0.0)
    joint.set("second_x", 0.6e-3)
    joint.set("second_y", 0.7e-3)
    joint.set("second_velocity_x", 1.0)
    joint.refresh()
    assert (joint["first_force_x"], joint["first_force_y"], joint.energy()) == (0.0, 0.0, 0.0)
    joint.set("second_y", 1.1e-3)
    joint.set("second_velocity_x", 0.0)
    joint.refresh()
    opening = math.hypot(0.6e-3, 1.1e-3)
    assert math.hypot(joint["first_force_x"], joint["first_force_y"]) == pytest.approx(1e5 * (opening - 1e-3), rel=1e-12)
    assert joint.energy() == pytest.approx(0.5e5 * (opening - 1e-3) ** 2, rel=1e-12)


def split_chain(stiffness: float, end: float) -> np.ndarray:
    """(th1, th2, w1, w2) of a pinned link, a joint and a free link, all three integrated as one system of equations."""
    damping = 2.0 * 0.5 * math.sqrt(0.2 * stiffness)  # about half of critical for what the ends see of the masses
    first = started(("pinned", "gravity"), **ROD, start_angle=0.8)
    tip = 1.2 * np.array([math.sin(0.8), -math.cos(0.8)])
    second = started(("gravity",), **ROD, start_angle=-0.3, start_x=tip[0], start_y=tip[1])
    joint = CompliantJoint((), {"stiffness": stiffness, "damping": damping})
    joint.initialize(0.0)
    dx = np.empty(8)

    def right(t, x):
        first.x[:], second.x[:] = x[:2], x[2:]
        first.refresh()
        second.refresh()
        for name, link, end in (("first", first, "tip"), ("second", second, "base")):
            for a in "xy":
                joint.set(f"{name}_{a}", link[f"{end}_{a}"])
                joint.set(f"{name}_velocity_{a}", link[f"{end}_velocity_{a}"])
        joint.refresh()
        for name, link, end in (("first", first, "tip"), ("second", second, "base")):
            for a in "xy":
                link.set(f"{end}_force_{a}", joint[f"{name}_force_{a}"])
        link_derivatives(t, first.x, first.u[0], dx[:2], *first.arguments)
        link_derivatives(t, second.x, second.u[0], dx[2:], *second.arguments)
        return dx.copy()

    x = solve_ivp(right, (0.0, end), [*first.x, *second.x], method="LSODA", rtol=1e-9, atol=1e-11).y[:, -1]
    return x[[0, 2, 1, 3]]


def test_two_links_on_a_stiff_joint_tend_to_the_rigid_chain():
    """The difference falls as 1 / stiffness: what the joint gives, is force over stiffness."""
    chain = TwoLinkChain(
        ("gravity",),
        {
            "first_mass": 0.8,
            "first_length": 1.2,
            "first_centre": 0.5,
            "first_inertia": 0.09,
            "second_mass": 0.8,
            "second_length": 1.2,
            "second_centre": 0.5,
            "second_inertia": 0.09,
            "start_first_angle": 0.8,
            "start_second_angle": -0.3,
        },
    )
    chain.initialize(0.0)
    chain.step(0.0, 0.7)
    errors = [np.abs(split_chain(k, 0.7) - chain.y[:4]).max() for k in (2e4, 2e5)]
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.05)  # the next order is that of 1 / sqrt(stiffness)
    assert errors[1] < 1e-3
