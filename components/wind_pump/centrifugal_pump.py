"""Centrifugal pump by its curve at one speed and the affinity laws."""

from __future__ import annotations

import math
import warnings
from typing import Any

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.kernels import DONE, NOT_FINITE, OWN, kernel
from ..core.stateless import StatelessComponent, stateless_kernels
from ..core.variables import flag, input_, output, parameter, text
from .pump_table import operating_point, prepare, pump_curves

BEYOND_EFFICIENCY, ABOVE_UNITY = OWN + 1, OWN + 2
ALL = 1.0 + 1e-9  # an efficiency of 1, and its rounding


class SealFriction(Effect):
    """Dry friction of seals and bearings: a torque of its own, which the drive has to overcome at standstill, too."""

    torque = parameter(0.2, "N.m", "friction torque; a choice of ours", low=0.0)


class CurveTable(Effect):
    """The pump's own curves at `rated_speed`, as its data sheet has them, in the place of parabolas.

    A CSV table with a header: `flow`, rising from 0, `head`, falling, and `power` at the shaft or `efficiency`, such as
    `flow [l/s];head [m];power [W]`. Between the rows cubics without overshoot, other speeds by affinity. An efficiency does not
    say the power without flow, which is that of a straight line through the next two rows then. Behind the last row head and power
    go on straight, the run warns, and `beyond` is 1.
    """

    explicit_only = True
    replaces = ("shutoff_head", "linear_drop", "curve_drop", "best_flow", "best_efficiency")

    table = text(
        "flow [l/s],head [m],power [W]\n0,30,180\n0.6,27,315\n1.2,20,428\n1.8,9.2,470\n",
        "flow, head and power, or efficiency, as a CSV table; a scene may name its file",
    )
    beyond = flag("1 where the flow lies behind the last row of the table", feedthrough=("speed", "head"))


class CentrifugalPump(StatelessComponent):
    """Pump with head n² H0 - n d Q - c Q² at the relative speed n = w / w0, and a check valve.

        H = n² H0 - n d Q - c Q², or Q = 0 where the head H is higher;    efficiency = e (2 q - q²),  q = Q / (n Q0)
        T = rho g (n² H0 - n d Q - c Q²) Q0 / (e (2 - q) w0)

    The torque is that of the efficiency's parabola, T w = rho g H Q / efficiency, with what is 0/0 without flow divided out:
    against the closed valve, and at standstill, it is an ordinary number. Affinity: Q ~ n, H ~ n², T ~ n², T w ~ n³ exactly.
    A negative speed counts as standstill, a negative head as none. Form of curve and parabola are textbook, from memory; the
    numbers are a small pump of ours. In a pipe with friction, head and flow follow each other at once: a loop of the coupling.
    """

    title = "Centrifugal pump"
    system = "wind_pump"
    default_step = 1e-2
    default_stop = 20.0
    start_inputs = ()

    seal_friction = SealFriction
    curve_table = CurveTable

    rated_speed = parameter(150.0, "rad/s", "speed w0 of the curve", low=1e-6)
    shutoff_head = parameter(30.0, "m", "head H0 without flow at that speed", low=1e-6)
    linear_drop = parameter(
        2e3, "s/m2", "d, drop of the head per flow at that speed: the curve falls where the valve opens", low=0.0
    )
    curve_drop = parameter(5.3e6, "s2/m5", "c, drop of the head per flow squared", low=1e-6)
    best_flow = parameter(1.2e-3, "m3/s", "flow Q0 of the best efficiency at that speed", low=1e-9)
    best_efficiency = parameter(0.55, "1", "efficiency there", low=1e-3, high=1.0)
    density = parameter(1000.0, "kg/m3", "density of the water", low=1e-6)
    gravity = parameter(9.81, "m/s2", "acceleration of gravity", low=0.0)

    speed = input_(0.0, "rad/s", "speed of the shaft", nominal=100.0)
    head = input_(10.0, "m", "head against which it delivers", nominal=10.0)

    torque = output("N.m", "torque that it takes to turn it", feedthrough=("speed", "head"))
    flow = output("m3/s", "flow delivered", nominal=1e-2, feedthrough=("speed", "head"))
    hydraulic_power = output("W", "power given to the water", nominal=100.0, feedthrough=("speed", "head"))

    refusals = {
        BEYOND_EFFICIENCY: Refusal(
            "a curve that reaches {reach[0]} times best_flow",
            "less than twice, where the efficiency vanishes",
            "Raise best_flow or curve_drop.",
        ),
        ABOVE_UNITY: Refusal(
            "a row of curve_table.table whose power gives an efficiency of {reach[0]}",
            "a power at the shaft of at least rho g H Q",
            "Are its power in W or kW, and its flow in l/s or m3/h?",
        ),
    }

    def shapes(self) -> dict[str, Any]:
        """`reach`: largest flow at the rated speed over the best one; an efficiency that cannot be.
        `curves`: see `PumpCurves`; None without a table.

        `noted`: speed, rad/s, head, m, and time, s, of the first step that ended behind the table; zeros until then.
        """
        curves = None
        if "curve_table" in self.on:
            curves = pump_curves(str(self.parameters["curve_table.table"]), f"{self.name}: curve_table.table")
        return {"reach": 1, "curves": curves, "noted": 3}

    def _initialize(self, t: float) -> int:
        self._warned = False
        return super()._initialize(t)

    def stepped(self, t: float) -> None:
        """As of any component; warns once of a flow behind the table."""
        super().stepped(t)
        speed, head, when = self.arguments[0].noted.tolist()
        if speed > 0.0 and not self._warned:
            self._warned = True
            warnings.warn(
                f"{self.name}: at t = {when:.4g} s, with {speed:.4g} rad/s against {head:.4g} m, the flow lies behind the last row of "
                "curve_table.table; head and power go on straight there",
                stacklevel=2,
            )


IN = CentrifugalPump.input_places()
OUT = CentrifugalPump.output_places()


@kernel
def flow_at(n, surplus, linear, curve):
    """Flow whose drop of head is `surplus` m at the relative speed n, m³/s; 0 for none."""
    if surplus <= 0.0:
        return 0.0
    falling = n * linear
    return 2.0 * surplus / (falling + math.sqrt(falling * falling + 4.0 * curve * surplus))


@kernel
def pump_start(t, s, p, e):
    """Whether the parabola stays where the efficiency is known; the rates of a table."""
    if e.curve_table is not None:
        prepare(s.curves, p.density * p.gravity)
        last = s.curves.flows.size - 1
        for i in range(last + 1):
            given = p.density * p.gravity * s.curves.heads[last - i] * s.curves.flows[i]
            if s.curves.powers[i] < 0.0 or given > s.curves.powers[i] * ALL:
                s.reach[0] = given / s.curves.powers[i] if s.curves.powers[i] != 0.0 else math.inf
                return ABOVE_UNITY
        return DONE
    s.reach[0] = flow_at(1.0, p.shutoff_head, p.linear_drop, p.curve_drop) / p.best_flow
    return DONE if s.reach[0] < 2.0 else BEYOND_EFFICIENCY


@kernel
def pump_outputs(t, s, p, e):
    """Torque, flow and power."""
    u, y = s.u[0], s.y
    n, head = max(u[IN.speed], 0.0) / p.rated_speed, max(u[IN.head], 0.0)
    weight = p.density * p.gravity
    if e.curve_table is not None:
        flow, own_head, power = operating_point(n, head, s.curves)
        y[OUT.torque] = n * n * power / p.rated_speed
        y[e.curve_table.y] = 1.0 if flow > n * s.curves.flows[s.curves.flows.size - 1] else 0.0
    else:
        shutoff, share = n * n * p.shutoff_head, 0.0
        flow = flow_at(n, shutoff - head, p.linear_drop, p.curve_drop)
        if flow > 0.0:
            share = flow / (n * p.best_flow)
        own_head = shutoff - flow * (n * p.linear_drop + p.curve_drop * flow)
        y[OUT.torque] = weight * own_head * p.best_flow / (p.best_efficiency * (2.0 - share) * p.rated_speed)
    if e.seal_friction is not None:
        y[OUT.torque] += e.seal_friction.torque
    y[OUT.flow], y[OUT.hydraulic_power] = flow, weight * own_head * flow
    return DONE


_direct = stateless_kernels(__name__, pump_outputs, pump_start)
_step = _direct.step


@kernel
def pump_step(t, h, s, p, e):
    """The outputs, refused where they are no numbers."""
    status = _step(t, h, s, p, e)
    if e.curve_table is not None and s.y[e.curve_table.y] > 0.0 and s.noted[0] == 0.0:
        s.noted[0], s.noted[1], s.noted[2] = s.u[0, IN.speed], s.u[0, IN.head], t + h
    return status if math.isfinite(s.u[0].sum() + s.y.sum()) else NOT_FINITE


CentrifugalPump.kernels = _direct._replace(step=pump_step)
