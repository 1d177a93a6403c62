"""The bearings of this paper's studies, and the paths of the heat in them one by one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ......components.bearings.conductance import AngularContactConductance, rings_of, side_of_ball
from ......components.bearings.constriction import conductances_in_series, noted_contact

BORES = {"7008C": (40e-3, 68e-3), "7210B": (50e-3, 90e-3)}  # bore, outside diameter, m
ANGLES = {"7008C": 15.0, "7210B": 40.0}  # degrees
BULK = ("ball_bulk", "ring_walls")
SIDE = ("gas_path", "convection", "radiation")
ANNULUS: dict[str, float] = {"gas_path.widest_gap": 0.0}  # gas between the rings, none beside the contacts
TEMPERATURES = {"radiation.inner_temperature": 300.0, "radiation.outer_temperature": 300.0}  # K


def bearing(preset: str, effects: Sequence[str] = (), **given: Any) -> AngularContactConductance:
    """A bearing, initialized, without load."""
    parameters: dict[str, Any] = dict(given)
    if "ring_walls" in effects:
        parameters |= dict(zip(("ring_walls.bore", "ring_walls.outside_diameter"), BORES[preset], strict=True))
    if "radiation" in effects:
        parameters |= TEMPERATURES
    model = AngularContactConductance(effects, parameters, preset=preset)
    model.initialize(0.0)
    return model


def resistance(model: AngularContactConductance, axial: float, radial: float = 0.0) -> float:
    """Resistance from ring to ring under loads in N, K/W; the model keeps the loads."""
    model.set("axial_force", axial)
    model.set("radial_force", radial)
    model.refresh()
    return 1.0 / model["conductance"]


def exponent(model: AngularContactConductance, axial: float, ratio: float = 0.0, step: float = 0.02) -> float:
    """-d ln R / d ln F at a fixed ratio of radial to axial load, by a central difference."""
    ends = [resistance(model, f * axial, f * ratio * axial) for f in (math.exp(-step), math.exp(step))]
    return math.log(ends[0] / ends[1]) / (2.0 * step)


def ball_conductances(model: AngularContactConductance) -> np.ndarray:
    """Conductance of each ball under the present loads, (Z,) W/K, without films."""
    s = model.arguments[0]
    inner_race, outer_race, rings = noted_contact(s.races[0]), noted_contact(s.races[1]), rings_of(s)
    each = []
    for load in model.ball_loads:
        inner = side_of_ball(load, 0.0, inner_race, rings.inner_relief, *model.arguments)
        outer = side_of_ball(load, 0.0, outer_race, rings.outer_relief, *model.arguments)
        each.append(conductances_in_series(inner, outer))
    return np.array(each)


def shares(preset: str, axial: float, radial: float = 0.0, beside: bool = True, convection: bool = True) -> dict[str, float]:
    """Share of each path in the conductance, the paths added one after the other: contacts, gas, convection, radiation.

    beside: whether there is gas beside the contacts, too, or between the rings alone.
    """
    paths = ("gas_path", *(("convection",) if convection else ()), "radiation")
    conductance, parts = 1.0 / resistance(bearing(preset), axial, radial), {}
    parts["contacts"] = conductance
    for count, name in enumerate(paths, 1):
        model = bearing(preset, paths[:count], **({} if beside else ANNULUS))
        whole = 1.0 / resistance(model, axial, radial)
        parts[name.removesuffix("_path")], conductance = whole - conductance, whole
    return {name: part / conductance for name, part in parts.items()}
