"""Added mass between two units: exchanged once a step it diverges, iterated it converges, inside the hull it is exact."""

from __future__ import annotations

import numpy as np

from .....components.rov.added_mass import AddedMassForce
from .....components.rov.hull import RovHull
from ....harness.charts.chart import Chart, Panel, Series
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
    lost = runs["exchanged once per step"]
    notes = (
        f"Exchanged once per step the run ends after {lost.time[-1]:.3g} s with: {lost.message}.",
        "The factor per exchange is the ratio of added mass to mass. A shorter step makes it fail earlier, not later.",
    )
    return Evidence(measured, (_runs_chart(runs), _exchange_chart(plain, relaxed)), {"loop solved": solved}, notes)


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


def _runs_chart(runs: Runs) -> Chart:
    series = [Series(name, r.time, np.abs(r[SPLIT])) for name, r in runs.items()]
    shown = max(r.time[-1] for name, r in runs.items() if name != "loop solved")
    series.append(Series("inside the hull", runs["loop solved"].time, np.abs(runs["loop solved"][WHOLE])))
    panel = Panel("size of the acceleration, m/s²", tuple(series), logarithmic=True, x_range=(0.0, 1.2 * shown))
    return Chart("Added mass as a force", "time, s", (panel,), "Heave under 10 N; where a line ends, the run has failed.")


def _exchange_chart(plain: np.ndarray, relaxed: np.ndarray) -> Chart:
    k = np.arange(EXCHANGES + 1)
    series = tuple(
        Series(n, k, np.maximum(np.abs(a - TRUE), 1e-16))
        for n, a in (("as exchanged", plain), (f"relaxed by {RELAXATION:g}", relaxed))
    )
    panel = Panel("distance from the true one, m/s²", series, logarithmic=True)
    return Chart("One instant, exchange by exchange", "exchanges", (panel,))
