"""Thermal resistance of an angular contact bearing (Spence & Kaminski 1996), claim by claim.

Resistance over the plane of both loads, through the contacts alone; shares of conduction, convection and radiation, and how they
change the law of the cube root; contact areas and conductances ball by ball, lumped and in finite volumes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from .....components.bearings.conductance import AngularContactConductance, side_of_ball
from .....components.bearings.constriction import conductances_in_series, noted_contact
from .....components.bearings.load_zone import load_integrals
from .....components.bearings.radiation import STEFAN_BOLTZMANN
from ....harness.validation import Evidence, Runs
from .. import least_energy
from ..heat_path import Surroundings, ball_path, solve_bearing

BORES = {"7008C": (40e-3, 68e-3), "7210B": (50e-3, 90e-3), "25 degrees": (30e-3, 62e-3)}  # bore, outside diameter, m
ANGLES = {"7008C": 15.0, "7210B": 40.0}  # degrees
FRESH = {  # a bearing that no criterion was made with: 7206 by its size, groove radii and number of balls assumed
    "25 degrees": {"balls": 12, "ball_diameter": 9.525e-3, "pitch_diameter": 46e-3, "inner_conformity": 0.515,
                   "outer_conformity": 0.525, "contact_angle": math.radians(25.0), "width": 16e-3},
}  # fmt: skip
BULK = ("ball_bulk", "ring_walls")
SIDE = ("gas_path", "convection", "radiation")
ANNULUS: dict[str, float] = {"gas_path.widest_gap": 0.0}  # gas between the rings, none beside the contacts
TEMPERATURES = {"radiation.inner_temperature": 300.0, "radiation.outer_temperature": 300.0}  # K
RATIOS = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0)
AXIAL = {"7008C": (200.0, 1000.0), "7210B": (1000.0, 5000.0)}  # N
ZONES = (0.5, 0.7, 1.0, 1.25, 1.67, 2.5)  # epsilon, loaded share of the circumference, projected
ZONE_LOAD = 1.0  # N, axial: the contact angle stays what it is without load
FINE = np.linspace(0.0, 3.0, 61)
PLANE = np.geomspace(50.0, 5000.0, 33)  # N
HEAVY = 1000.0  # N
LIGHT = (1.0, 1e-3)  # N
MIXED = (0.5, 1.0, 2.0, 3.0, 5.0)  # radial over axial load
STEPS = np.linspace(0.0, 3.0, 61)  # the same, for the exponent's boundary
HELD = (0.29, 0.3383)  # of the exponent: what axial load alone has, 0.29 at 15 degrees to 1/3 and 0.005
CLOSEST, NARROW = 1e-6, 5e-5  # m, of the component's defaults: width added to a gap, and up to which it is narrow
SHARED = {  # N, axial and radial, at which shares are compared; both loads where balls are free, and in the bearing not looked at
    "7008C": ((10.0, 0.0), (1000.0, 0.0)),
    "7210B": ((1000.0, 0.0), (1000.0, 1000.0)),
    "25 degrees": ((10.0, 0.0), (1000.0, 1000.0)),
}
OVER = np.geomspace(1.0, 1e4, 17)  # N
AIR, GAP, COEFFICIENT, EMISSIVITY, TEMPERATURE = 0.026, 8e-3, 10.0, 0.2, 300.0  # of the component's defaults
CONDUCTIVITY = 46.0  # W/(m.K), of the rings, of its defaults
RINGS = {"7008C": (54e-3, 15e-3), "7210B": (70e-3, 20e-3), "25 degrees": (46e-3, 16e-3)}  # pitch diameter, width, m
AROUND = 1000.0  # N, both ways
HALF = 9  # balls from the load line to the other side
ANGLE = 360.0 / 16 * np.arange(HALF)  # of them, degrees
SOLVED = {"7008C": (0, 2, 3, 8), "7210B": (0, 2, 4)}  # balls in finite volumes; the first is the most loaded
FINENESS = 5  # of their grids: with 3 the shares scatter by 3 %, with 5 by less than 1 %


def bearing(preset: str, effects: Sequence[str] = (), **given: Any) -> AngularContactConductance:
    """A bearing, initialized, without load."""
    parameters: dict[str, Any] = {**FRESH.get(preset, {}), **given}
    if "ring_walls" in effects:
        parameters |= dict(zip(("ring_walls.bore", "ring_walls.outside_diameter"), BORES[preset], strict=True))
    if "radiation" in effects:
        parameters |= TEMPERATURES
    model = AngularContactConductance(effects, parameters, preset=None if preset in FRESH else preset)
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
    inner_race, outer_race, rings = noted_contact(s.races[0]), noted_contact(s.races[1]), s.rings
    each = []
    for load in model.ball_loads:
        inner = side_of_ball(load, 0.0, inner_race, rings.inner_relief, *model.arguments)
        outer = side_of_ball(load, 0.0, outer_race, rings.outer_relief, *model.arguments)
        each.append(conductances_in_series(inner, outer))
    return np.array(each)


def shares(preset: str, axial: float, radial: float = 0.0, within: Sequence[str] = ()) -> dict[str, float]:
    """Share of each path in the conductance, the paths added one after the other: contacts, gas, convection, radiation.

    within: effects of the solids, in the conductance with every path.
    """
    conductance, parts = 0.0, {}
    for count, name in enumerate(("contacts", *SIDE)):
        whole = 1.0 / resistance(bearing(preset, (*within, *SIDE[:count])), axial, radial)
        parts[name.removesuffix("_path")], conductance = whole - conductance, whole
    return {name: part / conductance for name, part in parts.items()}


def solved_shares(preset: str, axial: float, radial: float) -> tuple[float, dict[str, float]]:
    """Resistance in K/W and shares as in `shares`: balls, gaps and rings in finite volumes, the side paths in closed form.

    What flows from ring to ring beside the balls passes both walls, as what the balls carry.
    """
    model = bearing(preset)
    resistance(model, axial, radial)
    bore, outside = BORES[preset]
    inside, beyond = model.raceways
    diameter, width = RINGS[preset]
    area, walls = math.pi * diameter * width, math.log(outside / bore * inside / beyond) / (2.0 * math.pi * CONDUCTIVITY * width)
    dry, airy = (1.0 / solve_bearing(model, bore, outside, air) - walls for air in (None, Surroundings(AIR, CLOSEST, NARROW)))
    gas, moving = 1.0 / airy + area * AIR / GAP, area * 0.5 * COEFFICIENT
    between = np.array([1.0 / dry, gas, gas + moving, gas + moving + side_paths(preset) - area * (AIR / GAP + 0.5 * COEFFICIENT)])
    whole = 1.0 / (walls + 1.0 / between)
    parts = np.diff(whole, prepend=0.0) / whole[-1]
    return 1.0 / whole[-1], dict(zip(("contacts", "gas", "convection", "radiation"), parts.tolist(), strict=True))


def over_both_loads(runs: Runs) -> Evidence:
    """Equilibria of the component under both loads."""
    models = {preset: bearing(preset) for preset in ANGLES}
    measured: dict[str, float] = {}
    for preset, model in models.items():
        for axial in AXIAL[preset]:
            measured |= {f"{preset}.{axial:g}.{r:g}": resistance(model, axial, r * axial) for r in RATIOS}
        measured |= {f"exponent.{preset}.{axial:g}": exponent(model, axial) for axial in (50.0, 1000.0)}
    steep, flat = models["7210B"], models["7008C"]
    measured["exponent.joining"] = exponent(steep, 1000.0, 1.0)
    measured |= {f"zone.{e:g}": zone(e) for e in ZONES}
    curve = np.array([resistance(steep, 1000.0, r * 1000.0) for r in FINE])
    measured["maximum.ratio"] = FINE[int(np.argmax(curve))]
    measured["maximum.fall"] = 100.0 * (1.0 - curve[-1] / curve.max())
    rising = np.array([resistance(flat, 1000.0, r * 1000.0) for r in FINE])
    measured["flat.rise"] = np.diff(rising).min()
    drawn: dict[str, Any] = {"ratios": FINE}
    for preset, model in models.items():
        plane = np.array([[resistance(model, axial, radial) for axial in PLANE] for radial in PLANE])
        drawn[f"plane.{preset}"] = np.log10(PLANE), np.log10(PLANE), np.log10(plane)
        drawn[preset] = {f"{axial:g} N axial": [resistance(model, axial, r * axial) for r in FINE] for axial in AXIAL[preset]}
    return Evidence(measured, data=drawn)


def zone(epsilon: float) -> float:
    """Resistance over that under the same axial load alone, at the radial load that loads a share epsilon; light loads."""
    model = bearing("7210B")
    radial, axial = load_integrals(epsilon)
    tangent = math.tan(math.radians(ANGLES["7210B"]))
    return resistance(model, ZONE_LOAD, ZONE_LOAD * radial / (axial * tangent)) / resistance(model, ZONE_LOAD)


def like(model: AngularContactConductance) -> least_energy.Bearing:
    """The same bearing for the other equilibrium."""
    p: Any = model.parameters
    return least_energy.Bearing(
        p["balls"], p["ball_diameter"], p["pitch_diameter"], p["inner_conformity"], p["outer_conformity"], p["contact_angle"],
        p["modulus"] / (1.0 - p["poisson_ratio"] ** 2), p["ring_conductivity"],
    )  # fmt: skip


def over_the_ratio(runs: Runs) -> Evidence:
    """Exponents at fixed ratios of radial to axial load: light loads, and 1 kN up to and beyond where the first ball is free.

    Lengths, loads and approaches of all balls scale together while contact angles stay: then the exponent is 1/3 at any ratio. Under
    working loads the angle grows, and with it the loaded share of the circumference: beyond epsilon = 1 balls join with the load.
    """
    measured: dict[str, float] = {}
    curves = {}
    radial, axial = load_integrals(1.0)
    for preset, angle in (*ANGLES.items(), ("25 degrees", 25.0)):
        model = bearing(preset)
        other = like(model)
        light = [exponent(model, LIGHT[1], ratio) for ratio in MIXED]
        curves[preset] = over = np.array([exponent(model, HEAVY, float(ratio)) for ratio in STEPS])
        solved = np.array([least_energy.exponent(other, HEAVY, float(ratio)) for ratio in STEPS])
        free = radial / (axial * math.tan(math.radians(angle)))  # ratio at which the first ball is free, unloaded contact angle
        full, left = free >= STEPS, (over < HELD[0]) | (over > HELD[1])
        measured |= {
            f"{preset}.light.least": min(light),
            f"{preset}.light.most": max(light),
            f"{preset}.apart": np.abs(over - solved).max(),
            f"{preset}.full.most": over[full].max(),
            f"{preset}.beyond.most": over[~full].max(),
            f"{preset}.boundary": STEPS[int(np.argmax(left))] if left.any() else math.inf,
        }
    held = {f"{preset}.held": measured[f"{preset}.boundary"] - STEPS[1] for preset in curves}
    exponents = {f"{preset}, 1 kN axial": curve for preset, curve in curves.items()}
    return Evidence(measured, data={"steps": STEPS, "exponents": exponents, **held})


def by_path(runs: Runs) -> Evidence:
    """Networks with all paths, lumped and in finite volumes, and with the rings in series."""
    measured: dict[str, float] = {}
    percent: dict[str, float] = {}
    for preset in BORES:
        for axial, radial in SHARED[preset]:
            whole, parts = solved_shares(preset, axial, radial)
            lumped = shares(preset, axial, radial, within=BULK)
            here = f"{preset}.{axial:g}.{radial:g}"
            measured[f"{here}.whole"] = resistance(bearing(preset, (*BULK, *SIDE)), axial, radial) / whole
            measured |= {f"{here}.{path}": lumped[path] / parts[path] for path in ("contacts", "radiation")}
            percent |= {f"{here}.{path}": 100.0 * share for path, share in parts.items()}
    for preset in ANGLES:
        network = bearing(preset, (*BULK, *SIDE))
        measured |= {f"{preset}.exponent.{f:g}": exponent(network, f) for f in (HEAVY, *LIGHT)}
        series = bearing(preset, BULK)
        measured[f"{preset}.series"] = exponent(series, 5000.0) / exponent(series, 50.0)
        unloaded = resistance(bearing(preset, SIDE, **ANNULUS), 0.0)
        measured[f"{preset}.unloaded"] = unloaded * side_paths(preset) - 1.0
    curves = {preset: [shares(preset, float(f)) for f in OVER] for preset in ANGLES}
    paths = {preset: {name: [p[name] for p in of] for name in of[0]} for preset, of in curves.items()}
    return Evidence(measured, data={"loads": np.log10(OVER), **paths, **percent})


def side_paths(preset: str) -> float:
    """Conductance of an annulus of still air, moving air and radiation between rings at one temperature, W/K."""
    diameter, width = RINGS[preset]
    area = math.pi * diameter * width
    return area * (AIR / GAP + 0.5 * COEFFICIENT + 4.0 * EMISSIVITY * STEFAN_BOLTZMANN * TEMPERATURE**3)


def around_the_circumference(runs: Runs) -> Evidence:
    """One equilibrium each: loads, areas of the inner contacts, conductances."""
    measured: dict[str, float] = {}
    drawn: dict[str, Any] = {}
    for preset in ANGLES:
        model = bearing(preset)
        resistance(model, AROUND, AROUND)
        loads = model.ball_loads[:HALF]
        lumped = ball_conductances(model)[:HALF]
        at = list(SOLVED[preset])
        solid = np.array([ball_path(model, load, *BORES[preset], fineness=FINENESS).conductance for load in loads[at]])
        whole = bearing(preset, BULK)
        resistance(whole, AROUND, AROUND)
        bulk = ball_conductances(whole)[:HALF]
        area = areas(model, loads)
        root = np.cbrt(loads / loads.max())
        measured |= {f"{preset}.{j}": g for j, g in enumerate(lumped / lumped.max())}
        measured[f"{preset}.volumes"] = 100.0 * np.abs(solid / solid[0] - root[at]).max()
        measured[f"{preset}.bulk"] = 100.0 * np.abs(solid / solid[0] - (bulk / bulk[0])[at]).max()
        measured[f"{preset}.area"] = np.abs(area / area.max() - root**2).max()
        drawn |= {f"{preset}.lumped": lumped / lumped.max(), f"{preset}.root": root, f"{preset}.areas": area / area.max()}
        drawn |= {f"{preset}.solved": ANGLE[at], f"{preset}.solid": solid / solid[0], f"{preset}.largest": 1e6 * area.max()}
    return Evidence(measured, data={"angle": ANGLE, **drawn})


def areas(model, loads: np.ndarray) -> np.ndarray:
    """Area of the inner contact of each ball, (n,) m2, by Hertz's solution for its own load."""
    contact = model.geometry().contact("inner", model.material())
    return np.array([0.25 * math.pi * math.prod(contact.axes(load)) if load > 0.0 else 0.0 for load in loads])
