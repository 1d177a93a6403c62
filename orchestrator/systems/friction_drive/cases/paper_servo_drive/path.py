"""A path there and back in both degrees of freedom, within the limits of rate and voltage; hunting with an integral."""

from __future__ import annotations

import numpy as np

from .....harness.validation import Evidence, Runs
from .....run.results import Result
from .....scene.scene import Scene
from .... import load_scene
from .drive import FULL, ROLLERS, controlled

TIMES = [0.1, 0.6, 0.8, 1.3, 1.5, 2.0, 2.0, 2.0]  # s
FEED = [0.0, 0.03, 0.03, -0.01, -0.01, 0.0, 0.0, 0.0]  # m
ROTATION = [0.0, 1.0, 1.0, -1.5, -1.5, 0.0, 0.0, 0.0]  # rad
REFERENCE = {"reference": {"time": TIMES, "feed": FEED, "rotation": ROTATION}}
RATE = 20.0  # rad/s, asked of a wheel at most
STEP = {
    "reference": {
        "time": [0.1, 0.1, 1.0, 1.0, *[1.0] * 4],
        "feed": [0.0, 0.1, 0.1, *[0.0] * 5],
        "rotation": [0.0, 6.0, 6.0, *[0.0] * 5],
    }
}
END, QUIET = 3.2, 1.0  # s: end of the slow feed's way, and what it has to come to rest


def scenes() -> dict[str, Scene]:
    """A path, a step that is far too large, and the slow feed of two drives."""
    return {
        "path": controlled(2.5, ROLLERS, FULL, {}, REFERENCE, ("reference",)),
        "large": controlled(2.0, ROLLERS, FULL, {}, STEP, ("reference",)),
        "slow": load_scene("friction-drive-slow-feed"),
    }


def measure(runs: Runs) -> Evidence:
    """Errors along the path, what is asked of motors and wheels, hunting at rest."""
    path, large, slow = runs.values()
    measured = {
        "path.feed": 1e3 * _error(path, "feed"),
        "path.rotation": float(np.degrees(_error(path, "rotation"))),
        "path.end": 1e6 * abs(float(path["drive.feed"][-1])),
        "path.voltage": max(_most(r, "controller.{}_voltage") for r in (path, large)),
        "path.rate": max(_most(r, "drive.{}_rate") for r in (path, large)),
        "large.voltage": _most(large, "controller.{}_voltage"),
    }
    late = slow.time > END + QUIET
    for name in ("seeking", "plain"):
        measured[f"hunting.{name}"] = 1e6 * float(np.ptp(slow[f"{name}.feed"][late]))
    kept = slow.time > END - 0.2
    kinds = (("seeking", "with an integral of the way"), ("plain", "without"))
    rest = {text: 1e6 * (slow[f"{name}.feed"][kept] - 1.5e-3) for name, text in kinds}
    return Evidence(measured, data={"t": slow.time[kept], "rest": rest})


def _error(result: Result, way: str) -> float:
    return float(np.sqrt(np.mean((result[f"controller.wanted_{way}"] - result[f"drive.{way}"]) ** 2)))


def _most(result: Result, name: str) -> float:
    return max(float(np.abs(result[name.format(k)]).max()) for k in ("first", "second"))
