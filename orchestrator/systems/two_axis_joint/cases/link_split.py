"""Two links in two units with a compliant joint between them, against the chain in one unit and its small motion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from .....components.two_axis_joint.chain import TwoLinkChain
from ....harness.validation import Evidence, Runs
from ....scene.scene import Scene
from ... import load_scene

GRAVITY, STIFFNESS = 9.81, 1e5  # m/s2, N/m of the scene
SMALL = 1e-4  # rad
SAMPLED = 0.05  # s, between the samples of the small motion
SETTLED = 0.2  # s, after which the joint's own vibration is gone: exp(-70)
COMPLIANT = (1e4, 1e5, 1e6)  # N/m
SPAN = 0.5  # s, of the runs that are compared
STEPS = (2e-4, 5e-4, 1e-3, 2e-3, 5e-3)  # s, macro steps
PLAIN = ("jacobi, held", "jacobi, linear", "gauss-seidel, linear")
KINDS = (*PLAIN, "iterative, held", "iterative, linear")
ORDERS = ("jacobi, linear", "gauss-seidel, linear", "iterative, linear")
FOLLOWED = slice(0, 3)  # of the steps, for orders
LOST = 0.1  # rad, an error beyond which a run has not followed the motion
HALVINGS, TRIAL = 10, 1000  # macro steps of a trial


def measure(runs: Runs) -> Evidence:
    """Eigenvalues of the small motion, difference from the chain over the stiffness, error over the macro step, its limit."""
    measured: dict[str, float] = {
        f"{what}.{k}": v for what, values in small_motion(runs).items() for k, v in enumerate(values, 1)
    }
    differences = [_difference(runs, k) for k in COMPLIANT]
    measured["compliance.order"] = _slope(COMPLIANT, differences)
    exact = _angles(runs, _scene("jacobi, quadratic", 5e-5))
    errors = {kind: [_error(runs, kind, step, exact) for step in STEPS] for kind in KINDS}
    for kind in ORDERS:
        measured[f"order.{kind}"] = _slope(STEPS[FOLLOWED], errors[kind][FOLLOWED])
    measured["survivors"] = sum(errors[kind][-1] < LOST for kind in PLAIN)
    measured["order.iterative, held"] = _slope(STEPS, errors["iterative, held"])
    measured["limit"] = 1e3 * longest_step(runs)
    drawn = {
        "steps": [f"{1e3 * s:g} ms" for s in STEPS],
        "errors": {kind: [e if e < LOST else math.nan for e in by_step] for kind, by_step in errors.items()},
        "rows": [(kind, *(f"{e:.1e} rad" if e < LOST else "lost" for e in by_step)) for kind, by_step in errors.items()],
        "differences": differences,
        "tear": errors["gauss-seidel, linear"][1] / errors["jacobi, linear"][1],
    }
    return Evidence(measured, data=drawn)


def _scene(kind: str, step: float, stiffness: float = STIFFNESS, changes: Mapping[str, Any] | None = None) -> Scene:
    """The scene with another algorithm and macro step, sampled every 10 ms, for `SPAN`."""
    algorithm, _, degree = kind.partition(", ")
    given = {
        "stop_time": SPAN,
        "master.algorithm": algorithm,
        "master.extrapolation": ("held", "linear", "quadratic").index(degree),
        "master.step": step,
        "master.bonds": [],
        "units.joint.parameters": {"stiffness": stiffness, "damping": 100.0, "rotation": {"damping": 0.02}},
        "first.substep": 1e-4,
        "second.substep": 1e-4,
        "record": {"signals": ["first.angle", "second.angle"], "interval": 0.01},
    }
    return load_scene("link-split").with_changes(given | dict(changes or {}))


def _angles(runs: Runs, scene: Scene, *, at_its_steps: bool = False) -> np.ndarray:
    """Both angles at all samples, (2, n); NaN where the run failed."""
    result = runs.run(scene, may_fail=True, at_its_steps=at_its_steps)
    angles = np.array([result["first.angle"], result["second.angle"]])
    return angles if result.outcome == "done" else np.full_like(angles, math.nan)


def _error(runs: Runs, kind: str, step: float, exact: np.ndarray) -> float:
    """Largest difference of an angle, rad; NaN of a run that failed."""
    angles = _angles(runs, _scene(kind, step), at_its_steps=True)
    return float(np.abs(angles - exact).max()) if angles.shape == exact.shape else math.nan


def _slope(x: Any, y: Any) -> float:
    """Order of y in x."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def small_motion(runs: Runs) -> dict[str, list[float]]:
    """Frequencies, rad/s, and rates of decay, 1/s, of the two modes of the split chain, the slower one first.

    Samples of the motion follow one another by a matrix, z_k+1 = A z_k with z = (angles, rates): of a linear motion exactly.
    """
    stretch = GRAVITY / STIFFNESS
    scene = _scene("jacobi, linear", 2.5e-4, changes={
        "stop_time": 4.0,
        "units.joint.parameters": {"stiffness": STIFFNESS, "damping": 100.0, "rotation": {"damping": 0.05}},
        "first.start_angle": SMALL,
        "units.second.parameters": {"start_angle": -SMALL, "start_x": math.sin(SMALL), "start_y": -math.cos(SMALL) - stretch,
                                    "substep": 1e-4},
        "record": {"signals": ["first.angle", "second.angle", "first.rate", "second.rate"], "interval": SAMPLED},
    })  # fmt: skip
    result = runs.run(scene)
    z = np.array([result[n] for n in ("first.angle", "second.angle", "first.rate", "second.rate")])
    z = z[:, result.time > SETTLED]
    following = np.linalg.lstsq(z[:, :-1].T, z[:, 1:].T, rcond=None)[0]
    values = np.log(np.linalg.eigvals(following).astype(complex)) / SAMPLED
    values = sorted(values[values.imag > 0.0], key=lambda v: v.imag)
    return {"frequency": [float(v.imag) for v in values], "decay": [float(-v.real) for v in values]}


def _difference(runs: Runs, stiffness: float) -> float:
    """Largest difference of an angle between the split chain and the one in one unit, rad."""
    step = min(1e-3, 50.0 / stiffness)
    split = _angles(runs, _scene("jacobi, linear", step, stiffness))
    given = {"start_first_angle": 0.8, "start_second_angle": 1.2, "viscous.first": 0.0, "viscous.second": 0.02, "substep": 1e-4}
    chain = TwoLinkChain(["viscous"], given, preset="equal rods")
    chain.initialize(0.0)
    whole = [(chain["first_angle"], chain["second_angle"])]
    for k in range(split.shape[1] - 1):
        chain.step(0.01 * k, 0.01)
        whole.append((chain["first_angle"], chain["second_angle"]))
    return float(np.abs(split - np.array(whole).T).max())


def longest_step(runs: Runs) -> float:
    """Macro step above which the plain coupling with held forces grows, s; found by bisection of runs about the rest."""
    low, high = 1.5e-3, 2.5e-3
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _grows(runs, middle) else (middle, high)
    return 0.5 * (low + high)


def _grows(runs: Runs, step: float) -> bool:
    """Whether the joint's vibration grows: the part of its opening that changes sign from step to step."""
    scene = _scene("jacobi, held", step, changes={
        "stop_time": TRIAL * step,
        "first.start_angle": SMALL,
        "units.second.parameters": {"start_angle": -SMALL, "start_x": math.sin(SMALL), "start_y": -math.cos(SMALL),
                                    "substep": 1e-3},
        "record": {"signals": ["joint.first_force_x"]},
    })  # fmt: skip
    result = runs.run(scene, may_fail=True, at_its_steps=True)
    if result.outcome != "done":
        return True
    vibration = np.abs(np.diff(result["joint.first_force_x"], 4))
    return bool(vibration[-TRIAL // 4 :].max() > vibration[TRIAL // 4 : TRIAL // 2].max())
