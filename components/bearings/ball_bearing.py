"""Ball bearing with two degrees of freedom, dimensional and dimensionless: one model, one set of kernels.

Scaling. Let W be the load, K the stiffness of a ball between the races, m the mass. Lengths in x_s = (W/K)^(2/3), the
deformation of one ball under the whole load, and times in 1/w_0 with w_0 = sqrt(K x_s^0.5 / m) turn

    m x'' + c x' + sum K (x cos theta_j + ... - c_r)^1.5 cos theta_j = W + m e w² cos a

with x = x_s X, t = tau/w_0, after division by W = K x_s^1.5 = m x_s w_0², into

    X'' + 2 zeta X' + sum (X cos theta_j + ... - G)^1.5 cos theta_j = 1 + eps Om² cos a

    2 zeta = c / (m w_0),   G = c_r / x_s,   eps = e / x_s,   Om = w / w_0

Waviness and defects scale as lengths, the coefficient of the contact damping (s/m) as 1/(x_s w_0), angles not at all: the
dimensionless bearing is the dimensional one with m = K = W = 1, and neither has an equation of its own. What the scaling buys:
all states are near 1, so that a tolerance means the same for each. In metres and with an absolute tolerance of 1e-6, the
default of SciPy, a motion of 17 um is as large as its own tolerance.

Sources: the class of models of Fukata et al. (1985), Tiwari, Harsha, Zhang; Ambrozkiewicz et al. (2021) for what it covers
(stiffness after Hertz, nonlinear damping, radial clearance, load, eccentricity, shape error; dimensionless). That paper's
own parameters and numbers were not at hand.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.component import Effect, Preset
from ..core.contract import Refusal
from ..core.errors import BadInput, StepFailed
from ..core.integrators import SUBSTEP_TOO_LONG, OdeComponent
from ..core.kernels import kernel
from ..core.variables import PARTS, count, input_, integer, output, parameter
from .geometry import BallGeometry
from .races import BallDefect, CageFault, Defect, Waviness, wave_shapes
from .two_dof import (
    COSINE,
    DISPLACED_TOO_FAR,
    GAP,
    LARGE_BALLS,
    MESSAGE,
    NARROW,
    PASSED,
    SINCE,
    SINE,
    TOO_STIFF,
    Constants,
    fill_gaps,
)
from .two_dof_start import bearing_kernels, bearing_start, put_constants

JIS6306_SOURCE = "the JIS 6306 set of Fukata et al. (1985) as later papers on the same model quote it"


class RadialClearance(Effect):
    """A gap between balls and races; off, the concentric bearing is free of gap and of preload."""

    radial_clearance = parameter(10e-6, "m", "radial gap, half the diametral clearance; negative for preload", nominal=1e-6)


class ContactDamping(Effect):
    """Damping of each contact after Hunt and Crossley, Q = K delta^1.5 (1 + 1.5 k delta') >= 0; k is a choice of ours."""

    coefficient = parameter(0.2, "s/m", "k", low=0.0)


class Unbalance(Effect):
    """The mass sits off the shaft's axis."""

    eccentricity = parameter(5e-6, "m", "distance of the centre of mass from the axis", low=0.0, nominal=1e-6)
    phase = parameter(0.0, "rad", "its angle on the inner ring")


class LoadVariation(Effect):
    """A load beside the given one: amplitude · sin(2π frequency t + phase) along x."""

    explicit_only = True

    amplitude = parameter(20.0, "N", "amplitude", nominal=100.0)
    frequency = parameter(50.0, "Hz", "frequency", low=0.0)
    phase = parameter(0.0, "rad", "phase at time 0")


class SpeedRamp(Effect):
    """Speed that changes evenly from time 0 and then stays, on top of the input."""

    explicit_only = True

    acceleration = parameter(100.0, "rad/s2", "angular acceleration")
    duration = parameter(1.0, "s", "time after which the speed stays", low=0.0)


class GivenStart(Effect):
    """Start from a given state instead of from equilibrium."""

    explicit_only = True
    read_by = ("initialize",)

    x = parameter(0.0, "m", "position along the load", nominal=1e-6)
    y = parameter(0.0, "m", "position across the load", nominal=1e-6)
    velocity_x = parameter(0.0, "m/s", "velocity along the load", nominal=1e-3)
    velocity_y = parameter(0.0, "m/s", "velocity across the load", nominal=1e-3)


class TwoDofBearing(OdeComponent):
    """The common part of the dimensional and the dimensionless bearing; the latter replaces all variables with a unit."""

    system = "bearings"
    start_inputs = ("load", "transverse_load")

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

    balls = integer(8, "number of balls", low=1, high=200, structural=PARTS)
    contact_angle = parameter(0.0, "rad", "contact angle, for the speed of the cage", low=0.0, high=1.5)
    start_cage_angle = parameter(0.0, "rad", "angle of ball 1 from the line of the load at time 0")

    speed = input_(104.71975511965978, "rad/s", "speed of the inner ring, positive from x to y", nominal=100.0)
    load = input_(196.0, "N", "load along x", nominal=100.0)
    transverse_load = input_(0.0, "N", "load along y", nominal=100.0)

    displacement_x = output("m", "position along the load", nominal=1e-6)
    displacement_y = output("m", "position across the load", nominal=1e-6)
    velocity_x = output("m/s", "velocity along the load", nominal=1e-3)
    velocity_y = output("m/s", "velocity across the load", nominal=1e-3)
    acceleration_x = output("m/s2", "acceleration along the load", feedthrough=("load", "speed"))
    acceleration_y = output("m/s2", "acceleration across the load", feedthrough=("transverse_load", "speed"))
    force_x = output("N", "force of the balls on the shaft along x", nominal=100.0, feedthrough=("speed",))
    force_y = output("N", "force of the balls on the shaft along y", nominal=100.0, feedthrough=("speed",))
    max_ball_load = output("N", "load of the most loaded ball", nominal=100.0, feedthrough=("speed",))
    loaded_balls = count("number of balls in contact")
    inner_angle = output("rad", "angle of the inner ring in [0, 2 pi)")
    cage_angle = output("rad", "angle of ball 1 in [0, 2 pi)")

    refusals = {
        SUBSTEP_TOO_LONG: Refusal(
            "substep = {substep}", "at most {limits[1]}, what the impacts that may come need", "Reduce substep."
        ),
        DISPLACED_TOO_FAR: Refusal(
            "cage_fault.offset = {cage_fault.offset} rad", "less than {message[0]} rad, half the distance of two of {balls} balls"
        ),
        TOO_STIFF: Refusal(
            "a ball is pressed in by {message[0]}, too stiff a contact for internal steps of {message[1]}",
            "a softer one",
            "Reduce substep to {message[2]} or less",
        ),
    } | {
        PASSED + k: Refusal(
            "substep = {substep} at a speed of {message[1]}",
            "at most {message[0]}, a quarter of the passage of a ball through " + name,
            "Reduce substep or widen the defect.",
        )
        for k, name in enumerate(NARROW)
    }

    @property
    def geometry(self) -> BallGeometry:
        """Geometry of the balls, and with it the defect frequencies."""
        raise NotImplementedError

    def states(self) -> int:
        """x, y, their velocities, inner angle, cage angle and, with `ball_defect`, spin."""
        return 7 if "ball_defect" in self.on else 6

    def shapes(self) -> dict[str, Any]:
        """`constants`: see `two_dof`.  `balls`: see there.  `message`: numbers of a message.  Waves: see `races`."""
        n: Any = self.get("balls")
        if "ball_defect" in self.on and (ball := self.get("ball_defect.ball")) > n:
            raise BadInput(self.name, f"ball_defect.ball = {ball}", f"one of the {n} balls")
        if "cage_fault" in self.on and ((ball := self.get("cage_fault.ball")) > n or n < 4):
            raise BadInput(self.name, f"cage_fault.ball = {ball}", f"one of four or more balls, here {n}")
        return super().shapes() | {"constants": Constants, "balls": (SINCE + 1, n), "message": MESSAGE} | wave_shapes(self.on, n)

    def _check(self, status: int) -> None:
        if status == TOO_STIFF:  # a run under way
            actual, _, remedy = map(self._with_values, type(self).refusals[status])
            raise StepFailed(self.name, self.t, actual, remedy)
        super()._check(status)

    def energy(self) -> float:
        """Kinetic energy plus that of the contacts, J (or in units of the scales); the load is not counted."""
        s, _, e = self.arguments
        k = s.constants
        fill_gaps(self.x, 0.0, k, s.balls, s.inner_waves, s.outer_waves, e)
        cosine, sine, gap = s.balls[[COSINE, SINE, GAP]]
        at = self.x[5] + np.arctan2(sine, cosine)
        delta = np.maximum(self.x[0] * np.cos(at) + self.x[1] * np.sin(at) - gap, 0.0)
        return float(0.5 * k.mass * (self.x[2] ** 2 + self.x[3] ** 2) + 0.4 * k.stiffness * (delta**2.5).sum())


class BallBearing(TwoDofBearing):
    """A rigid mass on a shaft in a ball bearing: x along the load, y across it, positive about the shaft from x to y.

    The equations stand in `two_dof`, effects among them; without a static equilibrium the start is the middle, at rest.
    Massless balls at equal distances, no slip, fixed outer ring; contact after Hertz; damping c that stands for all but contact.
    """

    title = "Ball bearing with two degrees of freedom"
    default_stop = 0.5

    ball_diameter = parameter(11.9e-3, "m", "diameter of the balls", low=1e-6, nominal=0.01)
    pitch_diameter = parameter(52e-3, "m", "diameter of the circle of their centres", low=1e-6, nominal=0.1)
    contact_stiffness = parameter(
        1.334e10, "1", "stiffness of a ball between both races, N/m^1.5; no unit has broken exponents", low=1e-3, nominal=1e10
    )
    mass = parameter(20.0, "kg", "mass of shaft and inner ring", low=1e-12)
    damping = parameter(200.0, "N.s/m", "damping of the mass against the outer ring", low=0.0, nominal=100.0)
    substep = parameter(5e-5, "s", "longest internal step", low=1e-12, high=1.0)

    presets = {
        "JIS 6306": Preset(
            {
                "balls": 8,
                "ball_diameter": 11.9e-3,
                "pitch_diameter": 52e-3,
                "contact_stiffness": 1.334e10,
                "mass": 20.0,
                "damping": 200.0,
            },
            JIS6306_SOURCE + "; races of 40.1 and 63.9 mm; the stiffness is 18 % above that of grooves of 0.52 d",
            "unconfirmed",
        ),
        "6205": Preset(
            {"balls": 9, "ball_diameter": 7.94e-3, "pitch_diameter": 39.04e-3, "contact_stiffness": 9.319e9},
            "geometry of the 6205 from memory, its stiffness for steel and grooves of 0.52 d from Hertz's solution",
            "unconfirmed",
        ),
    }

    refusals = {
        LARGE_BALLS: Refusal(
            "balls of {ball_diameter} m on a pitch diameter of {pitch_diameter} m", "balls smaller than the pitch diameter"
        )
    }

    @property
    def geometry(self) -> BallGeometry:
        p: dict[str, Any] = self.parameters
        return BallGeometry(p["balls"], p["ball_diameter"], p["pitch_diameter"], contact_angle=p["contact_angle"])


@kernel
def ball_bearing_start(t, s, p, e):
    """The start of the dimensional bearing."""
    if not p.ball_diameter < p.pitch_diameter:
        return LARGE_BALLS
    put_constants(s, p.mass, p.damping, p.contact_stiffness, p.ball_diameter, p.pitch_diameter, p.contact_angle)
    return bearing_start(p.start_cage_angle, s, e)


BallBearing.kernels = bearing_kernels(__name__, ball_bearing_start)
