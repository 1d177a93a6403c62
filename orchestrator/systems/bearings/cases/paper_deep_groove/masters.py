"""The bearing as an element of other codes: one package of two FMUs, run by three masters, and the same system in one piece."""

from __future__ import annotations

import math
import shutil
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import Parameter, ParameterSet

from ......components.bearings.ball_bearing import BallBearing
from .....harness.other_masters import as_other_masters
from .....harness.validation import Evidence, Runs, done
from .....run.run import run
from .....scene.scene import Scene
from .....scene.shorter_steps import runs_with
from .....scene.ssp.write import write
from .shaft import BEARING, DAMPING, MASS, MOTION, STIFFNESS, WEIGHT, scene

TURNS, END = 30.0, 0.03  # per second; s: the shaft falls into the bearing, and three balls pass
STEPS = (5e-6, 2.5e-6)  # s; a force held and handed over once a step is 1.5 steps late, which takes 1.5 h k of the damping
HEAVY = 3.0 * DAMPING  # N.s/m; of this, 1.5 h k is 9 and 4 %
OURS, PLAIN, FMPY = "cosimo", "FMI functions called in turn", "FMPy, simulate_ssp"
OPTIONAL = {"libcosim": "libcosimpy", "Ecos": "ecospy", "OMSimulator": "OMSimulator"}
MICRO = 1e6


def scenes() -> dict[str, Scene]:
    """The scene as this program's own master runs it best: sequential, extrapolated."""
    return {"own": scene(END, STEPS[0], TURNS, damping=HEAVY)}


def measure(runs: Runs) -> Evidence:
    """Motion along the load by each master at two steps; as FMUs in all of them."""
    exact = in_one_piece(STEPS[0])
    packed = {h: as_other_masters(scene(END, h, TURNS, damping=HEAVY)) for h in STEPS}
    histories = {(name, h): x for h in STEPS for name, x in by_all(packed[h], h).items()}
    swing = float(np.ptp(exact))
    errors = {key: float(np.abs(x - exact).max() / swing) for key, x in histories.items()}
    coarse, fine = STEPS
    measured = {
        "error": max(100.0 * errors[n, fine] for n in (OURS, PLAIN, FMPY)),
        "same": float(np.abs(histories[OURS, fine] - histories[PLAIN, fine]).max() / swing),
        "package": float(100.0 * np.abs(histories[OURS, fine] - histories[FMPY, fine]).max() / swing),
    }
    ratios = [errors[n, coarse] / errors[n, fine] for n in (OURS, PLAIN, FMPY)]
    measured |= {"order.least": min(ratios), "order.greatest": max(ratios)}
    away = runs["own"]["rotor.displacement_y"][np.rint(_times() / coarse).astype(int)] - exact
    measured["own"] = float(100.0 * np.abs(away).max() / swing)
    rows: tuple[tuple[str | float, ...], ...] = tuple((n, 1e6 * h, 100.0 * e) for (n, h), e in errors.items())
    rows += ((f"{OURS}, sequential, extrapolated", 1e6 * coarse, measured["own"]),)
    rows += tuple((n, "", "not run here" if find_spec(module) else "not installed") for n, module in OPTIONAL.items())
    fine_ones = {n: histories[n, fine] for n in (OURS, PLAIN, FMPY)}
    drawn = {
        "t": 1e3 * _times(),
        "exact": MICRO * exact,
        "heights": {n: MICRO * x for n, x in fine_ones.items()},
        "differences": {n: 1e9 * (x - exact) for n, x in fine_ones.items()},
    }
    return Evidence(measured, data={**drawn, "rows": rows})


def _times() -> np.ndarray:
    """Instants at which all are compared, s: the ends of steps of every master."""
    return STEPS[0] * np.arange(1, round(END / STEPS[0]) + 1, 4)


def in_one_piece(step: float) -> np.ndarray:
    """Motion upwards of the same shaft in the component that has bearing and mass in one, (n,) m; its load acts along x."""
    model = BallBearing(["given_start"], {
        **BEARING, "contact_stiffness": STIFFNESS, "mass": MASS, "damping": HEAVY, "substep": 0.25 * step,
        "start_cage_angle": 0.5 * math.pi})  # fmt: skip
    model.set("speed", 2.0 * math.pi * TURNS)
    model.set("load", WEIGHT)
    model.initialize(0.0)
    at, last = [], 0.0
    for t in _times():
        model.step(last, t - last)
        at.append(-model["displacement_x"])
        last = t
    return np.array(at)


def by_all(packed: Scene, step: float) -> dict[str, np.ndarray]:
    """Motion upwards at `_times()` by each master, (n,) m, of a scene with held inputs.

    A repetition leaves the steps and meshes of ours, as the others cannot follow: masters are compared at the same ones.
    """
    with runs_with(parts=1, coarser=1):
        result = done(run(packed, in_process=False))
    rows = np.rint(_times() / step).astype(int)
    with TemporaryDirectory() as folder:
        package = write(packed, Path(folder) / "shaft.ssp")
        foreign = simulate_ssp(str(package), stop_time=END - 0.5 * step, step_size=step, parameter_set=_parameters(packed))
        plain = in_turn(packed, package, step)
    # FMPy's rows bear the time at which a step starts, ours that at which it ends
    return {OURS: result["rotor.displacement_y"][rows], PLAIN: plain[rows - 1],
            FMPY: foreign["rotor.displacement_y"][rows - 1]}  # fmt: skip


def _parameters(packed: Scene) -> ParameterSet:
    """The values of the scene's units, those of the effects among them, as FMPy's master takes them."""
    return ParameterSet(
        parameters=[Parameter(name=f"{unit}.{n}", value=v) for unit in packed.units for n, v in _values(packed, unit).items()]
    )


def _values(packed: Scene, unit: str) -> dict[str, Any]:
    given = packed.units[unit]
    return {**{f"effects.{e}": True for e in given.effects}, **given.parameters}


def in_turn(packed: Scene, package: Path, step: float) -> np.ndarray:
    """Motion upwards at the end of each step, (n,) m, by the functions of FMI 2.0 alone: all outputs, all inputs, all steps."""
    folder = Path(extract(str(package)))
    units: dict[str, FMU2Slave] = {}
    places: dict[str, dict[str, int]] = {}
    unpacked = []
    try:
        for name, kind in packed.kinds.items():
            packed_fmu = str(folder / "resources" / f"{kind.label}.fmu")
            description = read_model_description(packed_fmu)
            unpacked.append(extract(packed_fmu))
            unit = FMU2Slave(
                guid=description.guid,
                unzipDirectory=unpacked[-1],
                modelIdentifier=description.coSimulation.modelIdentifier,
                instanceName=name,
            )
            places[name] = {v.name: v.valueReference for v in description.modelVariables}
            types = {v.name: v.type for v in description.modelVariables}
            unit.instantiate()
            unit.setupExperiment(startTime=0.0)
            for variable, value in _values(packed, name).items():
                setter = {"Real": unit.setReal, "Integer": unit.setInteger, "Boolean": unit.setBoolean}[types[variable]]
                setter([places[name][variable]], [value])
            unit.enterInitializationMode()
            units[name] = unit
        rotor, bearing = units["rotor"], units["bearing"]
        moving = [[places[u][n] for n in (*MOTION, "speed")] for u in ("rotor", "bearing")]
        loaded = [[places[u][f"force_{a}"] for a in "xy"] for u in ("bearing", "rotor")]

        def exchange() -> list[float]:
            away = rotor.getReal(moving[0])
            force = bearing.getReal(loaded[0])
            bearing.setReal(moving[1], away)
            rotor.setReal(loaded[1], force)
            return away

        exchange()
        for unit in units.values():
            unit.exitInitializationMode()
        heights = []
        for k in range(round(END / step)):
            for unit in units.values():
                unit.doStep(currentCommunicationPoint=k * step, communicationStepSize=step)
            heights.append(exchange()[1])
        return np.array(heights)
    finally:
        for unit in units.values():
            unit.terminate()
            unit.freeInstance()
        for place in (folder, *unpacked):
            shutil.rmtree(place, ignore_errors=True)
