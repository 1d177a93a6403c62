"""How the steps of a scene or of a component are taken: in the compiled loop or by general code, and where Python is in them."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from typing import NamedTuple

from ...components.core.component import Component
from ..engine.stepping.adaptive import AdaptiveStepping
from ..engine.stepping.batch import inner, obstacles
from ..run import Run
from ..scene.scene import Scene
from ..units.component import ComponentUnit

ADAPTIVE = {"control": "master.control", "events": "master.events"}


class SteppingPath(NamedTuple):
    """Of a scene in process."""

    obstacles: tuple[str, ...]  # settings that put it on the general path; without any, batches of steps are compiled code
    python: Mapping[str, Mapping[str, str]]  # unit -> hook -> the statement that is Python, for components that have such


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
        units = [unit for node in run.master.nodes if isinstance(unit := inner(node), ComponentUnit)]
        python = {unit.name: unit.python_hooks(scene.master.step) for unit in units}
        return SteppingPath((*reasons, *dict.fromkeys(obstacles(run.master, run.account))),
                            {name: hooks for name, hooks in python.items() if hooks})


def python_of(component: Component) -> Mapping[str, str]:
    """Hook -> the statement that is Python, of a component with its inputs at their start values."""
    unit = ComponentUnit(component.name, component)
    unit.wire(component.inputs, component.outputs)
    unit.initialize(0.0, component.u[0].tolist())
    return unit.python_hooks(component.default_step)
