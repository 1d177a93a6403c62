"""A pipe along its way: slope, diameter and friction at a position."""

from __future__ import annotations

from typing import Any

from ..core.contract import Refusal
from ..core.kernels import DONE, OWN, kernel
from ..core.stateless import StatelessComponent, stateless_kernels
from ..core.variables import input_, output, parameter

KNOTS = 8
DISORDER = OWN + 1  # status


class PipeRoute(StatelessComponent):
    """Slope, diameter and a factor on friction over the position along the pipe, from a table of 8 places.

    Between the places a cubic without overshoot (monotone where the table is), whose first derivative is continuous; before
    the first and behind the last place everything is constant. Several robots in one pipe have one route each, of equal numbers.
    The pipe's course is ours; of Matuliauskas and Spruogis (2002), whose robot this is for, only the abstract is known to us.
    Source of the interpolation: Fritsch and Butland, SIAM Journal on Scientific and Statistical Computing 5 (1984) 300-304.
    """

    title = "Pipe along its way"
    system = "pipe_robot"

    place = parameter(tuple(float(i) for i in range(KNOTS)), "m", "places of the table, ascending", size=KNOTS)
    slope_table = parameter(
        0.0, "rad", "slopes at the places, positive where forwards is upwards", size=KNOTS, low=-1.5708, high=1.5708
    )
    diameter_table = parameter(0.2, "m", "diameters at the places", size=KNOTS, low=1e-6)
    factor_table = parameter(1.0, "1", "friction at the places over what it is elsewhere", size=KNOTS, low=0.0)

    position = input_(0.0, "m", "position along the pipe")

    slope = output("rad", "slope of the pipe, positive where forwards is upwards", feedthrough=("position",))
    diameter = output("m", "diameter of the pipe", nominal=0.1, feedthrough=("position",))
    taper = output("1", "growth of the diameter along the pipe", feedthrough=("position",))
    friction_factor = output("1", "factor on the friction", feedthrough=("position",))

    refusals = {
        DISORDER: Refusal(
            "place[{disorder[0]}] = {disorder[1]} m, then {disorder[2]} m", "places in ascending order, no two equal"
        )
    }

    def shapes(self) -> dict[str, Any]:
        """Constants that the tables determine.

        `rates`: (3, KNOTS) derivatives at the places of slope, diameter and factor.  `disorder`: (3,) the first place that the
        next one is not behind: its number, it, and the next.
        """
        return {"rates": (3, KNOTS), "disorder": 3}


IN = PipeRoute.input_places()
OUT = PipeRoute.output_places()


@kernel
def monotone_rates(places, table, rates):
    """Derivatives at the places, (n,), with which the cubics between them do not overshoot; zero at both ends.

    places, ascending, and table: (n,).
    """
    rates[0] = rates[-1] = 0.0
    for i in range(1, places.size - 1):
        step, next_step = places[i] - places[i - 1], places[i + 1] - places[i]
        before, after = (table[i] - table[i - 1]) / step, (table[i + 1] - table[i]) / next_step
        share = (1.0 + next_step / (step + next_step)) / 3.0  # weight of the secant before: the larger, the shorter its step
        rates[i] = before * after / (share * after + (1.0 - share) * before) if before * after > 0.0 else 0.0


@kernel
def route_start(t, s, p, e):
    """The derivatives of the tables, whose places have to ascend."""
    for i in range(KNOTS - 1):
        if not p.place[i + 1] > p.place[i]:
            s.disorder[0], s.disorder[1], s.disorder[2] = i + 1, p.place[i], p.place[i + 1]
            return DISORDER
    monotone_rates(p.place, p.slope_table, s.rates[0])
    monotone_rates(p.place, p.diameter_table, s.rates[1])
    monotone_rates(p.place, p.factor_table, s.rates[2])
    return DONE


@kernel
def between(share, h, table, rates, i):
    """Value of a cubic behind place i, at a share of the length h to the next."""
    a, b = share * share * (3.0 - 2.0 * share), share * (1.0 - share)
    return (1.0 - a) * table[i] + a * table[i + 1] + h * b * ((1.0 - share) * rates[i] - share * rates[i + 1])


@kernel
def route_at(t, s, p, e):
    """Slope, diameter, its growth, and factor at a position."""
    position, places, rates, y = s.u[0, IN.position], p.place, s.rates, s.y
    i = 0
    while i < KNOTS - 2 and position > places[i + 1]:
        i += 1
    h = places[i + 1] - places[i]
    share = min(max((position - places[i]) / h, 0.0), 1.0)
    y[OUT.slope] = between(share, h, p.slope_table, rates[0], i)
    y[OUT.diameter] = between(share, h, p.diameter_table, rates[1], i)
    y[OUT.taper] = (
        6.0 * (share * (1.0 - share)) * (p.diameter_table[i + 1] - p.diameter_table[i]) / h
        + (1.0 - share) * (1.0 - 3.0 * share) * rates[1, i]
        + share * (3.0 * share - 2.0) * rates[1, i + 1]
    )
    y[OUT.friction_factor] = between(share, h, p.factor_table, rates[2], i)
    return DONE


PipeRoute.kernels = stateless_kernels(__name__, route_at, route_start)
