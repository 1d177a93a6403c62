"""The same runs finer: shorter macro and internal steps, shorter elements, as changes to a scene; and all runs that a function makes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from typing import Any, NamedTuple, ParamSpec, TypeVar

from ...components.core.errors import BadInput
from ...components.core.variables import Causality
from ..units.component import make
from .meshes import coarser
from .scene import Scene
from .tolerances import tolerances_of

P = ParamSpec("P")
R = TypeVar("R")


class Alterations(NamedTuple):
    """How runs differ from their scenes, so that their numerical errors, and those of parameters, are seen.

    parts: of each macro step and each internal step, with rows at the same times.  coarser: times the length of elements.  moves:
    standard deviations of their tolerances that parameters, "unit.parameter", are moved by, where a scene has these.
    """

    parts: int = 1
    coarser: int = 1
    moves: tuple[tuple[str, float], ...] = ()

    def changes(self, scene: Scene) -> dict[str, Any]:
        """To a scene, by name. Raises `BadInput` for a mesh that is too coarse."""
        changes = shorter(scene, self.parts, denser=False) if self.parts > 1 else {}
        changes |= coarser(scene, self.coarser) if self.coarser > 1 else {}
        if self.moves and (tolerances := tolerances_of(scene)) is not None:
            by_name = zip(tolerances.names, tolerances.values.tolist(), tolerances.deviations.tolist(), strict=True)
            changes |= {name: value + dict(self.moves)[name] * d for name, value, d in by_name if name in dict(self.moves)}
        return changes

    def altered(self, scene: Scene) -> Scene:
        """The scene as it is to be run."""
        return scene.with_changes(changes) if (changes := self.changes(scene)) else scene


class MadeRun(NamedTuple):
    """scene: as it was run.  work: counted, see `run.work`; None where its components were FMUs, which do not count."""

    scene: Scene
    work: float | None


# of the runs that a function of a validation case makes, whoever wrote it and however it makes them; and where they are noted
_inside: ContextVar[tuple[Alterations, list[MadeRun] | None]] = ContextVar("runs inside", default=(Alterations(), None))


def numbers_in_use(scene: Scene, parameter: str, *, of_effects: bool = False) -> dict[str, float]:
    """Place in the scene -> value, of a parameter of this name in every component that uses it; `of_effects`: in an effect, too."""
    numbers: dict[str, float] = {}
    for unit, cls in scene.component_classes.items():
        names = [n for n in cls.variables if n == parameter or (of_effects and n.partition(".")[2] == parameter)]
        if names:
            component = make(unit, scene.units[unit])
            present = [n for n in names if n == parameter or n.partition(".")[0] in component.on]
            numbers |= {f"{unit}.{n}": float(component.get(n)) for n in present if not component.unused([n])}
    return numbers


def substeps(scene: Scene) -> dict[str, float]:
    """Place in the scene -> internal step, s, of every component, or effect, that integrates with a parameter `substep`."""
    return numbers_in_use(scene, "substep", of_effects=True)


def late_samples(scene: Scene) -> list[str]:
    """Warnings of units that sample inside their steps, where what they decide waits for the step's end."""
    texts = []
    for place, period in numbers_in_use(scene, "period").items():
        unit = place.removesuffix(".period")
        if not scene.component_classes[unit].holds_outputs:
            continue
        step = scene.units[unit].every * scene.master.step
        parts = (period / step, scene.start_time / step)
        within = parts[0] < 0.5 or any(abs(n - round(n)) > 1e-9 * max(abs(n), 1.0) for n in parts)
        if scene.master.control or within:
            steps = "steps of varying length" if scene.master.control else f"steps of {step:g} s from {scene.start_time:g} s on"
            texts.append(
                f"{unit} samples every {period:g} s, in {steps}: a sample inside a step acts only from the end of the step on. "
                f"Let steps of one length end at all samples: master.step = {period:g} s, or a whole part of it"
            )
    return texts


def refined(scene: Scene, factor: float) -> dict[str, Any]:
    """The changes to `factor` times the internal steps of all units, and the motion at which parts at rest begin to move."""
    return {place: value * factor for place, value in (substeps(scene) | numbers_in_use(scene, "front_threshold")).items()}


def meshes(scene: Scene) -> dict[str, float]:
    """Place -> length of the elements, of what the scene's [study] names as mesh; raises `BadInput` for what is none."""
    lengths = {}
    for name in scene.study.mesh:
        unit, parameter = scene.split(name)
        if (cls := scene.component_classes.get(unit)) is None or not parameter:
            raise BadInput(f"{scene.name}: study.mesh", repr(name), '"unit.parameter" of a component')
        variable = cls.variables.get(parameter)
        known = variable is not None and variable.causality is Causality.PARAMETER
        value = make(unit, scene.units[unit]).get(parameter) if known else None
        if not isinstance(value, float):
            raise BadInput(f"{scene.name}: study.mesh", repr(name), "a parameter that is a length")
        lengths[f"{unit}.{parameter}"] = value
    return lengths


def with_mesh(scene: Scene, factor: float) -> dict[str, Any]:
    """The change to `factor` times the elements; internal steps with the square of it where they get shorter, as beams need."""
    lengths = {place: factor * length for place, length in meshes(scene).items()}
    return {**lengths, **(refined(scene, factor**2) if factor < 1.0 else {})}


def shorter(scene: Scene, parts: int, *, denser: bool = True, inside: bool = True) -> dict[str, Any]:
    """Changes to a macro step and internal steps of one part in so many; with step control, to a tighter tolerance.

    inside: whether the internal steps are shorter, too.  denser: whether rows are as many times denser, as the largest value of a
    run is that of a sample and misses what is between two; or at the same times.
    """
    step, control, record = scene.master.step, scene.master.control, scene.record
    changes: dict[str, Any] = {"master.step": step / parts, **(refined(scene, 1.0 / parts) if inside else {})}
    if control is not None:  # steps follow the root of the tolerance
        changes |= {f"master.control.{key}": getattr(control, key) / parts**2 for key in ("relative", "absolute")}
        changes |= {"master.control.min_step": control.min_step / parts} if control.min_step else {}
        changes |= {"master.control.max_step": control.max_step / parts} if control.max_step else {}
        return changes
    if not denser and record.interval is None:
        changes["record.interval"] = step
    elif denser and record.interval is not None:
        changes["record.interval"] = record.interval / parts
    return changes | ({"record.snapshot_interval": step} if record.snapshots and record.snapshot_interval is None else {})


@contextmanager
def runs_with(**changes: Any) -> Iterator[None]:
    """Every run inside is made so, by the fields of `Alterations`; others stay."""
    alterations, noted = _inside.get()
    token = _inside.set((alterations._replace(**changes), noted))
    try:
        yield
    finally:
        _inside.reset(token)


def alterations_inside() -> Alterations:
    """Those that `runs_with` asks for: who makes runs elsewhere, in threads and processes, takes them along."""
    return _inside.get()[0]


@contextmanager
def made_runs() -> Iterator[list[MadeRun]]:
    """The runs that are made inside, those that `kept_runs` need not make again among them."""
    runs: list[MadeRun] = []
    token = _inside.set((alterations_inside(), runs))
    try:
        yield runs
    finally:
        _inside.reset(token)
        note_runs(runs)


def note_runs(runs: Iterable[MadeRun]) -> None:
    """Runs that have ended, for `made_runs`."""
    if (noted := _inside.get()[1]) is not None:
        noted += runs


def kept_runs(function: Callable[P, R]) -> Callable[P, R]:
    """As `functools.cache`, of a function that runs scenes: what it gives depends on what `runs_with` asks for, too."""
    known: dict[Any, tuple[R, list[MadeRun]]] = {}

    @wraps(function)
    def kept(*args: P.args, **kwargs: P.kwargs) -> R:
        key = (alterations_inside(), args, tuple(kwargs.items()))
        if key not in known:
            with made_runs() as runs:
                known[key] = function(*args, **kwargs), runs
        else:
            note_runs(known[key][1])
        return known[key][0]

    return kept
