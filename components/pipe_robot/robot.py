"""A robot that a vibrating mass moves through a pipe, with friction that is weaker forwards than backwards."""

from __future__ import annotations

import math

import numpy as np

from ..core.component import Preset
from ..core.errors import BadInput, StepFailed
from ..core.events import rk4_events
from ..core.friction import directed_mode
from ..core.integrators import rk4
from ..core.kernels import NOT_FINITE, bind, kernel
from ..core.variables import output, parameter
from .contact import (
    LOCKED,
    Bristles,
    LuGreFriction,
    SmoothedFriction,
    bristle_levels,
    bristle_rate,
    contact_guard,
    contact_switch,
    direction,
    friction_on_body,
)
from .exciters import HarmonicExciter, PrescribedMotion, Unbalance
from .parts import FASTEST_PHASE, CubicSpring, PipeSlope, ShakenRobot, Tow, fastest_eigenvalue, hanging_stretch, limit_of
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
    robot_energy,
    stretch_of,
    unbalance_of,
    weight_power,
)

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
    start_inputs = (  # whether it sticks follows from what drives it
        "harmonic_force.amplitude", "harmonic_force.frequency", "unbalance.torque", "tow.force", "route.slope",
        "route.friction_factor")

    harmonic_force = HarmonicExciter
    prescribed_motion = PrescribedMotion
    unbalance = Unbalance
    bristles = Bristles
    cubic_spring = CubicSpring
    smoothed_friction = SmoothedFriction
    lugre_friction = LuGreFriction
    tow = Tow
    route = Route

    forward_friction = parameter(2.0, "N", "kinetic friction against motion forwards", low=0.0)
    backward_friction = parameter(8.0, "N", "kinetic friction against motion backwards", low=0.0)
    static_ratio = parameter(1.0, "1", "static over kinetic friction, without smoothed_friction", low=1.0)

    friction_force = output("N", "friction on the body, positive forwards", nominal=10.0, feedthrough=FORCES)
    mode = output("1", "1 sliding forwards, -1 backwards, 0 at rest")
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

    def _initialize(self, t: float) -> int:
        if "bristles" in self.on:
            for name in ("forward_friction", "backward_friction"):
                if self.get(name) != type(self).variables[name].start:
                    raise BadInput(self.name, f"{name} = {self.get(name):g} N with the effect 'bristles'", "one of the two",
                                   "The bristles give the levels of friction.")
        if "smoothed_friction" in self.on and self.get("static_ratio") != 1.0:
            raise BadInput(self.name, f"static_ratio = {self.get('static_ratio'):g} with the effect 'smoothed_friction'", "1",
                           "Smoothed friction knows no rest; take lugre_friction, or the exact one.")
        self._check_unbalance()
        self._check_bristles()
        return super()._initialize(t)

    def _check_unbalance(self) -> None:
        if "unbalance" in self.on and self.get("unbalance.mass") > self.get("inner_mass"):
            raise BadInput(self.name, f"unbalance.mass = {self.get('unbalance.mass'):g} kg",
                           f"at most the inner mass, {self.get('inner_mass'):g} kg", "The unbalance belongs to it.")
        if "unbalance" in self.on and self.get("unbalance.mass") == self.get("inner_mass") and not self.get("unbalance.inertia"):
            raise BadInput(self.name, "an unbalance that is all of the inner mass, without inertia of the rotor",
                           "a mass or an inertia besides", "In front and behind nothing would resist its turning.")

    def _check_bristles(self) -> None:
        if "bristles" not in self.on or not {"smoothed_friction", "lugre_friction"} & {*self.on}:
            return
        factor = self.get("route.largest_factor") if "route" in self.on else 1.0
        lean = factor * self.get("bristles.friction") * math.tan(self.get("bristles.angle"))
        if 1.0 - lean <= LOCKED:
            raise BadInput(self.name, f"bristles with friction * tan(angle) = {lean:.4g}, locked backwards",
                           "less than 1 with smoothed_friction or lugre_friction, also at route.largest_factor",
                           "Leave both effects off: exact friction holds a locked robot.")

    def initial_state(self) -> np.ndarray:
        """x: position, velocity, inner position, inner velocity, mode or deflection of LuGre's bristles[, phase[, its rate]]."""
        p, e = self.arguments
        sag = hanging_stretch(p.inner_mass * downhill(self.u[0], e.route), p.stiffness,
                              e.cubic_spring.stiffness if e.cubic_spring else 0.0)
        if math.isnan(sag):
            raise BadInput(self.name, "a softening spring that does not hold the inner mass on the slope", "a stiffer one")
        x = [p.start_position, p.start_velocity, p.start_position + sag + p.start_stretch, p.start_velocity, 0.0]
        if e.harmonic_force is not None:
            x.append(0.0)
        if e.unbalance is not None:
            x += [e.unbalance.start_angle, e.unbalance.start_rate]
        state = np.array(x)
        if e.smoothed_friction is None and e.lugre_friction is None:
            drive, _ = drive_of(self.t, state, self.u[0], p, e.harmonic_force, e.prescribed_motion, e.cubic_spring, e.tow,
                                e.route)
            forward, backward = levels(self.u[0], p, e.bristles, e.route)
            state[CONTACT] = directed_mode(p.start_velocity, drive, p.static_ratio * forward, p.static_ratio * backward)
        return state

    def energy(self) -> float:
        """The output `mechanical_energy`, J."""
        p, e = self.arguments
        return float(robot_energy(self.t, self.x, p, e.prescribed_motion, e.unbalance, e.cubic_spring, e.lugre_friction))

    def stable_step(self) -> float:
        """RK4's limit, radius / max |eigenvalue| at the largest stretch and factor of friction, body free and stuck, s."""
        p, e = self._declared_arguments()
        k, inner = p.stiffness, p.inner_mass
        if e.cubic_spring is not None:
            k += 3.0 * max(e.cubic_spring.stiffness, 0.0) * e.cubic_spring.largest_stretch**2
        if e.unbalance is not None:
            q, inertia = unbalance_of(e.unbalance)
            inner -= q * q / inertia
        factor = e.route.largest_factor if e.route is not None else 1.0
        pair = bristle_levels(e.bristles, factor) if e.bristles is not None else (
            p.forward_friction * factor, p.backward_friction * factor)
        contact = (0.0, 0.0)
        if e.smoothed_friction is not None:
            contact = (0.0, max(pair) / e.smoothed_friction.width)
        if e.lugre_friction is not None:
            contact = (e.lugre_friction.stiffness, e.lugre_friction.damping)
        if e.prescribed_motion is not None:
            k_pipe, c_pipe = contact
            mass = p.body_mass + p.inner_mass
            return limit_of(float(np.abs(np.roots([mass, c_pipe, k_pipe])).max()))
        return limit_of(fastest_eigenvalue(p.body_mass, inner, (k, p.damping), contact)) if inner > 0.0 else math.inf

    def _step(self, t: float, h: float) -> int:
        if not {"smoothed_friction", "lugre_friction"} & {*self.on}:
            return super()._step(t, h)
        n = max(1, math.ceil(h / self._substep * (1.0 - 1e-9)))
        return robot_smooth(t, h, n, self.x, self.u, self.y, self._work, self.counts, *self.arguments)

    def _check(self, status: int) -> None:
        if status == NOT_FINITE:
            raise StepFailed(self.name, self.t, "the excitation turns by over a radian within a substep, the stretch of a cubic"
                             " spring or the factor of friction left its range, or the state is not finite",
                             "Reduce substep; check frequency, route.friction_factor and cubic_spring.largest_stretch")
        super()._check(status)


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
def robot_derivatives(t, x, u, dx, p, e):
    """dx/dt; not a number outside the range of the model. A prescribed motion needs no state of the inner mass."""
    drive, mass = drive_of(t, x, u, p, e.harmonic_force, e.prescribed_motion, e.cubic_spring, e.tow, e.route)
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
def robot_guards(t, x, u, g, p, e):
    """What keeps the body sliding, or at rest."""
    drive, _ = drive_of(t, x, u, p, e.harmonic_force, e.prescribed_motion, e.cubic_spring, e.tow, e.route)
    forward, backward = levels(u, p, e.bristles, e.route)
    g[0] = contact_guard(x[VELOCITY], x[CONTACT], drive, forward, backward, p.static_ratio)


@kernel
def robot_switch(which, t, x, u, p, e):
    """The body stops, turns back, or breaks loose."""
    x[VELOCITY] = 0.0
    drive, _ = drive_of(t, x, u, p, e.harmonic_force, e.prescribed_motion, e.cubic_spring, e.tow, e.route)
    forward, backward = levels(u, p, e.bristles, e.route)
    x[CONTACT] = contact_switch(x[CONTACT], drive, forward, backward, p.static_ratio)


@kernel
def robot_outputs(t, x, u, y, p, e):
    """Motion, friction, powers, energy, and what the effects add."""
    drive, mass = drive_of(t, x, u, p, e.harmonic_force, e.prescribed_motion, e.cubic_spring, e.tow, e.route)
    forward, backward = levels(u, p, e.bristles, e.route)
    friction = friction_on_body(x[VELOCITY], x[CONTACT], drive, forward, backward, p, e.smoothed_friction, e.lugre_friction)
    stretch, rate = stretch_of(t, x, e.prescribed_motion)
    y[0], y[1], y[2], y[3] = x[POSITION], x[VELOCITY], x[POSITION] + stretch, x[VELOCITY] + rate
    y[4] = -friction
    y[5] = x[CONTACT]
    if e.smoothed_friction is not None or e.lugre_friction is not None:
        y[5] = direction(x[VELOCITY])
    y[6] = exciter_power(t, x, u, (drive - friction) / mass, p, e.harmonic_force, e.prescribed_motion, e.unbalance,
                         e.cubic_spring, e.route)
    y[7] = dissipated_power(t, x, friction, forward, backward, p, e.prescribed_motion, e.unbalance, e.lugre_friction)
    y[8] = robot_energy(t, x, p, e.prescribed_motion, e.unbalance, e.cubic_spring, e.lugre_friction)
    if e.unbalance is not None:
        y[e.unbalance.y], y[e.unbalance.y + 1] = x[PHASE_RATE], x[PHASE]
    if e.route is not None:
        y[e.route.y] = weight_power(t, x, u, p, e.prescribed_motion, e.unbalance, e.route)


PipeRobot.advance = bind(rk4_events, __name__, derivatives=robot_derivatives, guards=robot_guards, switch=robot_switch,
                         outputs=robot_outputs)
PipeRobot.output_kernel = robot_outputs
robot_smooth = bind(rk4, __name__, derivatives=robot_derivatives, outputs=robot_outputs)
