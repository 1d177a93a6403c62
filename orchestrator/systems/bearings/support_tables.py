"""Stiffness and damping of a bearing for a rotor, as the table of supports that `BeamRotor` and other programs read."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np

from ....components.bearings.deep_groove import DeepGrooveBearing
from ....components.bearings.short_bearing import ShortBearing, film_load, film_state
from ....components.core.errors import BadInput
from ....components.core.kernels import DONE
from ....components.core.measure import number_in
from ....components.rotor.supports import UNITS
from ...output import write_table

ANGLES = 60  # places of the balls within one spacing, of which the stiffness is the mean
PLANE = np.ix_((0, 1), (0, 1))
HEADER = {"position": "m", **UNITS}


class SupportRow(NamedTuple):
    """At one speed, rad/s: K and C, (2, 2) in N/m and N.s/m; and words for what else is to be known, name -> text."""

    speed: float
    stiffness: np.ndarray
    damping: np.ndarray
    notes: Mapping[str, str]


def ball_rows(
    parameters: Mapping[str, Any], effects: Iterable[str], preset: str, load: tuple[float, float, float], speeds: Sequence[float]
) -> list[SupportRow]:
    """Of a deep groove bearing under a load on the shaft, N, at each speed: tangents at the static equilibrium, mean of a ball spacing.

    The inner ring does not tilt, and in the vibration it does not move along the shaft. Raises `BadInput` where there is no
    equilibrium, and where no ball is loaded.
    """
    given = {name: _number(name, value) for name, value in parameters.items()}
    bearing = DeepGrooveBearing([*effects, "linearisation"], {**given, "linearisation.idle_stiffness": 0.0}, preset=preset)
    names, balls = ("displacement_x", "displacement_y", "displacement_z"), cast(int, bearing.parameters["balls"])
    rows = []
    for speed in speeds:
        bearing.set("speed", speed)
        tangents = []
        for k in range(ANGLES):
            bearing.initialize(0.0)
            bearing.x[1] = 2.0 * math.pi * k / (ANGLES * balls)
            static = bearing.equilibrium(np.array([*load, 0.0, 0.0]), held=("tilt_x", "tilt_y"))
            if static.status != DONE or not static.ball_loads.any():
                reason = "no ball is loaded" if static.status == DONE else "no equilibrium within the range of the contacts"
                raise BadInput("load", f"{load} N: {reason}", "a load that some balls carry", "Give a load, or a preload.")
            for name, value in zip(names, static.displacement[:3], strict=True):
                bearing.set(name, float(value))
            bearing.refresh()
            tangents.append([_tangent(bearing, what) for what in ("stiffness", "damping")])
            for name in names:
                bearing.set(name, 0.0)
        stiffness, damping = np.mean(tangents, axis=0)
        spread = np.ptp([t[0] for t in tangents], axis=0) / np.abs(stiffness).max()
        notes = {"change of kxx and kyy as balls pass": f"{100.0 * spread[0, 0]:.2g} %, {100.0 * spread[1, 1]:.2g} %"}
        rows.append(SupportRow(speed, stiffness, damping, notes))
    return rows


def _number(name: str, value: Any) -> Any:
    """The value of a parameter, by its unit where it is a text with one."""
    variable = DeepGrooveBearing.variables.get(name.partition("[")[0])
    return number_in(value, variable.unit, name) if isinstance(value, str) and variable is not None and variable.unit else value


def _tangent(bearing: DeepGrooveBearing, what: str) -> np.ndarray:
    values = [bearing.get(f"linearisation.{what}[{k}]") for k in range(1, 26)]
    return np.reshape(np.asarray(values, dtype=float), (5, 5))[PLANE]


def film_rows(bearing: ShortBearing, load: tuple[float, float], speeds: Sequence[float]) -> list[SupportRow]:
    """Of a short plain bearing under a load on the journal, N, at each speed."""
    rows = []
    for speed in speeds:
        state = film_state(bearing, load, speed)
        notes = {
            "eccentricity": f"{state.eccentricity:.4g}",
            "attitude": f"{math.degrees(state.attitude):.4g} deg",
            "modified Sommerfeld number": f"{1.0 / film_load(state.eccentricity):.4g}",
        }
        rows.append(SupportRow(speed, state.stiffness, state.damping, notes))
    return rows


def save(rows: Sequence[SupportRow], position: float, directory: Path) -> Path:
    """supports.csv in the directory: the names of `HEADER`, a line of their units, a row for each speed."""
    lines = [(position, row.speed, *map(float, (*row.stiffness.ravel(), *row.damping.ravel()))) for row in rows]
    return write_table(directory, "supports.csv", tuple(HEADER), [tuple(HEADER.values()), *lines])
