"""The dimensionless form of the ball bearing with two degrees of freedom, and the way to it from the dimensional one.

The derivation stands in `ball_bearing`. Every value scales by its unit, as mass, length and time do: the scales are those
three, chosen so that mass, stiffness and load become 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

from ..core.component import Preset
from ..core.contract import Refusal
from ..core.errors import BadInput
from ..core.kernels import kernel
from ..core.measure import BASES, parse
from ..core.variables import Variable, parameter
from . import ball_bearing, races
from .ball_bearing import JIS6306_SOURCE, BallBearing, TwoDofBearing
from .geometry import BallGeometry
from .races import ORDERS, CageFault
from .two_dof import LARGE_BALLS
from .two_dof_start import bearing_kernels, bearing_start, put_constants


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


def unitless(variable: Variable, start: float | None = None, text: str = "") -> Variable:
    """The dimensionless form of a dimensional variable."""
    return replace(variable, unit="1", nominal=1.0, start=variable.start if start is None else start, text=text or variable.text)


class RadialClearance(ball_bearing.RadialClearance):
    """A gap between balls and races; off, the concentric bearing is free of gap and of preload."""

    radial_clearance = unitless(ball_bearing.RadialClearance.radial_clearance, 1.667, "radial gap; negative for preload")


class ContactDamping(ball_bearing.ContactDamping):
    """Damping of each contact after Hunt and Crossley, Q = delta^1.5 (1 + 1.5 k delta'), never pulling."""

    coefficient = unitless(ball_bearing.ContactDamping.coefficient, 1.533e-3)


class Unbalance(ball_bearing.Unbalance):
    """The mass sits off the shaft's axis."""

    eccentricity = unitless(ball_bearing.Unbalance.eccentricity, 0.8335)


class Waviness(races.Waviness):
    """Waves of a race: the surface lies deeper by the sum of amplitude * cos(order * angle + phase), angle along the race."""

    amplitude = parameter((0.1667, *[0.0] * (ORDERS - 1)), "1", "amplitude of the order", size=ORDERS)


class Defect(races.Defect):
    """A pit in a race with the profile of a raised cosine: depth and slope are continuous, so nothing jumps as a ball passes."""

    depth = unitless(races.Defect.depth, 0.8335)


class BallDefect(races.BallDefect):
    """A pit on one ball that meets the inner race and, half a turn of the ball later, the outer race."""

    depth = unitless(races.BallDefect.depth, 0.8335)


class LoadVariation(ball_bearing.LoadVariation):
    """A load beside the given one: amplitude · sin(2π frequency τ + phase) along x."""

    amplitude = unitless(ball_bearing.LoadVariation.amplitude, 0.1020)
    frequency = unitless(ball_bearing.LoadVariation.frequency, 0.03912, "periods per unit of time")


class SpeedRamp(ball_bearing.SpeedRamp):
    """Speed that changes evenly from time 0 and then stays, on top of the input."""

    acceleration = unitless(ball_bearing.SpeedRamp.acceleration, 6.121e-5)
    duration = unitless(ball_bearing.SpeedRamp.duration, 1278.0)


class GivenStart(ball_bearing.GivenStart):
    """Start from a given state instead of from equilibrium."""

    x = unitless(ball_bearing.GivenStart.x)
    y = unitless(ball_bearing.GivenStart.y)
    velocity_x = unitless(ball_bearing.GivenStart.velocity_x)
    velocity_y = unitless(ball_bearing.GivenStart.velocity_y)


class DimensionlessBallBearing(TwoDofBearing):
    """The bearing with mass, stiffness and load 1: damping, clearance, speed, number of balls, and effects remain.

    Lengths in x_s = (W/K)^(2/3), times in 1/w_0 = sqrt(m / (K x_s^0.5)), forces in W; the time of a run is tau. The
    defaults are those of `BallBearing`, scaled.
    """

    title = "Ball bearing with two degrees of freedom, dimensionless"
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
    cage_fault = CageFault
    load_variation = LoadVariation
    speed_ramp = SpeedRamp
    given_start = GivenStart

    diameter_ratio = parameter(11.9 / 52.0, "1", "ball diameter over pitch diameter", low=1e-6, high=1.0)
    damping_ratio = parameter(3.9119e-3, "1", "damping over 2 m w_0", low=0.0)
    substep = parameter(0.06391, "1", "longest internal step", low=1e-12, high=1e3)

    speed = replace(
        TwoDofBearing.speed, start=0.081931, unit="1", nominal=0.1, text="speed of the inner ring over w_0, positive from x to y"
    )
    load = unitless(TwoDofBearing.load, 1.0, "load along x over that of the scales")
    transverse_load = unitless(TwoDofBearing.transverse_load, 0.0, "load along y over that of the scales")

    displacement_x = unitless(TwoDofBearing.displacement_x)
    displacement_y = unitless(TwoDofBearing.displacement_y)
    velocity_x = unitless(TwoDofBearing.velocity_x)
    velocity_y = unitless(TwoDofBearing.velocity_y)
    acceleration_x = unitless(TwoDofBearing.acceleration_x)
    acceleration_y = unitless(TwoDofBearing.acceleration_y)
    force_x = unitless(TwoDofBearing.force_x)
    force_y = unitless(TwoDofBearing.force_y)
    max_ball_load = unitless(TwoDofBearing.max_ball_load)

    presets = {
        "JIS 6306": Preset(
            {"balls": 8, "diameter_ratio": 11.9 / 52.0, "damping_ratio": 3.9119e-3}, JIS6306_SOURCE + ", scaled", "unconfirmed"
        )
    }

    refusals = {
        LARGE_BALLS: Refusal("balls of {diameter_ratio} on a pitch diameter of 1", "balls smaller than the pitch diameter")
    }

    @property
    def geometry(self) -> BallGeometry:
        p: dict[str, Any] = self.parameters
        return BallGeometry(p["balls"], p["diameter_ratio"], 1.0, contact_angle=p["contact_angle"])


@kernel
def dimensionless_start(t, s, p, e):
    """The start of the dimensionless bearing."""
    if not p.diameter_ratio < 1.0:
        return LARGE_BALLS
    put_constants(s, 1.0, 2.0 * p.damping_ratio, 1.0, p.diameter_ratio, 1.0, p.contact_angle)
    return bearing_start(p.start_cage_angle, s, e)


DimensionlessBallBearing.kernels = bearing_kernels(__name__, dimensionless_start)


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
