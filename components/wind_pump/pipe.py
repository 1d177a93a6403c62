"""Delivery pipe with the height it leads to, losses, an air vessel and a tank."""

from __future__ import annotations

import math

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.events import EventComponent, event_kernels
from ..core.integrators import RK4_STABILITY_RADIUS
from ..core.kernels import DONE, OWN, kernel
from ..core.variables import input_, output, parameter

ATMOSPHERE = 101325.0  # Pa
GRAVITY = 9.81  # m/s²
EMPTY, PARTLY, FULL = -1.0, 0.0, 1.0
ABOVE_OVERFLOW = OWN + 1


class Friction(Effect):
    """Loss of head by turbulent flow, coefficient * q |q|; a straight pipe has 8 f L / (pi² g D⁵)."""

    coefficient = parameter(1e6, "s2/m5", "loss of head per flow squared; about 30 m of 35 mm pipe with f = 0.02", low=0.0)


class AirVessel(Effect):
    """Trapped air behind the pump, p V^n constant, and the water column in the pipe behind it, which has an inertia.

        V' = q_out - q,    L / (g A) q_out' = H_vessel - H

    Small oscillations: w² = n p A / (rho L V) with the absolute pressure p. At the start vessel and column are at rest.
    """

    explicit_only = True

    gas_volume = parameter(5e-3, "m3", "volume of the air at the start", low=1e-9)
    exponent = parameter(1.2, "1", "polytropic exponent: 1 slow, 1.4 quick changes", low=1.0, high=1.7)
    pipe_length = parameter(30.0, "m", "length of the pipe", low=1e-3)
    pipe_diameter = parameter(0.035, "m", "diameter of the pipe", low=1e-4)


class Tank(Effect):
    """Tank at the end of the pipe, filled from below: its level adds to the head; it can overflow, or run empty."""

    area = parameter(2.0, "m2", "area of the tank", low=1e-6)
    height = parameter(2.0, "m", "height of the overflow", low=1e-6)
    start_level = parameter(0.5, "m", "level at the start", low=0.0)
    demand = input_(0.0, "m3/s", "flow taken from the tank as long as there is water", nominal=1e-3)
    level = output("m", "level above the bottom")
    supplied = output("m3", "volume taken from the tank since the start")
    overflowed = output("m3", "volume lost over the overflow since the start")


class WaterPipe(EventComponent):
    """Pipe from a pump up to an open end at the static head: H = H_static + K q |q|, plus the tank's level.

    Without `air_vessel` the water column follows the pump without inertia. The flow is that of a pump with valves; a negative one
    is taken as it comes. All volumes are 0 at the start, so that delivered = supplied + overflowed + area * rise of the level.
    Head and outflow are declared to follow the flow at once, as they do with some of the effects: an FMU has one declaration for
    all of them, and a component shall be coupled as its FMU is.
    """

    title = "Delivery pipe and tank"
    system = "wind_pump"
    start_inputs = ()
    default_step = 1e-2
    default_stop = 60.0

    friction = Friction
    air_vessel = AirVessel
    tank = Tank

    static_head = parameter(20.0, "m", "height of the pipe's end, or of the tank's bottom, above the well's water", low=0.0)
    density = parameter(1000.0, "kg/m3", "density of the water", low=1e-6)
    substep = parameter(5e-3, "s", "longest internal step", low=1e-9, high=10.0)

    flow = input_(0.0, "m3/s", "flow from the pump", nominal=1e-3)

    head = output("m", "head at the pump", nominal=10.0, feedthrough=("flow",))
    outflow = output("m3/s", "flow at the end of the pipe", nominal=1e-3, feedthrough=("flow",))
    delivered = output("m3", "volume that has left the pipe since the start")

    refusals = {
        ABOVE_OVERFLOW: Refusal("tank.start_level = {tank.start_level} m", "at most the height, {tank.height} m", "Lower it.")
    }

    def states(self) -> int:
        """Delivered volume; air volume and flow of the column; level, mode, supplied and overflowed volume."""
        return 1 + (2 if "air_vessel" in self.on else 0) + (TANKED if "tank" in self.on else 0)


IN = WaterPipe.input_places()
OUT = WaterPipe.output_places()
DELIVERED, GAS, COLUMN = 0, 1, 2
TANKED = 4  # states of the tank, the last ones: level, mode, supplied, overflowed


@kernel
def end_head(x, p, tank):
    """Head at the end of the pipe, m."""
    if tank is not None:
        return p.static_head + x[x.size - TANKED]
    return p.static_head


@kernel
def outflow(x, u, vessel):
    """Flow at the end of the pipe, m³/s."""
    if vessel is not None:
        return x[COLUMN]
    return u[IN.flow]


@kernel
def pump_head(x, u, p, e):
    """Head at the pump, m."""
    if e.air_vessel is not None:
        start = p.static_head
        if e.tank is not None:
            start += e.tank.start_level
        pressure = (ATMOSPHERE + p.density * GRAVITY * start) * (e.air_vessel.gas_volume / x[GAS]) ** e.air_vessel.exponent
        return (pressure - ATMOSPHERE) / (p.density * GRAVITY)
    head = end_head(x, p, e.tank)
    if e.friction is not None:
        head += e.friction.coefficient * u[IN.flow] * abs(u[IN.flow])
    return head


@kernel
def pipe_start(t, s, p, e):
    """Vessel and column at rest, the tank at its level."""
    if e.air_vessel is not None:
        s.x[GAS] = e.air_vessel.gas_volume
    if e.tank is not None:
        if e.tank.start_level > e.tank.height:
            return ABOVE_OVERFLOW
        k = s.x.size - TANKED
        s.x[k], s.x[k + 1] = e.tank.start_level, FULL if e.tank.start_level == e.tank.height else PARTLY
    return DONE


@kernel
def pipe_stable(t, s, p, e):
    """RK4's limit, radius / w of the column on the air of the start, s; infinite without an air vessel."""
    if e.air_vessel is None:
        return math.inf
    start = p.static_head
    if e.tank is not None:
        start += e.tank.start_level
    pressure = ATMOSPHERE + p.density * GRAVITY * start
    area = 0.25 * math.pi * e.air_vessel.pipe_diameter**2
    square = e.air_vessel.exponent * pressure * area / (p.density * e.air_vessel.pipe_length * e.air_vessel.gas_volume)
    return RK4_STABILITY_RADIUS / math.sqrt(square)


@kernel
def pipe_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (delivered[, air volume, flow of the column][, level, mode, supplied, overflowed])."""
    leaving = outflow(x, u, e.air_vessel)
    dx[DELIVERED] = leaving
    if e.air_vessel is not None:
        dx[GAS] = leaving - u[IN.flow]
        surplus = pump_head(x, u, p, e) - end_head(x, p, e.tank)
        if e.friction is not None:
            surplus -= e.friction.coefficient * leaving * abs(leaving)
        dx[COLUMN] = GRAVITY * 0.25 * math.pi * e.air_vessel.pipe_diameter**2 / e.air_vessel.pipe_length * surplus
    if e.tank is not None:
        k = x.size - TANKED
        demand = u[e.tank.u]
        dx[k], dx[k + 1], dx[k + 2], dx[k + 3] = 0.0, 0.0, demand, 0.0
        if x[k + 1] == FULL:
            dx[k + 3] = leaving - demand
        elif x[k + 1] == EMPTY:
            dx[k + 2] = leaving
        else:
            dx[k] = (leaving - demand) / e.tank.area


@kernel
def pipe_guards(t, x, u, g, s, p, e):
    """Room and water in the tank, or what keeps it full or empty."""
    g[0] = 1.0
    if e.tank is not None:
        k = x.size - TANKED
        rise = outflow(x, u, e.air_vessel) - u[e.tank.u]
        if x[k + 1] == PARTLY:
            g[0] = min(x[k], e.tank.height - x[k])
        else:
            g[0] = x[k + 1] * rise


@kernel
def pipe_switch(which, t, x, u, s, p, e):
    """The tank becomes full or empty, or ceases to be."""
    if e.tank is not None:
        k = x.size - TANKED
        if x[k + 1] != PARTLY:
            x[k + 1] = PARTLY
        elif x[k] > 0.5 * e.tank.height:
            x[k], x[k + 1] = e.tank.height, FULL
        else:
            x[k], x[k + 1] = 0.0, EMPTY


@kernel
def pipe_outputs(t, s, p, e):
    """Head, flow and volumes."""
    x, u, y = s.x, s.u[0], s.y
    y[OUT.head] = pump_head(x, u, p, e)
    y[OUT.outflow], y[OUT.delivered] = outflow(x, u, e.air_vessel), x[DELIVERED]
    if e.tank is not None:
        k = x.size - TANKED
        y[e.tank.y], y[e.tank.y + 1], y[e.tank.y + 2] = x[k], x[k + 2], x[k + 3]
    return DONE


WaterPipe.kernels = event_kernels(
    __name__,
    start=pipe_start,
    stable=pipe_stable,
    derivatives=pipe_derivatives,
    guards=pipe_guards,
    switch=pipe_switch,
    outputs=pipe_outputs,
)
