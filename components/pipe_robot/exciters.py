"""What shakes the inner mass of a pipe robot: a harmonic force, a prescribed motion, or rotating unbalances."""

from __future__ import annotations

from ..core.component import Effect
from ..core.variables import input_, output, parameter
from .parts import HarmonicForce


class HarmonicExciter(HarmonicForce):
    """A force between body and inner mass that is harmonic in time; positive: body forwards."""

    excludes = ("prescribed_motion", "unbalance")


class PrescribedMotion(Effect):
    """The inner mass is driven against the body: its way from it is amplitude * sin(frequency * t), whatever force that takes."""

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
