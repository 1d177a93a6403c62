"""Stresses of both transmissions: torsion by a piston pump and by one-way clutches, its cycles, and the damage they add up to."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .....harness.analysis.fatigue import Endurance, rainflow
from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.build import unit
from .....scene.scene import Scene
from .... import build_scene, load_scene

TURN = 2.0 * math.pi
DIAMETERS = (20.0, 25.0, 30.0)  # mm, of the pump's shaft
SPEED, TURNS = 2.0, 10  # rad/s of the pump behind the fixed ratio; recorded turns
TURBINE, PUMP, GEAR, RECORDED = 2.5178906, 2.6416274, 6.0, 12  # rad/s, in 3 m/s; recorded turns of the crank
MEAN_TORQUE = 13.2435  # N.m, of the pump at 20 m
SEEN = 200  # instants a turn
ENDURANCE = Endurance(150e6, 2e6, 5.0)  # Pa in torsion; from memory for a shaft of plain steel
BENDING = 200e6  # Pa, amplitude that plain steel endures in bending; from memory
STRESS = "stresses.driven_shaft_stress"
THREE_YEARS = 3.0 * 365.25 * 86400.0  # s, of a run of three years


def scenes() -> dict[str, Scene]:
    """A piston pump behind a fixed ratio, a converter at held speeds, and one in gusts."""
    return {
        "piston behind a fixed ratio": piston(),
        "converter at held speeds": converter(),
        "gusts": load_scene("wind-pump-gusts"),
    }


def measure(runs: Runs) -> Evidence:
    """Torsion of the shaft behind a fixed ratio, of the shaft behind the clutches, and of the lever in gusts."""
    fixed, held, gusts = runs.values()
    measured = _fixed(fixed) | _clutches(held)
    bending = rainflow(gusts["converter.stresses.lever_stress"])
    measured["gust.lever"] = 0.5 * float(bending.ranges.max()) / BENDING
    measured["gust.cycles"] = float(bending.counts[bending.ranges > 0.5 * bending.ranges.max()].sum())
    pumped, passed = fixed["gear.driving_torque"], held["driving.driving_torque"]
    diameters, damages = np.linspace(8.0, 30.0, 45), {}
    for name, torque, seconds in (
        ("piston behind a fixed ratio", _last(pumped, TURNS), TURNS * TURN / SPEED),
        ("behind the clutches", _last(passed, RECORDED), RECORDED * TURN / (TURBINE * GEAR)),
    ):
        each = [ENDURANCE.damage(rainflow(1e6 * np.asarray(torsion(torque, d)))) for d in diameters.tolist()]
        damages[name] = np.array(each) * THREE_YEARS / seconds
    courses = {
        "piston behind a fixed ratio, over turns of the pump": torsion(_last(pumped, 2), 20.0),
        "behind the clutches, over turns of the crank": torsion(_last(passed, 2), 20.0),
    }
    drawn = {"turn": np.arange(2 * SEEN) / SEEN, "courses": courses, "diameters": diameters, "damages": damages}
    return Evidence(measured, data={**drawn, "amplitude": 0.5e-6 * bending.ranges.max()})


def piston() -> Scene:
    """A piston pump behind the shaft of a fixed ratio, the turbine's speed given; the inertia behind the shaft is small."""
    return build_scene(
        {
            "gear": unit("FixedTransmission", turbine_speed=SPEED, start_speed=SPEED, driven_inertia=0.05),
            "pump": unit("PistonPump", preset="60 x 150 mm"),
        },
        {"gear.speed": "pump.speed", "pump.torque": "gear.load_torque"},
        stop_time=(TURNS + 1) * TURN / SPEED,
        step=TURN / SPEED / 1000.0,
        name="paper-wind-pump",
        master={"extrapolation": 1},
        title="Piston pump behind a fixed ratio",
        record={"signals": ["gear.driving_torque", "pump.torque", "pump.angle"], "interval": TURN / SPEED / SEEN},
    )


def converter() -> Scene:
    """Converters whose flywheels hold the crank and the driven shaft: stalled, and at the speeds of the operating point."""
    period = TURN / (TURBINE * GEAR)
    held: dict[str, Any] = {"crank_inertia": 1e6, "driven_inertia": 1e6, "shaft_stiffness": 1e-3, "shaft_damping": 0.0,
                            "turbine_speed": TURBINE}  # fmt: skip
    units = {
        "stalled": unit("InertialConverter", effects=["stresses"], **held, load_torque=1e4),
        "driving": unit("InertialConverter", effects=["stresses"], **held, start_speed=PUMP),
    }
    return build_scene(
        units,
        stop_time=(RECORDED + 1) * period,
        step=period / SEEN,
        name="paper-wind-pump",
        title="Stresses of converters at held speeds",
        record={"signals": [f"{name}.{signal}" for name in units for signal in ("driving_torque", STRESS)]},
    )


def torsion(torque: np.ndarray | float, diameter: float) -> np.ndarray:
    """Shear stress, MPa, of a torque in N.m on a shaft of a diameter in mm."""
    return 16.0 * np.asarray(torque) / (math.pi * (1e-3 * diameter) ** 3) * 1e-6


def constant_damage(diameter: float) -> float:
    """Miner's sum of one stroke after Basquin's line, 1: amplitude 8 T / d³ of the pump's mean torque, diameter in mm."""
    return (8.0 * MEAN_TORQUE / (1e-3 * diameter) ** 3 / ENDURANCE.limit) ** ENDURANCE.exponent / ENDURANCE.cycles


def _fixed(result: Result) -> dict[str, float]:
    torque = _last(result["gear.driving_torque"], TURNS)
    measured: dict[str, float] = {}
    for d in DIAMETERS:
        stress = torsion(torque, d)
        cycles = rainflow(1e6 * np.asarray(stress))
        large = cycles.ranges > 0.5 * cycles.ranges.max()
        measured |= {
            f"mean.{d:g}": float(np.mean(stress)),
            f"peak.{d:g}": float(np.max(stress)),
            f"amplitude.{d:g}": 0.5e-6 * float(cycles.ranges.max()),
            f"damage.{d:g}": ENDURANCE.damage(cycles) / TURNS / constant_damage(d),
        }
        measured[f"cycles.{d:g}"] = float(cycles.counts[large].sum()) / TURNS
    return measured


def _clutches(result: Result) -> dict[str, float]:
    measured: dict[str, float] = {}
    for name in ("stalled", "driving"):
        torque, stress = (_last(result[f"{name}.{signal}"], RECORDED) for signal in ("driving_torque", STRESS))
        cycles = rainflow(stress)
        lines = np.abs(np.fft.rfft(torque - torque.mean()))
        measured |= {
            f"{name}.peak": float(torque.max() / torque.mean()),
            f"{name}.mean": float(torque.mean()),
            f"{name}.cycles": float(cycles.counts[cycles.ranges > 0.5 * cycles.ranges.max()].sum()) / RECORDED,
            f"{name}.order": float(np.argmax(lines)) / RECORDED,
            f"{name}.stress": float(stress.max() / (1e6 * torsion(torque.max(), 30.0))),
        }
    # what a stand would measure: the mean torque at stall, and at a known speed of both shafts
    crank = TURBINE * GEAR
    k1 = measured["stalled.mean"] / crank**2
    return measured | {"stand.k1": k1, "stand.k2": (k1 * crank**2 - measured["driving.mean"]) / (crank * PUMP)}


def _last(values: np.ndarray, turns: int) -> np.ndarray:
    """The last whole turns of a record with `SEEN` instants a turn."""
    return np.asarray(values)[-turns * SEEN :]
