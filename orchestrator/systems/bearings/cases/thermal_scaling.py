"""Heat resistance of angular contact bearings: scaling law, an independent table, and finite volumes for the lumped path."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.special import ellipkm1

from .....components.bearings.conductance import AngularContactConductance
from .....components.bearings.constriction import constriction
from ....harness.validation import Evidence, Runs
from ....harness.validation.reference import Row, TableRow, load_table
from ..heat_path import Surroundings, solve_bearing

BEARINGS: dict[str, tuple[float, float]] = {"7008C": (40e-3, 68e-3), "7210B": (50e-3, 90e-3)}  # bore, outside diameter, m
AXIAL, RADIAL = (50, 100, 500, 1000, 5000), (0, 200, 500, 1000, 2000)  # N; the radial ones beside 1 kN
CONTACTS_ONLY: tuple[str, ...] = ()
SOLID = ("ball_bulk", "ring_walls")
GAP = {"closest_gap": 1e-6, "gas_path.widest_gap": 5e-5, "gas_path.ring_gap": 1e6}  # no air beside the balls: the grid has none
CONTACT_BAND = 0.04  # 2 % are the grid's, 2 % the lumped rings' and ball's
AIR_BAND = 0.10  # the ladder of constrictions in the gap, too
OIL_BAND = 0.15  # as in air, and more of the heat takes that way
AIR, OIL, CONVECTION, EMISSIVITY = 0.026, 0.14, 10.0, 0.4  # W/(m.K) twice, W/(m2.K), 1
MENISCI = (5e-5, 1e-5)  # m
SOLID_LOADS = (("7008C", 50.0, 0.0), ("7008C", 1000.0, 0.0), ("7008C", 5000.0, 0.0), ("7210B", 1000.0, 0.0),
               ("7210B", 1000.0, 2000.0))  # fmt: skip
ALL_TOGETHER = "7008C, 50 N axial, air, convection and radiation"


class Study(NamedTuple):
    """The same path lumped and in finite volumes, K/W; band: relative, for the row."""

    condition: str
    band: float
    lumped: float
    reference: float

    @property
    def difference(self) -> float:
        """Of the lumped path, %."""
        return 100.0 * (self.lumped / self.reference - 1.0)


def measure(runs: Runs) -> Evidence:
    """Closed forms and table for the contacts, finite volumes for the whole path."""
    studies = _against_finite_volumes()
    rows = []
    for s in studies:
        low, high = (float((1.0 + sign * s.band) * s.reference) for sign in (-1.0, 1.0))
        source = "finite volumes of balls and rings by this project, checked against closed forms; their own error is about 2 %"
        row = TableRow("resistance of the lumped path", s.condition, s.condition, "K/W", low, high, "computed", source)
        rows.append(Row(row, s.lumped))
    drawn: dict[str, Any] = {"rows": [(s.condition, s.lumped, s.reference, s.difference) for s in studies]}
    for name, band in (("solid", CONTACT_BAND), ("air", AIR_BAND), ("oil", OIL_BAND)):
        differences = [s.difference for s in studies if s.band == band]
        drawn |= {f"{name}.least": min(differences), f"{name}.most": max(differences)}
    reference = {s.condition: s.reference for s in studies}
    saved = 100.0 * (1.0 - reference["7008C, 1000 N axial, air beside the contacts"] / reference["7008C, 1000 N axial"])
    return Evidence(_contacts() | _laws(), rows=tuple(rows), data={**drawn, **_over_axial(), "saved": saved})


def bearing(preset: str, effects: tuple[str, ...], axial: float, radial: float = 0.0, more: Mapping[str, Any] | None = None):
    """A bearing under load, its outputs computed."""
    given: dict[str, Any] = {"axial_force": axial, "radial_force": radial, **(more or {})}
    if "ring_walls" in effects:
        given |= dict(zip(("ring_walls.bore", "ring_walls.outside_diameter"), BEARINGS[preset], strict=True))
    model = AngularContactConductance(effects, given, preset=preset)
    model.initialize(0.0)
    return model


def _contacts() -> dict[str, float]:
    measured = {}
    for preset in BEARINGS:
        loads = [(fa, 0) for fa in AXIAL] + [(1000, fr) for fr in RADIAL[1:]]
        for axial, radial in loads:
            model = bearing(preset, CONTACTS_ONLY, axial, radial)
            measured[f"{preset}.{axial}.{radial}"] = 1.0 / model["conductance"]
            measured[f"{preset}.balls.{radial}"] = model["loaded_balls"]
    return measured


def _laws() -> dict[str, float]:
    light, heavy = (bearing("7008C", CONTACTS_ONLY, force) for force in (10.0, 5000.0))
    per_load = math.log(heavy["max_ball_load"] / light["max_ball_load"])
    major, minor = 6e-4, 1e-4  # m
    ellipse = ellipkm1((minor / major) ** 2) / (2.0 * math.pi * 46.0 * major)
    low, high = (bearing("7210B", CONTACTS_ONLY, force)["conductance"] for force in (50.0, 100.0))
    warm = {"radiation.inner_temperature": 300.0, "radiation.outer_temperature": 300.0}
    return {
        "slope.ball": -math.log(heavy["conductance"] / light["conductance"]) / per_load,
        "slope.bearing": -math.log(high / low) / math.log(2.0),
        "ellipse": constriction(major, minor, 46.0) / ellipse,
        "side.radiation": 1.0 / bearing("7008C", ("radiation",), 0.0, 0.0, warm)["conductance"],
        "side.air": 1.0 / bearing("7008C", ("gas_path",), 0.0, 0.0, {"gas_path.widest_gap": 0.0})["conductance"],
    }


def _against_finite_volumes() -> list[Study]:
    studies = []
    for preset, axial, radial in SOLID_LOADS:
        model = bearing(preset, SOLID, axial, radial)
        reference = 1.0 / solve_bearing(model, *BEARINGS[preset])
        text = f"{preset}, {axial:g} N axial" + (f", {radial:g} N radial" if radial else "")
        studies.append(Study(text, CONTACT_BAND, 1.0 / model["conductance"], reference))
    gap = AIR, GAP["closest_gap"], GAP["gas_path.widest_gap"]
    air = Surroundings(*gap)
    for axial in (0.0, 50.0, 1000.0):
        model = bearing("7008C", (*SOLID, "gas_path"), axial, 0.0, GAP)
        reference = 1.0 / solve_bearing(model, *BEARINGS["7008C"], air)
        text = f"7008C, {axial:g} N axial, air beside the contacts"
        studies.append(Study(text, AIR_BAND, 1.0 / model["conductance"], reference))
    for width in MENISCI:
        oil = {"closest_gap": GAP["closest_gap"], "lubricant_path.conductivity": OIL, "lubricant_path.meniscus_height": width}
        model = bearing("7008C", (*SOLID, "lubricant_path"), 1000.0, 0.0, oil)
        reference = 1.0 / solve_bearing(model, *BEARINGS["7008C"], Surroundings(OIL, GAP["closest_gap"], width))
        text = f"7008C, 1000 N axial, oil up to a gap of {1e6 * width:g} um"
        studies.append(Study(text, OIL_BAND, 1.0 / model["conductance"], reference))
    # ring - node - ring: half of each coefficient, as of the emissivity; temperatures as in the finite volumes
    warm = {"radiation.inner_temperature": 303.15, "radiation.outer_temperature": 293.15}
    rings = {"radiation.emissivity": 0.5 * EMISSIVITY, **warm}
    model = bearing("7008C", (*SOLID, "gas_path", "convection", "radiation"), 50.0, 0.0, GAP | rings)
    everything = Surroundings(*gap, CONVECTION, EMISSIVITY)
    reference = 1.0 / solve_bearing(model, *BEARINGS["7008C"], everything)
    studies.append(Study(ALL_TOGETHER, AIR_BAND, 1.0 / model["conductance"], reference))
    return studies


def _over_axial() -> dict[str, Any]:
    """Resistances over the axial force, and those of the independent solver."""
    force = np.geomspace(10.0, 1e4, 25)
    table = {r.measure: np.mean([end for end in (r.low, r.high) if end is not None]) for r in load_table("thermal-scaling").rows}
    resistances = {p: np.array([1.0 / bearing(p, CONTACTS_ONLY, f)["conductance"] for f in force]) for p in BEARINGS}
    return {
        "force": np.log10(force),
        **resistances,
        "scaled": {p: resistance * np.cbrt(force) for p, resistance in resistances.items()},
        "given": np.log10(AXIAL),
        **{f"{p}.solver": [table[f"{p}.{f}.0"] for f in AXIAL] for p in BEARINGS},
    }
