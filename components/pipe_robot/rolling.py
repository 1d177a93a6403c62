"""A robot on elastic rings whose rollers turn one way only: it rolls forwards and would have to slide backwards."""

from __future__ import annotations

import math

from ..core.component import Preset
from ..core.errors import StepFailed
from ..core.events import event_kernels
from ..core.friction import directed_friction, directed_guard, directed_mode, directed_switch
from ..core.integrators import RK4_STABILITY_RADIUS
from ..core.kernels import DONE, NOT_FINITE, kernel
from ..core.spectrum import step_within
from ..core.variables import PARTS, count, input_, integer, output, parameter
from .parts import FASTEST_PHASE, HarmonicForce, PipeSlope, ShakenRobot, Tow, free_rate
from .robot_equations import (
    CONTACT,
    INNER,
    INNER_VELOCITY,
    PHASE,
    POSITION,
    VELOCITY,
    downhill,
    harmonic_force,
    inner_accelerations,
    robot_energy,
    shaken_drive,
    weight_power,
)

RING = 1.0 / (0.25 * math.pi - 2.0 / math.pi)  # stiffness of a thin ring between two points, times R³ / EI: 6.7214
SOFTEST = 0.2  # of the free diameter, pressed in, beyond which the small deflection of a ring is no longer one
FORCES = ("diameter", "taper", "harmonic_force.amplitude", "tow.force", "route.slope", "route.friction_factor")


class RollingPipeRobot(ShakenRobot):
    """A body on elastic rings that the pipe presses in; at each end of the pressed diameter a roller on a one-way bearing.

        N = EI / ((pi / 4 - 2 / pi) R³) (2 R - D)            force of a ring on either roller, D: diameter of the pipe
        forwards   (m1 + 2 n J / rho²) x1'' = drive - mu_r 2 n N        backwards   m1 x1'' = drive + mu 2 n N
        drive = f + n N D' - m1 g sin(slope) + tow,    m2 x2'' = -f - m2 g sin(slope),    f as in `PipeRobot`

    n: rings, mu_r: rolling resistance, J, rho: inertia and radius of a roller. Backwards the bearings lock and the rollers slide
    without turning. At rest the body stays exactly, between the two levels. Where the pipe widens (D' > 0), the rings push
    forwards, with the energy they give up. `grip` tells whether the rollers would really roll; that they slip is left out.
    A pipe wider than the free rings leaves the robot without contact: the run fails there.
    Elastic elements of circular form are in the abstract of Matuliauskas and Spruogis (2002), all that is known to us of that
    paper; that they carry one-way rollers, and all equations and numbers, are ours. The ring's stiffness is the classical one.
    """

    title = "Pipe robot on elastic rings with one-way rollers"
    start_inputs = (  # they decide whether it sticks
        "diameter",
        "taper",
        "harmonic_force.amplitude",
        "harmonic_force.frequency",
        "tow.force",
        "route.slope",
        "route.friction_factor",
    )

    harmonic_force = HarmonicForce
    tow = Tow
    route = PipeSlope

    body_mass = parameter(1.0, "kg", "mass of the body with its rings, without turning of rollers", low=1e-9)
    rings = integer(2, "number of rings", low=1, structural=PARTS)
    free_diameter = parameter(0.204, "m", "diameter of a ring over its rollers without load", low=1e-6)
    bending_stiffness = parameter(0.2, "N.m2", "EI of the strip of a ring", low=0.0)
    rolling_resistance = parameter(0.03, "1", "resistance of a rolling roller over the force on it", low=0.0)
    friction = parameter(0.4, "1", "coefficient of friction of a locked roller", low=0.0)
    roller_inertia = parameter(2e-6, "kg.m2", "moment of inertia of a roller", low=0.0)
    roller_radius = parameter(0.01, "m", "radius of a roller", low=1e-9)

    diameter = input_(0.2, "m", "diameter of the pipe", nominal=1e-3)
    taper = input_(0.0, "1", "growth of the diameter along the pipe", nominal=1e-2)

    friction_force = output("N", "friction on the body, positive forwards", nominal=10.0, feedthrough=FORCES)
    mode = count("1 rolling forwards, -1 sliding backwards, 0 at rest")
    exciter_power = output("W", "power that the exciter gives", nominal=10.0, feedthrough=("harmonic_force.amplitude",))
    dissipation = output(
        "W", "power lost in rolling, sliding and the damper", nominal=10.0, feedthrough=("diameter", "route.friction_factor")
    )
    mechanical_energy = output("J", "kinetic energy, energy of spring and rings", feedthrough=("diameter",))
    pressing_force = output("N", "force of a ring on either roller", nominal=10.0, feedthrough=("diameter",))
    grip = output("1", "share of the friction that turning the rollers takes; above 1 they would slip", feedthrough=FORCES)

    presets = {
        "two steel rings": Preset(
            {"harmonic_force.amplitude": 20.0, "harmonic_force.frequency": 60.0, "rings": 2, "bending_stiffness": 0.2},
            "numbers of ours: strips of 20 mm by 0.85 mm, 5.1 N on a roller",
            "inferred",
            ("harmonic_force",),
        )
    }

    def states(self) -> int:
        """Position, velocity, inner position, inner velocity, mode[, phase]."""
        return 5 + ("harmonic_force" in self.on)

    def energy(self) -> float:
        """The output `mechanical_energy`, J."""
        return float(rolling_energy(self.t, self.x, self.u[0], self.arguments[1]))

    def _check(self, status: int) -> None:
        if status == NOT_FINITE:
            raise StepFailed(
                self.name,
                self.t,
                "the rings lost contact with the pipe or are pressed in too far, the excitation"
                " turns by over a radian within a substep, or the state is not finite",
                "Check diameter and free_diameter, route.friction_factor, and frequency times substep",
            )
        super()._check(status)


IN = RollingPipeRobot.input_places()
OUT = RollingPipeRobot.output_places()


@kernel
def ring_stiffness(p):
    """Force between two opposite points of a ring over the change of its diameter, N/m."""
    radius = 0.5 * p.free_diameter
    return RING * p.bending_stiffness / (radius * radius * radius)


@kernel
def pressing(u, p):
    """Force of a ring on either of its rollers, N; not below zero."""
    return ring_stiffness(p) * max(p.free_diameter - u[IN.diameter], 0.0)


@kernel
def rolling_levels(u, p, route):
    """(against rolling forwards, against sliding backwards), N."""
    factor = u[route.u + 1] if route is not None else 1.0
    normal = 2.0 * p.rings * pressing(u, p) * factor
    return p.rolling_resistance * normal, p.friction * normal


@kernel
def moved_mass(mode, p):
    """Mass of the body, while it rolls with the turning of the rollers, kg."""
    if mode > 0.0:
        return p.body_mass + 2.0 * p.rings * p.roller_inertia / (p.roller_radius * p.roller_radius)
    return p.body_mass


@kernel
def rolling_drive(x, u, p, e):
    """Force on the body without friction, N."""
    drive = shaken_drive(x, u, p, e.harmonic_force, None, e.tow, e.route)
    return drive + p.rings * pressing(u, p) * u[IN.taper]


@kernel
def rolling_energy(t, x, u, p):
    """Kinetic energy with the turning of the rollers, energy of spring and rings, J."""
    pressed = max(p.free_diameter - u[IN.diameter], 0.0)
    turning = 0.5 * (moved_mass(x[CONTACT], p) - p.body_mass) * x[VELOCITY] ** 2
    return robot_energy(t, x, p, None, None, None, None) + turning + 0.5 * p.rings * ring_stiffness(p) * pressed**2


@kernel
def contact_holds(u, p, harmonic, route):
    """Whether the rings touch, are not pressed in too far, and the substep follows the excitation."""
    fine = (1.0 - SOFTEST) * p.free_diameter <= u[IN.diameter] < p.free_diameter
    if harmonic is not None:
        fine = fine and abs(u[harmonic.u + 1]) * p.substep <= FASTEST_PHASE
    if route is not None:
        fine = fine and u[route.u + 1] >= 0.0
    return fine


@kernel
def rolling_start(t, s, p, e):
    """Both masses as the parameters say, the inner one from where it hangs; the body sticks if it can."""
    x, u = s.x, s.u[0]
    sag = -p.inner_mass * downhill(u, e.route) / p.stiffness
    x[POSITION], x[VELOCITY] = p.start_position, p.start_velocity
    x[INNER], x[INNER_VELOCITY] = p.start_position + sag + p.start_stretch, p.start_velocity
    forward, backward = rolling_levels(u, p, e.route)
    x[CONTACT] = directed_mode(p.start_velocity, rolling_drive(x, u, p, e), forward, backward)
    return DONE


@kernel
def rolling_stable(t, s, p, e):
    """RK4's limit, radius / max |eigenvalue| with the body free, s."""
    return step_within(RK4_STABILITY_RADIUS, free_rate(p.body_mass, p.inner_mass, p.stiffness, p.damping))


@kernel
def rolling_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (position, velocity, inner position, inner velocity, mode[, phase]); not a number out of range."""
    drive = rolling_drive(x, u, p, e)
    forward, backward = rolling_levels(u, p, e.route)
    friction = directed_friction(x[CONTACT], drive, forward, backward)
    dx[POSITION], dx[VELOCITY] = x[VELOCITY], (drive - friction) / moved_mass(x[CONTACT], p)
    inner, _ = inner_accelerations(x, u, p, e.harmonic_force, None, None, e.route)
    dx[INNER], dx[INNER_VELOCITY], dx[CONTACT] = x[INNER_VELOCITY], inner, 0.0
    if e.harmonic_force is not None:
        dx[PHASE] = u[e.harmonic_force.u + 1]
    if not contact_holds(u, p, e.harmonic_force, e.route):
        dx[VELOCITY] = math.nan


@kernel
def rolling_guards(t, x, u, g, s, p, e):
    """Guard: positive while the body goes on rolling or sliding, or stays at rest."""
    forward, backward = rolling_levels(u, p, e.route)
    g[0] = directed_guard(x[CONTACT], x[VELOCITY], rolling_drive(x, u, p, e), forward, backward)


@kernel
def rolling_switch(which, t, x, u, s, p, e):
    """The body stops, turns back, or breaks loose."""
    x[VELOCITY] = 0.0
    forward, backward = rolling_levels(u, p, e.route)
    x[CONTACT] = directed_switch(x[CONTACT], rolling_drive(x, u, p, e), forward, backward)


@kernel
def rolling_outputs(t, s, p, e):
    """Motion, friction, powers, energy, force of a ring, grip of the rollers."""
    x, u, y = s.x, s.u[0], s.y
    drive = rolling_drive(x, u, p, e)
    forward, backward = rolling_levels(u, p, e.route)
    friction = directed_friction(x[CONTACT], drive, forward, backward)
    y[OUT.position], y[OUT.velocity], y[OUT.inner_position], y[OUT.inner_velocity] = (
        x[POSITION],
        x[VELOCITY],
        x[INNER],
        x[INNER_VELOCITY],
    )
    y[OUT.friction_force], y[OUT.mode] = -friction, x[CONTACT]
    rate = x[INNER_VELOCITY] - x[VELOCITY]
    y[OUT.exciter_power] = -harmonic_force(x, u, e.harmonic_force) * rate if e.harmonic_force is not None else 0.0
    y[OUT.dissipation] = friction * x[VELOCITY] + p.damping * rate * rate
    y[OUT.mechanical_energy] = rolling_energy(t, x, u, p)
    y[OUT.pressing_force] = pressing(u, p)
    mass = moved_mass(x[CONTACT], p)
    y[OUT.grip] = abs(drive - friction) / mass * (mass - p.body_mass) / backward if backward > 0.0 else 0.0
    if e.route is not None:
        y[e.route.y] = weight_power(t, x, u, p, None, None, e.route)
    return DONE


RollingPipeRobot.kernels = event_kernels(
    __name__,
    start=rolling_start,
    derivatives=rolling_derivatives,
    outputs=rolling_outputs,
    stable=rolling_stable,
    guards=rolling_guards,
    switch=rolling_switch,
)
