"""How the steps of a scene or of a component are taken: in the compiled loop or by general code, and where Python is in them."""

from __future__ import annotations

from contextlib import ExitStack
from typing import NamedTuple

from ..engine.stepping.adaptive import AdaptiveStepping
from ..engine.stepping.batch import obstacles
from ..run import Run
from ..scene.scene import Scene

ADAPTIVE = {"control": "master.control", "events": "master.events"}


class SteppingPath(NamedTuple):
    """Of a scene in process."""

    obstacles: tuple[str, ...]  # settings that put it on the general path; without any, batches of steps are compiled code
    python: tuple[str, ...]  # units that are stepped through Python


def stepping_path(scene: Scene) -> SteppingPath:
    """Opens and initializes the scene's units, in process where they are components; raises what a run of it would."""
    with ExitStack() as stack:
        run = Run(scene, stack, in_process=True, native=False, progress=False)
        run.prepare()
        run.faults.before_start()
        (run.account or run.master).initialize(0.0)
        reasons = [words for key, words in ADAPTIVE.items() if getattr(scene.master, key)]
        if isinstance(run.stepping, AdaptiveStepping) and not reasons:
            reasons = ["units that may return early from a step"]
        return SteppingPath((*reasons, *dict.fromkeys(obstacles(run.master, run.account))), run.master.machine.in_python)
