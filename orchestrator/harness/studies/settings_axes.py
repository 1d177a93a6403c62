"""The settings that trade accuracy for time, as changes of a scene: how it is coupled, internal steps, meshes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from ...scene.scene import Scene
from ...scene.shorter_steps import meshes, refined, with_mesh
from ...settings.algorithms import ALGORITHMS
from .full_model import effect_changes, effects_on

DEGREES = ("held", "linear", "quadratic")
ADAPTIVE = (1e-2, 1e-3, 1e-4, 1e-5)  # tolerances of the step control
MACRO = (8, 4, 2, 1, 0.5)  # times the scene's macro step
SUBSTEPS = (4.0, 2.0, 0.5, 0.25)  # times the internal steps of the scene
MESHES = (2.0, 0.5)


@dataclass(frozen=True)
class Setting:
    """One way to run a scene.

    series: the points it belongs to, in words.  axis: "coupling", "adaptive", "substep", "mesh" or "effect".
    size: what differs along the series: a macro step, s, or a tolerance where the macro step follows it.
    changes: of the scene, with values as such, not as shares of the scene's own.
    """

    series: str
    axis: str
    size: float
    changes: dict[str, Any] = field(hash=False)


def coupling_changes(scene: Scene, algorithm: str, degree: int) -> dict[str, Any]:
    """The changes to another algorithm and degree of the inputs; what belongs to the scene's own algorithm goes."""
    own = algorithm == scene.master.algorithm
    changes: dict[str, Any] = {
        "master.algorithm": algorithm,
        "master.control": None,
        "master.iteration": scene.master.iteration.model_dump() if own and scene.master.iteration else None,
    }
    if scene.coupling.links:  # without any, a degree or an order would have no effect, which a scene refuses
        changes |= {"master.extrapolation": degree, "master.order": list(scene.master.order) if own else []}
    return changes


def pinned(scene: Scene) -> dict[str, Any]:
    """The scene's own setting as changes, so that a measured one means the same when the scene runs at another."""
    master = scene.master
    control = {"master.control": master.control.model_dump() if master.control else None}
    return {
        **coupling_changes(scene, master.algorithm, master.extrapolation),
        **control,
        "master.step": master.step,
        **refined(scene, 1.0),
        **meshes(scene),
    }


def macro_steps(scene: Scene) -> list[float]:
    """Macro steps to try, the longest first; each is a whole number of the next ones."""
    return [factor * scene.master.step for factor in MACRO if 4.0 * factor * scene.master.step <= scene.duration]


def couplings(scene: Scene) -> Iterator[tuple[str, dict[str, Any]]]:
    """(series, changes) of every algorithm and degree of the inputs that makes sense for the scene's connections.

    Without connections only the scene's own; without circles iterating has nothing to repeat.
    """
    coupling = scene.coupling
    own = scene.master.algorithm
    if not coupling.links:
        yield "macro step", {}
        return
    circles = any(len(group) > 1 for group in coupling.groups)
    algorithms = [
        name for name, of in ALGORITHMS.items() if (circles or not of.rollback) and (scene.contacts or not of.reduces_contacts)
    ]
    for algorithm in algorithms:
        for degree, name in enumerate(DEGREES):
            yield f"{algorithm}, {name}", coupling_changes(scene, algorithm, degree)
    if own not in algorithms:
        yield f"{own}, {DEGREES[scene.master.extrapolation]}", {}


def settings(scene: Scene) -> Iterator[Setting]:
    """Settings of the first round: meshes, whose error no coupling mends; then couplings over macro steps, the cheapest first."""
    for factor in MESHES if scene.study.mesh else ():
        yield Setting(f"elements x {factor:g}", "mesh", scene.master.step, with_mesh(scene, factor))
    every = list(couplings(scene))
    for step in macro_steps(scene):
        for series, changes in every:
            yield Setting(series, "coupling", step, {**changes, "master.step": step})
    if scene.coupling.links:
        for tolerance in ADAPTIVE:
            control = {"method": "milne", "relative": tolerance, "absolute": tolerance}
            yield Setting(
                "gauss-seidel, linear, step control",
                "adaptive",
                tolerance,
                {**coupling_changes(scene, "gauss-seidel", 1), "master.control": control},
            )


def finer_inside(scene: Scene, setting: Setting) -> Iterator[Setting]:
    """The same setting with other internal steps."""
    for factor in SUBSTEPS:
        if changes := refined(scene, factor):
            yield Setting(f"{setting.series}, substeps x {factor:g}", "substep", setting.size, {**setting.changes, **changes})


def without_effects(scene: Scene) -> Iterator[Setting]:
    """The scene's own settings without one of its effects, each in turn; what needs that effect refuses to start."""
    every = effects_on(scene)
    for name, on in every.items():
        for effect in on:
            changes = effect_changes(scene, every | {name: tuple(e for e in on if e != effect)})
            yield Setting(f"without {name}.{effect}", "effect", scene.master.step, changes)
