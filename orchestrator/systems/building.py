"""FMUs of components, scenes and units of scenes: what `cosimo build` writes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...components.catalogue import CATALOGUE, component_class, component_name
from ...components.core.component import Component
from ...components.core.errors import BadInput, nearest
from ..renamed import OUTPUT
from ..scene.scene import Scene
from . import load_scene

if TYPE_CHECKING:
    from ...fmus.evidence import Evidence

What = str | Path | type[Component] | Scene
Say = Callable[[str], AbstractContextManager[Any]]  # what is under way
OTHERS = "other FMUs are configured by their host"


@OUTPUT
def build(
    what: What,
    output: str | Path = ".",
    *,
    native: bool = False,
    target: str | Sequence[str] = (),
    fmi: int = 2,
    effects: Sequence[str] = (),
    parameters: Mapping[str, Any] | None = None,
    preset: str = "",
    unit: str = "",
    derivatives: bool = False,
    evidence: bool = False,
) -> Path:
    """Write an FMU into a directory and return its path: of a component, or with `native` of a scene or a unit of one.

    what: the name of a component, "module:Class", a class; a scene, its name or its file.  native: without Python; effects and
    parameters are constants then.  target: with native, platforms such as "linux64" or a list; default: this machine.  fmi: with
    native, 2 or 3.  effects, parameters, preset: with native, of a component.  unit: with native, one component of the scene `what`, as
    the scene configures and starts it.  derivatives: list der(v) and der(v,2) of each input, for masters that extrapolate.
    evidence: measure what steps cost in accuracy, and pack it with reference results. Raises `BadInput`.
    """
    options: dict[str, Any] = {"target": target, "effects": effects, "parameters": parameters, "preset": preset, "unit": unit}
    refused = [name for name, value in options.items() if value] + (["fmi"] if fmi != 2 else [])
    if not native and refused:
        raise BadInput(f"build: {refused[0]}", f"no effect without native: {OTHERS}", "", "Set native = True, or remove it.")
    if fmi not in (2, 3):
        raise BadInput("build: fmi", repr(fmi), "2 or 3")
    if not native:
        return pythonfmu(what, Path(output), derivatives, evidence)
    targets = [target] if isinstance(target, str) else list(target)
    return natives(what, Path(output), targets, [fmi], effects, parameters or {}, preset, unit, derivatives, evidence)[0]


def is_scene(what: What) -> bool:
    """Whether it is a scene, the name of one or a scene's file, and no component."""
    if isinstance(what, Scene):
        return True
    from ..scene.files import SCENES, scene_files

    text = str(what)
    return not isinstance(what, type) and (text.endswith(SCENES) or (text not in CATALOGUE and text in scene_files()))


def pythonfmu(what: What, output: Path, derivatives: bool, evidence: bool, say: Say = nullcontext) -> Path:
    """The FMU of a component that runs in Python."""
    from ...fmus.build import build as build_fmu

    if is_scene(what):
        raise BadInput("build", f"the scene {getattr(what, 'name', what)}", "a component", "A scene is an FMU with native alone.")
    assert not isinstance(what, Scene)
    name = component_name(what) if isinstance(what, type) else str(what)
    measured = _evidence(name, component_class(name, "build"), say) if evidence else None
    return build_fmu(name, output, derivatives=derivatives, evidence=measured)


def natives(
    what: What,
    output: Path,
    targets: Sequence[str],
    standards: Iterable[int],
    effects: Sequence[str],
    parameters: Mapping[str, Any],
    preset: str,
    unit: str,
    derivatives: bool,
    evidence: bool,
    say: Say = nullcontext,
) -> list[Path]:
    """FMUs without Python, of one compilation: one for each of the standards, versions of FMI. The others as of `build`."""
    from ...components.core.signals import Signals
    from ...fmus.build import file_stem
    from ...fmus.native.build import build_native, own_target
    from ...fmus.native.machine_code import TARGETS

    targets = [t for t in targets if t] or [own_target()]
    if not targets[0]:
        raise BadInput("build --native", "this machine", "one of " + ", ".join(TARGETS), "Give --target.")
    make: Callable[[], Component]
    if unit or is_scene(what):
        if effects or parameters or preset:
            raise BadInput(
                "build", "effects, parameters and preset have no effect with a scene, which sets its own", "", "Remove them."
            )
        scene = what if isinstance(what, Scene) else load_scene(str(what))
        if not unit:
            return _of_scene(scene, output, targets, standards, derivatives, evidence, say)
        from ..opened.native import makers

        if unit not in (known := scene.component_classes):
            raise BadInput("build --scene", f"unit {unit!r}", f"a component of the scene {scene.name}", nearest(unit, known))
        name, make = unit, makers(scene, [unit])[unit]
    else:
        assert not isinstance(what, Scene)
        whole = component_name(what) if isinstance(what, type) else str(what)
        name, cls = file_stem(whole), component_class(whole, "build")
        make = partial(cls.hosted() if issubclass(cls, Signals) else cls, list(effects), dict(parameters), preset=preset)
    measured = _evidence(name, make, say) if evidence else None
    return build_native(name, make, output, targets, standards, derivatives, measured)


def _of_scene(
    scene: Scene, output: Path, targets: Sequence[str], standards: Iterable[int], derivatives: bool, evidence: bool, say: Say
) -> list[Path]:
    from ..harness.evidence import scene_evidence
    from ..scene_fmu import build_scene_fmu, refuse_what_needs_python

    if derivatives:
        raise BadInput("build", "derivatives have no effect with a scene: its inputs are held over a step", "", "Remove them.")
    measured = None
    if evidence:
        refuse_what_needs_python(scene)
        with say(f"measuring what steps of {scene.name} cost in accuracy"):
            measured = scene_evidence(scene)
    return build_scene_fmu(scene, output, targets, standards, measured)


def _evidence(name: str, make: Callable[[], Component], say: Say) -> Evidence:
    from ..harness.evidence import component_evidence

    with say(f"measuring what steps of {name} cost in accuracy"):
        return component_evidence(make)
