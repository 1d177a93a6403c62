"""Common parts of pipe robots: the inner mass's spring, the harmonic force, the pipe's slope, the load in tow, stable steps."""

from __future__ import annotations

import math

from ..core.component import Effect
from ..core.events import EventComponent
from ..core.kernels import kernel
from ..core.spectrum import fastest_rate
from ..core.variables import input_, output, parameter

FASTEST_PHASE = 1.0  # rad in a substep, above which an excitation is not followed


class ShakenRobot(EventComponent):
    """A body in a pipe and in it an inner mass on a spring, shaken along the pipe."""

    system = "pipe_robot"
    default_stop = 10.0

    body_mass = parameter(1.0, "kg", "mass of the body", low=1e-9)
    inner_mass = parameter(0.5, "kg", "mass on the spring", low=1e-9)
    stiffness = parameter(2000.0, "N/m", "stiffness of the spring", low=1e-9)
    damping = parameter(5.0, "N.s/m", "damping between body and inner mass", low=0.0)
    start_position = parameter(0.0, "m", "position of the body at the start")
    start_velocity = parameter(0.0, "m/s", "velocity of body and inner mass at the start")
    start_stretch = parameter(0.0, "m", "way of the inner mass from where it hangs, at the start")
    substep = parameter(5e-4, "s", "longest internal step", low=1e-9, high=1.0)

    position = output("m", "position of the body")
    velocity = output("m/s", "velocity of the body")
    inner_position = output("m", "position of the inner mass, unstretched that of the body")
    inner_velocity = output("m/s", "velocity of the inner mass")


class HarmonicForce(Effect):
    """A force amplitude * sin(phase) between body and inner mass; the phase grows with the frequency. Positive: body forwards."""

    amplitude = input_(20.0, "N", "amplitude of the force", nominal=10.0)
    frequency = input_(60.0, "rad/s", "angular frequency of the force", nominal=10.0)


class Tow(Effect):
    """A force on the body along the pipe: a load in tow, a coupling to another robot, the drag of a fluid."""

    force = input_(0.0, "N", "force on the body, positive forwards")


class PipeSlope(Effect):
    """The pipe along the way: its slope, and a factor on the friction; off: level and as given."""

    acceleration = parameter(9.81, "m/s2", "acceleration of gravity", low=0.0)
    slope = input_(0.0, "rad", "slope of the pipe, positive where forwards is upwards", nominal=0.1)
    friction_factor = input_(1.0, "1", "friction over that of the parameters")
    weight_power = output("W", "power that the weight gives, negative uphill", feedthrough=("route.slope",))


class CubicSpring(Effect):
    """A share of the spring's force that grows with the third power of its stretch; negative: the spring softens."""

    stiffness = parameter(1e6, "N/m3", "factor of the third power of the stretch")
    largest_stretch = parameter(0.05, "m", "stretch beyond which a run fails; it sets the stable step", low=1e-9)


@kernel
def spring_force(stretch, rate, p, cubic):
    """Force on the body by spring and damper when the inner mass is `stretch` further on, N; `cubic`: values or None."""
    force = p.stiffness * stretch + p.damping * rate
    if cubic is not None:
        force += cubic.stiffness * stretch**3
    return force


@kernel
def spring_energy(stretch, p, cubic):
    """Energy of the spring, J."""
    energy = 0.5 * p.stiffness * stretch**2
    if cubic is not None:
        energy += 0.25 * cubic.stiffness * stretch**4
    return energy


@kernel
def free_rate(body, inner, stiffness, damping):
    """Largest |eigenvalue| of body and inner mass with nothing but a spring between, 1/s; of a body that stands it is less."""
    return fastest_rate(body * inner / (body + inner), damping, stiffness)


@kernel
def hanging_stretch(weight, stiffness, cubic):
    """Stretch at which spring and weight down the pipe are in balance, m; not a number where a softening spring gives way."""
    stretch = -weight / stiffness
    for _ in range(60):
        slope = stiffness + 3.0 * cubic * stretch**2
        if slope <= 0.0:
            return math.nan
        change = (weight + stiffness * stretch + cubic * stretch**3) / slope
        stretch -= change
        if abs(change) <= 1e-15 * abs(stretch):
            return stretch
    return math.nan


class HarmonicExciter(HarmonicForce):
    """A force between body and inner mass that is harmonic in time; positive: body forwards."""

    excludes = ("prescribed_motion", "unbalance")


class PrescribedMotion(Effect):
    """The inner mass is driven against the body: its way from it is amplitude · sin(frequency · t), whatever force that takes."""

    explicit_only = True

    excludes = ("harmonic_force", "unbalance")
    amplitude = parameter(0.02, "m", "amplitude of the motion of the inner mass against the body", low=0.0)
    frequency = parameter(60.0, "rad/s", "angular frequency of the motion", low=0.0)


class Unbalance(Effect):
    """A pair of unbalances on the inner mass that turn against each other, driven by a torque: their force is along the pipe.

    Their own motion reacts on the drive, which has to lift their power over the resonance; a weak one stays caught there
    (Sommerfeld). At angle 0 the unbalance is across the pipe, at pi / 2 in front. It belongs to the inner mass.
    """

    excludes = ("harmonic_force", "prescribed_motion")
    mass = parameter(0.1, "kg", "mass of the unbalance, of both together; a part of the inner mass", low=1e-9)
    radius = parameter(0.02, "m", "distance of the unbalance from its shaft", low=1e-9)
    inertia = parameter(2e-5, "kg.m2", "moment of inertia of rotor and shaft without the unbalance", low=0.0)
    damping = parameter(1e-5, "N.m.s/rad", "viscous friction of the shaft", low=0.0)
    start_angle = parameter(0.0, "rad", "angle at the start")
    start_rate = parameter(0.0, "rad/s", "rate at the start")

    torque = input_(0.0, "N.m", "torque of the motor", nominal=0.1)
    rate = output("rad/s", "rate of the unbalance", nominal=10.0)
    angle = output("rad", "angle of the unbalance")
