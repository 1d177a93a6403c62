"""The modules of a page: the scene with each set of the offered effects, and with each offered master algorithm."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from ....components.core.errors import BadInput, nearest
from ....fmus.native.build import Library
from ...derivatives.tangent_module import tangent_module
from ...run.run import run
from ...scene.scene import Scene
from ...scene_fmu import scene_block, scene_library

MOST_EFFECTS = 3  # switches: a module for each set of them
MOST_MODULES = 8
FEW_MODULES = 4  # up to which the other algorithm is offered unasked
LOOPS = ("gauss-seidel", "jacobi")  # algorithms that are kernels alone
DEGREES = (0, 1, 2)  # of extrapolation
NO_SLIDERS = b"", (), "a page without sliders"  # of the derivatives of a variant


@dataclass(frozen=True)
class Variant:
    """The scene with some of the offered effects on, and one of the offered algorithms.

    extrapolations: by degree, what it changes in the block: (cell, lower and upper 32 bits).
    tangents: the module of its derivatives, empty where it has none, and `known`, what they can be taken by; refused: why there are none.
    """

    effects: Mapping[str, bool]
    algorithm: str
    library: Library
    extrapolations: Mapping[int, Sequence[tuple[int, int, int]]]
    tangents: bytes
    known: Collection[str]
    refused: str


def switches(scene: Scene, wanted: Sequence[str] | None, say: Callable[[str], None]) -> list[str]:
    """The effects that a page offers: those asked for, else the first ones in the scene's order without which it runs."""
    known = [f"{unit}.{effect}" for unit, settings in scene.units.items() for effect in settings.effects]
    if wanted is None:
        offered: list[str] = []
        for name in known:
            if len(offered) < MOST_EFFECTS and _runs_without(scene, name, say):
                offered.append(name)
        return offered
    if unknown := [e for e in wanted if e not in known]:
        raise BadInput("explore", f"effect {unknown[0]!r}", "an effect that is on in the scene", nearest(unknown[0], known))
    if len(wanted) > MOST_EFFECTS:
        raise BadInput("explore", f"{len(wanted)} effects", f"at most {MOST_EFFECTS}: each set of them is a module of the page")
    return list(wanted)


def without(scene: Scene, effects: Sequence[str]) -> dict[str, Any]:
    """The changes that switch off effects, each "unit.effect"."""
    return {"{}.effects.{}".format(*scene.split(name)): False for name in effects}


def _runs_without(scene: Scene, name: str, say: Callable[[str], None]) -> bool:
    say(f"running the scene without {name}")
    try:
        return run(scene.with_changes(without(scene, [name])), in_process=True).unless_stopped().outcome == "done"
    except BadInput:
        return False


def algorithms(scene: Scene, wanted: Sequence[str] | None, modules: int) -> list[str]:
    """Those that a page offers, the scene's first. modules: for one of them."""
    own = scene.master.algorithm
    if wanted is not None:
        if unable := [name for name in wanted if name not in LOOPS]:
            raise BadInput("explore.algorithms", repr(unable[0]), "one of " + ", ".join(LOOPS), "A page has no iterations.")
        return list(dict.fromkeys((own, *wanted)))
    both = scene.coupling.links and 2 * modules <= FEW_MODULES and not scene.master.order
    return list(dict.fromkeys((own, *(LOOPS if both else ()))))


def variants(
    scene: Scene, effects: Sequence[str], wanted: Sequence[str] | None, say: Callable[[str], None], slopes: bool = True
) -> Iterator[Variant]:
    """The scene itself first, then all other sets of effects and algorithms; wanted: algorithms, None for the usual ones.

    slopes: with modules of derivatives.
    """
    sets = list(product((True, False), repeat=len(effects)))
    offered = algorithms(scene, wanted, len(sets))
    count = len(sets) * len(offered)
    if count > MOST_MODULES:
        raise BadInput(
            "explore", f"{count} modules", f"at most {MOST_MODULES}", "Offer fewer effects, or the algorithm of the scene alone."
        )
    for k, (algorithm, states) in enumerate(product(offered, sets), 1):
        say(f"compiling module {k} of {count}")
        off = [name for name, on in zip(effects, states, strict=True) if not on]
        changes = without(scene, off)
        if algorithm != scene.master.algorithm:
            changes["master.algorithm"] = algorithm
        changed = scene.with_changes(changes) if changes else scene
        library = scene_library(changed, ["wasm32"], ("live.c",))
        states_of = dict(zip(effects, states, strict=True))
        yield Variant(states_of, algorithm, library, _extrapolations(changed), *(_tangents(changed) if slopes else NO_SLIDERS))


def _tangents(scene: Scene) -> tuple[bytes, Collection[str], str]:
    """The module of a scene's derivatives, what they can be taken by, and why there are none."""
    try:
        return (*tangent_module(scene, "wasm32"), "")
    except BadInput as error:
        return b"", (), str(error)


def _extrapolations(scene: Scene) -> dict[int, list[tuple[int, int, int]]]:
    """The degrees that the code of a scene can do, as it only reads them from its block."""
    base = scene_block(scene)
    known: dict[int, list[tuple[int, int, int]]] = {scene.master.extrapolation: []}
    if not scene.coupling.links:
        return known
    for degree in set(DEGREES) - known.keys():
        try:
            other = scene_block(scene.with_changes({"master.extrapolation": degree}))
        except BadInput:
            continue  # a setting of the master that goes with the scene's own alone
        if other.code == base.code and other.image.size == base.image.size:
            cells = np.flatnonzero(other.image != base.image)
            known[degree] = [(int(c), int(v) & 0xFFFFFFFF, int(v) >> 32) for c, v in zip(cells, other.image[cells], strict=True)]
    return dict(sorted(known.items()))
