"""Centrifugal pump by its curve at one speed and the affinity laws."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..core.component import Component, Effect
from ..core.errors import BadInput
from ..core.kernels import DONE, NOT_FINITE, hold_inputs, kernel
from ..core.variables import input_, output, parameter


class SealFriction(Effect):
    """Dry friction of seals and bearings: a torque of its own, which the drive has to overcome at standstill, too."""

    torque = parameter(0.2, "N.m", "friction torque; a choice of ours", low=0.0)


class CentrifugalPump(Component):
    """Pump with head n² H0 - n d Q - c Q² at the relative speed n = w / w0, and a check valve.

        H = n² H0 - n d Q - c Q², or Q = 0 where the head H is higher;    efficiency = e (2 q - q²),  q = Q / (n Q0)
        T = rho g (n² H0 - n d Q - c Q²) Q0 / (e (2 - q) w0)

    The torque is that of the efficiency's parabola, T w = rho g H Q / efficiency, with what is 0/0 without flow divided out:
    against the closed valve, and at standstill, it is an ordinary number. Affinity: Q ~ n, H ~ n², T ~ n², T w ~ n³ exactly.
    A negative speed counts as standstill, a negative head as none. Form of curve and parabola are textbook, recalled; the
    numbers are a small pump of ours. In a pipe with friction, head and flow follow each other at once: a loop of the coupling.
    """

    title = "Centrifugal pump"
    system = "wind_pump"
    start_inputs = ()
    counters = ("steps",)
    default_step = 1e-2
    default_stop = 20.0

    seal_friction = SealFriction

    rated_speed = parameter(150.0, "rad/s", "speed w0 of the curve", low=1e-6)
    shutoff_head = parameter(30.0, "m", "head H0 without flow at that speed", low=1e-6)
    linear_drop = parameter(2e3, "s/m2", "d, drop of the head per flow at that speed: the curve falls where the valve opens",
                            low=0.0)
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

    def _initialize(self, t: float) -> int:
        p: Any = self.parameters
        largest = flow_at(1.0, p["shutoff_head"], p["linear_drop"], p["curve_drop"]) / p["best_flow"]
        if largest >= 2.0:
            raise BadInput(self.name, f"a curve that reaches {largest:.3g} times best_flow", "less than twice, where the "
                           "efficiency vanishes", "Raise best_flow or curve_drop.")
        self.arguments = self._declared_arguments()
        self.x = np.zeros(0)
        return DONE

    def _step(self, t: float, h: float) -> int:
        self.counts[0] += 1
        hold_inputs(self.u, h)
        self._outputs(t + h)
        return DONE if math.isfinite(self.u[0].sum() + self.y.sum()) else NOT_FINITE

    def _outputs(self, t: float) -> None:
        pump_outputs(self.u[0], self.y, *self.arguments)


SPEED, HEAD = CentrifugalPump.input_indices("speed", "head")
TORQUE_OUT, FLOW_OUT, POWER_OUT = CentrifugalPump.output_indices("torque", "flow", "hydraulic_power")


@kernel
def flow_at(n, surplus, linear, curve):
    """Flow whose drop of head is `surplus` m at the relative speed n, m³/s; 0 for none."""
    if surplus <= 0.0:
        return 0.0
    falling = n * linear
    return 2.0 * surplus / (falling + math.sqrt(falling * falling + 4.0 * curve * surplus))


@kernel
def pump_outputs(u, y, p, e):
    """Torque, flow and power."""
    n, head = max(u[SPEED], 0.0) / p.rated_speed, max(u[HEAD], 0.0)
    shutoff = n * n * p.shutoff_head
    flow, weight, share = flow_at(n, shutoff - head, p.linear_drop, p.curve_drop), p.density * p.gravity, 0.0
    if flow > 0.0:
        share = flow / (n * p.best_flow)
    own_head = shutoff - flow * (n * p.linear_drop + p.curve_drop * flow)
    y[TORQUE_OUT] = weight * own_head * p.best_flow / (p.best_efficiency * (2.0 - share) * p.rated_speed)
    if e.seal_friction is not None:
        y[TORQUE_OUT] += e.seal_friction.torque
    y[FLOW_OUT], y[POWER_OUT] = flow, weight * own_head * flow
