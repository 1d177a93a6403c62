"""Centrifugal pump by its curve at one speed and the affinity laws."""

from __future__ import annotations

import math
from typing import Any

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.kernels import DONE, NOT_FINITE, OWN, kernel
from ..core.stateless import StatelessComponent, stateless_kernels
from ..core.variables import input_, output, parameter

BEYOND_EFFICIENCY = OWN + 1


class SealFriction(Effect):
    """Dry friction of seals and bearings: a torque of its own, which the drive has to overcome at standstill, too."""

    torque = parameter(0.2, "N.m", "friction torque; a choice of ours", low=0.0)


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

    seal_friction = SealFriction

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
        )
    }

    def shapes(self) -> dict[str, Any]:
        """`reach`: largest flow at the rated speed over the best one."""
        return {"reach": 1}


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
    """Whether the curve stays where the efficiency is known."""
    s.reach[0] = flow_at(1.0, p.shutoff_head, p.linear_drop, p.curve_drop) / p.best_flow
    return DONE if s.reach[0] < 2.0 else BEYOND_EFFICIENCY


@kernel
def pump_outputs(t, s, p, e):
    """Torque, flow and power."""
    u, y = s.u[0], s.y
    n, head = max(u[IN.speed], 0.0) / p.rated_speed, max(u[IN.head], 0.0)
    shutoff = n * n * p.shutoff_head
    flow, weight, share = flow_at(n, shutoff - head, p.linear_drop, p.curve_drop), p.density * p.gravity, 0.0
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
    return status if math.isfinite(s.u[0].sum() + s.y.sum()) else NOT_FINITE


CentrifugalPump.kernels = _direct._replace(step=pump_step)
