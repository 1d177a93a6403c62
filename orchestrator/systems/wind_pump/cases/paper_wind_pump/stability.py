"""Where the set of turbine and converter is stable: eigenvalues of the closed equations against pushes on the components."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import Any

import numpy as np

from .....harness.studies.modes import modes
from .....harness.validation import Evidence, Runs
from .....scene.build import unit
from .....scene.scene import Scene
from .... import build_scene
from .plant import RADIUS, Plant, farm, heier

PUSH, LINE = 1.02, 0.02  # times the speed of the turbine; share of the load within which a point counts as on the line
PLANTS = {"farm": Plant(farm, 6.0, 2.4), "heier": Plant(heier, 1.0, 14.0)}
WINDS = {"farm": np.arange(1.0, 8.1, 1.0), "heier": np.arange(2.5, 9.1, 0.75)}  # m/s
LOADS = {"farm": np.geomspace(4.0, 40.0, 8), "heier": np.geomspace(0.8, 22.0, 14)}  # N.m
STEPS, STOPS = {"farm": 0.05, "heier": 0.2}, {"farm": 40.0, "heier": 360.0}  # s
GIVEN = (3.0, 6.0, 8.0)  # m/s, winds in which the eigenvalues of the components are measured
MEAN_TORQUE = 13.2435  # N.m
COUPLED = 2e-4  # s: modes are those of the coupled step
RESTING = 0.05  # rad/s, below which a pump that has no equilibrium counts as standing: it turned at 1 at the start
FIXED_WIND, FIXED_LOAD = 6.0, 8.0  # m/s, N.m, of the turbine with Heier's curve and a gear without steps


Speeds = tuple[float, float]  # rad/s, of turbine and driven shaft


@dataclass(frozen=True)
class Point:
    """An equilibrium, or a wind and a load without one (NaN): speeds in rad/s, growth in 1/s; what a push on it led to."""

    wind: float
    load: float
    speed: float
    pump: float
    growth: float
    near: bool  # the sign of the growth is another one within 2 % of the load
    returned: bool

    @property
    def right(self) -> bool:
        """Whether the run did what the eigenvalue says."""
        return self.returned == (self.growth < 0.0)


def scenes() -> dict[Any, Scene]:
    """Pushed sets of each turbine in each wind, by both; the pushed turbine behind a fixed ratio on both branches."""
    runs: dict[Any, Scene] = {}
    for name, plant in PLANTS.items():
        for wind in WINDS[name].tolist():
            starts = [(load, at and (PUSH * at[0], at[1])) for load, at in _cells(name, wind)]
            runs[name, wind] = scene(plant, wind, starts, STEPS[name], STOPS[name])
    return runs | {branch: _fixed(branch, speed) for branch, speed in _branches().items()}


def measure(runs: Runs) -> Evidence:
    """Maps of both turbines, eigenvalues measured on the components, and the same turbine behind a fixed ratio."""
    measured: dict[str, float] = {}
    points: dict[str, list[Point]] = {}
    for name in PLANTS:
        points[name], none = _map(name, runs)
        sure = [p for p in points[name] if not p.near]
        measured |= {
            f"map.{name}": 100.0 * sum(p.right for p in sure) / len(sure),
            f"points.{name}": len(sure),
            f"unstable.{name}": sum(p.growth > 0.0 for p in points[name]),
        }
        if none:
            measured[f"standing.{name}"] = 100.0 * float(np.mean(none))
    rising = [p for p in points["heier"] if PLANTS["heier"].slope(p.wind, p.speed) > 0.0]
    measured["rising.stable"] = 100.0 * sum(p.growth < 0.0 and p.right for p in rising) / len(rising)
    for wind in GIVEN:
        measured |= _eigenvalues(wind)
    for branch, speed in _branches().items():
        measured[f"fixed.{branch}"] = abs(runs[branch]["turbine.speed"][-1] / speed - 1.0) / (PUSH - 1.0)
    worst = _worst(points["heier"])
    drawn = {f"worst.{name}": [getattr(p, name) for p in worst] for name in ("wind", "load", "growth")}
    return Evidence(measured, data=drawn | _equilibria(points["heier"]))


@cache
def _cells(name: str, wind: float) -> list[tuple[float, Speeds | None]]:
    """(load, an equilibrium under it) of a turbine in a wind; None for a load without one."""
    plant = PLANTS[name]
    cells: list[tuple[float, Speeds | None]] = []
    for load in LOADS[name].tolist():
        cells += [(load, at) for at in plant.equilibria(wind, load)] or [(load, None)]
    return cells


def _map(name: str, runs: Runs) -> tuple[list[Point], list[bool]]:
    """All points of a turbine, and for winds and loads without an equilibrium whether the pump came to stand."""
    plant = PLANTS[name]
    points: list[Point] = []
    standing: list[bool] = []
    for wind in WINDS[name].tolist():
        result = runs[name, wind]
        for k, (load, at) in enumerate(_cells(name, wind)):
            turbine, pump = result[f"turbine_{k}.speed"], result[f"converter_{k}.speed"]
            if at is None:
                standing.append(bool(pump[-1] < RESTING))
                continue
            growths = [
                plant.growth(wind, *near)
                for s in (1.0 - LINE, 1.0, 1.0 + LINE)
                for near in [_nearest(plant.equilibria(wind, s * load), at)]
                if near
            ]
            here = plant.growth(wind, *at)
            near = len(growths) < 3 or min(growths) < 0.0 < max(growths)
            returned = abs(float(turbine[-1]) / at[0] - 1.0) < PUSH - 1.0
            points.append(Point(wind, load, *at, here, near, returned))
    return points, standing


def _nearest(points: list[Speeds], at: Speeds) -> Speeds | None:
    """The equilibrium at a changed load that belongs to the one given; None where it is gone."""
    close = [x for x in points if abs(x[0] / at[0] - 1.0) < 0.2]
    return min(close, key=lambda x: abs(x[0] - at[0])) if close else None


def scene(plant: Plant, wind: float, starts: Sequence[tuple[float, Speeds | None]], step: float, stop: float) -> Scene:
    """Sets of turbine and averaged converter side by side, each under its load and from its speeds; None: a slow pump."""
    units: dict[str, Any] = {}
    connections: dict[str, str] = {}
    curve: dict[str, Any] = {
        "curve": "farm" if plant.coefficient is farm else "heier",
        "inertia": plant.inertias[0],
        "wind": wind,
    }
    gear: dict[str, Any] = {"gear_ratio": plant.gear, "driven_inertia": plant.inertias[1]}
    for k, (load, at) in enumerate(starts):
        turbine, pump = at or (0.9 * plant.largest_ratio * wind / RADIUS, 1.0)
        units[f"turbine_{k}"] = unit("WindTurbine", **curve, start_speed=turbine, substep=step)
        units[f"converter_{k}"] = unit(
            "AveragedConverter", **gear, load_torque=load, start_speed=pump, largest_turbine_speed=120.0
        )
        connections[f"turbine_{k}.speed"] = f"converter_{k}.turbine_speed"
        connections[f"converter_{k}.turbine_torque"] = f"turbine_{k}.torque"
    signals = [f"{kind}_{k}.speed" for kind, k in product(("turbine", "converter"), range(len(starts)))]
    return build_scene(
        units,
        connections,
        stop_time=stop,
        step=step,
        name="paper-wind-pump",
        master={"extrapolation": 1},
        title=f"Pushed sets in {wind:g} m/s",
        record={"signals": signals, "interval": stop},
    )


def _eigenvalues(wind: float) -> dict[str, float]:
    """Eigenvalues and Jt J2 det of the components at the operating point of the pump's mean torque, linearised."""
    plant = Plant(farm, 6.0, 2.4, (8.0, 0.5))
    at = plant.equilibria(wind, MEAN_TORQUE)[0]
    parts = scene(plant, wind, [(MEAN_TORQUE, at)], COUPLED, 1.0)
    slow, *others = sorted((mode.rate for _, mode in modes(parts).rows() if mode.kind == "coupling"), key=lambda x: -x.real)
    fast = others[0] if others else slow.conjugate()
    return {
        f"slow.{wind:g}": slow.real,
        f"fast.{wind:g}": fast.real,
        f"swing.{wind:g}": abs(fast.imag),
        f"det.{wind:g}": (slow * fast).real,
    }


def _branches() -> dict[str, float]:
    """Speeds, rad/s, at which Heier's turbine balances a constant load: on the rising and on the falling branch of its torque."""
    return dict(zip(("rising", "falling"), PLANTS["heier"].balanced(FIXED_WIND, FIXED_LOAD), strict=True))


def _fixed(branch: str, speed: float) -> Scene:
    """The turbine with Heier's curve behind a gear of ratio 1, pushed from a speed, rad/s, that balances a constant load."""
    start = PUSH * speed
    return build_scene(
        {
            "turbine": unit("WindTurbine", curve="heier", wind=FIXED_WIND, start_speed=start, inertia=15.0),
            "gear": unit("FixedTransmission", load_torque=FIXED_LOAD, start_speed=start),
        },
        {"turbine.speed": "gear.turbine_speed", "gear.turbine_torque": "turbine.torque"},
        stop_time=60.0,
        step=0.02,
        name="paper-wind-pump",
        title=f"Fixed ratio, {branch} branch, pushed",
        record={"signals": ["turbine.speed"], "interval": 1.0},
    )


def _equilibria(points: list[Point]) -> dict[str, dict[str, Any]]:
    """For four winds the closed form's loads and tip speed ratios, stable and not, and those of the runs, as they went on."""
    drawn: dict[str, dict[str, Any]] = {}
    plant, winds = PLANTS["heier"], sorted({p.wind for p in points})
    for wind in winds[:: max(len(winds) // 4, 1)][:4]:
        line = []
        for load in np.geomspace(LOADS["heier"][0], LOADS["heier"][-1], 60).tolist():
            line += [(load, w * RADIUS / wind, plant.growth(wind, w, x)) for w, x in plant.equilibria(wind, load)]
        for word in ("stable", "unstable"):
            some = [x[:2] for x in line if (x[2] < 0.0) == (word == "stable")]
            drawn[f"{word}.{wind:g}"] = {f"closed form, {word}": tuple(zip(*some, strict=True)) or ((), ())}
        here = [(p.returned, p.load, p.speed * RADIUS / wind) for p in points if p.wind == wind]
        drawn[f"runs.{wind:g}"] = {
            word: tuple(zip(*[p[1:] for p in here if p[0] == returned], strict=True)) or ((), ())
            for word, returned in (("returns", True), ("leaves", False))
        }
    return drawn


def _worst(points: list[Point]) -> list[Point]:
    cells: dict[tuple[float, float], Point] = {}
    for p in points:
        key = (p.wind, p.load)
        if key not in cells or p.growth > cells[key].growth:
            cells[key] = p
    return list(cells.values())
