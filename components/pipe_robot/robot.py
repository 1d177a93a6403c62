"""A robot that a vibrating mass moves through a pipe, with friction that is weaker forwards than backwards."""

from __future__ import annotations

import math
from typing import Any

from ..core.component import Preset
from ..core.contract import Refusal
from ..core.errors import StepFailed
from ..core.events import event_kernels
from ..core.friction import directed_mode
from ..core.integrators import RK4_STABILITY_RADIUS
from ..core.kernels import DONE, NOT_FINITE, OWN, kernel
from ..core.spectrum import fastest_rate, spectral_radius, step_within
from ..core.variables import count, output, parameter
from .contact import (
    LOCKED,
    Bristles,
    LuGreFriction,
    SmoothedFriction,
    bristle_rate,
    contact_guard,
    contact_switch,
    direction,
    friction_on_body,
)
from .parts import (
    FASTEST_PHASE,
    CubicSpring,
    HarmonicExciter,
    PipeSlope,
    PrescribedMotion,
    ShakenRobot,
    Tow,
    Unbalance,
    free_rate,
    hanging_stretch,
)
from .robot_equations import (
    CONTACT,
    INNER,
    INNER_VELOCITY,
    PHASE,
    PHASE_RATE,
    POSITION,
    VELOCITY,
    dissipated_power,
    downhill,
    drive_of,
    exciter_power,
    inner_accelerations,
    levels,
    levels_at,
    robot_energy,
    stretch_of,
    unbalance_of,
    weight_power,
)

FORWARD, BACKWARD = 2.0, 8.0  # N, levels of friction by default
FORWARD_GIVEN, BACKWARD_GIVEN, STATIC_RATIO, HEAVY_UNBALANCE, NO_INERTIA, LOCKED_BRISTLES, GIVES_WAY = range(OWN + 1, OWN + 8)
FORCES = ("harmonic_force.amplitude", "tow.force", "route.slope", "route.friction_factor")


class Route(PipeSlope):
    """The pipe along the way: its slope, and a factor on the friction; off: level and as given."""

    largest_factor = parameter(1.5, "1", "factor of friction beyond which a run fails; it sets the stable step", low=0.0)


class PipeRobot(ShakenRobot):
    """A body braced in a pipe by inclined elastic elements, and in it an inner mass on a spring that is shaken along the pipe.

        m1 x1'' = f - R - m1 g sin(slope) + tow,    m2 x2'' = -f - m2 g sin(slope)
        f = k s + c s' + F sin(psi),    s = x2 - x1

    R is dry friction: `forward_friction` against motion forwards, `backward_friction` against motion backwards. It sticks
    exactly: at rest the body's velocity is zero to the last bit, up to static_ratio times the level; breaking loose and
    stopping are events. Since R is weaker forwards, a force without mean moves the robot forwards.
    One exciter: `harmonic_force`, `prescribed_motion`, or `unbalance`; without any, the robot is pulled or stands.
    Spring and inner mass start at rest against the body, `start_stretch` from where they hang on the slope.
    The arrangement (inclined elastic elements, exciter along one axis) is that of Matuliauskas and Spruogis (2002), known to
    us by the abstract; equations and numbers are ours, the equations as in the literature on locomotion by vibration
    (Zimmermann, Zeidis, Bolotnik).
    """

    title = "Pipe robot with inclined elastic elements"
    start_inputs = (  # they decide whether it sticks
        "harmonic_force.amplitude",
        "harmonic_force.frequency",
        "unbalance.torque",
        "tow.force",
        "route.slope",
        "route.friction_factor",
    )

    harmonic_force = HarmonicExciter
    prescribed_motion = PrescribedMotion
    unbalance = Unbalance
    bristles = Bristles
    cubic_spring = CubicSpring
    smoothed_friction = SmoothedFriction
    lugre_friction = LuGreFriction
    tow = Tow
    route = Route

    forward_friction = parameter(FORWARD, "N", "kinetic friction against motion forwards", low=0.0)
    backward_friction = parameter(BACKWARD, "N", "kinetic friction against motion backwards", low=0.0)
    static_ratio = parameter(1.0, "1", "static over kinetic friction, without smoothed_friction", low=1.0)

    friction_force = output("N", "friction on the body, positive forwards", nominal=10.0, feedthrough=FORCES)
    mode = count("1 sliding forwards, -1 backwards, 0 at rest")
    exciter_power = output("W", "power that the exciter gives", nominal=10.0, feedthrough=(*FORCES, "unbalance.torque"))
    dissipation = output("W", "power lost in friction, damper and bearings", nominal=10.0, feedthrough=("route.friction_factor",))
    mechanical_energy = output("J", "kinetic energy, energy of the spring and of LuGre's bristles")

    presets = {
        "force of 20 N": Preset(
            {"harmonic_force.amplitude": 20.0, "harmonic_force.frequency": 60.0, "forward_friction": 2.0,
             "backward_friction": 8.0}, "numbers of ours, 0.360 m/s in the mean", "computed", ("harmonic_force",)),
        "true stick phases": Preset(
            {"harmonic_force.amplitude": 1.5, "harmonic_force.frequency": 60.0, "forward_friction": 2.0,
             "backward_friction": 8.0}, "numbers of ours: it stands a part of every period", "computed", ("harmonic_force",)),
        "bristles at 60 degrees": Preset(
            {"bristles.angle": math.pi / 3.0, "bristles.friction": 0.3},
            "numbers of ours: friction 3.2 times as strong backwards", "computed", ("harmonic_force", "bristles")),
    }  # fmt: skip

    refusals = {
        FORWARD_GIVEN: Refusal(
            "forward_friction = {forward_friction} N with the effect 'bristles'",
            "one of the two",
            "The bristles give the levels of friction.",
        ),
        BACKWARD_GIVEN: Refusal(
            "backward_friction = {backward_friction} N with the effect 'bristles'",
            "one of the two",
            "The bristles give the levels of friction.",
        ),
        STATIC_RATIO: Refusal(
            "static_ratio = {static_ratio} with the effect 'smoothed_friction'",
            "1",
            "Smoothed friction knows no rest; take lugre_friction, or the exact one.",
        ),
        HEAVY_UNBALANCE: Refusal(
            "unbalance.mass = {unbalance.mass} kg", "at most the inner mass, {inner_mass} kg", "The unbalance belongs to it."
        ),
        NO_INERTIA: Refusal(
            "an unbalance that is all of the inner mass, without inertia of the rotor",
            "a mass or an inertia besides",
            "In front and behind nothing would resist its turning.",
        ),
        LOCKED_BRISTLES: Refusal(
            "bristles with friction * tan(angle) = {lean[0]}, locked backwards",
            "less than 1 with smoothed_friction or lugre_friction, also at route.largest_factor",
            "Leave both effects off: exact friction holds a locked robot.",
        ),
        GIVES_WAY: Refusal("a softening spring that does not hold the inner mass on the slope", "a stiffer one"),
    }

    @property
    def guards_count(self) -> int:  # type: ignore[override]
        """One where friction sticks exactly."""
        return 0 if {"smoothed_friction", "lugre_friction"} & {*self.on} else 1

    def states(self) -> int:
        """Position, velocity, inner position, inner velocity, mode or deflection of LuGre's bristles[, phase[, its rate]]."""
        return 5 + ("harmonic_force" in self.on) + 2 * ("unbalance" in self.on)

    def shapes(self) -> dict[str, Any]:
        """`lean`: (1,) friction * tan(angle) of the bristles, at the largest factor of friction.

        `matrix`: of the linear equations of both masses and friction without standstill, and workspace.
        """
        return super().shapes() | {"lean": 1, "matrix": (2, 4, 4)}

    def energy(self) -> float:
        """The output `mechanical_energy`, J."""
        _, p, e = self.arguments
        return float(robot_energy(self.t, self.x, p, e.prescribed_motion, e.unbalance, e.cubic_spring, e.lugre_friction))

    def _check(self, status: int) -> None:
        if status == NOT_FINITE:
            raise StepFailed(
                self.name,
                self.t,
                "the excitation turns by over a radian within a substep, the stretch of a cubic"
                " spring or the factor of friction left its range, or the state is not finite",
                "Reduce substep; check frequency, route.friction_factor and cubic_spring.largest_stretch",
            )
        super()._check(status)


OUT = PipeRobot.output_places()


@kernel
def robot_refused(s, p, e):
    """The status of parameters that do not go together."""
    if e.bristles is not None:
        if p.forward_friction != FORWARD:
            return FORWARD_GIVEN
        if p.backward_friction != BACKWARD:
            return BACKWARD_GIVEN
    if e.smoothed_friction is not None and p.static_ratio != 1.0:
        return STATIC_RATIO
    if e.unbalance is not None:
        if e.unbalance.mass > p.inner_mass:
            return HEAVY_UNBALANCE
        if e.unbalance.mass == p.inner_mass and e.unbalance.inertia == 0.0:
            return NO_INERTIA
    if e.bristles is not None:
        s.lean[0] = largest_factor(e.route) * e.bristles.friction * math.tan(e.bristles.angle)
        if s.guards is None and 1.0 - s.lean[0] <= LOCKED:
            return LOCKED_BRISTLES
    return DONE


@kernel
def largest_factor(route):
    """Factor of friction up to which a run goes on."""
    return route.largest_factor if route is not None else 1.0


@kernel
def robot_start(t, s, p, e):
    """Both masses as the parameters say, the inner one from where it hangs; the body sticks if it can."""
    x, u = s.x, s.u[0]
    status = robot_refused(s, p, e)
    if status != DONE:
        return status
    sag = hanging_stretch(
        p.inner_mass * downhill(u, e.route), p.stiffness, e.cubic_spring.stiffness if e.cubic_spring is not None else 0.0
    )
    if math.isnan(sag):
        return GIVES_WAY
    x[POSITION], x[VELOCITY] = p.start_position, p.start_velocity
    x[INNER], x[INNER_VELOCITY] = p.start_position + sag + p.start_stretch, p.start_velocity
    if e.unbalance is not None:
        x[PHASE], x[PHASE_RATE] = e.unbalance.start_angle, e.unbalance.start_rate
    if s.guards is not None:
        drive, _ = drive_of(t, x, u, p, e)
        forward, backward = levels(u, p, e.bristles, e.route)
        x[CONTACT] = directed_mode(p.start_velocity, drive, p.static_ratio * forward, p.static_ratio * backward)
    return DONE


@kernel
def robot_stable(t, s, p, e):
    """RK4's limit, radius / max |eigenvalue| at the largest stretch and factor of friction, body free and stuck, s."""
    k, inner, k_pipe, c_pipe = p.stiffness, p.inner_mass, 0.0, 0.0
    if e.cubic_spring is not None:
        k += 3.0 * max(e.cubic_spring.stiffness, 0.0) * e.cubic_spring.largest_stretch**2
    if e.unbalance is not None:
        q, inertia = unbalance_of(e.unbalance)
        inner -= q * q / inertia
        if not inner > 0.0:
            return math.inf
    if e.smoothed_friction is not None:
        forward, backward = levels_at(largest_factor(e.route), p, e.bristles)
        c_pipe = max(forward, backward) / e.smoothed_friction.width
    if e.lugre_friction is not None:
        k_pipe, c_pipe = e.lugre_friction.stiffness, e.lugre_friction.damping
    if e.prescribed_motion is not None:
        fastest = fastest_rate(p.body_mass + p.inner_mass, c_pipe, k_pipe)
    elif s.guards is not None:
        fastest = free_rate(p.body_mass, inner, k, p.damping)
    else:
        fastest = held_rate(s.matrix, p.body_mass, inner, (k, p.damping), (k_pipe, c_pipe))
    return step_within(RK4_STABILITY_RADIUS, fastest)


@kernel
def held_rate(matrix, body, inner, spring, contact):
    """Largest |eigenvalue| of body and inner mass, 1/s, with the body free, and with it stuck.

    matrix: (2, 4, 4) workspace.  spring, contact to the pipe: (stiffness, damping).
    """
    (k, c), (k_pipe, c_pipe) = spring, contact
    A = matrix[0]
    A[:] = 0.0
    A[0, 2], A[1, 3] = 1.0, 1.0
    A[2, 0], A[2, 1], A[2, 2], A[2, 3] = -(k + k_pipe) / body, k / body, -(c + c_pipe) / body, c / body
    A[3, 0], A[3, 1], A[3, 2], A[3, 3] = k / inner, -k / inner, c / inner, -c / inner
    return max(spectral_radius(A, matrix[1]), fastest_rate(inner, c, k))


@kernel
def in_range(t, x, u, p, e):
    """Whether the substep follows the excitation, and stretch and factor of friction are in their range.

    A trial that goes past an event, beyond which its mode does not hold, may lead anywhere: it is not judged.
    """
    fine = True
    if e.smoothed_friction is None and e.lugre_friction is None and x[CONTACT] * x[VELOCITY] < 0.0:
        return fine
    if e.harmonic_force is not None:
        fine = abs(u[e.harmonic_force.u + 1]) * p.substep <= FASTEST_PHASE
    if e.prescribed_motion is not None:
        fine = e.prescribed_motion.frequency * p.substep <= FASTEST_PHASE
    if e.unbalance is not None:
        fine = abs(x[PHASE_RATE]) * p.substep <= FASTEST_PHASE
    if e.cubic_spring is not None:
        stretch, _ = stretch_of(t, x, e.prescribed_motion)
        fine = fine and abs(stretch) <= e.cubic_spring.largest_stretch
    if e.route is not None:
        fine = fine and 0.0 <= u[e.route.u + 1] <= e.route.largest_factor
    return fine


@kernel
def robot_derivatives(t, x, u, dx, s, p, e):
    """dx/dt; not a number outside the range of the model. A prescribed motion needs no state of the inner mass."""
    drive, mass = drive_of(t, x, u, p, e)
    forward, backward = levels(u, p, e.bristles, e.route)
    friction = friction_on_body(x[VELOCITY], x[CONTACT], drive, forward, backward, p, e.smoothed_friction, e.lugre_friction)
    dx[POSITION], dx[VELOCITY] = x[VELOCITY], (drive - friction) / mass
    dx[CONTACT] = 0.0
    if e.lugre_friction is not None:
        dx[CONTACT] = bristle_rate(x[VELOCITY], x[CONTACT], forward, backward, p.static_ratio, e.lugre_friction, p.substep)
    if e.prescribed_motion is not None:
        dx[INNER] = dx[INNER_VELOCITY] = 0.0
    else:
        inner, angular = inner_accelerations(x, u, p, e.harmonic_force, e.unbalance, e.cubic_spring, e.route)
        dx[INNER], dx[INNER_VELOCITY] = x[INNER_VELOCITY], inner
        if e.unbalance is not None:
            dx[PHASE], dx[PHASE_RATE] = x[PHASE_RATE], angular
    if e.harmonic_force is not None:
        dx[PHASE] = u[e.harmonic_force.u + 1]
    if not in_range(t, x, u, p, e):
        dx[VELOCITY] = math.nan


@kernel
def robot_guards(t, x, u, g, s, p, e):
    """Guard: positive while the body goes on sliding, or stays at rest."""
    drive, _ = drive_of(t, x, u, p, e)
    forward, backward = levels(u, p, e.bristles, e.route)
    g[0] = contact_guard(x[VELOCITY], x[CONTACT], drive, forward, backward, p.static_ratio)


@kernel
def robot_switch(which, t, x, u, s, p, e):
    """The body stops, turns back, or breaks loose."""
    x[VELOCITY] = 0.0
    drive, _ = drive_of(t, x, u, p, e)
    forward, backward = levels(u, p, e.bristles, e.route)
    x[CONTACT] = contact_switch(x[CONTACT], drive, forward, backward, p.static_ratio)


@kernel
def robot_outputs(t, s, p, e):
    """Motion, friction, powers, energy, and the outputs of effects."""
    x, u, y = s.x, s.u[0], s.y
    drive, mass = drive_of(t, x, u, p, e)
    forward, backward = levels(u, p, e.bristles, e.route)
    friction = friction_on_body(x[VELOCITY], x[CONTACT], drive, forward, backward, p, e.smoothed_friction, e.lugre_friction)
    stretch, rate = stretch_of(t, x, e.prescribed_motion)
    y[OUT.position], y[OUT.velocity], y[OUT.inner_position], y[OUT.inner_velocity] = (
        x[POSITION],
        x[VELOCITY],
        x[POSITION] + stretch,
        x[VELOCITY] + rate,
    )
    y[OUT.friction_force] = -friction
    y[OUT.mode] = x[CONTACT]
    if e.smoothed_friction is not None or e.lugre_friction is not None:
        y[OUT.mode] = direction(x[VELOCITY])
    y[OUT.exciter_power] = exciter_power(t, x, u, (drive - friction) / mass, p, e)
    y[OUT.dissipation] = dissipated_power(t, x, friction, forward, backward, p, e)
    y[OUT.mechanical_energy] = robot_energy(t, x, p, e.prescribed_motion, e.unbalance, e.cubic_spring, e.lugre_friction)
    if e.unbalance is not None:
        y[e.unbalance.y], y[e.unbalance.y + 1] = x[PHASE_RATE], x[PHASE]
    if e.route is not None:
        y[e.route.y] = weight_power(t, x, u, p, e.prescribed_motion, e.unbalance, e.route)
    return DONE


PipeRobot.kernels = event_kernels(
    __name__,
    start=robot_start,
    derivatives=robot_derivatives,
    outputs=robot_outputs,
    stable=robot_stable,
    guards=robot_guards,
    switch=robot_switch,
)
