"""One link of a planar chain as a body of its own: forces at its two ends in, motion of both ends out."""

from __future__ import annotations

import math

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.integrators import RK4_STABILITY_RADIUS, OdeComponent, ode_kernels
from ..core.kernels import DONE, OWN, kernel
from ..core.variables import input_, output, parameter

PINNED_POINT, FREE_POINT, PINNED_MOVES = OWN + 1, OWN + 2, OWN + 3  # statuses
LOADS = ("base_force_x", "base_force_y", "base_torque", "tip_force_x", "tip_force_y", "tip_torque")


class Pinned(Effect):
    """The base is held by a joint without friction: the link only turns. Forces on the base go into the joint."""

    explicit_only = True

    reaction_x = output("N", "force of the joint on the base along x", nominal=10.0, feedthrough=LOADS)
    reaction_y = output("N", "force of the joint on the base along y", nominal=10.0, feedthrough=LOADS)


class Gravity(Effect):
    """Weight, against y."""

    acceleration = parameter(9.81, "m/s2", "acceleration of gravity")


class PlanarLink(OdeComponent):
    """A rigid link in a plane, free or pinned; its angle from the downward vertical (from -y), positive from x to y.

        m xc'' = sum F_x,    m yc'' = sum F_y - m g,    n = (cos th, sin th)
        I th'' = (L - a) n·F_tip - a n·F_base + T_base + T_tip
        pinned:  (I + m a²) th'' = L n·F_tip - m g a sin th + T_base + T_tip

    Motion out, forces in: joints between links are massless components with a compliance, such as `CompliantJoint`. The
    interface then carries all of the joint's stiffness, sqrt(k (1/m_1 + 1/m_2)) in rad/s as it is seen at the two ends.
    """

    title = "Planar link"
    system = "two_axis_joint"
    start_inputs = ()
    default_stop = 10.0
    refusals = {
        PINNED_POINT: Refusal("a link without inertia about its joint", "a positive one", "Give inertia."),
        FREE_POINT: Refusal("a link without inertia about its centre of mass", "a positive one", "Give inertia."),
        PINNED_MOVES: Refusal(
            "a start velocity of ({start_velocity_x}, {start_velocity_y}) m/s at a pinned base",
            "none",
            "Leave it out, or the effect 'pinned'.",
        ),
    }

    pinned = Pinned
    gravity = Gravity

    mass = parameter(1.0, "kg", "mass of the link", low=1e-12)
    length = parameter(1.0, "m", "distance of the tip from the base", low=0.0)
    centre = parameter(0.5, "m", "distance of the centre of mass from the base, along the link")
    inertia = parameter(1.0 / 12.0, "kg.m2", "moment of inertia about the centre of mass; a uniform rod's by default", low=0.0)
    start_x = parameter(0.0, "m", "place of the base at the start, horizontal; pinned: for good")
    start_y = parameter(0.0, "m", "place of the base at the start, upwards; pinned: for good")
    start_angle = parameter(0.0, "rad", "angle at the start")
    start_velocity_x = parameter(0.0, "m/s", "velocity of the base at the start along x; of a free link")
    start_velocity_y = parameter(0.0, "m/s", "velocity of the base at the start along y; of a free link")
    start_rate = parameter(0.0, "rad/s", "rate at the start")
    substep = parameter(1e-3, "s", "longest internal step", low=1e-9, high=1.0)

    base_force_x = input_(0.0, "N", "force on the base along x", nominal=10.0)
    base_force_y = input_(0.0, "N", "force on the base along y", nominal=10.0)
    base_torque = input_(0.0, "N.m", "torque on the link at the base", nominal=1.0)
    tip_force_x = input_(0.0, "N", "force on the tip along x", nominal=10.0)
    tip_force_y = input_(0.0, "N", "force on the tip along y", nominal=10.0)
    tip_torque = input_(0.0, "N.m", "torque on the link at the tip", nominal=1.0)

    base_x = output("m", "place of the base, horizontal")
    base_y = output("m", "place of the base, upwards")
    base_velocity_x = output("m/s", "velocity of the base along x", nominal=3.0)
    base_velocity_y = output("m/s", "velocity of the base along y", nominal=3.0)
    tip_x = output("m", "place of the tip, horizontal")
    tip_y = output("m", "place of the tip, upwards")
    tip_velocity_x = output("m/s", "velocity of the tip along x", nominal=3.0)
    tip_velocity_y = output("m/s", "velocity of the tip along y", nominal=3.0)
    angle = output("rad", "angle of the link")
    rate = output("rad/s", "rate of the link", nominal=3.0)
    mechanical_energy = output("J", "kinetic energy, and height above the origin where there is gravity", nominal=10.0)

    def states(self) -> int:
        """Angle, rate and, of a free link, place and velocity of the centre of mass."""
        return 2 if "pinned" in self.on else 6

    def energy(self) -> float:
        """Kinetic energy, J, and with gravity that of the height above the origin."""
        return float(link_energy(self.x, *self.arguments[1:]))


IN = PlanarLink.input_places()
OUT = PlanarLink.output_places()


@kernel
def link_start(t, s, p, e):
    """The pose and rates given."""
    x = s.x
    x[0], x[1] = p.start_angle, p.start_rate
    if e.pinned is not None:
        if p.inertia + p.mass * p.centre * p.centre == 0.0:
            return PINNED_POINT
        if p.start_velocity_x != 0.0 or p.start_velocity_y != 0.0:
            return PINNED_MOVES
    else:
        if p.inertia == 0.0:
            return FREE_POINT
        sine, cosine = math.sin(p.start_angle), math.cos(p.start_angle)
        x[2], x[3] = p.start_x + p.centre * sine, p.start_y - p.centre * cosine
        x[4] = p.start_velocity_x + p.centre * cosine * p.start_rate
        x[5] = p.start_velocity_y + p.centre * sine * p.start_rate
    return DONE


@kernel
def link_stable(t, s, p, e):
    """RK4's limit, radius / frequency for the hanging pinned link, s; a free one has no frequency of its own."""
    if e.pinned is None or e.gravity is None:
        return math.inf
    inertia = p.inertia + p.mass * p.centre * p.centre
    moment = abs(p.mass * e.gravity.acceleration * p.centre)
    return RK4_STABILITY_RADIUS * math.sqrt(inertia / moment) if moment > 0.0 else math.inf


@kernel
def link_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (angle, rate[, x, y, x', y' of the centre of mass])."""
    sine, cosine = math.sin(x[0]), math.cos(x[0])
    torque = u[IN.base_torque] + u[IN.tip_torque]
    dx[0] = x[1]
    if e.pinned is not None:
        torque += p.length * (cosine * u[IN.tip_force_x] + sine * u[IN.tip_force_y])
        if e.gravity is not None:
            torque -= p.mass * e.gravity.acceleration * p.centre * sine
        dx[1] = torque / (p.inertia + p.mass * p.centre * p.centre)
    else:
        torque += (p.length - p.centre) * (cosine * u[IN.tip_force_x] + sine * u[IN.tip_force_y]) - p.centre * (
            cosine * u[IN.base_force_x] + sine * u[IN.base_force_y]
        )
        dx[1] = torque / p.inertia
        dx[2], dx[3] = x[4], x[5]
        dx[4], dx[5] = (u[IN.base_force_x] + u[IN.tip_force_x]) / p.mass, (u[IN.base_force_y] + u[IN.tip_force_y]) / p.mass
        if e.gravity is not None:
            dx[5] -= e.gravity.acceleration


@kernel
def link_energy(x, p, e):
    """Kinetic energy, and with gravity that of the height above the origin, J."""
    if e.pinned is not None:
        energy = 0.5 * (p.inertia + p.mass * p.centre * p.centre) * x[1] * x[1]
        height = p.start_y - p.centre * math.cos(x[0])
    else:
        energy = 0.5 * (p.inertia * x[1] * x[1] + p.mass * (x[4] * x[4] + x[5] * x[5]))
        height = x[3]
    if e.gravity is not None:
        energy += p.mass * e.gravity.acceleration * height
    return energy


@kernel
def link_outputs(t, s, p, e):
    """Motion of both ends, angle, rate and energy; pinned: the joint's force."""
    x, u, y = s.x, s.u[0], s.y
    sine, cosine = math.sin(x[0]), math.cos(x[0])
    if e.pinned is not None:
        y[OUT.base_x], y[OUT.base_y], y[OUT.base_velocity_x], y[OUT.base_velocity_y] = p.start_x, p.start_y, 0.0, 0.0
    else:
        y[OUT.base_x], y[OUT.base_y] = x[2] - p.centre * sine, x[3] + p.centre * cosine
        y[OUT.base_velocity_x], y[OUT.base_velocity_y] = x[4] - p.centre * cosine * x[1], x[5] - p.centre * sine * x[1]
    y[OUT.tip_x], y[OUT.tip_y] = y[OUT.base_x] + p.length * sine, y[OUT.base_y] - p.length * cosine
    y[OUT.tip_velocity_x], y[OUT.tip_velocity_y] = (
        y[OUT.base_velocity_x] + p.length * cosine * x[1],
        y[OUT.base_velocity_y] + p.length * sine * x[1],
    )
    y[OUT.angle], y[OUT.rate] = x[0], x[1]
    y[OUT.mechanical_energy] = link_energy(x, p, e)
    if e.pinned is not None:
        torque = u[IN.base_torque] + u[IN.tip_torque] + p.length * (cosine * u[IN.tip_force_x] + sine * u[IN.tip_force_y])
        weight = p.mass * e.gravity.acceleration if e.gravity is not None else 0.0
        acceleration = (torque - weight * p.centre * sine) / (p.inertia + p.mass * p.centre * p.centre)
        turning = x[1] * x[1]
        y[e.pinned.y] = p.mass * p.centre * (acceleration * cosine - turning * sine) - u[IN.base_force_x] - u[IN.tip_force_x]
        y[e.pinned.y + 1] = (
            p.mass * p.centre * (acceleration * sine + turning * cosine) + weight - u[IN.base_force_y] - u[IN.tip_force_y]
        )
    return DONE


PlanarLink.kernels = ode_kernels(
    __name__, start=link_start, derivatives=link_derivatives, outputs=link_outputs, stable=link_stable
)
