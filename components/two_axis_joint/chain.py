"""Two links in a plane, one behind the other: a double pendulum, or without gravity a horizontal manipulator."""

from __future__ import annotations

import math
from typing import Any

from ..core import high_order
from ..core.component import Effect, Preset
from ..core.contract import Refusal
from ..core.events import EventComponent
from ..core.friction import stick_mode
from ..core.kernels import DONE, OWN, kernel
from ..core.spectrum import spectral_radius, step_within
from ..core.variables import count, flag, input_, output, parameter
from .chain_equations import chain_derivatives, chain_energy, chain_guards, chain_switch, mass_matrix, motion, static_level

WITHOUT_INERTIA, STOPS_CROSSED, START_BEYOND_STOP, LATCH_TURNS = OWN + 1, OWN + 2, OWN + 3, OWN + 4  # statuses


class Gravity(Effect):
    """Weight, against y: the chain hangs. Without it the plane is horizontal."""

    acceleration = parameter(9.81, "m/s2", "acceleration of gravity")


class Viscous(Effect):
    """Damping in the joints in proportion to their rates; the second joint's rate is that of the links against each other."""

    first = parameter(0.1, "N.m.s/rad", "damping of the first joint", low=0.0)
    second = parameter(0.05, "N.m.s/rad", "damping of the second joint", low=0.0)


class Springs(Effect):
    """Torsion springs in the joints, stiffness * (angle - rest); the second one's angle is that of the links against each other.

    A rest beyond the stops is a preload: such a spring swings a satellite's panel out and holds it against its stop.
    """

    explicit_only = True

    first_stiffness = parameter(0.0, "N.m/rad", "stiffness of the first joint's spring", low=0.0)
    second_stiffness = parameter(0.25, "N.m/rad", "stiffness of the second joint's spring", low=0.0)
    first_rest = parameter(0.0, "rad", "angle of the first link at which its spring is relaxed")
    second_rest = parameter(0.0, "rad", "angle of the second link against the first at which its spring is relaxed")


class SmoothedFriction(Effect):
    """Dry friction as level * tanh(rate / width): quick, but a joint under load creeps instead of standing."""

    excludes = ("lugre_friction", "stick_friction")

    first_level = parameter(0.1, "N.m", "friction torque of the first joint", low=0.0)
    second_level = parameter(0.1, "N.m", "friction torque of the second joint", low=0.0)
    width = parameter(0.01, "rad/s", "rate at which the friction has 76 % of its level", low=1e-9)


class LuGreFriction(Effect):
    """Dry friction by bristles (Canudas de Wit and others, 1995): joints stand on a stiff spring and break loose."""

    excludes = ("smoothed_friction", "stick_friction")

    first_level = parameter(0.1, "N.m", "kinetic friction torque of the first joint", low=0.0)
    second_level = parameter(0.1, "N.m", "kinetic friction torque of the second joint", low=0.0)
    static_ratio = parameter(1.5, "1", "static over kinetic friction", low=1.0)
    stribeck_rate = parameter(0.01, "rad/s", "rate over which static falls to kinetic friction", low=1e-9)
    stiffness = parameter(1000.0, "N.m/rad", "stiffness of the bristles", low=0.0)
    damping = parameter(2.0, "N.m.s/rad", "damping of the bristles", low=0.0)


class StickFriction(Effect):
    """Dry friction with exact standstill: a joint at rest stays there to the last bit until the static level is reached."""

    excludes = ("smoothed_friction", "lugre_friction")

    first_level = parameter(0.1, "N.m", "kinetic friction torque of the first joint", low=0.0)
    second_level = parameter(0.1, "N.m", "kinetic friction torque of the second joint", low=0.0)
    static_ratio = parameter(1.0, "1", "static over kinetic friction", low=1.0)

    first_stuck = flag("1 while the first joint stands, 0 while it turns")
    second_stuck = flag("1 while the second joint stands, 0 while it turns")


class Stops(Effect):
    """Elastic stops of the second joint, stiffness * depth * (1 + dissipation * rate of the depth), never pulling."""

    lower = parameter(-math.pi / 2.0, "rad", "lower stop of the second link's angle against the first")
    upper = parameter(math.pi / 2.0, "rad", "upper stop of the second link's angle against the first")
    stiffness = parameter(1000.0, "N.m/rad", "stiffness of the stops", low=0.0)
    dissipation = parameter(0.1, "s/rad", "losses of the stops; about 3 (1 - restitution) / (2 rate of the impact)", low=0.0)


class Latch(Effect):
    """A rigid end of the second joint's way, by impact: the rate jumps to -restitution * rate, and the moment of momentum about the
    first joint goes on. What arrives slower than the capture rate is caught and held from then on, as a deployed panel is.
    """

    explicit_only = True
    excludes = ("stops",)

    angle = parameter(math.pi / 2.0, "rad", "angle of the second link against the first at which the end is")
    restitution = parameter(0.3, "1", "rate after an impact over that before", low=0.0, high=0.99)
    capture_rate = parameter(0.05, "rad/s", "rate up to which the link is caught", low=1e-6)

    latched = flag("1 while the second link is caught")
    impacts = count("number of impacts so far")


TORQUES = ("first_torque", "second_torque")


class Reactions(Effect):
    """Loads of the joints by Newton's and Euler's equations: of the ground on the first link, of the first on the second."""

    explicit_only = True

    first_x = output("N", "force of the ground on the first link along x", nominal=10.0, feedthrough=TORQUES)
    first_y = output("N", "force of the ground on the first link along y", nominal=10.0, feedthrough=TORQUES)
    first_moment = output("N.m", "torque of the ground on the first link, motor and losses together", feedthrough=TORQUES)
    second_x = output("N", "force of the first link on the second along x", nominal=10.0, feedthrough=TORQUES)
    second_y = output("N", "force of the first link on the second along y", nominal=10.0, feedthrough=TORQUES)
    second_moment = output("N.m", "torque of the first link on the second, motor and losses together", feedthrough=TORQUES)


class HighOrder(high_order.HighOrder):
    """Internal steps of order eight: what has kinks or events is excluded."""

    excludes = ("lugre_friction", "stick_friction", "stops", "latch")


class TwoLinkChain(high_order.SmoothComponent, EventComponent):
    """Two rigid links in a plane with rotary joints; angles from the downward vertical (from -y), positive from x to y.

        M a + h + D w + G = (T1 - T2, T2),   a, w: accelerations and rates of the absolute angles th1, th2
        M = [[I1 + m1 a1² + m2 l1², m2 l1 a2 cos(th1 - th2)], [.., I2 + m2 a2²]]
        h = m2 l1 a2 sin(th1 - th2) (w2², -w1²),    D = [[d1 + d2, -d2], [-d2, d2]]
        G = g ((m1 a1 + m2 l1) sin th1, m2 a2 sin th2)

    I is about the centre of mass, a its distance from the joint before. The motor T2 acts on the second link and back on the
    first; its rate, for the power, is `relative_rate`. The double pendulum is chaotic: from a high start two runs that differ
    in rounding part after some seconds, and what remains comparable is energy and angular momentum.
    The equations are classical. Akulenko, Bolotnik, Leshchenko, Palii (2020) treat a body on a two-axis joint with damping; of
    that paper only the abstract was at hand, and no number here is from it. Numbers of friction and stops are a choice of ours.
    """

    title = "Two-link chain"
    system = "two_axis_joint"
    default_stop = 10.0
    start_inputs = ("first_torque", "second_torque")  # they decide whether a joint sticks
    refusals = {
        WITHOUT_INERTIA: Refusal(
            "links without inertia: the mass matrix of the stretched chain is singular",
            "a mass or an inertia at both links that does not vanish",
            "Give first_inertia, or second_inertia, or a first_mass away from the joint.",
        ),
        STOPS_CROSSED: Refusal(
            "stops.lower = {stops.lower}, stops.upper = {stops.upper} rad", "a lower stop below the upper one"
        ),
        START_BEYOND_STOP: Refusal(
            "the second link at {x[1]} rad against the first at the start",
            "an angle between its stops, {stops.lower} and {stops.upper} rad",
        ),
        LATCH_TURNS: Refusal(
            "a second link that turns against the first at {x[3]} rad/s while the latch at {latch.angle} rad holds it",
            "no rate between them at this angle",
        ),
    }

    gravity = Gravity
    viscous = Viscous
    springs = Springs
    smoothed_friction = SmoothedFriction
    lugre_friction = LuGreFriction
    stick_friction = StickFriction
    stops = Stops
    latch = Latch
    reactions = Reactions
    high_order = HighOrder

    first_mass = parameter(1.0, "kg", "mass of the first link", low=0.0)
    first_length = parameter(1.0, "m", "distance of the second joint from the first", low=1e-9)
    first_centre = parameter(1.0, "m", "distance of the first link's centre of mass from the first joint", low=0.0)
    first_inertia = parameter(0.0, "kg.m2", "moment of inertia of the first link about its centre of mass", low=0.0)
    second_mass = parameter(1.0, "kg", "mass of the second link", low=0.0)
    second_length = parameter(1.0, "m", "distance of the tip from the second joint", low=1e-9)
    second_centre = parameter(1.0, "m", "distance of the second link's centre of mass from the second joint", low=0.0)
    second_inertia = parameter(0.0, "kg.m2", "moment of inertia of the second link about its centre of mass", low=0.0)
    start_first_angle = parameter(0.0, "rad", "first link's angle at the start")
    start_second_angle = parameter(0.0, "rad", "second link's angle at the start, absolute as the first one's")
    start_first_rate = parameter(0.0, "rad/s", "first link's rate at the start")
    start_second_rate = parameter(0.0, "rad/s", "second link's rate at the start, absolute")
    substep = parameter(1e-3, "s", "longest internal step", low=1e-9, high=1.0)

    first_torque = input_(0.0, "N.m", "motor torque in the first joint", nominal=1.0)
    second_torque = input_(0.0, "N.m", "motor torque in the second joint, on the second link", nominal=1.0)

    first_angle = output("rad", "angle of the first link")
    second_angle = output("rad", "angle of the second link, absolute")
    first_rate = output("rad/s", "rate of the first link, and of its joint", nominal=3.0)
    second_rate = output("rad/s", "rate of the second link, absolute", nominal=3.0)
    relative_angle = output("rad", "angle of the second link against the first")
    relative_rate = output("rad/s", "rate of the second joint", nominal=3.0)
    tip_x = output("m", "place of the tip, horizontal")
    tip_y = output("m", "place of the tip, upwards")
    tip_velocity_x = output("m/s", "velocity of the tip along x", nominal=3.0)
    tip_velocity_y = output("m/s", "velocity of the tip along y", nominal=3.0)
    angular_momentum = output("N.m.s", "angular momentum about the first joint", nominal=3.0)
    mechanical_energy = output(
        "J", "kinetic energy, height above the hanging chain, bending of springs, bristles and stops", nominal=10.0
    )

    presets = {
        "equal point masses": Preset(
            {"first_mass": 1.0, "second_mass": 1.0, "first_length": 1.0, "second_length": 1.0, "first_centre": 1.0,
             "second_centre": 1.0, "first_inertia": 0.0, "second_inertia": 0.0},
            "textbook double pendulum of equal masses and lengths, here 1 kg and 1 m", "computed", ("gravity",)),
        "equal rods": Preset(
            {"first_mass": 1.0, "second_mass": 1.0, "first_length": 1.0, "second_length": 1.0, "first_centre": 0.5,
             "second_centre": 0.5, "first_inertia": 1.0 / 12.0, "second_inertia": 1.0 / 12.0},
            "textbook double pendulum of uniform rods, here 1 kg and 1 m", "computed", ("gravity",)),
        "proportional damping": Preset(
            {"first_mass": 1.0, "second_mass": 1.0, "first_length": 1.0, "second_length": 1.0, "first_centre": 1.0,
             "second_centre": 1.0, "first_inertia": 0.0, "second_inertia": 0.0, "viscous.first": 0.05, "viscous.second": 0.05},
            "equal point masses with equal joint dampers: D = d (2 K / g - M), whose small motion has an exact solution",
            "computed", ("gravity", "viscous")),
        "laboratory arm": Preset(
            {"first_mass": 23.9, "first_length": 0.45, "first_centre": 0.091, "first_inertia": 1.27, "second_mass": 3.88,
             "second_length": 0.45, "second_centre": 0.048, "second_inertia": 0.093, "viscous.first": 2.29,
             "viscous.second": 0.175, "stick_friction.first_level": 7.2, "stick_friction.second_level": 1.7},
            "a two-link arm that many papers on control take, its parameters from memory; length of the second link chosen",
            "unconfirmed", ("gravity", "viscous", "stick_friction")),
        "satellite panel": Preset(
            {"first_mass": 0.0, "first_inertia": 10.0, "first_centre": 0.0, "first_length": 0.5,
             "second_mass": 500.0 / 105.0, "second_length": 0.8, "second_centre": 0.4, "second_inertia": 5.0 * 0.64 / 12.0,
             "springs.second_stiffness": 0.25, "springs.second_rest": 0.0, "viscous.second": 1.2, "viscous.first": 0.0,
             "stick_friction.second_level": 0.08, "stick_friction.first_level": 0.0, "start_second_angle": math.pi,
             "stops.lower": math.pi / 2.0, "stops.upper": math.pi + 0.01},
            "numbers of ours: a free hub of 100 kg and 10 kg.m2, panel of 5 kg and 0.8 m, hinged 0.5 m from the hub's centre; "
            "the second mass is that of both bodies in series, with which free bodies move as these links do", "inferred",
            ("springs", "viscous", "stick_friction", "stops")),
    }  # fmt: skip

    @property
    def guards_count(self) -> int:  # type: ignore[override]
        """Of both joints and the stops, where one of them has events."""
        return 3 if {"stick_friction", "stops", "latch"} & set(self.on) else 0

    def states(self) -> int:
        """(q1, q2, q1', q2'), bristles or modes of both joints, and which stop is touched, or impacts and the latch."""
        return (
            4
            + (2 if {"lugre_friction", "stick_friction"} & set(self.on) else 0)
            + ("stops" in self.on)
            + 2 * ("latch" in self.on)
        )

    def shapes(self) -> dict[str, Any]:
        """`matrix`: of the linear equations, and workspace."""
        return super().shapes() | {"matrix": (2, 4, 4)}

    def energy(self) -> float:
        """The output `mechanical_energy`, J."""
        _, p, e = self.arguments
        return float(chain_energy(self.x, p, e))


OUT = TwoLinkChain.output_places()


@kernel
def chain_start(t, s, p, e):
    """(q1, q2, q1', q2') as given, bristles without load; joints at rest stay so where friction holds them."""
    x = s.x
    m11, _, m22, stretched = mass_matrix(0.0, p)
    if stretched <= 1e-12 * m11 * m22:  # also both zero
        return WITHOUT_INERTIA
    x[0], x[1] = p.start_first_angle, p.start_second_angle - p.start_first_angle
    x[2], x[3] = p.start_first_rate, p.start_second_rate - p.start_first_rate
    if e.stops is not None:
        if not e.stops.lower < e.stops.upper:
            return STOPS_CROSSED
        if not e.stops.lower <= x[1] <= e.stops.upper:
            return START_BEYOND_STOP
        if x[1] == e.stops.upper:
            x[-1] = 1.0
        elif x[1] == e.stops.lower:
            x[-1] = -1.0
    if e.latch is not None:
        x[-1] = 0.0 if x[1] == e.latch.angle else math.copysign(1.0, e.latch.angle - x[1])
        if x[-1] == 0.0 and x[3] != 0.0:
            return LATCH_TURNS
    if e.stick_friction is not None:
        g = s.guards
        x[4] = stick_mode(x[2], 0.0, static_level(e.stick_friction.first_level, e.stick_friction))
        x[5] = stick_mode(x[3], 0.0, static_level(e.stick_friction.second_level, e.stick_friction))
        for _ in range(4):  # of two joints at rest none, one or both break loose at once
            chain_guards(t, x, s.u[0], g, s, p, e)
            which = 0
            for i in range(1, g.size):
                if g[i] < g[which]:
                    which = i
            if g[which] >= 0.0:
                break
            chain_switch(which, t, x, s.u[0], s, p, e)
    return DONE


@kernel
def chain_outputs(t, s, p, e):
    """Angles and rates, the tip, angular momentum and energy, and the outputs of effects."""
    x, u, y = s.x, s.u[0], s.y
    second, rate = x[0] + x[1], x[2] + x[3]
    s1, c1, s2, c2 = math.sin(x[0]), math.cos(x[0]), math.sin(second), math.cos(second)
    y[OUT.first_angle], y[OUT.second_angle], y[OUT.first_rate], y[OUT.second_rate] = x[0], second, x[2], rate
    y[OUT.relative_angle], y[OUT.relative_rate] = x[1], x[3]
    y[OUT.tip_x] = p.first_length * s1 + p.second_length * s2
    y[OUT.tip_y] = -p.first_length * c1 - p.second_length * c2
    y[OUT.tip_velocity_x] = p.first_length * c1 * x[2] + p.second_length * c2 * rate
    y[OUT.tip_velocity_y] = p.first_length * s1 * x[2] + p.second_length * s2 * rate
    m11, m12, _, _ = mass_matrix(x[1], p)
    y[OUT.angular_momentum] = m11 * x[2] + m12 * x[3]
    y[OUT.mechanical_energy] = chain_energy(x, p, e)
    if e.stick_friction is not None:
        y[e.stick_friction.y] = 1.0 if x[4] == 0.0 else 0.0
        y[e.stick_friction.y + 1] = 1.0 if x[5] == 0.0 else 0.0
    if e.latch is not None:
        y[e.latch.y], y[e.latch.y + 1] = 1.0 if x[-1] == 0.0 else 0.0, x[-2]
    if e.reactions is not None:
        a1, a2, _, _ = motion(x, u, p, e)
        a2 += a1
        weight = e.gravity.acceleration if e.gravity is not None else 0.0
        along1, up1 = a1 * c1 - x[2] * x[2] * s1, a1 * s1 + x[2] * x[2] * c1  # of a point at unit distance from the joint
        along2, up2 = a2 * c2 - rate * rate * s2, a2 * s2 + rate * rate * c2
        second_x = p.second_mass * (p.first_length * along1 + p.second_centre * along2)
        second_y = p.second_mass * (p.first_length * up1 + p.second_centre * up2 + weight)
        first_x = second_x + p.first_mass * p.first_centre * along1
        first_y = second_y + p.first_mass * (p.first_centre * up1 + weight)
        moment = p.second_inertia * a2 + p.second_centre * (second_x * c2 + second_y * s2)
        y[e.reactions.y], y[e.reactions.y + 1] = first_x, first_y
        y[e.reactions.y + 2] = (
            moment
            + p.first_inertia * a1
            + p.first_centre * (first_x * c1 + first_y * s1)
            + (p.first_length - p.first_centre) * (second_x * c1 + second_y * s1)
        )
        y[e.reactions.y + 3], y[e.reactions.y + 4], y[e.reactions.y + 5] = second_x, second_y, moment
    return DONE


@kernel
def chain_stable(t, s, p, e):
    """Limit, radius / max |eigenvalue| of the stretched chain, hanging or turning as fast as the start makes it, s.

    Motors may drive the chain to higher rates than that; a run that is too coarse then is seen by its energy.
    """
    m11, m12, m22, determinant = mass_matrix(0.0, p)
    g = abs(e.gravity.acceleration) if e.gravity is not None else 0.0
    second = p.second_mass * p.second_centre
    turning = max(p.start_first_rate * p.start_first_rate, p.start_second_rate * p.start_second_rate) + 4.0 * g / (
        p.first_length + p.second_length
    )
    k11, k12 = g * (p.first_mass * p.first_centre + p.second_mass * p.first_length + second), g * second
    k22 = k12 + second * p.first_length * turning
    c1, c2 = 0.0, 0.0
    if e.viscous is not None:
        c1, c2 = e.viscous.first, e.viscous.second
    if e.springs is not None:
        k11, k22 = k11 + e.springs.first_stiffness, k22 + e.springs.second_stiffness
    if e.smoothed_friction is not None:
        c1 += e.smoothed_friction.first_level / e.smoothed_friction.width
        c2 += e.smoothed_friction.second_level / e.smoothed_friction.width
    if e.lugre_friction is not None:
        k11, k22 = k11 + e.lugre_friction.stiffness, k22 + e.lugre_friction.stiffness
        c1, c2 = c1 + e.lugre_friction.damping, c2 + e.lugre_friction.damping
    if e.stops is not None:
        k22 += e.stops.stiffness
    w11, w12, w22 = m22 / determinant, -m12 / determinant, m11 / determinant  # inverse of the mass matrix
    A = s.matrix[0]
    A[:] = 0.0
    A[0, 2], A[1, 3] = 1.0, 1.0
    A[2, 0], A[2, 1], A[2, 2], A[2, 3] = -(w11 * k11 + w12 * k12), -(w11 * k12 + w12 * k22), -w11 * c1, -w12 * c2
    A[3, 0], A[3, 1], A[3, 2], A[3, 3] = -(w12 * k11 + w22 * k12), -(w12 * k12 + w22 * k22), -w12 * c1, -w22 * c2
    return step_within(high_order.stability_radius(e), spectral_radius(A, s.matrix[1]))


TwoLinkChain.kernels = high_order.smooth_event_kernels(
    __name__,
    start=chain_start,
    derivatives=chain_derivatives,
    outputs=chain_outputs,
    stable=chain_stable,
    guards=chain_guards,
    switch=chain_switch,
)
