"""Wind turbine: the rotor, its inertia, and the torque that the wind gives it."""

from __future__ import annotations

import math
import warnings
from typing import Any

from ..core.component import Effect, Preset
from ..core.contract import Refusal
from ..core.errors import BadInput
from ..core.events import EventComponent, event_kernels
from ..core.friction import stick_friction, stick_guard, stick_mode, stick_switch
from ..core.integrators import RK4_STABILITY_RADIUS
from ..core.kernels import DONE, OWN, kernel
from ..core.variables import choice, input_, output, parameter, text
from .curves import BETZ, CURVES, FARM, torque_coefficient
from .performance import coefficient_of_table, performance_of, prepare

STRONGEST_WIND = 60.0  # m/s, for the stable step
LARGEST_NUMBER = 1e12  # of a ratio: where the wind dies under a turning rotor, the torque is that of no wind long before
LARGEST_RATIO = 20.0  # up to which the curves are meant; where the wind dies under a turning rotor, there is no bound
DEGREE = math.pi / 180.0
STEEPNESS = 400  # pieces of the curve whose slopes are compared, up to the largest ratio
ROUNDED = 1e-9  # degrees by which a pitch in rad misses that of a row
PITCHES, MOST_PITCH = 90, 90.0  # pitches at which they are compared, and the largest, degrees: a feathered blade
ABOVE_BETZ, STATIC_BELOW_KINETIC = OWN + 1, OWN + 2


class Pitch(Effect):
    """Blades that turn about their own axis: the curves "heier", "simple" and "variant" know it; a negative angle counts as 0."""

    angle = input_(0.0, "rad", "pitch of the blades out of their best position", nominal=0.1)


class PerformanceTable(Effect):
    """The turbine's own curve, measured or computed, in the place of the fits.

    A CSV table with a header and one column of `power_coefficient` or `torque_coefficient` over `tip_speed_ratio`, and, where needed,
    `pitch [deg]`: the same ratios for each pitch; without the effect `pitch` that of 0 counts. Between the ratios a cubic without
    overshoot of the torque coefficient, between the pitches a straight line; before the first and behind the last row the coefficient
    stays as it is, and a run warns of a pitch beyond those of the table. So the
    table has to end at runaway, where the power is 0 or negative. At a ratio of 0 a power coefficient says
    nothing of the torque: such a row is left out, and a rotor starts with the torque coefficient of the next one.
    """

    explicit_only = True
    replaces = ("curve", "standstill_coefficient", "runaway_ratio")

    table = text(
        "pitch [deg],tip_speed_ratio,torque_coefficient\n0,0,0.5\n0,1.2,0.25\n0,2.4,0\n20,0,0.2\n20,1.2,0.05\n20,2.4,-0.02\n",
        "coefficients as a CSV table; a scene may name its file",
    )


class Furling(Effect):
    """The rotor turns out of a strong wind, so that the component along its axis stays at a given speed; a model of ours."""

    explicit_only = True

    wind = parameter(8.0, "m/s", "wind above which the rotor turns away", low=1e-3)


class BearingFriction(Effect):
    """Dry friction of the rotor's bearings, with exact standstill."""

    kinetic = parameter(1.0, "N.m", "friction torque while the rotor turns; a choice of ours", low=0.0)
    static = parameter(1.0, "N.m", "torque that sets the resting rotor in motion; no less than the kinetic one", low=1e-9)


class WindTurbine(EventComponent):
    """Rotor of radius R in a wind v, with its inertia J and a transmission that takes a torque from it.

        J w' = T - T1 - b w,    T = rho/2 pi R³ v² C_Q(w R / v),    P = T w = rho/2 pi R² v³ C_p,    C_p = (w R / v) C_Q

    Curves: three exponential fits in wide use, see `curves`, and the straight line of a farm windmill with many blades,
    C_Q = C_0 (1 - ratio / ratio_0), whose C_p is at most C_0 ratio_0 / 4, at half of ratio_0. At standstill "simple" and
    "variant" give no torque, "heier" 0.0068 of its linear term, and the farm windmill its largest: that is what it is built for.
    A negative wind counts as none. Coefficients refer to the undisturbed wind; without wind, and where the tips are more than 20
    times as fast as the wind, coefficient and ratio are given as 0.
    Source of the fits: S. Heier, Grid Integration of Wind Energy, and public repositories; of the line: textbooks, from memory.
    """

    title = "Wind turbine"
    system = "wind_pump"
    default_step = 1e-2
    default_stop = 60.0
    start_inputs = ("wind", "torque", "pitch.angle")  # they decide whether the rotor sticks

    pitch = Pitch
    performance_table = PerformanceTable
    furling = Furling
    bearing_friction = BearingFriction

    curve = choice("farm", CURVES, "curve of the torque coefficient over the tip speed ratio")
    radius = parameter(1.5, "m", "radius of the rotor", low=1e-3)
    inertia = parameter(15.0, "kg.m2", "moment of inertia of rotor and shaft", low=1e-9)
    damping = parameter(0.0, "N.m.s/rad", "viscous friction", low=0.0)
    density = parameter(1.225, "kg/m3", "density of the air", low=1e-6)
    standstill_coefficient = parameter(0.5, "1", "torque coefficient of the farm windmill at standstill; from memory", low=1e-6)
    runaway_ratio = parameter(2.4, "1", "tip speed ratio at which the farm windmill gives no torque; from memory", low=1e-3)
    start_speed = parameter(0.0, "rad/s", "speed at the start")
    start_angle = parameter(0.0, "rad", "angle at the start")
    substep = parameter(5e-3, "s", "longest internal step", low=1e-9, high=1.0)

    wind = input_(0.0, "m/s", "wind speed along the axis", nominal=5.0)
    torque = input_(0.0, "N.m", "torque of what the turbine drives, positive where it brakes", nominal=10.0)

    speed = output("rad/s", "speed of the rotor")
    angle = output("rad", "angle of the rotor, turns included")
    aerodynamic_torque = output("N.m", "torque of the wind", nominal=10.0, feedthrough=("wind", "pitch.angle"))
    power_coefficient = output("1", "power over that of the wind through the rotor's disk", feedthrough=("wind", "pitch.angle"))
    tip_speed_ratio = output("1", "speed of the blades' tips over wind speed", feedthrough=("wind",))
    power = output("W", "power of the wind's torque", nominal=10.0, feedthrough=("wind", "pitch.angle"))

    presets = {
        "farm windmill": Preset(
            {"radius": 1.5, "inertia": 15.0, "standstill_coefficient": 0.5, "runaway_ratio": 2.4},
            "straight line of the torque coefficient as textbooks draw it; its numbers from memory, size and inertia chosen",
            "unconfirmed",
        )
    }

    refusals = {
        ABOVE_BETZ: Refusal(
            "standstill_coefficient * runaway_ratio / 4 = {largest[0]}, the largest power coefficient",
            "at most 16/27, Betz's limit",
            "Reduce one of them.",
        ),
        STATIC_BELOW_KINETIC: Refusal(
            "bearing_friction.static = {bearing_friction.static} N.m",
            "at least the kinetic friction, {bearing_friction.kinetic} N.m",
            "Raise it.",
        ),
    }

    def states(self) -> int:
        """Speed and angle and, with `bearing_friction`, the direction of its sliding."""
        return 3 if "bearing_friction" in self.on else 2

    def shapes(self) -> dict[str, Any]:
        """`largest`: power coefficient of the farm windmill at its best.  `performance`: see `Performance`; None without a table.

        `noted`: whether a pitch lay beyond the table's, the first one, degrees, and its time, s; None without both.
        """
        performance = None
        if "performance_table" in self.on:
            performance = performance_of(str(self.parameters["performance_table.table"]), "pitch" in self.on, self.name)
        elif "pitch" in self.on and self.parameters["curve"] == "farm":
            raise BadInput(
                self.name,
                "effect 'pitch' with curve 'farm'",
                "a curve that knows pitch: heier, simple or variant",
                "Choose another curve, or leave the effect off.",
            )
        noted = 3 if performance is not None and "pitch" in self.on else None
        return super().shapes() | {"largest": 1, "performance": performance, "noted": noted}

    def _initialize(self, t: float) -> int:
        self._warned = False
        return super()._initialize(t)

    def stepped(self, t: float) -> None:
        """As of any component; warns once of a pitch beyond those of the table."""
        super().stepped(t)
        noted = self.arguments[0].noted
        if noted is not None and noted[0] > 0.0 and not self._warned:
            self._warned = True
            warnings.warn(
                f"{self.name}: at t = {noted[2]:.4g} s the pitch of {noted[1]:.4g} deg lies beyond those of performance_table.table; "
                "the nearest one of the table counts",
                stacklevel=2,
            )

    def energy(self) -> float:
        """Energy of rotation, J."""
        return 0.5 * self.arguments[1].inertia * float(self.x[0]) ** 2


IN = WindTurbine.input_places()
OUT = WindTurbine.output_places()


@kernel
def coefficient_at(ratio, degrees, s, p, e):
    """Torque coefficient at a tip speed ratio and a pitch in degrees."""
    if e.performance_table is not None:
        return coefficient_of_table(ratio, degrees, s.performance)
    return torque_coefficient(p.curve, ratio, degrees, p.standstill_coefficient, p.runaway_ratio)


@kernel
def wind_torque(speed, u, s, p, e):
    """Torque of the wind on the rotor, N.m."""
    wind = u[IN.wind]
    if e.furling is not None:
        wind = min(wind, e.furling.wind)
    if wind <= 0.0:  # exactly here the two sides have slopes of their own
        return 0.0
    degrees = 0.0
    if e.pitch is not None:
        degrees = u[e.pitch.u] / DEGREE
    ratio = min(max(speed * p.radius / wind, -LARGEST_NUMBER), LARGEST_NUMBER)
    coefficient = coefficient_at(ratio, degrees, s, p, e)
    return 0.5 * p.density * math.pi * p.radius**3 * wind * (wind * coefficient)


@kernel
def drive(speed, u, s, p, e):
    """Torque on the rotor, dry friction apart, N.m."""
    return wind_torque(speed, u, s, p, e) - u[IN.torque] - p.damping * speed


@kernel
def turbine_start(t, s, p, e):
    """Speed and angle at the start and, with `bearing_friction`, the direction of its sliding."""
    if e.performance_table is not None:
        prepare(s.performance)
    else:
        s.largest[0] = 0.25 * p.standstill_coefficient * p.runaway_ratio
        if p.curve == FARM and s.largest[0] > BETZ:
            return ABOVE_BETZ
    s.x[0], s.x[1] = p.start_speed, p.start_angle
    if e.bearing_friction is not None:
        if e.bearing_friction.static < e.bearing_friction.kinetic:
            return STATIC_BELOW_KINETIC
        s.x[2] = stick_mode(p.start_speed, drive(p.start_speed, s.u[0], s, p, e), e.bearing_friction.static)
    return DONE


@kernel
def steepest_slope(degrees, s, p, e):
    """Largest slope of the torque coefficient over the tip speed ratio at a pitch in degrees."""
    slope, width = 0.0, LARGEST_RATIO / STEEPNESS
    before = coefficient_at(0.0, degrees, s, p, e)
    for k in range(1, STEEPNESS + 1):
        now = coefficient_at(k * width, degrees, s, p, e)
        slope = max(slope, abs(now - before) / width)
        before = now
    return slope


@kernel
def turbine_stable(t, s, p, e):
    """RK4's limit, radius / |eigenvalue| at the steepest place of the curve at any pitch, in a wind of 60 m/s, s."""
    slope = steepest_slope(0.0, s, p, e)
    if e.pitch is not None:
        if e.performance_table is not None:  # between rows a curve is a mean of theirs
            for i in range(s.performance.pitches.size):
                slope = max(slope, steepest_slope(s.performance.pitches[i], s, p, e))
        else:
            for i in range(1, PITCHES + 1):
                slope = max(slope, steepest_slope(i * MOST_PITCH / PITCHES, s, p, e))
    steepest = 0.5 * p.density * math.pi * p.radius**4 * STRONGEST_WIND * slope
    return RK4_STABILITY_RADIUS * p.inertia / (p.damping + steepest)


@kernel
def turbine_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (speed, angle[, direction of sliding])."""
    torque = drive(x[0], u, s, p, e)
    if e.bearing_friction is not None:
        torque -= stick_friction(x[2], torque, e.bearing_friction.kinetic)
        dx[2] = 0.0
    dx[0] = torque / p.inertia
    dx[1] = x[0]


@kernel
def turbine_guards(t, x, u, g, s, p, e):
    """That of the dry friction, where there is one."""
    g[0] = 1.0
    if e.bearing_friction is not None:
        g[0] = stick_guard(x[2], x[0], drive(x[0], u, s, p, e), e.bearing_friction.static)


@kernel
def turbine_switch(which, t, x, u, s, p, e):
    """The rotor comes to rest, turns over, or breaks loose."""
    if e.bearing_friction is not None:
        x[0] = 0.0
        x[2] = stick_switch(x[2], drive(0.0, u, s, p, e), e.bearing_friction.static)


@kernel
def turbine_outputs(t, s, p, e):
    """Motion, torque, coefficients."""
    x, u, y = s.x, s.u[0], s.y
    torque, wind = wind_torque(x[0], u, s, p, e), u[IN.wind]
    y[OUT.speed], y[OUT.angle], y[OUT.aerodynamic_torque], y[OUT.power] = x[0], x[1], torque, torque * x[0]
    y[OUT.power_coefficient], y[OUT.tip_speed_ratio] = 0.0, 0.0
    if wind > 0.0 and wind**3 > 0.0 and abs(x[0]) * p.radius <= LARGEST_RATIO * wind:
        y[OUT.power_coefficient] = torque * x[0] / (0.5 * p.density * math.pi * p.radius**2 * wind**3)
        y[OUT.tip_speed_ratio] = x[0] * p.radius / wind
    if s.noted is not None and e.pitch is not None:
        degrees, pitches = u[e.pitch.u] / DEGREE, s.performance.pitches
        if s.noted[0] == 0.0 and not pitches[0] - ROUNDED <= degrees <= pitches[-1] + ROUNDED:
            s.noted[0], s.noted[1], s.noted[2] = 1.0, degrees, t
    return DONE


WindTurbine.kernels = event_kernels(
    __name__,
    start=turbine_start,
    stable=turbine_stable,
    derivatives=turbine_derivatives,
    guards=turbine_guards,
    switch=turbine_switch,
    outputs=turbine_outputs,
)
