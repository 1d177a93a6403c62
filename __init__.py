"""cosimo: physical components as FMI co-simulation FMUs, an orchestrator that couples them, and a harness that judges them.

What stands here is the public interface; whatever it needs is imported when it is asked for.

    import cosimo

    scene = cosimo.load_scene("en50318-2002").with_changes({"stop_time": 2.0})
    result = cosimo.run(scene, in_process=True)
    print(result["pantograph.contact_force"].max(), "N")

Scenes and runs: `load_scene`, `read_scene`, `build_scene`, `unit`, `write_scene`, `Scene`, `run`, `Result`, `read_result`,
`summary`, `write_report`, `delivered`.
A scene in the hand: `open`, to set, step, read, save and take back; `gym`, as an environment of Gymnasium.
Many runs: `function`, `gradient`, `run_many`, `sweep`, `sensitivity`, `uncertainty`, `fit`, `likelihood`, `estimate`, `design`.
Judging them: `validate`, `compare`, `accuracy`, `stability`, `effects`.
FMUs: `build`, `check`.
A component of one's own: `Component` in plain Python; of kernels `KernelComponent`, `Kernels`, `Refusal`, `OWN`, `DONE`, and
their kinds `OdeComponent`, `SmoothComponent`, `EventComponent`, `SampledComponent`, `StatelessComponent` with `ode_kernels`,
`smooth_kernels`, `event_kernels`, `sampled_kernels`, `stateless_kernels`; `Effect`, `Preset`; `parameter`, `integer`, `choice`,
`input_`, `output`, `count`, `flag`; `kernel`, `kernel_tuple`, `bind`, `hold_inputs`.
Errors: `BadInput` (what was given cannot be used), `StepFailed` (a simulation cannot go on).
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .components.catalogue import component_class
    from .components.core.component import Component, Effect, Preset
    from .components.core.contract import KernelComponent, Kernels, Refusal
    from .components.core.errors import BadInput, StepFailed
    from .components.core.events import EventComponent, event_kernels
    from .components.core.high_order import SmoothComponent, smooth_kernels
    from .components.core.integrators import OdeComponent, ode_kernels
    from .components.core.kernels import DONE, OWN, bind, hold_inputs, kernel, kernel_tuple
    from .components.core.sampled import SampledComponent, sampled_kernels
    from .components.core.stateless import StatelessComponent, stateless_kernels
    from .components.core.variables import choice, count, flag, input_, integer, output, parameter
    from .fmus.check import check
    from .orchestrator.delivery import delivered
    from .orchestrator.harness.studies.accuracy import accuracy
    from .orchestrator.harness.studies.effects import effects
    from .orchestrator.harness.studies.stability import stability
    from .orchestrator.run.results import Result
    from .orchestrator.scene.build import unit
    from .orchestrator.scene.scene import Scene, write_scene
    from .orchestrator.systems import (
        build_scene,
        compare,
        gym,
        load_scene,
        open,
        read_result,
        read_scene,
        run,
        summary,
        validate,
        write_report,
    )
    from .orchestrator.systems.building import build
    from .orchestrator.systems.many import (
        design,
        estimate,
        fit,
        function,
        gradient,
        likelihood,
        run_many,
        sensitivity,
        sweep,
        uncertainty,
    )

_PLACES = {
    "components.catalogue": ("component_class",),
    "fmus.check": ("check",),
    "orchestrator.delivery": ("delivered",),
    "orchestrator.harness.studies.accuracy": ("accuracy",),
    "orchestrator.harness.studies.effects": ("effects",),
    "orchestrator.harness.studies.stability": ("stability",),
    "orchestrator.systems.building": ("build",),
    "orchestrator.systems.many": (
        "design",
        "estimate",
        "fit",
        "function",
        "gradient",
        "likelihood",
        "run_many",
        "sensitivity",
        "sweep",
        "uncertainty",
    ),
    "orchestrator.run.results": ("Result",),
    "orchestrator.scene.build": ("unit",),
    "orchestrator.scene.scene": ("Scene", "write_scene"),
    "orchestrator.systems": (
        "build_scene",
        "compare",
        "gym",
        "load_scene",
        "open",
        "read_result",
        "read_scene",
        "run",
        "summary",
        "validate",
        "write_report",
    ),
}
_PLACE = {name: place for place, names in _PLACES.items() for name in names}

__all__ = [
    "DONE",
    "OWN",
    "BadInput",
    "Component",
    "Effect",
    "EventComponent",
    "KernelComponent",
    "Kernels",
    "OdeComponent",
    "Preset",
    "Refusal",
    "Result",
    "SampledComponent",
    "Scene",
    "SmoothComponent",
    "StatelessComponent",
    "StepFailed",
    "accuracy",
    "bind",
    "build",
    "build_scene",
    "check",
    "choice",
    "compare",
    "component_class",
    "count",
    "delivered",
    "design",
    "effects",
    "estimate",
    "event_kernels",
    "fit",
    "flag",
    "function",
    "gradient",
    "gym",
    "hold_inputs",
    "input_",
    "integer",
    "kernel",
    "kernel_tuple",
    "likelihood",
    "load_scene",
    "ode_kernels",
    "open",
    "output",
    "parameter",
    "read_result",
    "read_scene",
    "run",
    "run_many",
    "sampled_kernels",
    "sensitivity",
    "smooth_kernels",
    "stability",
    "stateless_kernels",
    "summary",
    "sweep",
    "uncertainty",
    "unit",
    "validate",
    "write_report",
    "write_scene",
]


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    place = _PLACE.get(name) or import_module(".components.public_names", __name__).PLACE[name]
    value = getattr(import_module("." + place, __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*globals(), *__all__]
