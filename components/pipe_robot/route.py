"""A pipe along its way: slope, diameter and friction at a position."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.columns import table_of
from ..core.component import Effect
from ..core.contract import Refusal
from ..core.errors import BadInput
from ..core.kernels import DONE, OWN, kernel
from ..core.stateless import StatelessComponent, stateless_kernels
from ..core.table_curve import between, monotone_rates, read_curve, row_before
from ..core.variables import input_, output, parameter, text

KNOTS = 8
STEEPEST = 1.5708  # rad, 90 degrees
DISORDER = OWN + 1  # status


class RouteTable(Effect):
    """The pipe as it was surveyed, in the place of the 8 places: a CSV table with a header and any number of rows.

    Columns: `position`, rising, and `diameter`; also `slope` and `friction_factor`, which are 0 and 1 where the table has none. Such as
    `position [m];diameter [mm];slope [deg]`.
    """

    explicit_only = True
    replaces = ("place", "slope_table", "diameter_table", "factor_table")

    table = text("position [m],diameter [mm]\n0,200\n7,200\n", "the pipe as a CSV table; a scene may name its file")


class PipeRoute(StatelessComponent):
    """Slope, diameter and a factor on friction over the position along the pipe, from a table of 8 places, or from a file.

    Between the places a cubic without overshoot (monotone where the table is), whose first derivative is continuous; before
    the first and behind the last place everything is constant. Several robots in one pipe have one route each, of equal numbers.
    The pipe's course is ours; of Matuliauskas and Spruogis (2002), whose robot this is for, only the abstract is known to us.
    Source of the interpolation: see `core.table_curve`.
    """

    title = "Pipe along its way"
    system = "pipe_robot"

    route_table = RouteTable

    place = parameter(tuple(float(i) for i in range(KNOTS)), "m", "places of the table, ascending", size=KNOTS)
    slope_table = parameter(
        0.0, "rad", "slopes at the places, positive where forwards is upwards", size=KNOTS, low=-STEEPEST, high=STEEPEST
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

        `rows`: (4, n) places, slopes, diameters and factors.  `rates`: (3, n) derivatives of slope, diameter and factor at the places.
        `disorder`: (3,) the first place that the next one is not behind: its number, it, and the next.
        """
        rows: Any = np.zeros((4, KNOTS))
        if "route_table" in self.on:
            rows = surveyed(str(self.parameters["route_table.table"]), f"{self.name}: route_table.table")
        return {"rows": rows, "rates": (3, rows.shape[1]), "disorder": 3}


def surveyed(text: str, where: str) -> np.ndarray:
    """(4, n) places, slopes, diameters and factors of a table as `RouteTable` describes it; raises `BadInput`."""
    units = {"position": "m", "diameter": "m", "slope": "rad", "friction_factor": "1"}
    there = table_of(text, where)
    chosen = {n: unit for n, unit in units.items() if n in ("position", "diameter") or there.place(n) is not None}
    columns = dict(zip(chosen, read_curve(text, where, chosen, others=tuple(units))[1], strict=True))
    if columns["diameter"].min() <= 0.0:
        raise BadInput(where, f"a diameter of {columns['diameter'].min():g} m", "positive ones")
    if columns.get("friction_factor", np.ones(1)).min() < 0.0:
        raise BadInput(where, f"a friction factor of {columns['friction_factor'].min():g}", "0 or more")
    if (steepest := np.abs(columns.get("slope", np.zeros(1))).max()) > STEEPEST:
        raise BadInput(
            where, f"a slope of {steepest:.4g} rad", "slopes from -90 to 90 degrees", "Is its unit that of the header?"
        )
    none = np.zeros_like(columns["position"])
    return np.array(
        (columns["position"], columns.get("slope", none), columns["diameter"], columns.get("friction_factor", none + 1.0))
    )


IN = PipeRoute.input_places()
OUT = PipeRoute.output_places()


@kernel
def route_start(t, s, p, e):
    """The derivatives of the tables, whose places have to ascend."""
    rows = s.rows
    if e.route_table is None:
        for i in range(KNOTS):
            rows[0, i], rows[1, i], rows[2, i], rows[3, i] = p.place[i], p.slope_table[i], p.diameter_table[i], p.factor_table[i]
        for i in range(KNOTS - 1):
            if not p.place[i + 1] > p.place[i]:
                s.disorder[0], s.disorder[1], s.disorder[2] = i + 1, p.place[i], p.place[i + 1]
                return DISORDER
    for k in range(3):
        monotone_rates(rows[0], rows[k + 1], s.rates[k])
    return DONE


@kernel
def route_at(t, s, p, e):
    """Slope, diameter, its growth, and factor at a position."""
    position, rows, rates, y = s.u[0, IN.position], s.rows, s.rates, s.y
    places, diameters = rows[0], rows[2]
    i = row_before(position, places)
    h = places[i + 1] - places[i]
    share = min(max((position - places[i]) / h, 0.0), 1.0)
    y[OUT.slope] = between(share, h, rows[1], rates[0], i)
    y[OUT.diameter] = between(share, h, diameters, rates[1], i)
    y[OUT.taper] = (
        6.0 * (share * (1.0 - share)) * (diameters[i + 1] - diameters[i]) / h
        + (1.0 - share) * (1.0 - 3.0 * share) * rates[1, i]
        + share * (3.0 * share - 2.0) * rates[1, i + 1]
    )
    y[OUT.friction_factor] = between(share, h, rows[3], rates[2], i)
    return DONE


PipeRoute.kernels = stateless_kernels(__name__, route_at, route_start)
