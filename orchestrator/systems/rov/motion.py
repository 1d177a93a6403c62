"""Underwater vehicles in motion: hull, thrusts and track, seen from the south and above."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from ...harness.analysis.records import RecordedUnit
from ...harness.charts.blocks import Moving
from ...harness.charts.formulas import largest, not_below, smallest
from ...harness.charts.motion import Kinematics, Picture, Values, polyline, trace
from .records import POSITION, QUATERNION, THRUSTS, Vehicle, axes_of, vehicles

if TYPE_CHECKING:
    from ...run.results import Result

DEPTH = 0.4  # share of a length to the north that a picture shows, to the right and up
SHARE = 0.2  # of the track, that a hull has at least
FLAT = 0.4  # height of a hull over its width, where all thrusters lie in one plane
SMALLEST = 1e-12  # N, so that no thrust at all is divided by some
# corners of a box in one line along all edges
EDGES = (0, 1, 3, 2, 0, 4, 5, 7, 6, 4, 5, 1, 3, 7, 6, 2)


def motions(result: Result) -> list[Kinematics]:
    """A picture of each vehicle whose attitude was recorded."""
    return [_kinematics(v, RecordedUnit(result, v.unit)) for v in vehicles(result) if v.axes is not None]


def _kinematics(vehicle: Vehicle, unit: RecordedUnit) -> Kinematics:
    places, directions = _thrusters(unit)
    numbers = [k for k in vehicle.thrusts if k <= places.shape[1]]
    # where faults change a thrust on its way, the run alone has what arrives
    thrusts = {str(k): vehicle.thrusts[k] if unit.result.scene.faults else unit.column(THRUSTS[k - 1]) for k in numbers}
    half = np.abs(places).max(axis=1, initial=0.0)
    half = np.maximum(half, FLAT * half.max()) if half.max() else np.array([0.5, 0.4, 0.3])

    def draw(values: Values) -> Picture:
        position, axes = [values[n] for n in POSITION], axes_of(*(values[n] for n in QUATERNION))
        extent = [largest(x) - smallest(x) for x in _seen(position)]
        size = not_below(SHARE * not_below(*extent) / (2.0 * half[0]), 1.0)

        def at(own: np.ndarray) -> list[Any]:
            """World places, 3 times (k,), of a point of the hull, (3,) m."""
            return [
                p + size * (row[0] * own[0] + row[1] * own[1] + row[2] * own[2]) for p, row in zip(position, axes, strict=True)
            ]

        corners = [at(np.array(signs) * half) for signs in product((-1.0, 1.0), repeat=3)]
        lines = [
            trace(*_seen(position)),
            Moving(polyline(*(_seen(corners[k]) for k in EDGES)), "part"),
            Moving(polyline(_seen(at(np.zeros(3))), _seen(at(np.array([1.3 * half[0], 0.0, 0.0])))), "second"),
        ]
        most: Any = SMALLEST
        for name in thrusts:
            most = not_below(largest(np.abs(values[name])), most)
        for k in numbers:
            place, reach = places[:, k - 1], 1.2 * half[0] * directions[:, k - 1]
            begin, whole = at(place), at(place + reach)
            end = [b + values[str(k)] / most * (w - b) for b, w in zip(begin, whole, strict=True)]
            lines.append(Moving(polyline(_seen(begin), _seen(end)), "load"))
        return Picture(lines, (most, size))

    signals = {n: f"{vehicle.unit}.{n}" for n in (*POSITION, *QUATERNION)}
    caption = (
        "East to the right, north into the picture. Blue: bow and track. Orange: thrusts, the largest {0} N. "
        "Scale of the hull: {1} to 1."
    )
    return Kinematics(f"{vehicle.unit} in motion", draw, signals | thrusts, caption=caption)


def _thrusters(unit: RecordedUnit) -> tuple[np.ndarray, np.ndarray]:
    """Places (3, 6), m, and directions (3, 6) of the thrusters in body axes; (3, 0) where nothing is known of them."""
    component = unit.component
    if component is None or "thruster_x[1]" not in component.parameters:
        return np.zeros((3, 0)), np.zeros((3, 0))
    return tuple(  # type: ignore[return-value]
        np.array([[component.get(f"thruster_{what}{axis}[{k}]") for k in range(1, 7)] for axis in "xyz"])
        for what in ("", "direction_")
    )


def _seen(v: Any) -> tuple[Any, Any]:
    """Place in the picture of north, east, down, 3 times (k,)."""
    return v[1] + DEPTH * v[0], -v[2] + DEPTH * v[0]
