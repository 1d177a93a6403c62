"""The solution that errors are measured against, and a second, independent one that tells how far it can be trusted.

Where all units are smooth, the scene is one differential equation: SciPy's DOP853 solves it, and LSODA once more. Else the
master itself does, far finer than what is measured and with another algorithm, and a second time with yet another one on a
coarser step: what both agree in is the reference's own accuracy. A scene's monolith, where it names one, is a further witness.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from time import perf_counter
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from ....components.core.errors import BadInput
from ...engine.coupling import resolve_coupling
from ...results import Result
from ...run import run
from ...scene.scene import Scene, load_scene
from .coupled_ode import CoupledOde
from .knobs import DEGREES, coupling_changes, refined
from .quantities import Course, Quantity, errors

METHODS = (("DOP853", 1e-11), ("LSODA", 1e-9), ("Radau", 1e-9))  # the first two that come to the end
PATIENCE = 60.0  # s, for one solution, while there are others to try
FINER = 2  # times the finest macro step that is measured, and times the scene's internal steps
# algorithm and degree of the inputs, of which the first two that come to the end are taken
MASTERS = (("iterative", 2), ("gauss-seidel", 1), ("gauss-seidel", 2), ("jacobi", 1), ("iterative", 1), ("gauss-seidel", 0))
PROBED = 100  # macro steps, to tell how long a run will take
TOLERANCE = 1e-10  # of the iteration


class _TooLong(Exception):
    pass


@dataclass(frozen=True)
class Witness:
    """Another solution of the same scene. errors: by quantity, against the reference; those it cannot tell are missing."""

    how: str
    errors: Mapping[str, float]

    @property
    def worst(self) -> float:
        """The largest of them."""
        return max(self.errors.values(), default=float("nan"))


@dataclass(frozen=True)
class Reference:
    """What errors are measured against. how: in words.  agreement: by quantity, the largest distance of a witness."""

    course: Course
    how: str
    witnesses: tuple[Witness, ...]

    @property
    def agreement(self) -> dict[str, float]:
        """By quantity the largest distance of a witness: smaller errors than that are below the reference's own."""
        names = dict.fromkeys(name for witness in self.witnesses for name in witness.errors)
        return {name: max(w.errors[name] for w in self.witnesses if name in w.errors) for name in names}

    @property
    def floor(self) -> float:
        """The largest of the agreements: no smaller error of a run is known."""
        return max(self.agreement.values(), default=float("inf"))


def reference(scene: Scene, quantities: Sequence[Quantity], finest: float,
              told: Callable[[str], None] = lambda text: None) -> Reference:
    """The reference of a scene for runs whose macro steps are no shorter than `finest`, s.

    `told` hears what is being done. Raises `BadInput` where fewer than two solutions come to the end.
    """
    signals = list(dict.fromkeys(q.signal for q in quantities))
    solved = _solutions(scene, signals, finest, told)
    if len(solved) < 2:
        raise BadInput(f"{scene.name}: reference", f"{len(solved)} solutions that come to the end", "two that can be compared",
                       "Shorten the run, or its macro step.")
    (how, course), *others = solved
    witnesses = [Witness(other, errors(quantities, found, course)) for other, found in others]
    if scene.study.monolith is not None:
        witnesses.append(_monolith(scene, quantities, course, finest, told))
    return Reference(course, how, tuple(witnesses))


def _solutions(scene: Scene, signals: Sequence[str], finest: float, told: Callable[[str], None]) -> list[tuple[str, Course]]:
    """(how, course) of the reference and of another solution, as far as they come to the end."""
    found: list[tuple[str, Course]] = []
    try:
        CoupledOde(scene)
        for method, tolerance in METHODS:
            if len(found) < 2:
                told(f"reference: SciPy {method}")
                course = solved_as_ode(scene, signals, finest, method, tolerance)
                found += [(f"one differential equation, SciPy {method}, tolerance {tolerance:g}", course)] if course else []
    except BadInput:
        pass
    tried: set[tuple[str, int]] = set()
    for patience in (PATIENCE, inf):  # what takes too long comes last
        for algorithm, degree in (*MASTERS, (scene.master.algorithm, 1)) if resolve_coupling(scene).links else MASTERS[:2]:
            if len(found) < 2 and (algorithm, degree) not in tried:
                how, changes = _finer(scene, signals, finest, algorithm, degree, 1.0 / (4 if not found else 2))
                if _expected(scene, changes) > patience:
                    continue
                tried.add((algorithm, degree))
                told(f"reference: {how}")
                course = _run(scene, changes)
                found += [(how, course)] if course else []
    return found


def solved_as_ode(scene: Scene, signals: Sequence[str], step: float, method: str, tolerance: float,
                  patience: float = PATIENCE) -> Course | None:
    """The scene as one differential equation at multiples of `step`, s; None where it takes longer than `patience`, s.

    Absolute tolerances are that share of the largest value a coarse solution gives each state.
    """
    ode = CoupledOde(scene)
    end = perf_counter() + patience

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        if perf_counter() > end:
            raise _TooLong
        return ode(t, x)

    count = max(round(scene.stop_time / step), 1)
    time = np.linspace(0.0, scene.stop_time, count + 1)
    try:
        coarse = solve_ivp(rates, (0.0, scene.stop_time), ode.start, "LSODA", rtol=1e-4, atol=1e-9)
        size = np.abs(coarse.y).max(axis=1)
        size = np.where(size > 0.0, size, size.max())
        fine = solve_ivp(rates, (0.0, scene.stop_time), ode.start, method, time, rtol=tolerance, atol=tolerance * size)
        if not (coarse.success and fine.success and np.isfinite(fine.y).all()):
            return None
        return ode.course(time, fine.y.T, signals)
    except (_TooLong, BadInput):  # BadInput: a state at which outputs no longer come to stand
        return None


def _finer(scene: Scene, signals: Sequence[str], finest: float, algorithm: str, degree: int,
           factor: float) -> tuple[str, dict[str, Any]]:
    """How a solution by the master is called, and its changes; without connections only the internal steps matter."""
    step = finest / FINER
    changes: dict[str, Any] = {**refined(scene, factor), "master.step": step, "record.signals": list(signals),
                               "record.interval": None, "record.snapshots": (), "record.snapshot_interval": None}
    how = f"internal steps / {round(1.0 / factor)}"
    if resolve_coupling(scene).links:
        changes |= coupling_changes(scene, algorithm, degree)
        changes |= {"master.iteration": {"tolerance": TOLERANCE, "max_iterations": 50}} if algorithm == "iterative" else {}
        how = f"{algorithm}, {DEGREES[degree]} inputs, macro step {step:.3g} s, {how}"
    return how, changes


def _expected(scene: Scene, changes: Mapping[str, Any]) -> float:
    """What a run will take, s, by its first steps; 0 where these cannot be made, which the run itself will tell."""
    stop = min(scene.stop_time, PROBED * changes["master.step"])
    times = []
    try:
        for _ in range(2):  # the first one compiles
            result = run(scene.with_changes({**changes, "stop_time": stop}), in_process=True)
            times.append(result.info["timing"]["run"])
    except BadInput:
        return 0.0
    return min(times) * scene.stop_time / stop


def _run(scene: Scene, changes: Mapping[str, Any]) -> Course | None:
    try:
        result: Result = run(scene.with_changes(changes), in_process=True)
    except BadInput:  # an algorithm that cannot step these units
        return None
    return Course(result.time, result.columns) if result.outcome == "done" else None


def _monolith(scene: Scene, quantities: Sequence[Quantity], course: Course, finest: float,
              told: Callable[[str], None]) -> Witness:
    """What the scene's monolith says of the quantities it has; raises `BadInput` for signals it lacks, or where it fails."""
    given = scene.study.monolith
    assert given is not None
    whole = load_scene(given.scene).with_changes({"stop_time": scene.stop_time})
    there = {f"{unit}.{name}" for unit, interface in resolve_coupling(whole).interfaces.items() for name in interface.outputs}
    names = {q.signal: given.signals.get(q.signal, q.signal) for q in quantities}
    names = {ours: theirs for ours, theirs in names.items() if theirs in there}
    if not names:
        raise BadInput(f"{scene.name}: study.monolith", f"{given.scene!r}, with none of the signals",
                       "signals = { ours = theirs }")
    solved = _solutions(whole, list(names.values()), finest, told)
    if not solved:
        raise BadInput(f"{scene.name}: study.monolith", f"{given.scene!r}, of which no solution comes to the end",
                       "one that does")
    how, found = solved[0]
    columns = {ours: found.columns[theirs] for ours, theirs in names.items()}
    kept = [q for q in quantities if q.signal in columns]
    return Witness(f"{given.scene}: {how}", errors(kept, Course(found.time, columns), course))
