"""Branches of periodic orbits over a parameter: pseudo-arclength, bifurcations located on them, and branches of doubled period.

A branch is followed along its arc, so that it turns back at folds. The number of multipliers beyond the unit circle tells of a
bifurcation between two points; it is located by bisection and named by the multiplier that lies on the circle there. Where none does,
multipliers jump: a contact begins to open or to close along the orbit (border collision, grazing).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ...components.core.errors import BadInput, StepFailed, counted
from ..output import write_table
from ..scene.scene import Scene
from .motions import MOTION_COLUMNS, Regime, motions
from .newton import newton
from .orbit import INSIDE, Forcing, Orbit, Shooting

FOLD, DOUBLING, TORUS, BRANCH, COLLISION = "fold", "period doubling", "Neimark-Sacker", "branch point", "border collision"
ON_CIRCLE = 2e-3  # distance of a multiplier from the unit circle where a bifurcation is located
SAME = 5e-2  # of the sizes: an orbit and the straight line between two others at the parameter are of one branch
LONGEST = 0.2  # of a step along a branch, in sizes
SHORTEST, BISECTIONS = 1e-3, 40  # of the first step along a branch; halvings of a stretch with a bifurcation
POINTS = 60  # of a branch for each value that was asked for
APART = (0.02, 0.05, 0.15, 0.005)  # of the sizes: how far from a doubling its branch is sought
LOOP, NEAR = 10, 1e-3  # points of the shortest loop; of the range: a doubling that a branch has ended at
MERGED = 1e-3  # of the sizes: halves of a doubled orbit that are one


@dataclass(frozen=True)
class Mark:
    """A bifurcation: kind, value of the parameter, period in s, and the multiplier nearest to the unit circle."""

    kind: str
    orbit: Orbit
    multiplier: complex


@dataclass
class Branch:
    """Orbits along an arc, of `multiple` periods each, with the bifurcations on it; ends: why it ends on either side."""

    multiple: int
    points: list[Orbit] = field(default_factory=list)
    marks: list[Mark] = field(default_factory=list)
    ends: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Orbits:
    """Branches over a parameter, or one orbit alone.  gaps: (value, reason) where none was reached by running on.

    motions: what the scene settles to at each of the values, where exponents were asked for.
    """

    scene: Scene
    parameter: str
    signals: tuple[str, ...]
    branches: tuple[Branch, ...]
    gaps: tuple[tuple[float, str], ...] = ()
    motions: tuple[Regime, ...] = ()

    @property
    def marks(self) -> list[Mark]:
        """All bifurcations, by the parameter."""
        return sorted((mark for branch in self.branches for mark in branch.marks), key=lambda mark: mark.orbit.value)

    def save(self, directory: str | Path) -> list[Path]:
        """Write orbits.csv and, over a parameter, bifurcations.csv."""
        first = self.parameter or "value"
        names = [f"{name}, {kind}" for name in self.signals for kind in ("minimum", "maximum", "section")]
        rows: list[list[Any]] = [
            [k, branch.multiple, *_numbers(point)] for k, branch in enumerate(self.branches, 1) for point in branch.points
        ]
        header = ("branch", "periods", first, "period, s", "stable", "largest multiplier", *names)
        files = [write_table(directory, "orbits.csv", header, rows)]
        if self.parameter:
            marks: list[list[Any]] = [
                [m.kind, m.orbit.value, m.orbit.period, m.multiplier.real, m.multiplier.imag] for m in self.marks
            ]
            columns = ("kind", self.parameter, "period, s", "multiplier, real", "multiplier, imaginary")
            files.append(write_table(directory, "bifurcations.csv", columns, marks))
        if self.motions:
            files.append(
                write_table(directory, "motions.csv", (self.parameter, *MOTION_COLUMNS), [m.row() for m in self.motions])
            )
        return files

    def to_json(self) -> dict[str, Any]:
        """All of it as plain data."""
        branches = [
            {
                "periods": branch.multiple,
                "ends": branch.ends,
                "points": [{"value": p.value, "period": p.period, "stable": p.stable} for p in branch.points],
                "bifurcations": [{"kind": m.kind, "value": m.orbit.value, "period": m.orbit.period} for m in branch.marks],
            }
            for branch in self.branches
        ]
        return {"scene": self.scene.name, "parameter": self.parameter, "branches": branches, "gaps": dict(self.gaps)}


def _numbers(point: Orbit) -> list[Any]:
    values = np.stack([point.low, point.high, point.sections[0]], axis=1).ravel().tolist()
    largest = float(np.abs(point.multipliers).max(initial=0.0))
    return [point.value, point.period, "stable" if point.stable else "unstable", largest, *values]


def orbits(
    scene: Scene,
    forcing: Forcing = Forcing(),  # noqa: B008 - it is frozen
    over: tuple[str, Sequence[float]] | None = None,
    *,
    after: int = 100,
    guess: float = 0.0,
    steps: int = 0,
    doublings: int = 1,
    exponents: int = 0,
    progress: Callable[[str], None] = lambda text: None,
) -> Orbits:
    """Periodic orbits of a scene: one, or branches over a parameter.

    over: a parameter and its values; the first one begins a branch, and each other that no branch has reached. after: periods of
    the run that each begins with.  guess: period of a free oscillation, s.  steps: macro steps of a period, at least.
    doublings: so many times branches are followed from period doublings.  exponents: periods of a run that measures the largest
    Lyapunov exponent at each value where no stable orbit was found. Raises `BadInput` where there is no orbit at all.
    """
    with ExitStack() as stack:
        shooting = Shooting(scene, stack, forcing, over[0] if over else "", steps)
        if over is None:
            unknown = _begun(shooting, None, after, guess)
            if isinstance(unknown, str):
                raise BadInput(
                    shooting.where, unknown, "an orbit of this period", "A longer run (after), or a multiple of the period."
                )
            return Orbits(scene, "", tuple(shooting.signals), (Branch(forcing.multiple, [shooting.orbit(unknown)]),))
        values = [float(v) for v in over[1]]
        if len(values) < 2:
            raise BadInput(shooting.where, f"{counted(len(values), 'value')} of {over[0]}", "two at least")
        branches: list[Branch] = []
        gaps: list[tuple[float, str]] = []
        for value in values:
            if any(_reached(branch, value) for branch in branches):
                continue
            progress(f"{over[0]} = {value:g}")
            unknown = _begun(shooting, value, after, guess)
            if isinstance(unknown, str):
                gaps.append((value, unknown))
                continue
            follower = _Follower(shooting, branches, values)
            branches.append(follower.both_ways(unknown, forward=values[-1] > values[0]))
        for branch in list(branches):
            _doubled(shooting, branch, branches, doublings, values)
        if not branches and not exponents:
            raise BadInput(shooting.where, f"none at {counted(len(gaps), 'value')} of {over[0]}", "an orbit", gaps[0][1])
        known = [(branch.multiple, branch.points) for branch in branches]
        regimes = tuple(motions(shooting, known, values, after, exponents)) if exponents else ()
        return Orbits(scene, over[0], tuple(shooting.signals), tuple(branches), tuple(gaps), regimes)


def _begun(shooting: Shooting, value: float | None, after: int, guess: float) -> np.ndarray | str:
    """An orbit from a run, or from one that is a period longer, or why there is none."""
    for more in range(3):
        unknown = _begun_behind(shooting, value, after + more, guess)
        if not isinstance(unknown, str):
            break
    return unknown


def _begun_behind(shooting: Shooting, value: float | None, after: int, guess: float) -> np.ndarray | str:
    try:
        unknown = shooting.solve(shooting.start(value, after, guess))
        while unknown is not None and shooting.refresh(shooting.split(unknown)[0]):
            unknown = shooting.solve(shooting.start(value, after, guess))
        if unknown is None:
            return f"no orbit of {counted(shooting.multiple, 'period')} behind {after} of them"
        return shooting.orbit(unknown).refused or unknown
    except StepFailed as error:
        return str(error)


def _reached(branch: Branch, value: float) -> bool:
    values = [point.value for point in branch.points]
    return any(min(a, b) <= value <= max(a, b) for a, b in pairwise(values)) or value in values


def _doubled(shooting: Shooting, branch: Branch, branches: list[Branch], depth: int, values: Sequence[float]) -> None:
    """Add the branches that begin at period doublings of a branch."""
    for mark in branch.marks if depth > 0 else []:
        near = NEAR * (max(values) - min(values))
        if mark.kind != DOUBLING or any(_merges(other, mark, 2 * branch.multiple, near) for other in branches):
            continue
        shooting.multiple = 2 * branch.multiple
        follower = _Follower(shooting, branches, values)
        further = follower.from_doubling(mark)
        if further is not None and len(further.points) > 1:  # one alone has joined another branch at once
            branches.append(further)
            _doubled(shooting, further, branches, depth - 1, values)
        shooting.multiple = branch.multiple
    shooting.multiple = branch.multiple


def _merges(branch: Branch, mark: Mark, multiple: int, near: float) -> bool:
    """Whether a branch of such a multiple ends at a doubling already, or as near to it."""
    ends = abs(branch.points[-1].value - mark.orbit.value) < near
    return branch.multiple == multiple and branch.ends[-1].startswith("merges") and ends


def _turned_round(before: np.ndarray, behind: np.ndarray) -> bool:
    return bool(before @ behind < -0.9 * np.linalg.norm(before) * np.linalg.norm(behind))


class _Follower:
    """Follows one branch. Unknowns are in sizes: of the states those along the first orbit, of the parameter the range's."""

    def __init__(self, shooting: Shooting, known: Sequence[Branch], values: Sequence[float]):
        """known: branches that it ends at."""
        self.shooting, self.known, self.low, self.high = shooting, known, min(values), max(values)
        self.first, self.most = abs(values[1] - values[0]) / (self.high - self.low), POINTS * len(values)

    def _joined(self, unknown: np.ndarray, multiple: int) -> bool:
        """Whether an orbit is on a branch that is known already."""
        pairs = (pair for branch in self.known if branch.multiple == multiple for pair in pairwise(branch.points))
        return any(self._between(a, b, unknown) for a, b in pairs)

    def _between(self, a: Orbit, b: Orbit, unknown: np.ndarray) -> bool:
        """Whether an orbit is all but on the straight line between two others."""
        if not min(a.value, b.value) <= unknown[-1] <= max(a.value, b.value) or a.value == b.value:
            return False
        between = a.unknown + (unknown[-1] - a.value) / (b.value - a.value) * (b.unknown - a.unknown)
        return bool(np.abs((unknown - between) / self.size)[: int(self.shooting.kept.sum())].max() < SAME)

    def _size(self, orbit: Orbit) -> np.ndarray:
        shooting = self.shooting
        z, period, _ = shooting.split(orbit.unknown)
        shooting.map.stand(z)
        largest = np.abs(z)
        for _ in range(64):
            shooting.map.block.advance(max(shooting.steps // 64, 1))
            largest = np.maximum(largest, np.where(shooting.angles, 0.0, np.abs(shooting.map.z)))
        states = np.maximum(largest[shooting.kept], 1e-12)
        return np.concatenate([states, [period] if shooting.unknown_period else [], [self.high - self.low]])

    # -- along the arc -----------------------------------------------------------------------------------------------
    def both_ways(self, unknown: np.ndarray, forward: bool) -> Branch:
        """The branch through an orbit, from where it was near onwards, and back where that is inside of the range."""
        first = self.shooting.orbit(unknown)
        self.size = self._size(first)
        branch = Branch(self.shooting.multiple, [first])
        way = self._tangent(unknown, None, 1.0 if forward else -1.0)
        onwards = self._follow(branch, first, way)
        if self.low < first.value < self.high and branch.points[-1] is not first:
            back = Branch(branch.multiple, [first])
            onwards = [*self._follow(back, first, -way), *onwards]
            branch.points[:0] = back.points[:0:-1]
            branch.marks[:0] = back.marks
        branch.ends = onwards
        return branch

    def from_doubling(self, mark: Mark) -> Branch | None:
        """The branch of the doubled period that begins at a doubling; None where none is near."""
        shooting, at = self.shooting, mark.orbit.unknown
        shooting.base, shooting.pinned = shooting.split(at)[0], at[: int(shooting.kept.sum())].copy()
        shooting.steps = shooting.steps_of(mark.orbit.period) // 2
        shooting.steps *= 2
        direction = self._eigenvector(at, -1.0)
        if shooting.unknown_period:
            at = at.copy()
            at[-2] *= 2.0
        self.size = self._size(mark.orbit)
        if shooting.unknown_period:
            self.size[-2] *= 2.0
        direction = np.concatenate([direction, np.zeros(at.size - direction.size)]) / self.size
        direction /= np.linalg.norm(direction)
        for length in APART:
            near = self._correct(at + length * direction * self.size, direction)
            if near is not None and np.linalg.norm(self._apart(near)) > MERGED:
                first = shooting.orbit(near)
                branch = Branch(shooting.multiple, [first])
                way = self._tangent(near, direction, 0.0)
                branch.ends = ["merges at the doubling that it begins at", *self._follow(branch, first, way)]
                return branch
        return None

    def _eigenvector(self, unknown: np.ndarray, value: float) -> np.ndarray:
        """Of the derivative over the single period, nearest to a value."""
        shooting = self.shooting
        multiple, steps = shooting.multiple, shooting.steps
        shooting.multiple, shooting.steps = multiple // 2, steps // 2
        self._equations(unknown)
        shooting.multiple, shooting.steps = multiple, steps
        values, vectors = np.linalg.eig(shooting.derivative)
        return np.real(vectors[:, np.argmin(np.abs(values - value))])

    def _apart(self, unknown: np.ndarray) -> np.ndarray:
        """From the first half of a doubled orbit to the second, in sizes."""
        shooting = self.shooting
        z, period, p = shooting.split(unknown)
        shooting.map.begin(p, period / shooting.steps, shooting.steps)
        half = np.where(shooting.angles, z, shooting.map.run(z, shooting.steps // 2))
        return np.asarray((half - z)[shooting.kept] / self.size[: shooting.kept.sum()])

    def _equations(self, unknown: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.shooting.equations(unknown)

    def _tangent(self, unknown: np.ndarray, before: np.ndarray | None, sign: float) -> np.ndarray:
        """Along the branch, in sizes; on from the tangent before, or in the direction of the parameter by a sign."""
        _, matrix = self._equations(unknown)
        tangent = np.linalg.svd(matrix * self.size)[2][-1]
        way = np.sign(tangent[-1]) * sign if before is None else np.sign(tangent @ before)
        return tangent * (way or 1.0)

    def _correct(self, unknown: np.ndarray, way: np.ndarray) -> np.ndarray | None:
        """The orbit nearest to a prediction, across the way; None where there is none."""

        def bordered(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            residual, matrix = self._equations(x)
            return np.append(residual, way @ ((x - unknown) / self.size)), np.vstack([matrix, way / self.size])

        try:
            solution = newton(bordered, unknown, most=8)
        except StepFailed:
            return None
        self.corrections = solution.steps
        return solution.x if solution.converged and (solution.left <= INSIDE).all() else None

    def _predicted(self, unknown: np.ndarray, way: np.ndarray, length: float) -> np.ndarray | None:
        shooting = self.shooting
        ahead = unknown + length * way * self.size
        shooting.base = shooting.split(unknown)[0]
        shooting.pinned = unknown[: int(shooting.kept.sum())].copy()
        shooting.steps = shooting.steps_of(float(ahead[-2]) if shooting.unknown_period else shooting.period(ahead[-1:]))
        near = self._correct(ahead, way)
        if near is None or np.linalg.norm((near - ahead) / self.size) > 0.5 * length + 1e-9:
            return None
        return near

    def _follow(self, branch: Branch, point: Orbit, way: np.ndarray) -> list[str]:
        """Add points to a branch until it leaves the range; why it ends."""
        length, shortest, first, begun = self.first, SHORTEST * self.first, point, way
        doubled = self.shooting.multiple > self.shooting.forcing.multiple
        apart = self._apart(point.unknown) if doubled else np.zeros(0)
        for done in range(self.most):
            unknown = self._predicted(point.unknown, way, length)
            if unknown is None:
                length *= 0.5
                if length < shortest:
                    return [f"no orbit next to {point.value:g}"]
                continue
            ahead = self.shooting.orbit(unknown)
            if doubled:
                before_apart, apart = apart, self._apart(unknown)
                small = np.linalg.norm(apart) < 5.0 * MERGED
                if not small and _turned_round(before_apart, apart) and length > shortest:  # beyond it halves are exchanged
                    length, apart = max(0.5 * length, shortest), before_apart
                    continue
                if small or _turned_round(before_apart, apart):
                    branch.points.append(ahead)
                    return [f"merges with the branch of half its period at {ahead.value:g}"]
            if ahead.refused:
                return [f"at {ahead.value:g} {ahead.refused}"]
            if done > LOOP and way @ begun > 0.0 and self._between(point, ahead, first.unknown):
                branch.points.append(first)
                return [f"closes at {first.value:g}"]
            if self._joined(unknown, branch.multiple):
                return [f"joins a branch at {ahead.value:g}"]
            if _beyond(ahead) != _beyond(point):
                branch.marks.append(self._located(point, ahead, way, length))
            if not self.low <= ahead.value <= self.high:
                bound = min(max(ahead.value, self.low), self.high)
                between = (bound - point.value) / (ahead.value - point.value)
                last = self.shooting.solve(np.append((point.unknown + between * (unknown - point.unknown))[:-1], bound))
                if last is not None:
                    branch.points.append(self.shooting.orbit(last))
                return [f"the range ends at {bound:g}"]
            before, states = self.size, slice(0, int(self.shooting.kept.sum()))
            self.size = before.copy()
            self.size[states] = np.maximum(before, np.abs(unknown))[states]
            turned, way = self._tangent(unknown, way * before / self.size, 0.0), way * before / self.size
            way /= np.linalg.norm(way)
            branch.points.append(ahead)
            if self.corrections <= 3 and turned @ way > 0.97:
                length = min(1.5 * length, LONGEST)
            elif turned @ way < 0.8:
                length = max(0.5 * length, shortest)
            point, way = ahead, turned
            length = min(length, self.first / max(abs(way[-1]), 1e-12))
        return [f"{self.most} points"]

    # -- bifurcations ------------------------------------------------------------------------------------------------
    def _located(self, before: Orbit, behind: Orbit, way: np.ndarray, length: float) -> Mark:
        """The bifurcation between two orbits, by bisection along the arc."""
        low, high, left, right = 0.0, length, before, behind
        for _ in range(BISECTIONS):
            for share in (0.5, 0.3, 0.7):  # a prediction may lead Newton's method astray
                middle = low + share * (high - low)
                unknown = self._predicted(before.unknown, way, middle)
                if unknown is not None:
                    break
            else:
                break
            orbit = self.shooting.orbit(unknown)
            if _beyond(orbit) == _beyond(before):
                low, left = middle, orbit
            else:
                high, right = middle, orbit
            if high - low < 1e-7 * length:
                break
        return self._named(left, right, way)

    def _named(self, left: Orbit, right: Orbit, way: np.ndarray) -> Mark:
        nearest = [min(o.multipliers, key=lambda value: abs(abs(value) - 1.0)) for o in (left, right)]
        orbit, value = min(zip((left, right), nearest, strict=True), key=lambda item: abs(abs(item[1]) - 1.0))
        value = complex(value)
        if max(abs(abs(v) - 1.0) for v in nearest) > ON_CIRCLE:
            return Mark(COLLISION, orbit, value)
        if abs(value.imag) > ON_CIRCLE:
            return Mark(TORUS, orbit, value)
        if value.real < 0.0:
            return Mark(DOUBLING, orbit, value)
        turns = [self._tangent(o.unknown, way, 0.0)[-1] for o in (left, right)]
        steep = max(abs(t) for t in turns) < 0.05 or turns[0] * turns[1] < 0.0
        return Mark(FOLD if steep else BRANCH, orbit, value)


def _beyond(orbit: Orbit) -> int:
    return int((np.abs(orbit.multipliers) > 1.0).sum())
