"""How long the macro step of a scene may be before its coupling lets disturbances grow, by algorithm and extrapolation.

Over the values of up to two parameters it is a map.

    [study]
    stability = { spring.stiffness = [25.0, 100.0, 400.0], mass.mass = { from = 0.5, to = 4.0, points = 8 } }
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from ....components.core.errors import BadInput, StepFailed
from ...judgement.advice import coupling_of
from ...judgement.growth import limit_text
from ...output import write_table
from ...run.progress import tracked
from ...scene.names import measure_of
from ...scene.scene import Scene
from ...settings.algorithms import ALGORITHMS
from ..journal import once
from ..sweep import points

Scheme = tuple[str, int]  # algorithm, extrapolation

EIGENVALUE, ALONG_THE_RUN = "eigenvalue", "growth along the run"
COLUMNS = {
    "algorithm": "algorithm",
    "extrapolation": "extrapolation",
    "longest": "longest stable macro step, s",
    "how": "told by",
    "own": "growth with short steps, 1/s",
    "seen": "seen",
    "tried": "tried, s",
}


@dataclass(frozen=True)
class SchemeLimit:
    """The longest stable macro step of one scheme at one point of a map.

    point: "unit.parameter" -> value.  longest, seen, tried: as of `judgement.growth.StepLimit`; NaN where nothing was measured, and
    `seen` tells why.  how: what has told it.  own: growth of disturbances with a quarter of the scene's step, 1/s.
    """

    point: Mapping[str, float]
    algorithm: str
    extrapolation: int
    longest: float
    seen: str
    tried: float
    how: str = ""
    own: float = math.nan


@dataclass(frozen=True)
class StabilityMap:
    """Limits of a scene over a map.

    varied: "unit.parameter" -> unit of measure.  limits: points in the order of the map, schemes within each.
    remarks: what a reader of the limits should know.
    """

    scene: Scene
    varied: Mapping[str, str]
    limits: tuple[SchemeLimit, ...]
    remarks: tuple[str, ...]

    @property
    def schemes(self) -> tuple[Scheme, ...]:
        """Algorithms with extrapolations, as they were asked for."""
        return tuple(dict.fromkeys((limit.algorithm, limit.extrapolation) for limit in self.limits))

    def of(self, scheme: Scheme) -> tuple[SchemeLimit, ...]:
        """The limits of one scheme, in the order of the map."""
        return tuple(limit for limit in self.limits if (limit.algorithm, limit.extrapolation) == scheme)

    def __repr__(self) -> str:
        """A line a scheme: its longest stable macro step, of a map the shortest and the longest of them."""
        lines = [f"<StabilityMap of {self.scene.name}: longest stable macro step, s>"]
        for algorithm, extrapolation in self.schemes:
            of = sorted(self.of((algorithm, extrapolation)), key=lambda limit: limit.longest)
            ends = dict.fromkeys(limit_text(limit.longest, limit.tried) for limit in (of[0], of[-1]))
            lines.append(f"{algorithm}, extrapolation {extrapolation}: {' to '.join(ends)}")
        return "\n".join([*lines, *self.remarks])

    def save(self, directory: str | Path) -> Path:
        """Write stability.csv: one row for each scheme at each point."""
        names = [f"{name}, {unit}" if unit else name for name, unit in self.varied.items()]
        rows = [(*limit.point.values(), *(getattr(limit, field) for field in COLUMNS)) for limit in self.limits]
        return write_table(directory, "stability.csv", [*names, *COLUMNS.values()], rows)


def schemes_of(algorithms: Sequence[str] = (), extrapolations: Sequence[int] = ()) -> list[Scheme]:
    """The schemes to be measured: those given, or all whose macro steps have derivatives."""
    usual = [name for name, of in ALGORITHMS.items() if of.rates]
    return [(algorithm, degree) for algorithm in algorithms or usual for degree in extrapolations or (0, 1, 2)]


def stability(scene: Scene, schemes: Sequence[Scheme] = (), *, progress: bool = False) -> StabilityMap:
    """The limits of a scene with each scheme, over the map of its [study] if it has one.

    Raises `BadInput` where no units feed one another.
    """
    if all(len(group) == 1 for group in scene.coupling.groups):
        raise BadInput(
            f"{scene.name}: stability",
            "units of which none feeds back to another",
            "a coupling that can grow",
            "For the internal step of a component: cosimo stability component:Name.",
        )
    varied = {name: measure_of(scene, name) for name in scene.study.stability}
    given = points(scene.with_changes({"sweep": dict(scene.study.stability)})) if varied else [({}, scene)]
    tasks = [(point, one, scheme) for point, one in given for scheme in schemes or schemes_of()]
    limits = tuple(
        once("limit", (one, scheme), partial(_measured, point, one, scheme), SchemeLimit)
        for point, one, scheme in tracked(tasks, scene.title or scene.name, progress)
    )
    return StabilityMap(scene, varied, limits, tuple(_remarks(scene, limits)))


def _remarks(scene: Scene, limits: Sequence[SchemeLimit]) -> list[str]:
    remarks = []
    if (own := max((limit.own for limit in limits if math.isfinite(limit.own)), default=0.0)) > 0.0:
        remarks.append(
            f"disturbances grow by themselves, with short steps by up to {own:.3g} 1/s; a coupling is called unstable where they grow "
            "faster"
        )
    if scene.master.control is not None or scene.master.events:
        remarks.append("all macro steps were of one length: without step control and located events")
    return remarks


def _with(scene: Scene, scheme: Scheme) -> Scene:
    """The scene with a scheme, without step control, events, faults and energy accounts."""
    algorithm, degree = scheme
    changes = {"algorithm": algorithm, "extrapolation": degree, "control": None, "events": ()}
    changes |= {} if ALGORITHMS[algorithm].sequential else {"order": ()}
    changes |= {} if "iteration" in ALGORITHMS[algorithm].options else {"iteration": None}
    changes |= {} if scene.master.energy_correction else {"bonds": ()}
    return scene.with_changes({f"master.{key}": value for key, value in changes.items()} | {"faults": ()})


def _measured(point: Mapping[str, float], scene: Scene, scheme: Scheme) -> SchemeLimit:
    with ExitStack() as stack:
        try:
            coupling = coupling_of(_with(scene, scheme), stack)
            longest = coupling.longest()
            how = EIGENVALUE if coupling.constant else ALONG_THE_RUN
            own = coupling.growth(scene.master.step).finer
            return SchemeLimit(point, *scheme, longest.longest, longest.seen, longest.tried, how, own)
        except (BadInput, StepFailed) as error:
            return SchemeLimit(point, *scheme, math.nan, str(error), math.nan)
