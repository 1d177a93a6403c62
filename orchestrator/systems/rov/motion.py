"""Underwater vehicles in motion: hull, thrusts and track, seen from the south and above."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from ...harness.analysis.records import RecordedUnit
from ...harness.charts.blocks import Motion, Moving
from ...harness.charts.motion import instants, polyline, trace
from ...harness.charts.style import number
from .records import Vehicle, vehicles

if TYPE_CHECKING:
    from ...results import Result

DEPTH = 0.4  # share of a length to the north that a picture shows, to the right and up
SHARE = 0.2  # of the track, that a hull has at least
FLAT = 0.4  # height of a hull over its width, where all thrusters lie in one plane
# corners of a box in one line along all edges
EDGES = (0, 1, 3, 2, 0, 4, 5, 7, 6, 4, 5, 1, 3, 7, 6, 2)


def motions(result: Result) -> list[Motion]:
    """A picture of each vehicle whose attitude was recorded."""
    rows = instants(result.time)
    return [_motion(v, RecordedUnit(result, v.unit), rows) for v in vehicles(result) if v.axes is not None]


def _motion(vehicle: Vehicle, unit: RecordedUnit, rows: np.ndarray) -> Motion:
    assert vehicle.axes is not None
    position, axes = vehicle.position[:, rows], vehicle.axes[:, :, rows]
    places, directions = _thrusters(unit)
    half = np.abs(places).max(axis=1, initial=0.0)
    half = np.maximum(half, FLAT * half.max()) if half.max() else np.array([0.5, 0.4, 0.3])
    extent = float(np.ptp(np.array(_seen(position)), axis=1).max())
    size = max(1.0, SHARE * extent / (2.0 * half[0]))

    def at(own: np.ndarray) -> np.ndarray:
        """World places (3, k) of a point of the hull, (3,) m."""
        return position + size * np.einsum("ijk,j->ik", axes, own)

    corners = [at(np.array(signs) * half) for signs in product((-1.0, 1.0), repeat=3)]
    lines = [
        trace(*_seen(position)),
        Moving(polyline(*(_seen(corners[k]) for k in EDGES)), "part"),
        Moving(polyline(_seen(at(np.zeros(3))), _seen(at(np.array([1.3 * half[0], 0.0, 0.0])))), "second"),
    ]
    most = max((float(np.abs(f).max()) for f in vehicle.thrusts.values()), default=0.0)
    for k, thrust in vehicle.thrusts.items():
        if most and k <= places.shape[1]:
            place, reach = places[:, k - 1], 1.2 * half[0] * directions[:, k - 1]
            begin, whole = at(place), at(place + reach)
            lines.append(Moving(polyline(_seen(begin), _seen(begin + thrust[rows] / most * (whole - begin))), "load"))
    text = f"East to the right, north into the picture. Blue: bow and track. Orange: thrusts, the largest {number(most)} N."
    text += f" The hull is drawn {size:.2g} times its size." if size > 1.0 else ""
    return Motion(f"{vehicle.unit} in motion", vehicle.time[rows], lines, caption=text)


def _thrusters(unit: RecordedUnit) -> tuple[np.ndarray, np.ndarray]:
    """Places (3, 6), m, and directions (3, 6) of the thrusters in body axes; (3, 0) where nothing is known of them."""
    component = unit.component
    if component is None or "thruster_x[1]" not in component.parameters:
        return np.zeros((3, 0)), np.zeros((3, 0))
    return tuple(  # type: ignore[return-value]
        np.array([[component.get(f"thruster_{what}{axis}[{k}]") for k in range(1, 7)] for axis in "xyz"])
        for what in ("", "direction_")
    )


def _seen(v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Place in the picture of north, east, down, (3, k)."""
    return v[1] + DEPTH * v[0], -v[2] + DEPTH * v[0]
