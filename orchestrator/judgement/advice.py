"""What a run will need, before it is started: whether its coupling is stable, and how long it will take.

A macro step may hold millions of internal steps. Its cost is therefore seen over parts of it, each ten times as long as the one
before, which are made and taken back, until the next part would take too much. The answer says so.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from math import ceil, inf
from time import perf_counter
from typing import TYPE_CHECKING

from ...components.core.errors import BadInput, StepFailed
from ...components.core.kernels import COMPILED
from ..opened.open_scene import Course, OpenScene, started
from ..run import work
from ..run.run_info import CompileTime
from ..run.thresholds import PREFIX_STEPS, PREFIX_WORK
from ..scene.scene import Scene
from .growth import Growth, StepLimit, limit_text

if TYPE_CHECKING:
    from .stability import CouplingStability

PACE = 10.0  # from one part to the next
SHARES = tuple(PACE**k for k in range(-6, 1))  # of a macro step
MOST_CALLS = 200_000  # operations that a step which is made to see its cost may take
TIMED_STEPS, TIMED_SECONDS = 32, 0.3  # of the longest stretch, whose time tells that of a macro step; s that it may take
RUNS = 10.0  # with tangents and short steps, that the growth of disturbances in a run takes


@dataclass(frozen=True)
class StepCost:
    """share: part of the step that was made, 1 for all of it. calls: counted operations of that part.

    seconds: real time of it, from which only the time of a run is foretold.
    """

    share: float = 1.0
    calls: int = 0
    seconds: float = 0.0

    @property
    def cut(self) -> bool:
        """Whether the whole step takes more than may be made to see its cost."""
        return self.share < 1.0

    def text(self, name: str, step: float) -> str:
        """For the reader of a dry run: what was cut, and what a whole `step` (s) would take."""
        return (
            f"the probe was cut: {name} takes {self.calls} operations for {self.share:g} of its step of {step:g} s, so about "
            f"{self.calls / self.share:.2g} for a whole one; its time is extrapolated"
        )


def step_cost(open_scene: OpenScene, name: str, step: float) -> StepCost:
    """The cost of a step of a unit of `step` s from where it stands, with its inputs held; it is left as it was.

    A unit that cannot go back or cannot shorten its steps is not asked, and its step is taken as one that may be made. So is that
    of an FMU, which counts a step as one operation, however long it takes: a clock would cut it elsewhere on another machine.
    """
    interface, unit = open_scene.scene.coupling.interfaces[name], open_scene.units[name]
    if not interface.saves_state or not interface.variable_step or interface.fixed_step:
        return StepCost()
    try:
        open_scene.alone(name, SHARES[0] * step)  # which compiles
        for share in SHARES:
            before, start = work.calls_of(unit.work()), perf_counter()
            open_scene.alone(name, share * step)
            calls, seconds = work.calls_of(unit.work()) - before, perf_counter() - start
            if PACE * calls > MOST_CALLS and share < 1.0:
                return StepCost(share, calls, seconds)
    except StepFailed:  # the run's own first step will say why
        return StepCost()
    return StepCost(1.0, calls, seconds)


@dataclass(frozen=True)
class StabilityAdvice:
    """Of the coupling of a scene. growth: with its macro step, of the first `looked` seconds; None where it was not examined.

    limit: of the macro step, where one is known at once.  why: why it was not examined; "" where no unit feeds back to another, too.
    """

    growth: Growth | None = None
    limit: StepLimit | None = None
    looked: float = 0.0
    why: str = ""


@dataclass(frozen=True)
class Advice:
    """stability: of the coupling. steps: of the run. seconds: real time of one step, work: what is counted of it.

    compiling: s that this took just now; 0 where all machine code was kept from earlier. cut: units whose cost was seen over a part
    of the macro step only, and what a whole one takes.
    """

    stability: StabilityAdvice
    steps: int
    seconds: float
    work: float
    compiling: float
    cut: tuple[str, ...] = ()

    def lines(self) -> Iterator[str]:
        """What is known of the stability of the coupling, for the reader."""
        growth, limit = self.stability.growth, self.stability.limit
        if self.stability.why:
            yield f"stability of the coupling: not examined: {self.stability.why}"
        if growth is None:
            return
        where = (
            "its derivative is the same all along the run"
            if growth.constant
            else f"mean of the first {self.stability.looked:.3g} s"
        )
        own = ", as it does with shorter steps" if growth.rate > 0.0 and not growth.unstable else ""
        yield f"stability of the coupling: a disturbance {growth.text}{own} ({where})"
        if not growth.unstable and growth.lost > 0.0:
            yield f"damping that the coupling takes away: {growth.lost:.3g} 1/s, beside a quarter of the macro step"
        if limit is not None:
            yield f"longest stable macro step: {limit_text(limit.longest, limit.tried)} s"

    def warnings(self, scene: Scene) -> list[str]:
        """What is wrong with the scene's macro step."""
        growth = self.stability.growth
        if growth is None or not growth.unstable:
            return []
        what = f"at a macro step of {growth.step:g} s the coupling is unstable: a disturbance {growth.text}"
        return [f"{what}. {remedy_of(scene, self.stability.limit, examined=True)}"]


def remedy_of(scene: Scene, limit: StepLimit | None, examined: bool) -> str:
    """What would help an unstable scene; limit: of its macro step, where that is known at once."""
    if limit is None or limit.longest == inf:
        return "Reduce the macro step" + ("; cosimo stability tells the longest stable one" if examined else "")
    degree = f"master.extrapolation = {scene.master.extrapolation}"
    if not limit.longest:
        return f"Change master.extrapolation: with {degree} no macro step down to {limit.tried:.3g} s is stable"
    return f"Reduce the macro step: the coupling is stable up to {limit.longest:.3g} s with {degree}"


def remedy(scene: Scene) -> str:
    """What would help a run that became unstable."""
    with suppress(BadInput, StepFailed), ExitStack() as stack:
        coupling = coupling_of(scene, stack)
        return remedy_of(scene, coupling.longest() if coupling.constant else None, examined=True)
    return remedy_of(scene, None, examined=False)


def coupling_of(scene: Scene, stack: ExitStack) -> CouplingStability:
    """For macro steps of any length, without faults; `stack` closes the units.

    Raises `BadInput` for what has no derivatives, `StepFailed`.
    """
    if not COMPILED:
        raise BadInput(f"{scene.name}: stability", "no machine code", "Numba, which derivatives are made with")
    from .stability import CouplingStability

    return CouplingStability(scene.with_changes({"faults": ()}) if scene.faults else scene, stack)


def stability_of(scene: Scene, counted: float = 0.0) -> StabilityAdvice:
    """Of a scene; counted: work of a macro step, which shortens what is looked at."""
    if all(len(group) == 1 for group in scene.coupling.groups):
        return StabilityAdvice()
    looked = scene.duration
    if (whole := RUNS * counted * looked / scene.master.step) > PREFIX_WORK:
        looked *= PREFIX_WORK / whole
        if looked < PREFIX_STEPS * scene.master.step:
            return StabilityAdvice(why="a macro step takes too much work")
        scene = work.beginning(scene, looked)
    try:
        with ExitStack() as stack:
            coupling = coupling_of(scene, stack)
            growth = coupling.growth(scene.master.step)
            if not growth.unstable and scene.master.step > coupling.most:
                return StabilityAdvice(why="the run has too few macro steps to see growth along it")
            if growth.untold:
                return StabilityAdvice(why=growth.untold)
            return StabilityAdvice(growth, coupling.longest() if growth.constant else None, looked)
    except BadInput as error:
        return StabilityAdvice(why=error.actual)
    except StepFailed as error:
        return StabilityAdvice(why=str(error))


def advise(scene: Scene, *, in_process: bool = False) -> Advice:
    """Start the scene, look how disturbances grow, and time a few steps; raises `StepFailed` where it does not start or a step fails."""
    with CompileTime() as compiling:
        with started(scene, watched=()) as course:  # in process, where components count what they do
            costs, counted = _costs(course.open_scene), 0.0
            for name, (cost, every) in costs.items():
                counted += work.HAND_OVER + work.of_calls(course.open_scene.units[name], max(cost.calls, 1) / cost.share / every)
            cut = tuple(cost.text(name, scene.master.step * every) for name, (cost, every) in costs.items() if cost.cut)
            seconds = sum(cost.seconds / cost.share / every for cost, every in costs.values())
            if not cut and (here := work.as_repeated(scene, in_process)):
                seconds = _timed(course)
        if not cut and not here:
            with started(scene, in_process=False, watched=()) as course:
                seconds = _timed(course)
        stability = stability_of(scene, counted)
    steps = ceil(scene.duration / scene.master.step * (1.0 - 1e-12))
    return Advice(stability, steps, seconds, counted, compiling.seconds, cut)


def _costs(open_scene: OpenScene) -> dict[str, tuple[StepCost, int]]:
    """By unit the cost of a step of it, and the macro steps that this one spans."""
    scene = open_scene.scene
    every = {name: scene.coupling.rates.get(name, 1) for name in open_scene.order}
    return {name: (step_cost(open_scene, name, n * scene.master.step), n) for name, n in every.items()}


def _timed(course: Course) -> float:
    """Time of a macro step, s: the least mean over stretches, each twice as long as the one before; the first warms up."""
    stepping, n, times = course.stepping, 1, list[float]()
    while n <= TIMED_STEPS and stepping.tick < stepping.end and (n <= 2 or n * times[-1] < TIMED_SECONDS):
        begin, first = perf_counter(), stepping.tick
        stepping.run((), n)
        times.append((perf_counter() - begin) * stepping.stride / (stepping.tick - first))
        n *= 2
    return min(times[1:] or times)
