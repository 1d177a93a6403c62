"""What the meshes of a scene's components make of the error of each number, from a run whose meshes are coarser.

Half as many elements cost half a run or less. With x, x2, x4 of a number with elements of the lengths 1, 2 and 4 and the difference
d = |x - x2|, the error of x is

    signals   d / (2^p - 1), p the order that |x2 - x4| shows, within 1/2 to 1
    figures   d + |x2 - x4| / 56, as the difference of two figures may vanish by chance; the second is what order 3 leaves of x

Higher orders are not believed: a wave that elements of four times the length do not resolve shows one that finer ones do not have.
What is measured of a scene is kept in the cache, so that a second run of it pays nothing. Another number of random parts, such as
the waves of a sea, is another history: it has no error of this kind, and is named with the seeds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from ...components.core.errors import BadInput
from ..kept import Kept
from ..run.comparison import Difference, differences
from ..run.dependence import depends_on
from ..run.key_results import KeyResults, known_results
from ..run.results import Result
from ..run.run_record import MeshRecord, known
from ..run.thresholds import MESH_ORDERS
from ..scene.meshes import coarsened, coarser, meshes_of
from ..scene.scene import Scene

LEFT = 56.0  # 2^p (2^p - 1) at p = 3: error of x over |x2 - x4|
FOLDER = "meshes"  # folder in the cache
Again = Callable[[Scene, Mapping[str, Any]], tuple[Result | None, str]]
Distances = Callable[[Result, Result], Mapping[str, float]]


@dataclass(frozen=True)
class MeshError:
    """What meshes make of the errors.

    places: parameters that are meshes, "unit.parameter", which are covered.  signals: name -> rms and largest, shares of the scale.
    figures: in their units.  quantities: shares, of further quantities.  not_covered: mesh -> why not.  left_out: "unit.parameter" or
    unit -> what it is that no repetition covers.  kept: whether it was measured before.
    """

    places: tuple[str, ...] = ()
    signals: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    figures: Mapping[str, float] = field(default_factory=dict)
    quantities: Mapping[str, float] = field(default_factory=dict)
    not_covered: Mapping[str, str] = field(default_factory=dict)
    left_out: Mapping[str, str] = field(default_factory=dict)
    kept: bool = False

    @property
    def worst(self) -> tuple[str, float]:
        """The signal with the largest error, and this, rms; ("", 0) without any."""
        return max(((name, rms) for name, (rms, _) in self.signals.items()), key=lambda one: one[1], default=("", 0.0))

    @property
    def record(self) -> MeshRecord:
        """As it is written."""
        return MeshRecord(
            places=self.places,
            signals={name: known(rms) for name, (rms, _) in self.signals.items()} if self.places else {},
            figures={name: known(error) for name, error in self.figures.items()} if self.places else {},
            kept=self.kept,
            not_covered=self.not_covered,
            left_out=self.left_out,
        )


def mesh_error(result: Result, again: Again, affordable: Callable[[], bool], distances: Distances | None = None) -> MeshError:
    """Of a result that has reached its end; affordable: whether runs of half and of a quarter of its cost may be made
    where nothing is kept."""
    scene = result.scene
    left_out = _never_covered(scene)
    if not meshes_of(scene):
        return MeshError(left_out=left_out)
    place = kept_errors(scene)
    kept: MeshError | None = place.read(MeshError) if distances is None else None
    if kept and {*result.columns, *result.texts} <= {*kept.signals} and {*known_results(result)} <= {*kept.figures}:
        return replace(kept, quantities={}, left_out=left_out, kept=True)
    places = tuple(meshes_of(scene))
    if not affordable():
        why = "a run with a coarser mesh is too much work to be made without being asked for (--verify whole)"
        return MeshError(not_covered=dict.fromkeys(places, why), left_out=left_out)
    try:
        changes = coarser(scene, 2)
    except BadInput as error:
        return MeshError(not_covered=dict.fromkeys(places, str(error)), left_out=left_out)
    coarse, why = again(scene, changes)
    if coarse is None:
        return MeshError(not_covered=dict.fromkeys(places, f"a coarser one is refused: {why}"), left_out=left_out)
    gaps = differences(coarse, result)
    if not any(gap.rms for gap in gaps.values()):
        return MeshError(not_covered=dict.fromkeys(places, "a coarser one has the same nodes"), left_out=left_out)
    coarsest, sizes = None, [coarsened(scene, changes)] * 2
    with suppress(BadInput):
        coarsest, _ = again(scene, further := coarser(scene, 4))
        sizes[1] = coarsened(scene, further)
    of_meshes = MeshError(
        places,
        _of_signals(gaps, differences(coarsest, coarse) if coarsest is not None else {}, (sizes[0], sizes[1])),
        _of_figures(*(known_results(one) for one in (result, coarse, coarsest) if one is not None)),
        dict(distances(coarse, result)) if distances is not None else {},
        left_out=left_out,
    )
    place.write(of_meshes)
    return of_meshes


def kept_errors(scene: Scene) -> Kept:
    """Where it is kept."""
    return Kept(FOLDER, depends_on("mesh", scene, of="figures"))


def _never_covered(scene: Scene) -> dict[str, str]:
    """What no repetition covers, each with what it is."""
    return {name: m.what for name, m in meshes_of(scene, random=True).items()} | {
        name: "internal steps and mesh of an FMU, which are not known"
        for name in scene.units
        if name not in scene.component_classes
    }


def _of_signals(
    gaps: Mapping[str, Difference], gaps_before: Mapping[str, Difference], sizes: tuple[float, float]
) -> dict[str, tuple[float, float]]:
    """Of the differences between a coarser run and the run, and between two coarser ones; sizes: their elements over the run's."""
    errors = {}
    for name, gap in gaps.items():
        order = _order(gaps_before[name].rms / gap.rms, sizes) if name in gaps_before and gap.rms > 0.0 else MESH_ORDERS[1]
        factor = 1.0 / (sizes[0] ** order - 1.0)
        errors[name] = factor * gap.rms, factor * gap.largest
    return errors


def _order(seen: float, sizes: tuple[float, float]) -> float:
    """The order p within `MESH_ORDERS` at which the difference of the coarser meshes is so many times the other one."""
    low, high = MESH_ORDERS
    for _ in range(20):
        p = 0.5 * (low + high)
        low, high = (p, high) if (sizes[1] ** p - sizes[0] ** p) < seen * (sizes[0] ** p - 1.0) else (low, p)
    return 0.5 * (low + high)


def _of_figures(fine: KeyResults, coarse: KeyResults, coarsest: Mapping[str, float] = MappingProxyType({})) -> dict[str, float]:
    chances = coarse.finite_gaps(coarsest)
    return {name: gap + chances.get(name, 0.0) / LEFT for name, gap in fine.gaps(coarse).items()}
