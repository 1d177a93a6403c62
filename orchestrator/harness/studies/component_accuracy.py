"""One component alone: what its own integrator's accuracy costs, and what SciPy's methods would need for the same equations.

Its inputs follow a slow wave of a fraction of their nominal values, handed over as the parabolas that a master gives, or are
held. The component's own integrator is measured over its internal step; for a component that is a smooth differential equation,
SciPy's methods solve the same compiled right-hand side for the same inputs, and DOP853 is the reference.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from math import inf
from time import perf_counter, process_time
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from ....components.catalogue import component_class
from ....components.core.component import Component
from ....components.core.errors import BadInput, StepFailed
from ..journal import once
from .accuracy import OWN, PATIENCE, Accuracy, Point, judged, machine_name, versions, with_finer_errors
from .coupled_ode import rate_kernel
from .quantities import Quantity, TimeHistory, errors
from .reference import EQUATIONS, INTEGRATORS, Solution
from .trial import REPEATS, WORK, Trial, repeated_trial

SUBSTEPS = (8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.125)  # times the component's own
FINER = (32.0, 16.0)  # the internal steps of the reference and of the second solution, where the component solves itself
METHODS = ("RK45", "DOP853", "LSODA", "Radau", "BDF")
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
REFERENCE, SECOND = ("DOP853", 1e-12), ("Radau", 1e-10)
WAVES = 2.0  # of the inputs, in the time simulated
SHARE = 0.05  # of an input's nominal value: the wave's amplitude
STEPS = 2000  # most macro steps of a run
BUDGET = 30.0  # s


def waves(start: np.ndarray, sizes: np.ndarray, stop: float, t: np.ndarray) -> np.ndarray:
    """Inputs (n, m) at the times (n,), s: `WAVES` waves from `start` to `sizes` beyond it and back in `stop` s."""
    return start + 0.5 * (1.0 - np.cos(2.0 * np.pi * WAVES / stop * t))[:, None] * sizes


def parabolas(values: np.ndarray, step: float) -> np.ndarray:
    """Inputs with their derivatives, (n, 3, m), of n steps of so many s, through values (2 n + 1, m) at their ends and middles."""
    left, middle, right = values[:-1:2], values[1::2], values[2::2]
    return np.stack([left, (4.0 * middle - 3.0 * left - right) / step, 2.0 * (left - 2.0 * middle + right) / step**2], axis=1)


def integrated(component: Component, inputs: np.ndarray, step: float) -> tuple[np.ndarray, float]:
    """Outputs, (n + 1, outputs), behind n steps of so many s with inputs (n, 3, m), and their CPU time, s.

    The component has not been initialized. Raises `BadInput` and `StepFailed`.
    """
    component.u[0] = inputs[0, 0]
    component.initialize(0.0)
    rows, advance = np.empty((len(inputs) + 1, component.y.size)), component.step
    rows[0] = component.y
    start_time = process_time()
    for k, polynomial in enumerate(inputs):
        component.u[:] = polynomial
        advance(k * step, step)
        rows[k + 1] = component.y
    return rows, process_time() - start_time


class ComponentRun:
    """A component with inputs that are known functions of time.

    Integrated over `stop` s in macro steps of `step` s, by itself (`own`) or by a method of SciPy (`by_scipy`).
    """

    def __init__(
        self,
        name: str,
        effects: tuple[str, ...] = (),
        parameters: Mapping[str, Any] | None = None,
        stop: float | None = None,
        preset: str = "",
    ):
        self.cls: type[Component] = component_class(name, "component")
        self.effects, self.parameters, self.preset = effects, dict(parameters or {}), preset
        self.key = (self.cls, effects, self.parameters, stop, preset)  # for a study's journal
        first = self.make()
        self.stop = stop or self.cls.default_stop
        self.steps = max(min(round(self.stop / self.cls.default_step), STEPS), 4)
        self.step = self.stop / self.steps
        sizes = [SHARE * first.variables[n].nominal if n not in self.parameters else 0.0 for n in first.inputs]
        grid = np.linspace(0.0, self.stop, 2 * self.steps + 1)
        self.inputs = parabolas(waves(first.u[0], np.array(sizes), self.stop, grid), self.step)
        self.kernel = rate_kernel(self.cls)

    def make(self, substep: float | None = None) -> Component:
        """A component that has not been initialized."""
        more = {} if substep is None else {"substep": substep}
        return self.cls(self.effects, {**self.parameters, **more}, preset=self.preset)

    def own(self, substep: float | None = None) -> Trial:
        """The outputs by the component's own integrator; raises `BadInput` and `StepFailed`."""
        component = self.make(substep)
        rows, seconds = integrated(component, self.inputs, self.step)
        return self._trial(component, rows, seconds, component.work)

    def by_scipy(self, method: str, tolerance: float, patience: float = inf, longest: float = inf) -> Trial:
        """The outputs by `solve_ivp` with the component's right-hand side; raises `StepFailed` where that gives up.

        longest: s, of its steps; one macro step keeps the kinks of the inputs out of them.
        """
        component, kernel = self.make(), self.kernel
        assert kernel is not None
        component.u[0] = self.inputs[0, 0]
        component.initialize(0.0)
        start, arguments, dx = component.x.copy(), component.arguments, np.empty_like(component.x)  # type: ignore[attr-defined]
        inputs, h, last = self.inputs, self.step, self.steps - 1
        time = np.linspace(0.0, self.stop, self.steps + 1)
        least = tolerance * np.abs(start).max(initial=1e-3)
        end = perf_counter() + patience

        def rates(t: float, x: np.ndarray) -> np.ndarray:
            k = min(int(t / h), last)
            s = t - k * h
            kernel(t, x, inputs[k, 0] + s * (inputs[k, 1] + s * inputs[k, 2]), dx, *arguments)
            if perf_counter() > end:
                raise StepFailed(method, t, f"took longer than {patience:.2g} s", "")
            return dx.copy()

        start_time = process_time()
        solved = solve_ivp(rates, (0.0, self.stop), start, method, time, rtol=tolerance, atol=least, max_step=longest)
        seconds = process_time() - start_time
        if not solved.success or not np.isfinite(solved.y).all():
            raise StepFailed(method, float(solved.t[-1]) if solved.t.size else 0.0, str(solved.message), "")
        rows = np.empty((time.size, component.y.size))
        for k, (t, x) in enumerate(zip(time.tolist(), solved.y.T, strict=True)):
            component.x[:], component.t = x, t
            component.u[0] = inputs[k, 0] if k <= last else inputs[last, 0] + h * (inputs[last, 1] + h * inputs[last, 2])
            component.refresh()
            rows[k] = component.y
        return self._trial(component, rows, seconds, {"derivative_calls": int(solved.nfev)})

    def _trial(self, component: Component, rows: np.ndarray, seconds: float, counters: Mapping[str, int]) -> Trial:
        work = {n: int(counters.get({"unit_steps": "steps"}.get(n, n), 0)) for n in WORK} | {"calls": max(counters.values())}
        time = np.linspace(0.0, self.stop, self.steps + 1)
        return Trial("done", "", (seconds,), work, time, dict(zip(component.outputs, rows.T, strict=True)))


def component_accuracy(
    name: str,
    effects: tuple[str, ...] = (),
    parameters: Mapping[str, Any] | None = None,
    *,
    preset: str = "",
    stop: float | None = None,
    budget: float = BUDGET,
    repeats: int = REPEATS,
    on_message: Callable[[str], None] = lambda text: None,
) -> Accuracy:
    """Measure a component of the catalogue alone; raises `BadInput` where it integrates nothing."""
    one = ComponentRun(name, effects, parameters, stop, preset=preset)
    probe = one.make()
    probe.initialize(0.0)
    usual = float(probe.get("substep")) if "substep" in probe.parameters else None
    if not probe.x.size or (usual is None and one.kernel is None):
        raise BadInput(
            f"component:{name}",
            "nothing that is integrated with steps to choose",
            "a component with a parameter substep, or a differential equation",
        )
    truth, second = _solutions(one, usual, on_message)
    quantities = [
        Quantity(f"{n}, time history", n, "time history", 0.0, 0.0, v.nominal, v.unit)
        for n in probe.outputs
        for v in [probe.variables[n]]
    ]
    agreement = errors(quantities, second.history, truth.history)
    points: list[Point] = []
    timed: dict[str, Any] = {"repeats": repeats, "patience": PATIENCE * budget, "confirm": repeats > 1}

    def measure(series: str, size: float, solve: Callable[[], Trial]) -> None:
        on_message(f"{series}, {size:.3g}")
        axis = "own" if series == OWN else "method" if series.startswith("SciPy") else "substep"
        run = once("component", (*one.key, timed, budget, series, size), partial(repeated_trial, solve, **timed), Trial)
        points.append(judged(Point(series, axis, size, {}, ""), run, quantities, truth.history, agreement))

    one.own(), one.own()  # compiled, and its caches warm
    measure(OWN, usual or one.step, one.own)
    if usual is not None:
        longest = min(one.step, probe.stable_step())
        for size in sorted({min(factor * usual, max(longest, usual)) for factor in SUBSTEPS}, reverse=True):
            measure("its own integrator, substeps", size, partial(one.own, size))
    if one.kernel is not None:
        for method in METHODS:
            for tolerance in TOLERANCES:
                measure(f"SciPy {method}", tolerance, partial(one.by_scipy, method, tolerance, 0.05 * budget))
    title = ", ".join([f"{one.cls.title} alone", *([preset] if preset else []), f"{one.stop:g} s"])
    return Accuracy(
        f"component:{name}",
        title,
        tuple(with_finer_errors(points)),
        truth.method,
        second.method,
        agreement,
        machine_name(),
        versions(),
        ", ".join(truth.shares),
    )


def _solutions(one: ComponentRun, usual: float | None, on_message: Callable[[str], None]) -> list[Solution]:
    """The reference and a second solution; raises `BadInput` where there are no two."""
    solutions: list[Solution] = []

    def solve(method: str, by: Callable[[], Trial], *shares: str) -> None:
        def history() -> TimeHistory | None:
            with suppress(StepFailed):
                return by().history
            return None

        on_message(f"reference: {method}")
        if (solved := once("solution", (*one.key, method), history, TimeHistory)) is not None:
            solutions.append(Solution(method, solved, (EQUATIONS, *shares)))

    for method, tolerance in (REFERENCE, SECOND) if one.kernel is not None else ():
        solve(f"SciPy {method}, tolerance {tolerance:g}", partial(one.by_scipy, method, tolerance, 30.0, one.step))
    for factor in FINER if usual is not None else ():
        if len(solutions) < 2 and usual is not None:
            name = f"its own integrator, substep / {factor:g}"
            solve(name, partial(one.own, min(usual, one.step) / factor), INTEGRATORS)
    if len(solutions) < 2:
        raise BadInput(f"component:{one.cls.__name__}", "no two solutions to compare", "a component with a parameter substep")
    return solutions[:2]
