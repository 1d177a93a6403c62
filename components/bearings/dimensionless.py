"""The dimensionless form of the ball bearing with two degrees of freedom, and the way to it from the dimensional one.

The derivation stands in `ball_bearing`. Every value scales by its unit, as mass, length and time do: the scales are those
three, chosen so that mass, stiffness and load become 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..core.component import Effect, Preset
from ..core.errors import BadInput
from ..core.measure import BASES, parse
from ..core.variables import input_, integer, output, parameter
from .ball_bearing import JIS6306_SOURCE, BallBearing, TwoDofBearing
from .geometry import BallGeometry
from .races import ORDERS, TWO_PI
from .two_dof import Constants, constants


@dataclass(frozen=True)
class Scales:
    """Units of the dimensionless form: a dimensional value is the dimensionless one times its scale."""

    mass: float  # kg
    length: float  # m
    time: float  # s

    def of(self, unit: str) -> float:
        """The scale of a quantity by its SI unit ("m/s", "N", "rad/s")."""
        powers = dict(zip(BASES, parse(unit).exponents, strict=True))
        return self.mass ** powers["kg"] * self.length ** powers["m"] * self.time ** powers["s"]


class RadialClearance(Effect):
    """A gap between balls and races; off, the concentric bearing is free of gap and of preload."""

    radial_clearance = parameter(1.667, "1", "radial gap; negative for preload")


class ContactDamping(Effect):
    """Damping of each contact after Hunt and Crossley, Q = delta^1.5 (1 + 1.5 k delta'), never pulling."""

    coefficient = parameter(1.533e-3, "1", "k", low=0.0)


class Unbalance(Effect):
    """The mass sits off the shaft's axis."""

    eccentricity = parameter(0.8335, "1", "distance of the centre of mass from the axis", low=0.0)
    phase = parameter(0.0, "rad", "its angle on the inner ring")


class Waviness(Effect):
    """Waves of a race: the surface lies deeper by the sum of amplitude * cos(order * angle + phase), angle along the race."""

    order = integer((2, 3, 4, 5, 6, 7, 8, 9), "number of waves along the race; amplitude 0 leaves an order out", size=ORDERS,
                    low=1, high=10000)
    amplitude = parameter((0.1667, *[0.0] * (ORDERS - 1)), "1", "amplitude of the order", size=ORDERS)
    phase = parameter(0.0, "rad", "phase of the order at the race's own angle 0", size=ORDERS)


class Defect(Effect):
    """A pit in a race with the profile of a raised cosine: depth and slope are continuous, so nothing jumps as a ball passes."""

    explicit_only = True

    depth = parameter(0.8335, "1", "depth in the middle; negative for a bump")
    width = parameter(math.radians(3.0), "rad", "extent along the race", low=1e-6, high=TWO_PI)
    position = parameter(0.0, "rad", "middle of the pit on its race")


class BallDefect(Effect):
    """A pit on one ball that meets the inner race and, half a turn of the ball later, the outer race."""

    explicit_only = True

    depth = parameter(0.8335, "1", "depth in the middle; negative for a bump")
    width = parameter(math.radians(10.0), "rad", "extent along the ball's circumference", low=1e-6, high=TWO_PI)
    position = parameter(0.0, "rad", "turn of the ball from its start at which the pit meets the inner race")
    ball = integer(1, "number of the ball, counted from 1", low=1)


class LoadVariation(Effect):
    """A load beside the given one: amplitude * sin(2 pi frequency tau + phase) along x."""

    explicit_only = True

    amplitude = parameter(0.1020, "1", "amplitude")
    frequency = parameter(0.03912, "1", "periods per unit of time", low=0.0)
    phase = parameter(0.0, "rad", "phase at time 0")


class SpeedRamp(Effect):
    """Speed that changes evenly from time 0 and then stays, on top of the input."""

    explicit_only = True

    acceleration = parameter(6.121e-5, "1", "angular acceleration")
    duration = parameter(1278.0, "1", "time after which the speed stays", low=0.0)


class GivenStart(Effect):
    """Start from a given state instead of from equilibrium."""

    explicit_only = True

    x = parameter(0.0, "1", "position along the load")
    y = parameter(0.0, "1", "position across the load")
    velocity_x = parameter(0.0, "1", "velocity along the load")
    velocity_y = parameter(0.0, "1", "velocity across the load")


class DimensionlessBallBearing(TwoDofBearing):
    """The bearing with mass, stiffness and load 1: what is left are damping, clearance, speed, number of balls, and effects.

    Lengths in x_s = (W/K)^(2/3), times in 1/w_0 = sqrt(m / (K x_s^0.5)), forces in W; the time of a run is tau. The
    defaults are those of `BallBearing`, scaled.
    """

    title = "Ball bearing with two degrees of freedom, dimensionless"
    system = "bearings"
    default_step = 1.0
    default_stop = 640.0

    clearance = RadialClearance
    contact_damping = ContactDamping
    unbalance = Unbalance
    inner_waviness = Waviness
    outer_waviness = Waviness
    inner_defect = Defect
    outer_defect = Defect
    ball_defect = BallDefect
    load_variation = LoadVariation
    speed_ramp = SpeedRamp
    given_start = GivenStart

    balls = integer(8, "number of balls", low=1, high=200)
    diameter_ratio = parameter(11.9 / 52.0, "1", "ball diameter over pitch diameter", low=1e-6, high=1.0)
    contact_angle = parameter(0.0, "rad", "contact angle, for the speed of the cage", low=0.0, high=1.5)
    damping_ratio = parameter(3.9119e-3, "1", "damping over 2 m w_0", low=0.0)
    start_cage_angle = parameter(0.0, "rad", "angle of ball 1 from the line of the load at time 0")
    substep = parameter(0.06391, "1", "longest internal step", low=1e-12, high=1e3)

    speed = input_(0.081931, "1", "speed of the inner ring over w_0, positive from x to y", nominal=0.1)
    load = input_(1.0, "1", "load along x over that of the scales")
    transverse_load = input_(0.0, "1", "load along y over that of the scales")

    displacement_x = output("1", "position along the load")
    displacement_y = output("1", "position across the load")
    velocity_x = output("1", "velocity along the load")
    velocity_y = output("1", "velocity across the load")
    acceleration_x = output("1", "acceleration along the load", feedthrough=("load", "speed"))
    acceleration_y = output("1", "acceleration across the load", feedthrough=("transverse_load", "speed"))
    force_x = output("1", "force of the balls on the shaft along x", feedthrough=("speed",))
    force_y = output("1", "force of the balls on the shaft along y", feedthrough=("speed",))
    max_ball_load = output("1", "load of the most loaded ball", feedthrough=("speed",))
    loaded_balls = output("1", "number of balls in contact")
    inner_angle = output("rad", "angle of the inner ring in [0, 2 pi)")
    cage_angle = output("rad", "angle of ball 1 in [0, 2 pi)")

    presets = {
        "JIS 6306": Preset({"balls": 8, "diameter_ratio": 11.9 / 52.0, "damping_ratio": 3.9119e-3},
                           JIS6306_SOURCE + ", scaled", "recalled"),
    }

    @property
    def geometry(self) -> BallGeometry:
        p: dict[str, Any] = self.parameters
        return BallGeometry(p["balls"], p["diameter_ratio"], 1.0, contact_angle=p["contact_angle"])

    def constants(self) -> Constants:
        return constants(1.0, 2.0 * self.get("damping_ratio"), 1.0, self.geometry)


def scales(bearing: BallBearing) -> Scales:
    """The scales of a bearing with its present load; raises `BadInput` without a load, which leaves no length to scale by."""
    p: dict[str, Any] = bearing.parameters
    load = abs(bearing["load"])
    if load == 0.0:
        raise BadInput(bearing.name, "load = 0", "a load to scale by")
    length = (load / p["contact_stiffness"]) ** (2.0 / 3.0)
    return Scales(p["mass"], length, math.sqrt(p["mass"] / (p["contact_stiffness"] * math.sqrt(length))))


def dimensionless(bearing: BallBearing) -> tuple[DimensionlessBallBearing, Scales]:
    """The same bearing in dimensionless form, with its present inputs; not initialized."""
    by = scales(bearing)
    p: dict[str, Any] = bearing.parameters
    own = {
        "balls": p["balls"],
        "diameter_ratio": p["ball_diameter"] / p["pitch_diameter"],
        "contact_angle": p["contact_angle"],
        "damping_ratio": 0.5 * p["damping"] / by.of("N.s/m"),
        "start_cage_angle": p["start_cage_angle"],
        "substep": p["substep"] / by.time,
    }
    of_effects = {n: v / by.of(bearing.variables[n].unit) for n, v in p.items() if "." in n}
    scaled = DimensionlessBallBearing(bearing.on, own | of_effects, name=bearing.name)
    for name in scaled.inputs:
        scaled.set(name, bearing[name] / by.of(bearing.variables[name].unit))
    return scaled, by
