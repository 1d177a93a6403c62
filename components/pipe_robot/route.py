"""A pipe along its way: slope, diameter and friction at a position."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.errors import BadInput
from ..core.kernels import DONE, kernel
from ..core.stateless import StatelessComponent
from ..core.variables import input_, output, parameter

KNOTS = 8


class PipeRoute(StatelessComponent):
    """Slope, diameter and a factor on friction over the position along the pipe, from a table of 8 places.

    Between the places a cubic without overshoot (monotone where the table is), whose first derivative is continuous; before
    the first and behind the last place everything is constant. Several robots in one pipe have one route each, of equal numbers.
    The pipe's course is ours; of Matuliauskas and Spruogis (2002), whose robot this is for, only the abstract is known to us.
    Source of the interpolation: Fritsch and Butland, SIAM Journal on Scientific and Statistical Computing 5 (1984) 300-304.
    """

    title = "Pipe along its way"
    system = "pipe_robot"
    start_inputs = ()

    place = parameter(tuple(float(i) for i in range(KNOTS)), "m", "places of the table, ascending", size=KNOTS)
    slope_table = parameter(0.0, "rad", "slopes at the places, positive where forwards is upwards", size=KNOTS, low=-1.5708,
                            high=1.5708)
    diameter_table = parameter(0.2, "m", "diameters at the places", size=KNOTS, low=1e-6)
    factor_table = parameter(1.0, "1", "friction at the places over what it is elsewhere", size=KNOTS, low=0.0)

    position = input_(0.0, "m", "position along the pipe")

    slope = output("rad", "slope of the pipe, positive where forwards is upwards", feedthrough=("position",))
    diameter = output("m", "diameter of the pipe", nominal=0.1, feedthrough=("position",))
    taper = output("1", "growth of the diameter along the pipe", feedthrough=("position",))
    friction_factor = output("1", "factor on the friction", feedthrough=("position",))

    def _initialize(self, t: float) -> int:
        self.arguments = self._declared_arguments()
        p: Any = self.arguments[0]
        if not (np.diff(p.place) > 0.0).all():
            actual = "place = " + ", ".join(f"{v:g}" for v in p.place)
            raise BadInput(self.name, actual, "places in ascending order, no two equal")
        self._tables = np.array([p.slope_table, p.diameter_table, p.factor_table])
        self._rates = monotone_rates(p.place, self._tables)
        return DONE

    def _outputs(self, t: float) -> None:
        route_at(self.u[0, 0], self.y, self.arguments[0].place, self._tables, self._rates)


def monotone_rates(places: np.ndarray, tables: np.ndarray) -> np.ndarray:
    """Derivatives at the places with which the cubics between them do not overshoot; zero at both ends.

    places: (n,), ascending.  tables, result: (m, n).
    """
    steps = np.diff(places)
    secants = np.diff(tables) / steps
    rates = np.zeros_like(tables)
    before, after = secants[:, :-1], secants[:, 1:]
    share = (1.0 + steps[1:] / (steps[:-1] + steps[1:])) / 3.0  # weight of the secant before: the larger, the shorter its step
    same = before * after > 0.0
    mean = share * np.where(same, after, 1.0) + (1.0 - share) * np.where(same, before, 1.0)
    rates[:, 1:-1] = np.where(same, before * after / mean, 0.0)
    return rates


@kernel
def route_at(position, y, places, tables, rates):
    """Slope, diameter, its growth, and factor at a position."""
    last = places.size - 1
    i = 0
    while i < last - 1 and position > places[i + 1]:
        i += 1
    h = places[i + 1] - places[i]
    s = min(max((position - places[i]) / h, 0.0), 1.0)
    a, b = s * s * (3.0 - 2.0 * s), s * (1.0 - s)
    for j in range(3):
        y[j if j < 2 else 3] = (1.0 - a) * tables[j, i] + a * tables[j, i + 1] + h * b * (
            (1.0 - s) * rates[j, i] - s * rates[j, i + 1])
    y[2] = (6.0 * b * (tables[1, i + 1] - tables[1, i]) / h
            + (1.0 - s) * (1.0 - 3.0 * s) * rates[1, i] + s * (3.0 * s - 2.0) * rates[1, i + 1])
