"""Which gear and lever an inertial converter needs at a site, and where it gives less water than the best fixed ratio.

python -m cosimo.orchestrator.systems.wind_pump.sizing scene.toml --mean "4 m/s"

Rotor, converter, pump and pipe are those of a scene, with the reader's tables. In each wind turbine and converter are at an equilibrium
to which the turbine's speed returns, that with most water, by the equations of `AveragedConverter`; so is the turbine behind a fixed
ratio, which runs from the least wind on in which it can, not from that in which it starts. So where the converter wins here, it wins.
Winds have a Weibull distribution; above the wind in which the rotor furls the flow stays. Whether vibrations about an equilibrium die
out is not asked.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import brentq, minimize_scalar
from scipy.special import gamma

from ....components.core.errors import BadInput, counted
from ....components.core.measure import number_in
from ....components.wind_pump.averaged import AveragedConverter
from ....components.wind_pump.centrifugal_pump import CentrifugalPump
from ....components.wind_pump.pipe import WaterPipe
from ....components.wind_pump.piston_pump import PistonPump
from ....components.wind_pump.turbine import LARGEST_RATIO, WindTurbine
from ...output import ensure_directory, write_table
from ...scene.files import table_text
from ...scene.scene import Scene
from .. import load_scene

YEAR = 365.25 * 86400.0  # s
WINDS, RATIOS, SPEEDS = 100, 400, 600  # places of the integral, of each search for an equilibrium, and of the pump's curve
GEARS = np.geomspace(0.5, 60.0, 41)  # crank over turbine, where a best gear and the ends of its range are sought
FIXED = (1e-2, 1e3)  # pump over turbine
HALVINGS = 40
ERROR = 1e-3  # of the water of a year: what twice the places, and the equations of the paper's case, change
COUNTED = {"performance_table", "furling", "bearing_friction"}  # of the turbine; of the pump all, of the pipe friction


@dataclass(frozen=True)
class Site:
    """Rotor, pump and winds as arrays. winds: (n,) m/s and weights: s of a year; torques: (n, RATIOS) N.m of the wind less
    friction at speeds, rad/s, likewise; pump: speeds, rad/s, with torques, N.m, and flows, m³/s, and the last speed at which its table
    says them.  notes: what is not counted."""

    winds: np.ndarray
    weights: np.ndarray
    speeds: np.ndarray
    torques: np.ndarray
    pump: tuple[np.ndarray, np.ndarray, np.ndarray]
    last: float
    converter: Any
    notes: tuple[str, ...]

    def by_converter(self, gear: float, lever: float) -> float:
        """Water of a year, m³, with a gear and a mass of the lever, kg."""
        return self._water(self.converter_speeds(gear, lever))

    def converter_speeds(self, gear: float, lever: float) -> np.ndarray:
        """(n,) speeds of the pump in the winds, rad/s, with a gear and a mass of the lever, kg."""
        settings = self.converter
        one = AveragedConverter((), {**settings.parameters, "lever_mass": lever}, preset=settings.preset)
        k1, k2 = one.coefficients()
        crank = gear * self.speeds
        low, high = np.zeros_like(crank), crank * k1 / k2
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            faster = k1 * crank**2 - k2 * crank * middle > np.interp(middle, *self.pump[:2])
            low, high = np.where(faster, middle, low), np.where(faster, high, middle)
        return self._turning(self.torques - gear * (k1 * crank - k2 * low) * low, low)

    def by_fixed(self, ratio: float) -> float:
        """Water of a year, m³, behind a fixed ratio, pump over turbine, that always runs where it can."""
        return self._water(self.fixed_speeds(ratio))

    def fixed_speeds(self, ratio: float) -> np.ndarray:
        """(n,) speeds of the pump in the winds, rad/s, behind a fixed ratio."""
        speed = ratio * self.speeds
        return self._turning(self.torques - ratio * np.interp(speed, *self.pump[:2]), speed)

    def best_fixed(self) -> tuple[float, float]:
        """(ratio, water of a year in m³) of the fixed ratio that gives most."""
        return _best(self.by_fixed, np.geomspace(*FIXED, 61))

    def best_gear(self, lever: float) -> tuple[float, float]:
        """(gear, water of a year in m³) of the converter that gives most with a lever, kg."""
        return _best(lambda gear: self.by_converter(gear, lever), GEARS)

    def beyond(self, what: str, speeds: np.ndarray) -> list[str]:
        """A note where speeds of the pump in the winds, (n,) rad/s, are those at which its table says nothing."""
        first = self.winds[speeds > self.last]
        where = f"in winds from {first.min():.3g} m/s on" if first.size else ""
        return [f"{what}: {where} the flow lies behind the last row of the pump's table, which goes on straight"] if where else []

    def _water(self, speeds: np.ndarray) -> float:
        return float(self.weights @ np.interp(speeds, self.pump[0], self.pump[2]))

    def _turning(self, surplus: np.ndarray, speeds: np.ndarray) -> np.ndarray:
        """Of torques that are left, N.m, at speeds of the pump, rad/s: where they fall through 0 it turns, with the largest flow."""
        before, after = surplus[:, :-1], surplus[:, 1:]
        falls = (before > 0.0) & (after <= 0.0)
        share = np.where(falls, before / np.where(falls, before - after, 1.0), 0.0)
        return np.asarray(np.where(falls, speeds[:, :-1] + share * np.diff(speeds, axis=1), 0.0).max(axis=1))


def site_of(scene: Scene, mean: float, shape: float = 2.0) -> Site:
    """That of a scene's rotor, converter, pump and pipe in winds of a mean, m/s, and Weibull's shape. Raises `BadInput`."""
    turbine, rotor = _one(scene, WindTurbine)
    pump, _ = _one(scene, PistonPump, CentrifugalPump)
    pipe, way = _one(scene, WaterPipe)
    _, converter = _one(scene, AveragedConverter)
    if "pitch" in rotor.effects:
        raise BadInput(scene.name, "a rotor whose pitch changes", "a fixed pitch", "Leave out the effect 'pitch'.")
    if isinstance(pump, PistonPump) and "averaged" not in pump.on:
        raise BadInput(scene.name, "a piston pump in its strokes", "its mean over a turn", "Switch on its effect 'averaged'.")
    _, values, effects = turbine.arguments
    furled = effects.furling.wind if effects.furling is not None else 2.0 * mean
    ratios = np.linspace(0.0, LARGEST_RATIO, 6 * RATIOS + 1)[1:]
    torques = np.array([_torque(turbine, r) for r in ratios.tolist()])
    if not (torques > 0.0).any():
        raise BadInput(scene.name, "a rotor without torque", "a curve with power")
    runaway = ratios[np.flatnonzero(torques > 0.0)[-1]]
    chosen = np.linspace(0.0, min(1.02 * runaway, LARGEST_RATIO), RATIOS + 1)[1:]
    scale = mean / float(gamma(1.0 + 1.0 / shape))
    ends = furled * np.linspace(0.0, 1.0, WINDS + 1)
    winds = np.append(0.5 * (ends[1:] + ends[:-1]), furled)
    above = np.exp(-((ends / scale) ** shape))  # share of the time with more wind
    weights = np.append(-np.diff(above), above[-1])
    speeds = chosen * winds[:, None] / values.radius
    drag = values.damping * speeds + (effects.bearing_friction.kinetic if effects.bearing_friction is not None else 0.0)
    driving = winds[:, None] ** 2 * np.interp(chosen, ratios, torques)
    left_out = [
        f"{e} of the {n}" for n, unit in (("converter", converter), ("turbine", rotor), ("pipe", way)) for e in unit.effects
    ]
    uncounted = [text for text in left_out if text.split()[0] not in COUNTED | {"friction"}]
    notes = [f"not counted: {', '.join(uncounted)}"] if uncounted else []
    notes += (
        []
        if effects.furling is not None
        else [f"the rotor does not furl: the flow stays above {furled:g} m/s, twice the mean wind"]
    )
    return Site(winds, YEAR * weights, speeds, driving - drag, *_curve(pump, pipe), converter, tuple(notes))


def _torque(turbine: Any, ratio: float) -> float:
    """Of a wind of 1 m/s at a tip speed ratio, N.m."""
    turbine.set("wind", 1.0)
    turbine.set("start_speed", ratio / float(turbine.get("radius")))
    turbine.initialize(0.0)
    return float(turbine.get("aerodynamic_torque"))


def _one(scene: Scene, *classes: type) -> tuple[Any, Any]:
    """(component, settings) of the only unit of these classes."""
    named = [name for name, cls in scene.component_classes.items() if issubclass(cls, classes)]
    if len(named) != 1:
        names = " or ".join(cls.__name__ for cls in classes)
        raise BadInput(scene.name, f"{counted(len(named), 'unit')} {names}", "one", "As in the scene wind-pump-record.")
    settings = scene.units[named[0]]
    component = scene.component_classes[named[0]](settings.effects, settings.parameters, preset=settings.preset)
    component.initialize(0.0)
    return component, settings


def _curve(pump: Any, pipe: Any) -> tuple[tuple[np.ndarray, np.ndarray, np.ndarray], float]:
    """Speeds, rad/s, with torque, N.m, and flow, m³/s, of a pump against its pipe; the first speed is hardly any. And the last speed
    before the flow lies behind the last row of the pump's table."""
    static = float(pipe.parameters["static_head"])
    loss = float(pipe.parameters["friction.coefficient"]) if "friction" in pipe.on else 0.0

    def flow(head: float) -> float:
        pump.set("head", head)
        pump.refresh()
        return float(pump.get("flow"))

    speeds = np.concatenate(([0.0], np.geomspace(1e-3, 1e4, SPEEDS)))
    torques, flows, last = np.empty_like(speeds), np.empty_like(speeds), math.inf
    for k, speed in enumerate(speeds.tolist()):
        pump.set("speed", speed)
        most = static + loss * flow(static) ** 2
        head = brentq(lambda h: h - static - loss * flow(h) ** 2, static, most, xtol=1e-9 * most) if most > static else static
        flows[k], torques[k] = flow(float(head)), pump.get("torque")
        if last == math.inf and "curve_table" in pump.on and pump.get("curve_table.beyond"):
            last = float(speeds[k - 1])
    return (speeds, torques, flows), last


def _best(water: Any, places: np.ndarray) -> tuple[float, float]:
    """Place and value of the largest value, sought between the neighbours of the best of the places."""
    k = int(np.argmax([water(x) for x in places.tolist()]))
    ends = [math.log(places[max(k - 1, 0)]), math.log(places[min(k + 1, places.size - 1)])]
    optimum = minimize_scalar(lambda x: -water(math.exp(x)), bounds=ends, method="bounded", options={"xatol": 1e-3})
    return math.exp(optimum.x), -float(optimum.fun)


def wins(site: Site, lever: float, fixed: float) -> tuple[float, float]:
    """Gears about the best one between which a lever, kg, gives more than `fixed`, m³ a year; NaN where none does."""
    more = np.array([site.by_converter(gear, lever) - fixed for gear in GEARS.tolist()])
    if more.max() <= 0.0:
        return math.nan, math.nan
    first = last = int(np.argmax(more))
    while first > 0 and more[first - 1] > 0.0:
        first -= 1
    while last < GEARS.size - 1 and more[last + 1] > 0.0:
        last += 1

    def end(k: int, beside: int) -> float:
        if not 0 <= beside < GEARS.size:
            return float(GEARS[k])
        low, high = sorted((GEARS[k], GEARS[beside]))
        return float(brentq(lambda gear: site.by_converter(gear, lever) - fixed, low, high, rtol=1e-4))

    return end(first, first - 1), end(last, last + 1)


def _change(text: str) -> tuple[str, Any]:
    name, _, value = text.partition("=")
    known = {"true": True, "false": False}.get(value, value)
    return name, table_text(known, Path(), f"--set {name}")


def main(arguments: Sequence[str] | None = None) -> None:
    """Of a scene and a mean wind: sizing.csv, and the settings of the best one. Exit code 2 for what cannot be sized."""
    parser = argparse.ArgumentParser(prog="python -m cosimo.orchestrator.systems.wind_pump.sizing", description=__doc__)
    parser.add_argument("scene", help="scene with a WindTurbine, an AveragedConverter, a pump and a WaterPipe")
    parser.add_argument("--mean", required=True, help='mean wind of the site, m/s or with a unit: "14 km/h"')
    parser.add_argument("--shape", type=float, default=2.0, help="of the Weibull distribution; 2 is Rayleigh's")
    parser.add_argument("--levers", default="10,20,40", help="masses of the lever, kg")
    parser.add_argument("--set", action="append", default=[], help="of the scene: turbine.performance_table.table=rotor.csv")
    parser.add_argument("-o", "--output", type=Path, default=Path("sizing"))
    given = parser.parse_args(arguments)
    try:
        mean = number_in(given.mean, "m/s", "--mean") if given.mean.strip()[-1:].isalpha() else float(given.mean)
        levers = [float(text) for text in given.levers.split(",")]
        if not (0.0 < mean < math.inf and 0.5 < given.shape < math.inf and all(0.0 < lever < math.inf for lever in levers)):
            raise ValueError
        scene = load_scene(given.scene).with_changes(dict(map(_change, given.set)))
        site = site_of(scene, mean, given.shape)
        for lever in levers:
            AveragedConverter.variables["lever_mass"].checked(lever, "--levers")
        ensure_directory(given.output)
    except (BadInput, ValueError) as error:
        why = error if isinstance(error, BadInput) else "mean wind, shape (above 0.5) and levers are positive numbers"
        print(f"cosimo: {why}", file=sys.stderr)
        raise SystemExit(2) from None
    ratio, fixed = site.best_fixed()
    if not 2.0 * FIXED[0] < ratio < 0.5 * FIXED[1]:
        print(
            f"cosimo: the best fixed ratio lies outside {FIXED[0]:g} to {FIXED[1]:g}: the pump does not suit the site",
            file=sys.stderr,
        )
        raise SystemExit(2)
    rows = []
    for lever in levers:
        gear, water = site.best_gear(lever)
        rows.append((lever, gear, water, water / fixed, *wins(site, lever, fixed)))
        print(
            f"lever of {lever:g} kg: best gear {gear:.3g}, {water:.4g} m3 a year, {water / fixed:.3g} of the best fixed ratio;",
            end=" ",
        )
        low, high = rows[-1][4:]
        if abs(water / fixed - 1.0) < ERROR:
            print(f"which it equals within {100.0 * ERROR:g} %, the error of these sums")
        else:
            print(f"it wins with gears from {low:.3g} to {high:.3g}" if low == low else "it loses with every gear")
    print(f"sought: gears from {GEARS[0]:g} to {GEARS[-1]:g}")
    print(f"best fixed ratio, pump over turbine: {ratio:.3g}, {fixed:.4g} m3 a year where it always runs")
    best = max(rows, key=lambda row: row[2])
    beyond = [
        *site.beyond("best fixed ratio", site.fixed_speeds(ratio)),
        *site.beyond(f"lever of {best[0]:g} kg", site.converter_speeds(best[1], best[0])),
    ]
    for note in (*site.notes, *beyond):
        print(note)
    header = ("lever_mass", "gear_ratio", "water", "over_fixed", "wins_from", "wins_to")
    print(f"wrote {write_table(given.output, 'sizing.csv', header, [('kg', '1', 'm3', '1', '1', '1'), *rows])}")
    unit = next(name for name, cls in scene.component_classes.items() if issubclass(cls, AveragedConverter))
    print(f"next: --set {unit}.lever_mass={best[0]:g} --set {unit}.gear_ratio={best[1]:.4g}")


if __name__ == "__main__":
    main()
