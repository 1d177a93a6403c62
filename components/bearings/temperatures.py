"""Temperatures of a bearing and its surroundings as a network of heat capacities, and their effect on the clearance."""

from __future__ import annotations

import math
from typing import Any

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.kernels import DONE, NOT_CONVERGED, OUT_OF_RANGE, OWN, kernel
from ..core.rosenbrock import StiffComponent, stiff_kernels
from ..core.variables import input_, output, parameter
from .radiation import STEFAN_BOLTZMANN, radiative_coefficient

TOO_LARGE_SHARES = OWN + 1  # status


class Housing(Effect):
    """A heat capacity of its own around the outer ring, which then gives its heat to the housing instead of the ambient."""

    heat_capacity = parameter(2000.0, "J/K", "heat capacity of the housing", low=1e-9)
    seat_conductance = parameter(5.0, "W/K", "conductance of the seat between outer ring and housing", low=0.0)


class OilFlow(Effect):
    """Oil that flows through and leaves at the balls' temperature."""

    capacity_rate = parameter(2.0, "W/K", "mass flow times specific heat of the oil", low=0.0)
    inlet_temperature = input_(293.15, "K", "temperature of the oil that comes in", nominal=100.0)


class Radiation(Effect):
    """Radiation of the outermost surface, housing or outer ring, to the ambient: emissivity * area * sigma (T⁴ - Ta⁴)."""

    emissivity = parameter(0.8, "1", "emissivity of the surface; painted, from memory", low=0.0, high=1.0)
    area = parameter(0.05, "m2", "area of the surface", low=0.0)


class ShaftHeat(Effect):
    """Heat that the shaft brings in from elsewhere, such as a motor."""

    power = input_(0.0, "W", "heat flow into shaft and inner ring", nominal=10.0)


class BearingTemperatures(StiffComponent):
    """Shaft with inner ring, balls, outer ring with housing: three heat capacities in a row.

        Ci Ti' = s_i P - 2 G (Ti - Tb) - Gs (Ti - Ta)
        Cb Tb' = (1 - s_i - s_o) P - 2 G (Tb - Ti) - 2 G (Tb - To)
        Co To' = s_o P - 2 G (To - Tb) - Gh (To - Ta)

    G: conductance from ring to ring, half of the resistance on either side of the balls; P: friction; Ta: ambient.
    A negative conductance counts as none. Heat supplied and heat given off are integrated along, so that the balance
    heat_supplied = heat_stored + heat_released can be looked at; all three are 0 at the start.

    Change of the diametral clearance, each part growing freely from the reference temperature Tr, alpha one for all parts:

        (dm + d) alpha (To - Tr) - (dm - d) alpha (Ti - Tr) - 2 d alpha (Tb - Tr)

    which is 0 where all are equally warm. Interference of the seats, and a housing or shaft of other material, are not in it.
    Integrated with an L-stable method: without `radiation` the network is linear, and `substep` a matter of accuracy alone.
    T⁴ can lead a long substep astray; a step that ends hotter than heat and surroundings can make it fails as not converged.
    """

    title = "Temperatures of a bearing, its shaft and its housing"
    system = "bearings"
    start_inputs = ()
    default_step = 1.0
    default_stop = 3600.0
    refusals = {
        TOO_LARGE_SHARES: Refusal(
            "inner_share + outer_share = {refused}", "at most 1: the rest heats the balls", "Reduce one of them."
        )
    }

    housing = Housing
    oil_flow = OilFlow
    radiation = Radiation
    shaft_heat = ShaftHeat

    inner_capacity = parameter(400.0, "J/K", "heat capacity of shaft and inner ring", low=1e-9)
    ball_capacity = parameter(15.0, "J/K", "heat capacity of all balls", low=1e-9)
    outer_capacity = parameter(150.0, "J/K", "heat capacity of outer ring and, without `housing`, what it sits in", low=1e-9)
    shaft_conductance = parameter(0.2, "W/K", "conductance from the shaft to the ambient", low=0.0)
    ambient_conductance = parameter(1.0, "W/K", "conductance from housing or outer ring to the ambient", low=0.0)
    inner_share = parameter(0.25, "1", "share of the friction that heats the inner ring; a choice of ours", low=0.0, high=1.0)
    outer_share = parameter(0.25, "1", "share of the friction that heats the outer ring; a choice of ours", low=0.0, high=1.0)
    ball_diameter = parameter(7.938e-3, "m", "diameter of the balls", low=1e-6)
    pitch_diameter = parameter(54e-3, "m", "pitch diameter of the balls", low=1e-6)
    expansion = parameter(1.2e-5, "1/K", "coefficient of thermal expansion of rings and balls; steel, from memory", low=0.0)
    reference_temperature = parameter(293.15, "K", "temperature of all parts at which the clearance is unchanged", low=0.0)
    start_temperature = parameter(293.15, "K", "temperature of all parts at the start", low=0.0)
    substep = parameter(1.0, "s", "longest internal step", low=1e-9)

    conductance = input_(0.2, "W/K", "conductance of the bearing from ring to ring", nominal=0.1)
    friction_power = input_(0.0, "W", "power lost to friction in the bearing", nominal=10.0)
    ambient = input_(293.15, "K", "temperature of the surroundings", nominal=100.0)

    inner_temperature = output("K", "temperature of shaft and inner ring", nominal=100.0)
    ball_temperature = output("K", "temperature of the balls", nominal=100.0)
    outer_temperature = output("K", "temperature of the outer ring", nominal=100.0)
    housing_temperature = output("K", "temperature of the outermost part, housing or outer ring", nominal=100.0)
    clearance_change = output("m", "change of the diametral clearance by thermal expansion", nominal=1e-5)
    heat_supplied = output("J", "heat supplied since the start", nominal=1e4)
    heat_stored = output("J", "heat stored since the start", nominal=1e4)
    heat_released = output("J", "heat given off to the ambient and to oil since the start", nominal=1e4)

    def states(self) -> int:
        """Temperatures of inner ring, balls, outer ring and, with `housing`, housing, K; heat supplied and released, J."""
        return 6 if "housing" in self.on else 5

    def shapes(self) -> dict[str, Any]:
        """`refused`: a number for a message."""
        return super().shapes() | {"refused": 1}

    def left_range(self) -> str:
        """The coldest part, and the inputs that cool it."""
        heat = ", ".join(f"{n} = {self.get(n):g} {self.variables[n].unit}" for n in self.inputs)
        return f"a temperature of {coldest(self.x):.4g} K with {heat}, expected 0 K or more"


IN = BearingTemperatures.input_places()
OUT = BearingTemperatures.output_places()
INNER, BALL, OUTER, HOUSED = 0, 1, 2, 3


ABSOLUTE_ZERO = -1e-6  # K: with the rounding of parts that are at 0 K


@kernel
def coldest(x):
    """Lowest temperature of a part, K."""
    lowest = x[0]
    for i in range(1, x.size - 2):
        lowest = min(lowest, x[i])
    return lowest


@kernel
def range_outside(h, x, u, e):
    """(lowest, highest) temperature in K of the outermost part, if it radiates, after a step of h s; u: (3, m) with slopes.

    It rises above the warmest of parts, ambient and oil only as far as until radiation alone takes all supplied heat away,
    and does not fall below 0 K unless an input extrapolated too far takes it there. A tenth and 1 K are for the method's error.
    """
    if e.radiation is None or e.radiation.emissivity * e.radiation.area == 0.0:
        return -math.inf, math.inf
    warmest, coldest, power = 0.0, 0.0, 0.0
    for part in x[:-2]:
        warmest, coldest = max(warmest, part), min(coldest, part)
    for since in (0.0, h):
        ambient = u[0, IN.ambient] + since * (u[1, IN.ambient] + since * u[2, IN.ambient])
        warmest, coldest = max(warmest, ambient), min(coldest, ambient)
        supplied = u[0, IN.friction_power] + since * (u[1, IN.friction_power] + since * u[2, IN.friction_power])
        if e.oil_flow is not None:
            inlet = u[0, e.oil_flow.u] + since * (u[1, e.oil_flow.u] + since * u[2, e.oil_flow.u])
            warmest, coldest = max(warmest, inlet), min(coldest, inlet)
        if e.shaft_heat is not None:
            supplied += u[0, e.shaft_heat.u] + since * (u[1, e.shaft_heat.u] + since * u[2, e.shaft_heat.u])
        power, coldest = max(power, supplied), min(coldest, supplied)  # heat taken away counts as cold
    high = (warmest**4 + power / (e.radiation.emissivity * e.radiation.area * STEFAN_BOLTZMANN)) ** 0.25
    low = -math.inf if coldest < 0.0 else -0.1 * high - 1.0
    return low, 1.1 * high + 1.0


@kernel
def network_start(t, s, p, e):
    """All parts at the same temperature; no heat supplied or released yet."""
    s.refused[0] = p.inner_share + p.outer_share
    if s.refused[0] > 1.0 + 1e-12:  # rounding of shares such as 0.7 and 0.3
        return TOO_LARGE_SHARES
    for i in range(s.x.size - 2):
        s.x[i] = p.start_temperature
    return DONE


@kernel
def network_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (Ti, Tb, To[, Th], heat supplied, heat released)."""
    n = x.size - 2
    to_balls = 2.0 * max(u[IN.conductance], 0.0) * (x[INNER] - x[BALL])
    to_outer = 2.0 * max(u[IN.conductance], 0.0) * (x[BALL] - x[OUTER])
    friction, ambient = u[IN.friction_power], u[IN.ambient]
    supplied = friction
    from_shaft = p.shaft_conductance * (x[INNER] - ambient)
    inner = p.inner_share * friction - to_balls - from_shaft
    ball = (1.0 - p.inner_share - p.outer_share) * friction + to_balls - to_outer
    outer = p.outer_share * friction + to_outer
    if e.shaft_heat is not None:
        inner += u[e.shaft_heat.u]
        supplied += u[e.shaft_heat.u]
    outside = x[n - 1]  # of the outermost part
    to_ambient = p.ambient_conductance * (outside - ambient)
    if e.radiation is not None:
        to_ambient += e.radiation.emissivity * e.radiation.area * radiative_coefficient(outside, ambient) * (outside - ambient)
    released = from_shaft + to_ambient
    if e.oil_flow is not None:
        with_oil = e.oil_flow.capacity_rate * (x[BALL] - u[e.oil_flow.u])
        ball -= with_oil
        released += with_oil
    if e.housing is not None:
        through_seat = e.housing.seat_conductance * (x[OUTER] - x[HOUSED])
        outer -= through_seat
        dx[HOUSED] = (through_seat - to_ambient) / e.housing.heat_capacity
    else:
        outer -= to_ambient
    dx[INNER], dx[BALL], dx[OUTER] = inner / p.inner_capacity, ball / p.ball_capacity, outer / p.outer_capacity
    dx[n], dx[n + 1] = supplied, released


@kernel
def network_jacobian(t, x, u, band, s, p, e):
    """Derivatives of `network_derivatives` by the temperatures, in the whole band of rodas3."""
    n, w = x.size - 2, x.size - 1
    released = n + 1
    last = n - 1
    across = 2.0 * max(u[IN.conductance], 0.0)
    band[INNER, w] = -(across + p.shaft_conductance) / p.inner_capacity
    band[INNER, w + 1] = across / p.inner_capacity
    band[BALL, w - 1] = band[BALL, w + 1] = across / p.ball_capacity
    band[BALL, w] = -2.0 * across / p.ball_capacity
    band[OUTER, w - 1] = across / p.outer_capacity
    band[OUTER, w] = -across / p.outer_capacity
    band[released, w + INNER - released] = p.shaft_conductance
    if e.oil_flow is not None:
        band[BALL, w] -= e.oil_flow.capacity_rate / p.ball_capacity
        band[released, w + BALL - released] = e.oil_flow.capacity_rate
    capacity = p.outer_capacity
    if e.housing is not None:
        capacity = e.housing.heat_capacity
        band[OUTER, w] -= e.housing.seat_conductance / p.outer_capacity
        band[OUTER, w + 1] = e.housing.seat_conductance / p.outer_capacity
        band[HOUSED, w - 1] = e.housing.seat_conductance / capacity
        band[HOUSED, w] = -e.housing.seat_conductance / capacity
    outside = p.ambient_conductance
    if e.radiation is not None:
        # 4 sigma T³ is the coefficient between two surfaces of temperature T
        outside += e.radiation.emissivity * e.radiation.area * radiative_coefficient(x[last], x[last])
    band[last, w] -= outside / capacity
    band[released, w + last - released] += outside


@kernel
def network_outputs(t, s, p, e):
    """Temperatures, change of clearance, balance of heat."""
    x, y = s.x, s.y
    n = x.size - 2
    y[OUT.inner_temperature], y[OUT.ball_temperature], y[OUT.outer_temperature], y[OUT.housing_temperature] = (
        x[INNER],
        x[BALL],
        x[OUTER],
        x[n - 1],
    )
    d, dm, reference = p.ball_diameter, p.pitch_diameter, p.reference_temperature
    grown = (dm + d) * (x[OUTER] - reference) - (dm - d) * (x[INNER] - reference) - 2.0 * d * (x[BALL] - reference)
    y[OUT.clearance_change] = p.expansion * grown
    start = p.start_temperature
    stored = p.inner_capacity * (x[INNER] - start) + p.ball_capacity * (x[BALL] - start) + p.outer_capacity * (x[OUTER] - start)
    if e.housing is not None:
        stored += e.housing.heat_capacity * (x[HOUSED] - start)
    y[OUT.heat_supplied], y[OUT.heat_stored], y[OUT.heat_released] = x[n], stored, x[n + 1]
    return DONE


_stiff = stiff_kernels(
    __name__, start=network_start, derivatives=network_derivatives, jacobian=network_jacobian, outputs=network_outputs
)
_advance = _stiff.step


@kernel
def network_step(t, h, s, p, e):
    """A step of the method; refuses temperatures that are physically impossible."""
    low, high = range_outside(h, s.x, s.u, e)
    status = _advance(t, h, s, p, e)
    if status == DONE and not low <= s.x[s.x.size - 3] <= high:
        return NOT_CONVERGED
    return OUT_OF_RANGE if status == DONE and coldest(s.x) < ABSOLUTE_ZERO else status


BearingTemperatures.kernels = _stiff._replace(step=network_step)
