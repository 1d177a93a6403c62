"""The solution that errors are measured against, how far it can be trusted, and what it shares with the runs it judges.

Where all units are smooth, the scene is one differential equation: SciPy's DOP853 solves it, and LSODA once more. Otherwise the
master itself does, with much shorter steps than any that is measured and another algorithm, and a second time with yet another
one: the distance of the two estimates the error of coupling and integration. A mesh is part of the model in both, and refining
steps does not show its error: the reference has a finer one, whose remaining error is extrapolated (Richardson) from three
meshes. A scene's monolith, where it names one, is a further solution.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import inf, log2
from time import perf_counter
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from ....components.core.errors import BadInput
from ...scene.scene import Scene
from ...scene.shorter_steps import refined, with_mesh
from ...settings.algorithms import ALGORITHMS
from ..journal import once
from .coupled_ode import CoupledOde
from .quantities import Quantity, TimeHistory, errors
from .settings_axes import DEGREES, coupling_changes
from .trial import trial

METHODS = (("DOP853", 1e-11), ("LSODA", 1e-9), ("Radau", 1e-9))  # the first two that come to the end
PATIENCE = 60.0  # s, for one solution, while there are others to try
FINER = 2  # times the finest macro step that is measured, and times the scene's internal steps
FINER_MESH = 0.5  # times the lengths of the scene's elements
ORDERS = (1.0, 2.0)  # between which the order of a mesh is taken, whatever three meshes show
# algorithm and degree of the inputs, of which the first two that come to the end are taken
MASTERS = (("iterative", 2), ("gauss-seidel", 1), ("gauss-seidel", 2), ("jacobi", 1), ("iterative", 1), ("gauss-seidel", 0))
PROBED = 100  # macro steps, from whose time that of a run is estimated
TOLERANCE = 1e-10  # of the iteration
EQUATIONS, INTEGRATORS, COUPLING, MESH = (
    "the components' equations",
    "the components' integrators",
    "the coupling",
    "the kind of mesh",
)


class _TooLong(Exception):
    pass


@dataclass(frozen=True)
class Solution:
    """A solution of a scene. method: in words.  shares: what it has in common with the runs it is compared with."""

    method: str
    history: TimeHistory
    shares: tuple[str, ...]


@dataclass(frozen=True)
class Reference:
    """Reference solution. shares: see `Solution`.

    second: other solutions of the scene by their methods, their errors by quantity, of the quantities that they have.
    By quantity, mesh_error: of the mesh that it has; between_samples: of an extreme that falls between two samples.
    """

    history: TimeHistory
    method: str
    second: Mapping[str, Mapping[str, float]]
    shares: tuple[str, ...] = ()
    mesh_error: Mapping[str, float] = field(default_factory=dict)
    between_samples: Mapping[str, float] = field(default_factory=dict)

    @property
    def agreement(self) -> dict[str, float]:
        """By quantity the largest distance of a second solution, and of an extreme what may lie between two samples."""
        every = self.second.values()
        names = dict.fromkeys(name for of in every for name in of)
        return {n: max(of[n] for of in every if n in of) + self.between_samples.get(n, 0.0) for n in names}

    @property
    def uncertainty(self) -> dict[str, float]:
        """By quantity the reference's own error: of coupling and integration as second solutions show it, and of the mesh."""
        return {name: error + self.mesh_error.get(name, 0.0) for name, error in self.agreement.items()}


def reference(
    scene: Scene, quantities: Sequence[Quantity], finest: float, on_message: Callable[[str], None] = lambda text: None
) -> Reference:
    """The reference of a scene for runs whose macro steps are no shorter than `finest`, s.

    `on_message` gets what is being done. Raises `BadInput` where fewer than two solutions come to the end.
    """
    signals = list(dict.fromkeys(q.signal for q in quantities))
    mesh = mesh_error(scene, quantities, on_message)
    finer = scene.with_changes(with_mesh(scene, FINER_MESH)) if mesh else scene
    solutions = _solutions(finer, signals, finest, on_message)
    if len(solutions) < 2:
        raise BadInput(
            f"{scene.name}: reference",
            f"{len(solutions)} solutions that come to the end",
            "two that can be compared",
            "Shorten the run, or its macro step.",
        )
    first, *others = solutions
    second = {other.method: errors(quantities, other.history, first.history) for other in others}
    if scene.study.monolith is not None:
        second |= _monolith(scene, quantities, first.history, finest, on_message)
    method = f"{first.method}, elements x {FINER_MESH:g}" if mesh else first.method
    return Reference(
        first.history,
        method,
        second,
        (*first.shares, MESH) if mesh else first.shares,
        mesh,
        {q.name: q.between_samples(first.history) for q in quantities},
    )


def mesh_error(
    scene: Scene, quantities: Sequence[Quantity], on_message: Callable[[str], None] = lambda text: None
) -> dict[str, float]:
    """By quantity the error of a mesh of `FINER_MESH` times the scene's; empty where the scene's [study] names no mesh.

    Three runs with the scene's own settings, elements of 2, 1 and 1/2 times the scene's: with the distances d1 of the first two
    and d2 of the last two the order is log2(d1 / d2), and what remains behind the last is d2 / (2^order - 1) (Richardson). The
    order is taken within `ORDERS`. Raises `BadInput` where one of the runs fails.
    """
    if not scene.study.mesh:
        return {}
    histories = []
    for factor in (2.0, 1.0, FINER_MESH):
        on_message(f"elements x {factor:g}")
        history = _run(scene, with_mesh(scene, factor))
        if history is None:
            raise BadInput(
                f"{scene.name}: study.mesh",
                f"a run with elements x {factor:g} that fails",
                "meshes from twice to half the scene's",
                "Shorten the elements, or the steps.",
            )
        histories.append(history)
    coarse, fine = errors(quantities, *histories[:2]), errors(quantities, *histories[1:])
    return {name: remaining_error(coarse[name], fine[name]) for name in fine}


def remaining_error(coarse: float, fine: float) -> float:
    """Error behind the finest of three meshes, each half as long as the one before, from the two distances between them."""
    order = log2(coarse / fine) if coarse > 0.0 and fine > 0.0 else ORDERS[0]
    return fine / (2.0 ** min(max(order, ORDERS[0]), ORDERS[1]) - 1.0)


def _solutions(scene: Scene, signals: Sequence[str], finest: float, on_message: Callable[[str], None]) -> list[Solution]:
    """The reference and another solution, as far as they come to the end."""
    solutions: list[Solution] = []
    try:
        CoupledOde(scene)
        for method, tolerance in METHODS:
            if len(solutions) < 2:
                on_message(f"reference: SciPy {method}")
                how = scene, signals, finest, method, tolerance
                history = once("solution", how, partial(solved_as_ode, *how), TimeHistory)
                if history is not None:
                    text = f"one differential equation, SciPy {method}, tolerance {tolerance:g}"
                    solutions.append(Solution(text, history, (EQUATIONS,)))
    except BadInput:
        pass
    tried: set[tuple[str, int]] = set()
    for patience in (PATIENCE, inf):  # what takes too long comes last
        for algorithm, degree in (*MASTERS, (scene.master.algorithm, 1)) if scene.coupling.links else MASTERS[:2]:
            if len(solutions) < 2 and (algorithm, degree) not in tried:
                method, changes = _finer(scene, signals, finest, algorithm, degree, 1.0 / (4 if not solutions else 2))
                if _expected(scene, changes) > patience:
                    continue
                tried.add((algorithm, degree))
                on_message(f"reference: {method}")
                if (history := _run(scene, changes)) is not None:
                    shares = (EQUATIONS, INTEGRATORS, *((COUPLING,) if scene.coupling.links else ()))
                    solutions.append(Solution(method, history, shares))
    return solutions


def solved_as_ode(
    scene: Scene, signals: Sequence[str], step: float, method: str, tolerance: float, patience: float = PATIENCE
) -> TimeHistory | None:
    """The scene as one differential equation at multiples of `step`, s; None where it takes longer than `patience`, s.

    Absolute tolerances are that share of the largest value a coarse solution gives each state.
    """
    ode = CoupledOde(scene)
    end = perf_counter() + patience

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        if perf_counter() > end:
            raise _TooLong
        return ode(t, x)

    count, span = max(round(scene.duration / step), 1), (scene.start_time, scene.stop_time)
    time = np.linspace(*span, count + 1)
    try:
        coarse = solve_ivp(rates, span, ode.start, "LSODA", rtol=1e-4, atol=1e-9)
        size = np.abs(coarse.y).max(axis=1)
        size = np.where(size > 0.0, size, size.max())
        fine = solve_ivp(rates, span, ode.start, method, time, rtol=tolerance, atol=tolerance * size)
        if not (coarse.success and fine.success and np.isfinite(fine.y).all()):
            return None
        return ode.history(time, fine.y.T, signals)
    except (_TooLong, BadInput):  # BadInput: a state at which outputs do not converge
        return None


def _finer(
    scene: Scene, signals: Sequence[str], finest: float, algorithm: str, degree: int, factor: float
) -> tuple[str, dict[str, Any]]:
    """How a solution by the master is called, and its changes; without connections only the internal steps matter."""
    step = finest / FINER
    changes: dict[str, Any] = {
        **refined(scene, factor),
        "master.step": step,
        "record.signals": list(signals),
        "record.interval": None,
        "record.snapshots": (),
        "record.snapshot_interval": None,
    }
    how = f"internal steps / {round(1.0 / factor)}"
    if scene.coupling.links:
        changes |= coupling_changes(scene, algorithm, degree)
        changes |= (
            {"master.iteration": {"tolerance": TOLERANCE, "max_iterations": 50}}
            if "iteration" in ALGORITHMS[algorithm].options
            else {}
        )
        how = f"{algorithm}, {DEGREES[degree]} inputs, macro step {step:.3g} s, {how}"
    return how, changes


def _expected(scene: Scene, changes: Mapping[str, Any]) -> float:
    """What a run will take, s, by its first steps; 0 where these cannot be made, which the run itself will tell."""
    length = min(scene.duration, PROBED * changes["master.step"])
    first = trial(scene, {**changes, "stop_time": scene.start_time + length}, repeats=1)
    return first.seconds * scene.duration / length if first.times else 0.0


def _run(scene: Scene, changes: Mapping[str, Any]) -> TimeHistory | None:
    """What the scene with changes records; None where it does not start, or does not come to its end."""
    one = trial(scene, changes, repeats=1)
    return one.history if one.done else None


def _monolith(
    scene: Scene, quantities: Sequence[Quantity], history: TimeHistory, finest: float, on_message: Callable[[str], None]
) -> dict[str, dict[str, float]]:
    """Method -> errors of the scene's monolith, in the quantities it has; raises `BadInput` for signals it lacks, or where it fails."""
    given = scene.study.monolith
    assert given is not None
    whole = scene.load_other(given.scene).with_changes({"start_time": scene.start_time, "stop_time": scene.stop_time})
    outputs = {f"{unit}.{name}" for unit, interface in whole.coupling.interfaces.items() for name in interface.outputs}
    names = {q.signal: given.signals.get(q.signal, q.signal) for q in quantities}
    names = {ours: theirs for ours, theirs in names.items() if theirs in outputs}
    if not names:
        raise BadInput(
            f"{scene.name}: study.monolith", f"{given.scene!r}, with none of the signals", "signals = { ours = theirs }"
        )
    solutions = _solutions(whole, list(names.values()), finest, on_message)
    if not solutions:
        raise BadInput(
            f"{scene.name}: study.monolith", f"{given.scene!r}, of which no solution comes to the end", "one that does"
        )
    solution = solutions[0]
    columns = {ours: solution.history.columns[theirs] for ours, theirs in names.items()}
    kept = [q for q in quantities if q.signal in columns]
    return {f"{given.scene}: {solution.method}": errors(kept, TimeHistory(solution.history.time, columns), history)}
