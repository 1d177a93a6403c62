"""Added mass between two units: exchanged once a step it diverges, iterated it converges, inside the hull it is exact."""

from __future__ import annotations

import numpy as np

from .....components.rov.added_mass import AddedMassForce
from .....components.rov.hull import RovHull
from ....harness.validation import Evidence, Runs
from ....run.results import Result
from ....scene.scene import Scene
from ... import load_scene

FORCE, MASS, ADDED = 10.0, 11.5, 14.57  # N, kg, kg: heave of Wu's vehicle
TRUE = FORCE / (MASS + ADDED)
EXCHANGES, RELAXATION = 30, 0.3
SPLIT, WHOLE = "hull.external.acceleration_z", "whole.external.acceleration_z"
LAGGED = {
    "master.algorithm": "gauss-seidel",
    "master.feedthrough": "delayed",
    "master.extrapolation": 0,
    "master.iteration": None,
}
KINDS = {
    "exchanged once per step": LAGGED,
    "loop solved": {},
    "exchanged once per step, half the step": {**LAGGED, "master.step": 0.0025},
}
FAILING = [name for name, changes in KINDS.items() if changes]


def scenes() -> dict[str, Scene]:
    """The scene as shipped and with the force exchanged once per step, at two lengths of the step."""
    return {name: load_scene("rov-added-mass").with_changes(changes) for name, changes in KINDS.items()}


def measure(runs: Runs) -> Evidence:
    """Both units exchange by hand; growth of the acceleration in the runs that fail, the solved loop beside the hull."""
    plain, relaxed = exchanged(1.0), exchanged(RELAXATION)
    measured = {"exchanged": plain[-1], "relaxed": relaxed[-1]}
    for key, result in zip(("lagged", "half"), (runs[name] for name in FAILING), strict=True):
        measured |= {f"{key}.growth": growth(result), f"{key}.failed": result.outcome != "done", f"{key}.kept": result.time.size}
    solved = runs["loop solved"]
    measured |= {
        "start.split": solved[SPLIT][0],
        "start.whole": solved[WHOLE][0],
        "heave": float(np.abs(solved["hull.heave"] - solved["whole.heave"]).max()),
        "depth": float(np.abs(solved["hull.depth"] - solved["whole.depth"]).max()),
    }
    sizes = {name: (r.time, np.abs(r[SPLIT])) for name, r in runs.items()}
    sizes["inside the hull"] = solved.time, np.abs(solved[WHOLE])
    exchanges = {"as exchanged": plain, f"relaxed by {RELAXATION:g}": relaxed}
    distances = {name: np.maximum(np.abs(a - TRUE), 1e-16) for name, a in exchanges.items()}
    lost = runs["exchanged once per step"]
    drawn = {"sizes": sizes, "exchange": np.arange(EXCHANGES + 1), "distances": distances}
    return Evidence(measured, data={**drawn, "end": lost.time[-1], "message": lost.message})


def exchanged(relaxation: float) -> np.ndarray:
    """Accelerations in heave, (31,), m/s²: hull and added mass exchange values at one instant, from no acceleration on."""
    hull, water = RovHull(["external"]), AddedMassForce()
    for k in (4, 5, 6):
        hull[f"thrust[{k}]"] = FORCE / 3.0
    for unit in (hull, water):
        unit.initialize(0.0)
    accelerations = [0.0]
    for _ in range(EXCHANGES):
        water["acceleration_z"] = accelerations[-1]
        water.refresh()
        hull["external.force_z"] = water["force_z"]
        hull.refresh()
        accelerations.append(accelerations[-1] + relaxation * (hull["external.acceleration_z"] - accelerations[-1]))
    return np.array(accelerations)


def growth(result: Result) -> float:
    """Size of the acceleration's change over that a step before, once it has grown; mean of the last half of the run."""
    size = np.abs(np.diff(result[SPLIT]))
    half = size[size.size // 2 :]
    return float((half[-1] / half[0]) ** (1.0 / (half.size - 1)))
