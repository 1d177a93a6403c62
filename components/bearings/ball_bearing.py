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

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ..core.component import Effect, Preset
from ..core.errors import BadInput, StepFailed
from ..core.integrators import OdeComponent
from ..core.kernels import DONE
from ..core.variables import input_, integer, output, parameter
from .geometry import BallGeometry
from .races import TWO_PI, BallDefect, CageFault, Defect, Displaced, Waviness, race_waves, smooth_pit, wrapped
from .two_dof import (
    COSINE,
    DEEPEST,
    GAP,
    GROWTH,
    LOAD,
    SINCE,
    SINE,
    SLOPE,
    SPEED,
    TRANSVERSE_LOAD,
    Clearance,
    Constants,
    Harmonic,
    HuntCrossley,
    Imbalance,
    Ramp,
    advance,
    bearing_outputs,
    constants,
    fill_gaps,
    static_position,
)

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
    """A load beside the given one: amplitude * sin(2 pi frequency t + phase) along x."""

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

    x = parameter(0.0, "m", "position along the load", nominal=1e-6)
    y = parameter(0.0, "m", "position across the load", nominal=1e-6)
    velocity_x = parameter(0.0, "m/s", "velocity along the load", nominal=1e-3)
    velocity_y = parameter(0.0, "m/s", "velocity across the load", nominal=1e-3)


class TwoDofBearing(OdeComponent):
    """What the dimensional and the dimensionless bearing share; the dimensionless one replaces what has a unit."""

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

    balls = integer(8, "number of balls", low=1, high=200)
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
    loaded_balls = output("1", "number of balls in contact")
    inner_angle = output("rad", "angle of the inner ring in [0, 2 pi)")
    cage_angle = output("rad", "angle of ball 1 in [0, 2 pi)")

    advance = advance
    output_kernel = bearing_outputs

    @property
    def geometry(self) -> BallGeometry:
        """Geometry of the balls, and with it the defect frequencies."""
        raise NotImplementedError

    def constants(self) -> Constants:
        """What the kernels need of the own parameters."""
        raise NotImplementedError

    def kernel_arguments(self) -> tuple[Any, ...]:
        p, (_, e) = self.constants(), self._declared_arguments()

        def waves(v: Any) -> Any:
            return race_waves(v.order, v.amplitude, v.phase, p.balls.shape[1])

        def pit(v: Any) -> Any:
            return smooth_pit(v.depth, v.width, v.position)

        def ball_pit(v: Any) -> Any:
            if v.ball > p.balls.shape[1]:
                raise BadInput(self.name, f"ball_defect.ball = {v.ball}", f"one of the {p.balls.shape[1]} balls")
            return smooth_pit(v.depth, v.width, v.position, v.ball)

        def displaced(v: Any) -> Any:
            n = p.balls.shape[1]
            if v.ball > n or n < 4:
                raise BadInput(self.name, f"cage_fault.ball = {v.ball}", f"one of four or more balls, here {n}")
            if abs(v.offset) >= math.pi / n:
                raise BadInput(self.name, f"cage_fault.offset = {v.offset:g} rad", f"less than {math.pi / n:.4g} rad, half the "
                               f"distance of two of {n} balls")
            at = TWO_PI * (v.ball - 1) / n + v.offset
            p.balls[COSINE, v.ball - 1], p.balls[SINE, v.ball - 1] = math.cos(at), math.sin(at)
            return Displaced(int(v.ball) - 1, float(v.offset))

        forms: dict[str, Callable[[Any], Any]] = {
            "clearance": lambda v: Clearance(v.radial_clearance),
            "contact_damping": lambda v: HuntCrossley(v.coefficient),
            "unbalance": lambda v: Imbalance(p.mass * v.eccentricity, v.phase),
            "inner_waviness": waves,
            "outer_waviness": waves,
            "inner_defect": pit,
            "outer_defect": pit,
            "ball_defect": ball_pit,
            "cage_fault": displaced,
            "load_variation": lambda v: Harmonic(v.amplitude, 2.0 * math.pi * v.frequency, v.phase),
            "speed_ramp": lambda v: Ramp(v.acceleration, v.duration),
            "given_start": lambda v: None,  # no business of the kernels
        }
        return p, e._replace(**{name: forms[name](getattr(e, name)) for name in self.on})

    def initial_state(self) -> np.ndarray:
        """x, y, their velocities, inner angle, cage angle and, with `ball_defect`, spin."""
        x = np.zeros(7 if "ball_defect" in self.on else 6)
        x[5] = wrapped(self.get("start_cage_angle"))
        if "given_start" in self.on:
            x[:4] = [self.get(f"given_start.{n}") for n in ("x", "y", "velocity_x", "velocity_y")]
            return x
        if static_position(x, self.u[0, LOAD], self.u[0, TRANSVERSE_LOAD], *self.arguments) != DONE:
            x[:2] = 0.0  # nothing carries the load: a fall from the middle
        return x

    def _initialize(self, t: float) -> int:
        """A step too long for impacts is refused; one too long for a defect is so here only, while parameters can be changed.

        One that a growing speed makes too long is shortened instead: a run under way is not broken off for what it costs.
        """
        if (given := self.get("substep")) > (limit := self.stable_step()):
            raise BadInput(self.name, f"substep = {given:g}", f"at most {limit:.3g}, what the impacts that may come need",
                           "Reduce substep.")
        status = super()._initialize(t)
        self._proven = 0.0
        self._pass_angle, narrowest = self._shortest_pass()
        if (needed := self._longest_substep(t, 0.0)) < self._substep:
            raise BadInput(self.name, f"substep = {self._substep:g} at a speed of {self._fastest(t, 0.0):g}",
                           f"at most {needed:.3g}, a quarter of the passage of a ball through {narrowest}",
                           "Reduce substep or widen the defect.")
        return status

    def _shortest_pass(self) -> tuple[float, str]:
        """Turn of the inner ring, rad, during which a ball passes a quarter of the narrowest pit or half wave, and its name."""
        p, e = self.arguments
        limits = [(math.inf, "nothing")]
        for name, pit, ratio in (("inner_defect", e.inner_defect, 1.0 - p.cage_ratio), ("outer_defect", e.outer_defect,
                                                                                        p.cage_ratio),
                                 ("ball_defect", e.ball_defect, p.spin_ratio)):
            if pit is not None:
                limits.append((0.5 * pit.half_width / ratio, name))
        for name, waves, ratio in (("inner", e.inner_waviness, 1.0 - p.cage_ratio), ("outer", e.outer_waviness, p.cage_ratio)):
            if waves is not None and waves.order.size:
                order = waves.order.max()
                limits.append((0.25 * math.pi / (order * ratio), f"half a wave of {name}_waviness of order {order:g}"))
        return min(limits)

    def _fastest(self, t: float, h: float) -> float:
        """Largest speed within a step."""
        _, e = self.arguments
        speed, slope, half = self.u[0, SPEED], self.u[1, SPEED], self.u[2, SPEED]
        if e.speed_ramp is None:
            return fastest(t, h, speed, slope, half, 0.0, 0.0)
        return fastest(t, h, speed, slope, half, e.speed_ramp.acceleration, e.speed_ramp.duration)

    def _longest_substep(self, t: float, h: float) -> float:
        """Longest internal step that does not step over a defect or a wave."""
        return self._pass_angle / max(self._fastest(t, h), 1e-300) if self._pass_angle < math.inf else math.inf

    def _step(self, t: float, h: float) -> int:
        substep = self._substep
        if self._pass_angle < math.inf:
            substep = min(substep, self._longest_substep(t, h))  # where the speed has grown since the start
        n = max(1, math.ceil(h / substep * (1.0 - 1e-9)))
        balls = self.arguments[0].balls
        balls[DEEPEST, 0] = 0.0
        if self.arguments[1].unbalance is not None:  # only an unbalance feels the speed's derivative
            balls[SLOPE, 0], balls[GROWTH, 0], balls[SINCE, 0] = self.u[1, SPEED], 2.0 * self.u[2, SPEED], t
        status = type(self).advance(t, h, n, self.x, self.u, self.y, self._work, self.counts, *self.arguments)
        if balls[DEEPEST, 0] > self._proven and status == DONE:
            self._check_contacts(t, h / n, float(balls[DEEPEST, 0]))
        return status

    def _check_contacts(self, t: float, substep: float, deepest: float) -> None:
        """Stop a run whose contacts became too stiff for its internal steps: it would stay finite, and be wrong."""
        p, e = self.arguments
        if (needed := _resolved_step(p, e.contact_damping, deepest)) < substep * (1.0 - 1e-9):
            raise StepFailed(self.name, t, f"a ball is pressed in by {deepest:.3g}, too stiff a contact for internal steps of "
                             f"{substep:.3g}", f"Reduce substep to {needed:.2g} or less")
        if substep >= self._substep * (1.0 - 1e-9):
            self._proven = deepest

    def energy(self) -> float:
        """Kinetic energy plus that of the contacts, J (or in units of the scales); the load is not counted."""
        p, e = self.arguments
        fill_gaps(self.x, 0.0, p, e)
        cosine, sine, gap = p.balls[[COSINE, SINE, GAP]]
        at = self.x[5] + np.arctan2(sine, cosine)
        delta = np.maximum(self.x[0] * np.cos(at) + self.x[1] * np.sin(at) - gap, 0.0)
        return float(0.5 * p.mass * (self.x[2] ** 2 + self.x[3] ** 2) + 0.4 * p.stiffness * (delta**2.5).sum())

    def stable_step(self) -> float:
        """Longest step for the deepest penetration to which energy at the start and a fall through the clearance can lead.

        With the forces of the start; what comes later, a greater load or resonance, is checked at every step.
        """
        p, e = self.kernel_arguments()
        gap = 0.0 if e.clearance is None else e.clearance.gap
        force = math.hypot(self.u[0, LOAD], self.u[0, TRANSVERSE_LOAD])
        force += 0.0 if e.load_variation is None else abs(e.load_variation.amplitude)
        force += 0.0 if e.unbalance is None else e.unbalance.moment * self.u[0, SPEED] ** 2
        energy, fall = 0.0, 2.0 * max(gap, 0.0)
        if "given_start" in self.on:
            x, y, vx, vy = (self.get(f"given_start.{n}") for n in ("x", "y", "velocity_x", "velocity_y"))
            away = math.hypot(x, y)
            energy = 0.5 * p.mass * (vx**2 + vy**2) + 0.4 * p.stiffness * _sharing(p) * max(away - max(gap, 0.0), 0.0) ** 2.5
            fall = max(fall, away + max(gap, 0.0))
        deepest = (2.5 * force / p.stiffness) ** (2.0 / 3.0)
        for _ in range(20):  # 2/5 K d^2.5 = energy + force (d + fall), a contraction
            deepest = (2.5 / p.stiffness * (energy + force * (deepest + fall))) ** 0.4
        return _resolved_step(p, e.contact_damping, deepest + max(-gap, 0.0))


def fastest(t: float, h: float, speed: float, slope: float, half: float, acceleration: float, duration: float) -> float:
    """Largest speed within a step: input and ramp together are one parabola before the ramp's end and one after it."""
    turns = (-0.5 * slope / half, -0.5 * (slope + acceleration) / half) if half != 0.0 else (0.0, 0.0)
    top = 0.0
    for s in (0.0, h, duration - t, turns[0], turns[1]):
        if 0.0 <= s <= h:
            top = max(top, abs(speed + s * (slope + s * half) + acceleration * min(max(t + s, 0.0), duration)))
    return top


def _sharing(p: Constants) -> float:
    """How many balls resist one direction at most: the largest sum of their squared cosines."""
    n, even, odd = p.balls.shape[1], 0.0, 0.0
    for k in range(n):
        c, s = p.balls[COSINE, k], p.balls[SINE, k]
        even += c * c - s * s
        odd += 2.0 * c * s
    uneven = math.hypot(even, odd)  # 0 for three and more at equal distances
    return 0.5 * (n + uneven) if uneven > 1e-9 * n else 0.5 * n


def _resolved_step(p: Constants, damping: HuntCrossley | None, deepest: float) -> float:
    """1 / |eigenvalue| at a penetration, an eighth of the duration of an impact on one of eight balls.

    RK4 is stable up to 2.78 / |eigenvalue|, but loses energy where contacts open and close: in 260 impacts without any
    damping 95 % at 2.2 / |eigenvalue|, 44 % at 1.1, 2 % at 0.56 and a permille at 0.27 were measured.
    """
    damper = p.damping
    if damping is not None:
        damper += 1.5 * damping.coefficient * p.stiffness * deepest**1.5 * _sharing(p)
    rate = math.sqrt(1.5 * p.stiffness * math.sqrt(deepest) * _sharing(p) / p.mass) + damper / p.mass
    return 1.0 / rate if rate > 0.0 else math.inf


class BallBearing(TwoDofBearing):
    """A rigid mass on a shaft in a ball bearing: x along the load, y across it, positive about the shaft from x to y.

    The equations stand in `two_dof`, effects among them; without a static equilibrium the start is the middle, at rest.
    Massless balls at equal distances, no slip, fixed outer ring; contact after Hertz; damping c that stands for all but contact.
    """

    title = "Ball bearing with two degrees of freedom"
    default_stop = 0.5

    ball_diameter = parameter(11.9e-3, "m", "diameter of the balls", low=1e-6, nominal=0.01)
    pitch_diameter = parameter(52e-3, "m", "diameter of the circle of their centres", low=1e-6, nominal=0.1)
    contact_stiffness = parameter(1.334e10, "1", "stiffness of a ball between both races, N/m^1.5; no unit has broken exponents",
                                  low=1e-3, nominal=1e10)
    mass = parameter(20.0, "kg", "mass of shaft and inner ring", low=1e-12)
    damping = parameter(200.0, "N.s/m", "damping of the mass against the outer ring", low=0.0, nominal=100.0)
    substep = parameter(5e-5, "s", "longest internal step", low=1e-12, high=1.0)

    presets = {
        "JIS 6306": Preset(
            {"balls": 8, "ball_diameter": 11.9e-3, "pitch_diameter": 52e-3, "contact_stiffness": 1.334e10, "mass": 20.0,
             "damping": 200.0},
            JIS6306_SOURCE + "; races of 40.1 and 63.9 mm; the stiffness is 18 % above that of grooves of 0.52 d", "recalled"),
        "6205": Preset(
            {"balls": 9, "ball_diameter": 7.94e-3, "pitch_diameter": 39.04e-3, "contact_stiffness": 9.319e9},
            "geometry of the 6205 as recalled, its stiffness for steel and grooves of 0.52 d from Hertz's solution", "recalled"),
    }

    @property
    def geometry(self) -> BallGeometry:
        p: dict[str, Any] = self.parameters
        return BallGeometry(p["balls"], p["ball_diameter"], p["pitch_diameter"], contact_angle=p["contact_angle"])

    def constants(self) -> Constants:
        p: dict[str, Any] = self.parameters
        return constants(p["mass"], p["damping"], p["contact_stiffness"], self.geometry)
