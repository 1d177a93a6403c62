"""How long the macro step of a scene may be before its coupling lets disturbances grow: measured, by algorithm and extrapolation.

Over the values of up to two parameters it is a map. A closed form is evaluated where units give the numbers that it needs; the
measured limit does not depend on it.

    [study]
    stability = { spring.stiffness = [25.0, 100.0, 400.0], mass.mass = { from = 0.5, to = 4.0, points = 8 } }
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from ....components.core.errors import BadInput, StepFailed
from ...judgement.disturbance import FEWEST, Disturbed, GrowthRate, IntrinsicGrowth, longest_stable
from ...judgement.probing import pair_limits
from ...output import write_table
from ...run.progress import tracked
from ...scene.names import measure_of
from ...scene.scene import Scene
from ...settings.algorithms import ALGORITHMS
from ..journal import once
from ..sweep import points

Scheme = tuple[str, int]  # algorithm, extrapolation

STEPS = 1000  # macro steps of a run that decides
SHORTEST = 64.0  # part of the scene's macro step below which no limit is looked for
FINE = 4.0  # part of the scene's macro step with which intrinsic growth is measured,
AHEAD = 2.0  # for as long as steps of so many macro steps take
EVEN = 1.01  # growth below this factor may be due to the sampling of an oscillation's crests


@dataclass(frozen=True)
class Limit:
    """The longest stable macro step of one scheme at one point of a map.

    point: "unit.parameter" -> value.  longest: s; infinite where the longest step tried is stable, 0 where the shortest is not,
    NaN where nothing was measured.  closed: s, of the closed form; NaN where there is none.  seen: what the next longer step
    did, or why nothing was measured.  tried: s, the longest or shortest step of all runs.  steps: macro steps of all runs.
    """

    point: Mapping[str, float]
    algorithm: str
    extrapolation: int
    longest: float
    closed: float
    seen: str
    tried: float
    steps: int


def limit_text(longest: float, tried: float) -> str:
    """A longest stable step, s, as text; see `Limit`."""
    if math.isnan(longest):
        return "not measured"
    return f"above {tried:.4g}" if longest == math.inf else f"below {tried:.4g}" if longest == 0.0 else f"{longest:.4g}"


@dataclass(frozen=True)
class Stability:
    """Limits of a scene over a map.

    varied: "unit.parameter" -> unit of measure.  limits: points in the order of the map, schemes within each.
    remarks: what a reader of the limits should know.
    """

    scene: Scene
    varied: Mapping[str, str]
    limits: tuple[Limit, ...]
    remarks: tuple[str, ...]

    @property
    def schemes(self) -> tuple[Scheme, ...]:
        """Algorithms with extrapolations, as they were asked for."""
        return tuple(dict.fromkeys((limit.algorithm, limit.extrapolation) for limit in self.limits))

    def of(self, scheme: Scheme) -> tuple[Limit, ...]:
        """The limits of one scheme, in the order of the map."""
        return tuple(limit for limit in self.limits if (limit.algorithm, limit.extrapolation) == scheme)

    def __repr__(self) -> str:
        """A line a scheme: its longest stable macro step, of a map the shortest and the longest of them."""
        lines = [f"<Stability of {self.scene.name}: longest stable macro step, s>"]
        for algorithm, extrapolation in self.schemes:
            of = sorted(self.of((algorithm, extrapolation)), key=lambda limit: limit.longest)
            ends = dict.fromkeys(limit_text(limit.longest, limit.tried) for limit in (of[0], of[-1]))
            lines.append(f"{algorithm}, extrapolation {extrapolation}: {' to '.join(ends)}")
        return "\n".join([*lines, *self.remarks])

    def save(self, directory: str | Path) -> Path:
        """Write stability.csv: one row for each scheme at each point."""
        names = [f"{name}, {unit}" if unit else name for name, unit in self.varied.items()]
        columns = (
            "algorithm",
            "extrapolation",
            "longest stable macro step, s",
            "closed form, s",
            "seen",
            "tried, s",
            "macro steps made",
        )
        fields = "algorithm", "extrapolation", "longest", "closed", "seen", "tried", "steps"
        rows = [(*limit.point.values(), *(getattr(limit, field) for field in fields)) for limit in self.limits]
        return write_table(directory, "stability.csv", [*names, *columns], rows)


def schemes_of(scene: Scene, algorithms: Sequence[str] = (), extrapolations: Sequence[int] = ()) -> list[Scheme]:
    """The schemes to be measured: those given, or all that the scene can have."""
    usual = [name for name, of in ALGORITHMS.items() if scene.contacts or not of.reduces_contacts]
    return [(algorithm, degree) for algorithm in algorithms or usual for degree in extrapolations or (0, 1, 2)]


def stability(scene: Scene, schemes: Sequence[Scheme] = (), *, steps: int = STEPS, progress: bool = False) -> Stability:
    """Measure the limits of a scene with each scheme, over the map of its [study] if it has one.

    `steps`: macro steps of each run; a slower growth than they can show counts as none.
    Raises `BadInput` where no units feed one another, and for units that cannot be run again from their start.
    """
    if all(len(group) == 1 for group in scene.coupling.groups):
        raise BadInput(
            f"{scene.name}: stability",
            "units of which none feeds back to another",
            "a coupling that can grow",
            "For the internal step of a component: cosimo stability component:Name.",
        )
    if steps < FEWEST:
        raise BadInput("steps", str(steps), f"at least {FEWEST}")
    varied = {name: measure_of(scene, name) for name in scene.study.stability}
    given = points(scene.with_changes({"sweep": dict(scene.study.stability)})) if varied else [({}, scene)]
    tasks = [(point, one, scheme) for point, one in given for scheme in schemes or schemes_of(scene)]
    limits: list[Limit] = []
    messages: dict[str, None] = {}
    own: dict[tuple[float, ...], IntrinsicGrowth] = {}  # what grows by itself, by point
    for point, one, scheme in tracked(tasks, scene.title or scene.name, progress):
        place = tuple(point.values())
        if place not in own:
            own[place] = once("own growth", (one, steps), partial(_own, one, steps), IntrinsicGrowth)
            messages |= dict.fromkeys(_remarks(one, own[place]))
        measure = partial(_measured, point, one, scheme, own[place], steps)
        limits.append(once("limit", (one, scheme, steps), measure, Limit))
    return Stability(scene, varied, tuple(limits), tuple(messages))


def _with(scene: Scene, scheme: Scheme) -> Scene:
    """The scene with a scheme, without step control, events, faults and energy accounts."""
    algorithm, degree = scheme
    changes = {"algorithm": algorithm, "extrapolation": degree, "control": None, "events": ()}
    changes |= {} if ALGORITHMS[algorithm].sequential else {"order": ()}
    changes |= {} if "iteration" in ALGORITHMS[algorithm].options else {"iteration": None}
    changes |= {} if scene.master.energy_correction else {"bonds": ()}
    return scene.with_changes({f"master.{key}": value for key, value in changes.items()} | {"faults": ()})


def _own(scene: Scene, steps: int) -> IntrinsicGrowth:
    """Growth of disturbances where the coupling has hardly any part in it: with short steps and quadratic inputs."""
    step = scene.master.step
    with ExitStack() as stack:
        try:
            return Disturbed(_with(scene, ("gauss-seidel", 2)), stack).intrinsic_growth(step / FINE, AHEAD * steps * step)
        except (BadInput, StepFailed):
            return IntrinsicGrowth(np.zeros(0), step)  # a scene that cannot start is listed with each scheme


def _remarks(scene: Scene, own: IntrinsicGrowth) -> Iterator[str]:
    master = scene.master
    if not own.sizes.size:
        yield f"a run with a macro step of {own.h:g} s ends early: what grows by itself is not known"
    elif (factor := own.factor(math.inf)) > EVEN:
        yield (
            f"disturbances grow by themselves, in {own.sizes.size * own.h:.3g} s by a factor of {factor:.3g}; a coupling is "
            "called unstable where they grow faster"
        )
    if master.control is not None or master.events:
        yield "all macro steps were of one length: without step control and located events"


def _measured(point: Mapping[str, float], scene: Scene, scheme: Scheme, own: IntrinsicGrowth, steps: int) -> Limit:
    algorithm, degree = scheme
    with ExitStack() as stack:
        try:
            changed = _with(scene, scheme)
            disturbed = Disturbed(changed, stack)
            closed = _closed_form(disturbed, degree)
        except (BadInput, StepFailed) as error:
            return Limit(point, algorithm, degree, math.nan, math.nan, str(error), math.nan, 0)
        step_counts: list[int] = []

        def growth(h: float) -> GrowthRate:
            measured = disturbed.growth(h, steps)
            step_counts.append(measured.steps)
            return measured

        step = scene.master.step
        longest, seen, tried = longest_stable(growth, own, EVEN, step, step / SHORTEST, disturbed.longest)
    return Limit(point, algorithm, degree, longest, closed, seen, tried, sum(step_counts))


def _closed_form(disturbed: Disturbed, degree: int) -> float:
    """The shortest limit of all pairs of units for which the closed form is known, s; NaN where there is none."""
    scene = disturbed.scene
    if scene.master.feedthrough == "delayed" and degree:
        return math.nan  # the form with a delay is for held forces
    pairs, _ = pair_limits(disturbed.open_scene)
    return min((contact.longest[degree] for contact in pairs), default=math.nan)
