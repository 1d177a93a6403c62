"""What a run will need, before it is started: how long its macro step may be, and how long it will take.

Two units that feed one another without delay (one gets forces and moves, the other gives forces for this motion) have a limit of the
macro step in closed form. It needs stiffness, damping and the masses behind the forces, which probing measures: small changes of the
inputs of the unit that gives forces, at the start; short steps of the unit that moves, under slightly changed forces, which are then
taken back. A response with the square of time is a mass. A response in proportion to time is a damper, such as a long wire, or a
velocity. Several forces and motions are decomposed into the modes of the pair.

Probing does not see other damping of the pair: a step somewhat above the limit may be stable. The damping that remains at the scene's
step is therefore reported as well.

A macro step may hold millions of internal steps. Its cost is therefore seen over parts of it, each ten times as long as the one
before, which are made and taken back, until the next part would take too much. Such a unit is probed over a part of its step,
and the answer says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import ceil, inf, log, pi, sqrt
from time import perf_counter

import numpy as np

from ...components.core.errors import BadInput, StepFailed
from ...components.core.measure import parse
from ..engine.coupling import Coupling
from ..engine.coupling.graph import Link
from ..run.run_info import CompileTime
from ..scene.scene import Scene
from ..session.open_scene import Course, OpenScene, started
from . import work
from .closed_form import longest_step, radii
from .thresholds import TOLERABLE

PACE = 10.0  # from one part to the next
SHARES = tuple(PACE**k for k in range(-6, 1))  # of a macro step
MOST_CALLS = 200_000  # operations that a probing step may take


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
        """Whether the whole step takes more than a probe may."""
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
        open_scene.alone(name, {}, SHARES[0] * step)  # which compiles
        for share in SHARES:
            before, start = work.calls_of(unit.work()), perf_counter()
            open_scene.alone(name, {}, share * step)
            calls, seconds = work.calls_of(unit.work()) - before, perf_counter() - start
            if PACE * calls > MOST_CALLS and share < 1.0:
                return StepCost(share, calls, seconds)
    except StepFailed:  # the run's own first step will say why
        return StepCost()
    return StepCost(1.0, calls, seconds)


SPANS = (0.1, 1.0, 5.0)  # macro steps: lengths of probing steps, the first in which the motion answers
NUDGE = 1e-4  # of a value or its nominal value
NOISE = 1e-6  # of the largest entry: what probing does not resolve
TIMED_STEPS, TIMED_SECONDS = 32, 0.3  # of the longest stretch, whose time tells that of a macro step; s that it may take
FORCES = [parse(unit).exponents[:7] for unit in ("N", "N.m", "W", "A", "V")]


@dataclass(frozen=True)
class PairLimit:
    """The mode of a unit and those it gives forces to that limits the macro step most, at the start of the run.

    omega2: stiffness over mass, 1/s²; 0 for a damper alone. damping: damper over mass, 1/s. longest: stable macro steps, s, of
    degrees 0, 1 and 2. left: share of critical damping that remains at the scene's step; below 0 the motion grows.
    """

    pair: str  # "mover against giver"
    omega2: float
    damping: float
    longest: tuple[float, float, float]
    left: float

    @property
    def frequency(self) -> float:
        """Of the mass on the spring, Hz."""
        return sqrt(self.omega2) / (2.0 * pi)

    @property
    def share(self) -> float:
        """Of critical damping; infinite for a damper alone."""
        return self.damping / (2.0 * sqrt(self.omega2)) if self.omega2 > 0.0 else inf


@dataclass(frozen=True)
class Advice:
    """limits: of pairs. unknown: why others have none. steps: of the run. seconds: real time of one step, work: what is counted
    of it. compiling: s that this took just now; 0 where all machine code was kept from earlier. cut: units that were probed
    over a part of the macro step only, and what a whole one takes.
    """

    limits: tuple[PairLimit, ...]
    unknown: tuple[str, ...]
    steps: int
    seconds: float
    work: float
    compiling: float
    cut: tuple[str, ...] = ()

    def warnings(self, scene: Scene) -> list[str]:
        """What is wrong with the scene's macro step."""
        return step_warnings(scene, self.limits, TOLERABLE)


def step_warnings(scene: Scene, limits: Sequence[PairLimit], tolerable: float, kept: float = 0.0) -> list[str]:
    """What is wrong with the scene's macro step, pair by pair; `tolerable`: share of critical damping that may be missing.

    `kept`: share of its own damping that a pair which oscillates is to keep.
    """
    degree, texts = scene.master.extrapolation, []
    for c in limits:
        oscillates = 0.0 < c.share < 1.0
        if c.left < -tolerable or (kept and oscillates and c.left < kept * c.share):
            own = f" from {c.share:.2g}" if oscillates else ""
            limit = c.longest[degree]
            stable = (
                f"It is stable up to {limit:.3g} s" if limit else "At any step only other damping in the units can keep it stable"
            )
            less = f"by {c.share - c.left:.2g}" if c.share - c.left < inf else "below any value"
            texts.append(
                f"at a macro step of {scene.master.step:g} s, the coupling of {c.pair} reduces the damping ratio{own} {less}. {stable}. "
                "Reduce master.step or change master.extrapolation"
            )
    return texts


def advise(scene: Scene, *, in_process: bool = False) -> Advice:
    """Start the scene, probe its units and time a few steps; raises `StepFailed` where it does not start or a step fails."""
    with CompileTime() as compiling:
        with started(scene, watched=()) as course:  # in process, where components count what they do
            limits, unknown = pair_limits(course.open_scene)
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
    steps = ceil(scene.duration / scene.master.step * (1.0 - 1e-12))
    return Advice(limits, unknown, steps, seconds, counted, compiling.seconds, cut)


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


def pair_limits(open_scene: OpenScene) -> tuple[tuple[PairLimit, ...], tuple[str, ...]]:
    """The limits of pairs of units in their present state, and why others have none; the state stays as it is."""
    scene, limits, unknown = open_scene.scene, [], []
    coupling = scene.coupling
    if not scene.master.abilities.rates:
        return (), ()
    for giver in coupling.interfaces:
        at_once = coupling.interfaces[giver].outputs
        out = [link for link in coupling.links if link.source[0] == giver and at_once[link.source[1]].feedthrough]
        fed = {link.target[0] for link in out}
        motions = [link for link in coupling.links if link.target[0] == giver and link.source[0] in fed]
        observed = {link.target[1] for link in motions}
        forces = [link for link in out if observed & set(at_once[link.source[1]].feedthrough or ())]
        if not any(_is_force(_unit(link, coupling)) for link in forces):
            continue
        movers = tuple(dict.fromkeys(link.target[0] for link in forces))
        pair = f"{' and '.join(movers)} against {giver}"
        if reason := _obstacle(scene, forces, movers):
            unknown.append(f"{pair}: {reason}")
            continue
        gains = _gains(open_scene, forces, motions)
        modes = _modes(*(-gains @ part for part in _answers(open_scene, forces, motions)))
        if modes:
            limits.append(min((_limit(scene, pair, *mode) for mode in modes), key=lambda limit: limit.left))
        elif gains.any():
            unknown.append(f"{pair}: nothing holds {' and '.join(movers)} back at the start")
        else:
            unknown.append(f"{pair}: at the start the force does not follow the motion, as in an open contact")
    return tuple(limits), tuple(unknown)


def _limit(scene: Scene, pair: str, omega2: float, damping: float) -> PairLimit:
    """A mode with its limits under the scene's algorithm."""
    degree, h = scene.master.extrapolation, scene.master.step
    delay = int(scene.master.feedthrough == "delayed")
    limits = [longest_step(omega2, damping, p, delay) for p in range(3)]
    grown = float(radii(np.array([omega2 * h * h]), np.array([damping * h]), degree, delay)[0])
    left = -log(max(grown, NOISE)) / (sqrt(omega2) * h) if omega2 > 0.0 else (-inf if h > limits[degree] else inf)
    return PairLimit(pair, omega2, damping, (limits[0], limits[1], limits[2]), left)


def _modes(omega2: np.ndarray, damping: np.ndarray) -> list[tuple[float, float]]:
    """(stiffness over mass, damper over mass) of the modes of two matrices, (n, n) each, that something holds back.

    Modes of the stiffness with the damping that each has of its own; of the damping where nothing is stiff.
    """
    if not (np.isfinite(omega2).all() and np.isfinite(damping).all()):
        return []
    stiff = np.abs(omega2).max() > NOISE * np.abs(damping).max() ** 2
    values, vectors = np.linalg.eig(omega2 if stiff else damping)
    if np.linalg.cond(vectors) > 1.0 / NOISE:
        return []
    held = values.real > NOISE * np.abs(values).max()
    if not stiff:
        return [(0.0, float(v)) for v in values.real[held]]
    own = np.diag(np.linalg.solve(vectors, damping @ vectors)).real
    return [(float(v), max(float(d), 0.0)) for v, d in zip(values.real[held], own[held], strict=True)]


def _obstacle(scene: Scene, forces: Sequence[Link], movers: Sequence[str]) -> str:
    """Why some units cannot be probed, or have no closed form; "" where they can."""
    coupling = scene.coupling
    for name in (forces[0].source[0], *movers):
        if not coupling.interfaces[name].saves_state:
            return f"{name} cannot save its state"
        if name in coupling.rates:
            return f"{name} has a rate of its own"
    for link in forces:
        if not _is_force(_unit(link, coupling)):
            return f"{link.target[0]} gets {link.target[1]} beside forces"
    if scene.master.feedthrough == "delayed" and scene.master.abilities.sequential:
        return f"delayed feedthrough with {scene.master.algorithm} have other limits"
    return ""


def _unit(link: Link, coupling: Coupling) -> str:
    return coupling.interfaces[link.target[0]].inputs[link.target[1]].unit


def _is_force(unit: str) -> bool:
    """Whether a unit of measure is one of forces, or not declared."""
    try:
        return not unit or parse(unit).exponents[:7] in FORCES
    except BadInput:  # a unit of measure that an FMU made up
        return False


def _gains(open_scene: OpenScene, forces: Sequence[Link], motions: Sequence[Link]) -> np.ndarray:
    """Derivatives of force inputs with respect to motion outputs, through both connections, (forces, motions)."""
    columns = [_changes(open_scene, link, 0.0, forces) * link.factor for link in motions]
    return np.array([force.factor for force in forces])[:, None] * np.array(columns).T


def _answers(open_scene: OpenScene, forces: Sequence[Link], motions: Sequence[Link]) -> tuple[np.ndarray, np.ndarray]:
    """Second and first time derivatives of motion outputs per unit of force, (motions, forces) each."""
    second, first = (np.zeros((len(motions), len(forces))) for _ in range(2))
    for column, force in enumerate(forces):
        mine = [row for row, link in enumerate(motions) if link.source[0] == force.target[0]]
        second[mine, column], first[mine, column] = _answer(open_scene, force, [motions[row] for row in mine])
    return second, first


def _answer(open_scene: OpenScene, force: Link, motions: Sequence[Link]) -> tuple[np.ndarray, np.ndarray]:
    """Second and first time derivatives of a unit's outputs per unit of a force on it, (n,) each.

    An output has one of both: that which its answers to steps of one and of two lengths show.
    """
    step, interface = open_scene.scene.master.step, open_scene.scene.coupling.interfaces[force.target[0]]
    cost = step_cost(open_scene, force.target[0], step)
    for share in (0.5 * cost.share,) if cost.cut else SPANS:
        h = interface.fixed_step or (share * step if interface.variable_step else step)
        once, twice = (_changes(open_scene, force, span, motions) for span in (h, 2.0 * h))
        if once.any():
            break
    with np.errstate(divide="ignore", invalid="ignore"):
        powers = np.round(np.log2(twice / once))
    return np.where(powers == 2.0, 2.0 * once / h**2, 0.0), np.where(powers == 1.0, once / h, 0.0)


def _changes(open_scene: OpenScene, link: Link, h: float, outputs: Sequence[Link]) -> np.ndarray:
    """Derivatives of the outputs that feed some links with respect to the input of one, (n,).

    Behind a step of h, s, or with 0 within the instant.
    """
    name, input_ = link.target
    value = open_scene.inputs(name)[input_]
    nudge = NUDGE * max(abs(value), open_scene.scene.coupling.interfaces[name].inputs[input_].nominal)
    below, above = (open_scene.alone(name, {input_: moved}, h) for moved in (value - nudge, value + nudge))
    changes = np.array([above[o.source[1]] - below[o.source[1]] for o in outputs])
    return changes / ((value + nudge) - (value - nudge))


def remedy(scene: Scene) -> str:
    """What would help a run that became unstable: a shorter macro step, and below what where a closed form tells."""
    degree = scene.master.extrapolation
    short = min(
        (c for c in _limits(scene) if c.longest[degree] < scene.master.step), key=lambda c: c.longest[degree], default=None
    )
    if short is None:
        return "Reduce the macro step; cosimo stability measures the longest stable one"
    if not (limit := short.longest[degree]):
        return (
            f"Reduce the macro step, or change master.extrapolation: with {degree}, only other damping in the units can keep {short.pair} "
            "stable"
        )
    return f"Reduce the macro step: {short.pair} is stable up to {limit:.3g} s with master.extrapolation = {degree}"


def _limits(scene: Scene) -> tuple[PairLimit, ...]:
    """The scene is started anew to ask its units, in this process; nothing where it does not start."""
    with suppress(BadInput, StepFailed), started(scene, watched=()) as course:
        return pair_limits(course.open_scene)[0]
    return ()
