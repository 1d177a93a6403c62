"""A body on two crossed axes: gimbal, pan and tilt head, universal joint."""

from __future__ import annotations

import math
from typing import Any

from ..core import high_order
from ..core.component import Effect, Preset
from ..core.contract import Refusal
from ..core.errors import StepFailed
from ..core.events import EventComponent
from ..core.friction import stick_mode, stick_switch
from ..core.kernels import DONE, NOT_FINITE, OWN, kernel
from ..core.spectrum import spectral_radius, step_within
from ..core.variables import choice, flag, input_, output, parameter
from .gimbal_equations import (
    ALPHA,
    BETA,
    CONTACT,
    INNER,
    OUTER,
    accelerations,
    axis_guard,
    body_rates,
    bristle_rates,
    drives,
    gimbal_energy,
    level_of_axis,
    outer_momentum,
    reactions_of_base,
)

GIMBAL_LOCK, OUTER_STOPS, INNER_STOPS = OWN + 1, OWN + 2, OWN + 3  # statuses
VANISHING = 1e-9  # least inertia about the outer axis over that about the inner one


class Gravity(Effect):
    """Weight of a body whose centre of mass is beside the crossing of the axes; it hangs at angles zero."""

    mass = parameter(2.0, "kg", "mass of the body", low=0.0)
    distance = parameter(0.15, "m", "distance of the centre of mass from the crossing of the axes, along body z", low=0.0)
    acceleration = parameter(9.81, "m/s2", "acceleration of gravity", low=0.0)


class Rotor(Effect):
    """A rotor of constant momentum about the body's axis, as in a gyroscope; it does no work."""

    explicit_only = True

    spin_momentum = parameter(0.5, "kg.m2/s", "momentum of the rotor about the body's axis, relative to the body")


class Viscous(Effect):
    """Viscous damping in both axes."""

    outer_coefficient = parameter(0.02, "N.m.s/rad", "damping of the outer axis", low=0.0)
    inner_coefficient = parameter(0.02, "N.m.s/rad", "damping of the inner axis", low=0.0)


class SmoothedFriction(Effect):
    """Dry friction as level * tanh(rate / width): cheap, and it creeps where real friction would stick."""

    excludes = ("lugre_friction", "stick_friction")
    outer_level = parameter(0.05, "N.m", "friction of the outer axis", low=0.0)
    inner_level = parameter(0.05, "N.m", "friction of the inner axis", low=0.0)
    width = parameter(0.01, "rad/s", "rate over which the friction changes sign", low=1e-9)


class LuGreFriction(Effect):
    """Dry friction by elastic bristles (LuGre); their fastest relaxation is held to one per substep."""

    excludes = ("smoothed_friction", "stick_friction")
    outer_level = parameter(0.05, "N.m", "kinetic friction of the outer axis", low=1e-9)
    inner_level = parameter(0.05, "N.m", "kinetic friction of the inner axis", low=1e-9)
    static_ratio = parameter(1.5, "1", "static over kinetic friction", low=1.0)
    stiffness = parameter(200.0, "N.m/rad", "stiffness of the bristles", low=0.0)
    damping = parameter(2.0, "N.m.s/rad", "damping of the bristles", low=0.0)
    stribeck_rate = parameter(0.01, "rad/s", "rate over which friction falls from static to kinetic", low=1e-9)


class StickFriction(Effect):
    """Dry friction with exact standstill: an axis at rest stays so until the static level is passed, found as an event."""

    excludes = ("smoothed_friction", "lugre_friction")
    outer_level = parameter(0.05, "N.m", "kinetic friction of the outer axis", low=0.0)
    inner_level = parameter(0.05, "N.m", "kinetic friction of the inner axis", low=0.0)
    static_ratio = parameter(1.0, "1", "static over kinetic friction", low=1.0)

    outer_stuck = flag("1 while the outer axis stands, 0 while it turns")
    inner_stuck = flag("1 while the inner axis stands, 0 while it turns")


class Stops(Effect):
    """Elastic stops with hysteresis: stiffness * depth * (1 + d * rate into the stop), never pulling.

    Source of the law: Hunt and Crossley, ASME Journal of Applied Mechanics 42 (1975) 440-445.
    """

    outer_lower = parameter(-2.9, "rad", "lower stop of the outer axis")
    outer_upper = parameter(2.9, "rad", "upper stop of the outer axis")
    inner_lower = parameter(-1.3, "rad", "lower stop of the inner axis")
    inner_upper = parameter(1.3, "rad", "upper stop of the inner axis")
    stiffness = parameter(1000.0, "N.m/rad", "stiffness of a stop", low=0.0)
    dissipation = parameter(0.2, "s/rad", "d, growth of the torque with the rate into the stop", low=0.0)


class BaseMotion(Effect):
    """The base turns about the vertical, and its point under the crossing of the axes accelerates; off, it is at rest.

    Components in base axes, x and y horizontal, z down; these axes turn with the base.
    """

    requires = ("gravity",)
    rate = input_(0.0, "rad/s", "rate of the base about the vertical, from x to y")
    acceleration = input_(0.0, "rad/s2", "angular acceleration of the base about the vertical")
    acceleration_x = input_(0.0, "m/s2", "acceleration of the crossing of the axes along x")
    acceleration_y = input_(0.0, "m/s2", "acceleration of the crossing of the axes along y")
    acceleration_z = input_(0.0, "m/s2", "acceleration of the crossing of the axes along z, downwards")


class Payload(Effect):
    """A port in body axes for something that turns in or on the body: it gets the body's rates and gives a moment."""

    moment_x = input_(0.0, "N.m", "moment on the body about the body's x")
    moment_y = input_(0.0, "N.m", "moment on the body about the inner axis")
    moment_z = input_(0.0, "N.m", "moment on the body about the body's axis")

    rate_x = output("rad/s", "angular velocity of the body about its x", feedthrough=("base_motion.rate",))
    rate_y = output("rad/s", "angular velocity of the body about the inner axis", feedthrough=("base_motion.rate",))
    rate_z = output("rad/s", "angular velocity of the body about its axis", feedthrough=("base_motion.rate",))


_TORQUES = (
    "outer_torque",
    "inner_torque",
    *(f"payload.moment_{axis}" for axis in "xyz"),
    *(f"base_motion.{n}" for n in ("rate", "acceleration", "acceleration_x", "acceleration_y", "acceleration_z")),
)


class Reactions(Effect):
    """Force and moment of the base on the joint in base axes, by Newton's and Euler's laws; frame without weight."""

    explicit_only = True

    requires = ("gravity",)
    force_x = output("N", "force of the base on the joint along x", feedthrough=_TORQUES)
    force_y = output("N", "force of the base on the joint along y", feedthrough=_TORQUES)
    force_z = output("N", "force of the base on the joint along z, downwards", feedthrough=_TORQUES, nominal=10.0)
    moment_x = output("N.m", "moment of the base on the joint about x", feedthrough=_TORQUES)
    moment_y = output("N.m", "moment of the base on the joint about y", feedthrough=_TORQUES)
    moment_z = output("N.m", "moment of the base on the joint about z", feedthrough=_TORQUES)


class HighOrder(high_order.HighOrder):
    """Internal steps of order eight: what has kinks or events is excluded."""

    excludes = ("lugre_friction", "stick_friction", "stops")


class GimbalBody(high_order.SmoothComponent, EventComponent):
    """A rigid body on two crossed axes: the outer one, angle alpha, lies in the base, the inner one, angle beta, in a frame.

        outer axis vertical:    J alpha'' + (I_x - I_z) sin 2beta alpha' beta' = T_outer
                                I_y beta'' - (I_x - I_z) sin beta cos beta alpha'² = T_inner - m g l sin beta
                                J = J_o + I_x sin² beta + I_z cos² beta
        outer axis horizontal:  J alpha'' - (I_x - I_z) sin 2beta alpha' beta' = T_outer - m g l sin alpha cos beta
                                I_y beta'' + (I_x - I_z) sin beta cos beta alpha'² = T_inner - m g l cos alpha sin beta
                                J = J_o + I_x cos² beta + I_z sin² beta

    I_y: moment of inertia about the inner axis, I_z: about the body's axis, which hangs down at angles zero and carries the
    centre of mass and the rotor, I_x: about the third, all for the crossing of the axes; J_o: of the frame. A body on a joint of
    two degrees of freedom is the subject of Akulenko, Bolotnik, Leshchenko and Palii (2020), known to us by its abstract; the
    equations are Lagrange's, written here for this arrangement of the axes. Default numbers are a choice of ours.
    """

    title = "Body on two crossed axes"
    system = "two_axis_joint"
    default_stop = 5.0
    start_inputs = (  # they decide whether an axis sticks
        "outer_torque",
        "inner_torque",
        "base_motion.rate",
        "base_motion.acceleration",
        "base_motion.acceleration_x",
        "base_motion.acceleration_y",
        "base_motion.acceleration_z",
        "payload.moment_x",
        "payload.moment_y",
        "payload.moment_z",
    )
    refusals = {
        GIMBAL_LOCK: Refusal(
            "an inertia about the outer axis that falls to {inertias.least} kg.m2",
            "at least {inertias.allowed} kg.m2 at every inner angle",
            "Give the frame inertia: without it nothing resists turning about the body's own axis (gimbal lock).",
        ),
        OUTER_STOPS: Refusal("stops of the outer axis at {stops.outer_lower} and {stops.outer_upper} rad", "first the lower"),
        INNER_STOPS: Refusal("stops of the inner axis at {stops.inner_lower} and {stops.inner_upper} rad", "first the lower"),
    }

    gravity = Gravity
    rotor = Rotor
    viscous = Viscous
    smoothed_friction = SmoothedFriction
    lugre_friction = LuGreFriction
    stick_friction = StickFriction
    stops = Stops
    base_motion = BaseMotion
    payload = Payload
    reactions = Reactions
    high_order = HighOrder

    axis_orientation = choice("vertical", ("vertical", "horizontal"), "direction of the outer axis")
    frame_inertia = parameter(0.02, "kg.m2", "moment of inertia of the frame about the outer axis", low=0.0)
    cross_inertia = parameter(0.03, "kg.m2", "moment of inertia of the body about its x, across the other two", low=0.0)
    inner_inertia = parameter(0.05, "kg.m2", "moment of inertia of the body about the inner axis", low=1e-12)
    axial_inertia = parameter(0.06, "kg.m2", "moment of inertia of the body about its own axis", low=0.0)
    start_outer_angle = parameter(0.0, "rad", "angle of the outer axis at the start")
    start_inner_angle = parameter(0.5, "rad", "angle of the inner axis at the start")
    start_outer_rate = parameter(0.0, "rad/s", "rate of the outer axis at the start")
    start_inner_rate = parameter(0.0, "rad/s", "rate of the inner axis at the start")
    substep = parameter(1e-3, "s", "longest internal step", low=1e-9, high=1.0)

    outer_torque = input_(0.0, "N.m", "torque of the drive on the outer axis")
    inner_torque = input_(0.0, "N.m", "torque of the drive on the inner axis")

    outer_angle = output("rad", "angle of the outer axis")
    inner_angle = output("rad", "angle of the inner axis")
    outer_rate = output("rad/s", "rate of the outer axis")
    inner_rate = output("rad/s", "rate of the inner axis")
    outer_momentum = output("kg.m2/s", "angular momentum about the outer axis", nominal=0.1, feedthrough=("base_motion.rate",))
    mechanical_energy = output(
        "J", "kinetic energy, height above the hanging body, bending of bristles and stops", feedthrough=("base_motion.rate",)
    )

    presets = {
        "inertial motion": Preset(
            {"frame_inertia": 0.02, "inner_inertia": 0.05, "cross_inertia": 0.03, "axial_inertia": 0.06},
            "numbers of ours: the largest moment about the body's axis, so that it is stable in its turning",
            "inferred",
        ),
        "governor": Preset(
            {
                "frame_inertia": 0.02,
                "inner_inertia": 0.06,
                "cross_inertia": 0.06,
                "axial_inertia": 0.02,
                "gravity.mass": 2.0,
                "gravity.distance": 0.15,
                "start_inner_angle": 0.0,
            },
            "numbers of ours: a slender body that rises when it turns faster than 8.58 rad/s",
            "inferred",
            ("gravity",),
        ),
    }

    @property
    def guards_count(self) -> int:  # type: ignore[override]
        """One of each axis that can stick."""
        return 2 if "stick_friction" in self.on else 0

    def states(self) -> int:
        """Angles, rates, and the bristles or modes of both axes."""
        return 6 if {"lugre_friction", "stick_friction"} & set(self.on) else 4

    def shapes(self) -> dict[str, Any]:
        """`inertias`: see `Inertias`.  `matrix`: for the stable step."""
        return super().shapes() | {"inertias": Inertias, "matrix": (2, 4, 4)}

    def energy(self) -> float:
        """The output `mechanical_energy`, J."""
        _, p, e = self.arguments
        return gimbal_energy(self.x, self.u[0], p, e)

    def _check(self, status: int) -> None:
        if status == NOT_FINITE:
            raise StepFailed(
                self.name,
                self.t,
                "an axis turns by over a radian within a substep, or the state is not finite",
                "Reduce substep; where the inertia about the outer axis nearly vanishes, give the frame inertia",
            )
        super()._check(status)


OUT = GimbalBody.output_places()


class Inertias:
    """The record `s.inertias`, kg.m², about the outer axis."""

    least: float
    allowed: float  # the least of those


@kernel
def gimbal_start(t, s, p, e):
    """Angles and rates of the parameters, bristles relaxed; axes at rest stay so where friction holds them."""
    x = s.x
    s.inertias.least = p.frame_inertia + min(p.cross_inertia, p.axial_inertia)
    s.inertias.allowed = VANISHING * p.inner_inertia
    if s.inertias.least < s.inertias.allowed:
        return GIMBAL_LOCK
    if e.stops is not None:
        if not e.stops.outer_lower < e.stops.outer_upper:
            return OUTER_STOPS
        if not e.stops.inner_lower < e.stops.inner_upper:
            return INNER_STOPS
    x[ALPHA], x[BETA], x[OUTER], x[INNER] = p.start_outer_angle, p.start_inner_angle, p.start_outer_rate, p.start_inner_rate
    if e.stick_friction is not None:
        _, outer, inner = drives(x, s.u[0], p, e)
        x[CONTACT] = stick_mode(x[OUTER], outer, level_of_axis(0, e.stick_friction))
        x[CONTACT + 1] = stick_mode(x[INNER], inner, level_of_axis(1, e.stick_friction))
    return DONE


@kernel
def gimbal_stable(t, s, p, e):
    """Limit, radius / max |eigenvalue| at the start rates, with every spring engaged and the least inertia, s."""
    fastest = max(abs(p.start_outer_rate), abs(p.start_inner_rate))
    outer, inner = 0.0, abs(p.cross_inertia - p.axial_inertia) * fastest * fastest  # stiffness
    outer_damping, inner_damping, gyroscopic = 0.0, 0.0, 0.0
    if e.gravity is not None:
        weight = e.gravity.mass * e.gravity.acceleration * e.gravity.distance
        outer, inner = outer + weight, inner + weight
    if e.viscous is not None:
        outer_damping, inner_damping = e.viscous.outer_coefficient, e.viscous.inner_coefficient
    if e.smoothed_friction is not None:
        outer_damping += e.smoothed_friction.outer_level / e.smoothed_friction.width
        inner_damping += e.smoothed_friction.inner_level / e.smoothed_friction.width
    if e.lugre_friction is not None:
        outer, inner = outer + e.lugre_friction.stiffness, inner + e.lugre_friction.stiffness
        outer_damping, inner_damping = outer_damping + e.lugre_friction.damping, inner_damping + e.lugre_friction.damping
    if e.stops is not None:
        outer, inner = outer + e.stops.stiffness, inner + e.stops.stiffness
    if e.rotor is not None:
        gyroscopic = e.rotor.spin_momentum
    A, inertia = s.matrix[0], s.inertias.least
    A[:] = 0.0
    A[0, 2], A[1, 3] = 1.0, 1.0
    A[2, 0], A[2, 2], A[2, 3] = -outer / inertia, -outer_damping / inertia, -gyroscopic / inertia
    A[3, 1], A[3, 2], A[3, 3] = -inner / p.inner_inertia, gyroscopic / p.inner_inertia, -inner_damping / p.inner_inertia
    return step_within(high_order.stability_radius(e), spectral_radius(A, s.matrix[1]))


@kernel
def gimbal_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (alpha, beta, alpha', beta'[, bristles or modes]); not a number where the substep cannot follow."""
    dx[ALPHA], dx[BETA] = x[OUTER], x[INNER]
    dx[OUTER], dx[INNER] = accelerations(x, u, p, e)
    if max(abs(x[OUTER]), abs(x[INNER])) * p.substep > 1.0:
        dx[OUTER] = math.nan
    if e.lugre_friction is not None:
        dx[CONTACT], dx[CONTACT + 1] = bristle_rates(x, p, e.lugre_friction)
    if e.stick_friction is not None:
        dx[CONTACT] = dx[CONTACT + 1] = 0.0


@kernel
def gimbal_guards(t, x, u, g, s, p, e):
    """Guards: positive while the modes of the two axes last."""
    _, outer, inner = drives(x, u, p, e)
    g[0], g[1] = axis_guard(0, outer, x, e.stick_friction), axis_guard(1, inner, x, e.stick_friction)


@kernel
def gimbal_switch(which, t, x, u, s, p, e):
    """An axis has come to rest or breaks loose: its rate is zero, and its drive decides what follows."""
    x[OUTER + which] = 0.0
    _, outer, inner = drives(x, u, p, e)
    x[CONTACT + which] = stick_switch(x[CONTACT + which], outer if which == 0 else inner, level_of_axis(which, e.stick_friction))


@kernel
def gimbal_outputs(t, s, p, e):
    """Angles, rates, momentum, and the outputs of effects."""
    x, u, y = s.x, s.u[0], s.y
    y[OUT.outer_angle], y[OUT.inner_angle], y[OUT.outer_rate], y[OUT.inner_rate] = x[ALPHA], x[BETA], x[OUTER], x[INNER]
    y[OUT.outer_momentum] = outer_momentum(x, u, p, e)
    y[OUT.mechanical_energy] = gimbal_energy(x, u, p, e)
    if e.stick_friction is not None:
        y[e.stick_friction.y] = 1.0 if x[CONTACT] == 0.0 else 0.0
        y[e.stick_friction.y + 1] = 1.0 if x[CONTACT + 1] == 0.0 else 0.0
    if e.payload is not None:
        y[e.payload.y], y[e.payload.y + 1], y[e.payload.y + 2] = body_rates(x, u, p, e.base_motion)
    if e.reactions is not None:
        first, second = accelerations(x, u, p, e)
        k = e.reactions.y
        y[k], y[k + 1], y[k + 2], y[k + 3], y[k + 4], y[k + 5] = reactions_of_base(x, u, first, second, p, e)
    return DONE


GimbalBody.kernels = high_order.smooth_event_kernels(
    __name__,
    start=gimbal_start,
    derivatives=gimbal_derivatives,
    outputs=gimbal_outputs,
    stable=gimbal_stable,
    guards=gimbal_guards,
    switch=gimbal_switch,
)
