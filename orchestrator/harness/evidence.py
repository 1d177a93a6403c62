"""What an FMU carries as evidence: reference results of an experiment, and what steps cost in accuracy, from studies of a few seconds.

Of a scene the macro step is varied, of a component alone the communication step, over which a master holds its inputs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from math import ceil, inf, isfinite
from time import process_time
from typing import Any

import numpy as np

from ...components.core.component import Component
from ...components.core.errors import BadInput, StepFailed
from ...fmus.evidence import Evidence, Step
from ..run import run
from ..scene.scene import Scene
from ..scene_fmu.variables import names_of
from .studies.accuracy import versions
from .studies.component_accuracy import SHARE, WAVES
from .studies.quantities import Quantity, TimeHistory, errors, quantities_of, recording
from .studies.stability import limit_text, stability

FACTORS = (8.0, 4.0, 2.0, 1.0, 0.5, 0.25)  # of the step
FINEST = 0.125  # of the reference
SHORTEST = 1.0 / 128.0  # of a component's default step
ENOUGH = 0.01  # error of the step that the default experiment takes
ROWS = 500  # most steps of an experiment
MOST = 2000  # steps of a component's run, at its default step
ROUNDING = 1e-9  # of the range of a signal: what other mathematics libraries may give
FEWEST = 50  # steps of the longest length


def scene_evidence(scene: Scene) -> Evidence:
    """Evidence of a scene, whose FMU holds its macro step."""
    step, shown = scene.master.step, [each.end for each in scene.coupling.shown.values() if each.causality == "output"]
    signals = [".".join(end) for end in dict.fromkeys((*scene.coupling.signals, *shown))]
    every = {"record.interval": None, "record.snapshots": (), "record.snapshot_interval": None, "record.signals": signals}
    whole = recording(scene.with_changes(every))
    quantities = quantities_of(scene)
    runs = {factor: _scene_run(whole, factor * step) for factor in (*FACTORS, FINEST)}
    (reference, _, why), near = runs[FINEST], runs[2.0 * FINEST][0]
    own, finer = runs[1.0][0], runs[0.5][0]
    if reference is None or near is None or own is None or finer is None:
        raise BadInput(
            f"{scene.name}: --evidence", f"a run that does not end ({why or runs[1.0][2]})", "a scene that runs to its end"
        )
    uncertainty = errors(quantities, near, reference)
    steps = [
        _measured(factor * step, quantities, history, reference, uncertainty, seconds, why)
        for factor, (history, seconds, why) in runs.items()
        if factor != FINEST
    ]
    every_nth = ceil((own.time.size - 1) / ROWS)
    time = own.time[::every_nth][: (own.time.size - 1) // every_nth + 1]
    names = names_of(scene)
    outputs: dict[str, np.ndarray] = {}
    tolerances: dict[str, float] = {}
    for end in dict.fromkeys((*scene.coupling.signals, *(e for e in shown if ("output", *e) in names))):
        column = ".".join(end)
        values = own.columns[column][::every_nth][: time.size]
        others = np.interp(time, finer.time, finer.columns[column])
        for name in names.get(("output", *end), [column]):
            outputs[name], tolerances[name] = values, _tolerance(values, others)
    return Evidence(
        step=step,
        stop=float(time[-1]),
        time=time,
        outputs=outputs,
        tolerances=tolerances,
        source=f"Computed in process by {versions()}; tolerances: distance from a run with half the steps.",
        steps=steps,
        meaning=(
            "The macro step of the scene, and the error of its quantities of interest "
            f"({'; '.join(q.name for q in quantities[:3])}{' and others' if len(quantities) > 3 else ''}): the largest distance from a "
            "run with an eighth of the macro step, with the error of that run, over the range of the signal. A communication step is "
            "any multiple of the macro step: it only changes how long inputs are held."
        ),
        stable=_stable(scene) + _advice(steps, step),
    )


def _scene_run(scene: Scene, step: float) -> tuple[TimeHistory | None, float, str]:
    """What a macro step gives, the CPU time of a second, s, and why there is nothing."""
    try:
        result = run(scene.with_changes({"master.step": step}), in_process=True)
    except BadInput as error:
        return None, inf, error.actual
    timing = result.info["timing"]
    seconds = timing["cpu"] / max(timing["simulated"], step)
    if result.info["outcome"] != "done":
        return None, seconds, result.info["outcome"]
    return TimeHistory(result.time, {name: np.asarray(result[name]) for name in result.columns}), seconds, ""


def _measured(
    length: float,
    quantities: Sequence[Quantity],
    history: TimeHistory | None,
    reference: TimeHistory,
    uncertainty: Mapping[str, float],
    seconds: float,
    why: str = "",
) -> Step:
    """A step with its largest error; `uncertainty`: the reference's own; `why`: there is no history."""
    if history is None:
        return Step(length, inf, seconds, why)
    error, name = max(
        (error + uncertainty.get(name, 0.0), name) for name, error in errors(quantities, history, reference).items()
    )
    return Step(length, error, seconds, of=name)


def _tolerance(values: np.ndarray, others: np.ndarray) -> float:
    """Of a reference result: how far a finer solution is from it, and rounding."""
    return max(float(np.abs(values - others).max()), ROUNDING * float(np.ptp(values) or np.abs(values).max() or 1.0))


def _stable(scene: Scene) -> str:
    scheme = scene.master.algorithm, scene.master.extrapolation
    try:
        (limit,) = stability(scene.with_changes({"study.stability": {}}), [scheme]).limits
    except BadInput as error:
        return f"Longest stable macro step: not measured ({error.actual})."
    return f"Longest stable macro step: {limit_text(limit.longest, limit.tried)} s."


def _advice(steps: Sequence[Step], step: float) -> str:
    chosen = largest_within(steps)
    if next(s for s in steps if s.length == step).error < ENOUGH:
        return ""
    better = "no step that was tried" if chosen is None else f"a macro step of {chosen:g} s (--set master.step={chosen:g})"
    return f" The error at the macro step is above {100.0 * ENOUGH:g} %: {better} keeps it below."


def largest_within(steps: Iterable[Step]) -> float | None:
    """The longest step, s, whose error and those of all shorter ones are below 1 %."""
    chosen = None
    for step in sorted(steps, key=lambda step: step.length):
        if not step.error < ENOUGH:
            break
        chosen = step.length
    return chosen


def component_evidence(make: Callable[[], Component]) -> Evidence:
    """Evidence of a component; `make` gives it with its effects, parameters and start values, not initialized."""
    first = make()
    cls = type(first)
    usual = cls.default_step
    longest = FACTORS[0] * usual
    count = max(int(min(cls.default_stop, MOST * usual) / longest * (1.0 + 1e-9)), FEWEST)
    stop = count * longest
    amplitude = np.array([SHARE * first.variables[n].nominal for n in first.inputs])
    start = first.u[0].copy()

    def waves(t: np.ndarray) -> np.ndarray:
        return start + 0.5 * (1.0 - np.cos(2.0 * np.pi * WAVES / stop * t))[:, None] * amplitude

    def solved(component: Component, step: float, n: int, *, held: bool = True) -> tuple[np.ndarray, float]:
        """Outputs of n steps, (n + 1, outputs), and CPU seconds; raises `StepFailed`."""
        times = step * np.arange(n + 1)
        values, middles = waves(times), waves(times[:-1] + 0.5 * step)
        component.u[0] = values[0]
        component.initialize(0.0)
        rows = np.empty((n + 1, component.y.size))
        rows[0] = component.y
        began = process_time()
        for k in range(n):
            component.u[0] = values[k]
            component.u[1:] = 0.0
            if not held:
                component.u[1] = (4.0 * middles[k] - 3.0 * values[k] - values[k + 1]) / step
                component.u[2] = 2.0 * (values[k] - 2.0 * middles[k] + values[k + 1]) / step**2
            component.step(float(times[k]), step)
            rows[k + 1] = component.y
        return rows, process_time() - began

    def history(rows: np.ndarray, step: float) -> TimeHistory:
        return TimeHistory(step * np.arange(len(rows)), dict(zip(first.outputs, rows.T, strict=True)))

    variables = first.variables
    finest = FINEST * usual
    try:
        reference = history(solved(make(), finest, round(stop / finest), held=False)[0], finest)
    except StepFailed as failure:
        raise BadInput(f"{cls.__name__}: --evidence", str(failure), "a component that runs with its start values") from None
    steps: list[Step] = []
    quantities = [
        Quantity(n, n, "time history", 0.0, 0.0, variables[n].nominal, variables[n].unit)
        for n, values in reference.columns.items()
        if not np.array_equal(values, np.round(values))
    ]
    if not quantities:
        expected = "outputs that follow the inputs"
        raise BadInput(
            f"{cls.__name__}: --evidence", "outputs that stand still or count", expected, "Give parameters and effects."
        )
    factors = list(FACTORS)
    for factor in factors:
        step, n = factor * usual, round(stop / (factor * usual))
        try:
            rows, seconds = solved(make(), step, n)
            steps.append(_measured(step, quantities, history(rows, step), reference, {}, seconds / stop))
        except (StepFailed, BadInput):
            steps.append(Step(step, inf, inf, "failed"))
        if factor == factors[-1] > SHORTEST and largest_within(steps) is None:
            factors.append(0.5 * factor)
    chosen = largest_within(steps)
    step = usual if chosen is None else chosen
    n = min(round(stop / step), ROWS)
    rows = solved(make(), step, n)[0]
    try:
        finer = solved(_finer(make), step, n)[0]
    except BadInput:  # a substep has no effect where nothing is integrated
        finer = rows
    outputs = dict(zip(first.outputs, rows.T, strict=True))
    times = step * np.arange(n + 1)
    limit = first.stable_step() if isfinite(first.stable_step()) else 0.0
    above = f" No step that was tried keeps the error below {100.0 * ENOUGH:g} %." if chosen is None else ""
    return Evidence(
        step=step,
        stop=float(times[-1]),
        time=times,
        outputs=outputs,
        tolerances={name: _tolerance(values, others) for (name, values), others in zip(outputs.items(), finer.T, strict=True)},
        source=f"Computed in process by {versions()}; tolerances: distance from a run with shorter internal steps.",
        steps=steps,
        meaning=(
            f"The communication step, and the largest error of an output while every input makes {WAVES:g} waves in {stop:g} s, of "
            f"{100.0 * SHARE:g} % of its nominal value, and is held over each step: the rms distance from a run with smooth inputs and "
            "an eighth of the default step, over the range of the output. "
            "Outputs that count are left out. Faster inputs need shorter steps in proportion."
        ),
        stable=(f"Internal steps are stable up to {limit:.3g} s." if limit else "No internal step can be unstable.") + above,
        inputs=dict(zip(first.inputs, waves(times).T, strict=True)),
    )


def _finer(make: Callable[[], Any]) -> Component:
    """The component with half its internal step, or a tenth of its tolerance, where it has one that may be changed so."""
    component = make()
    for name, factor in (("substep", 0.5), ("tolerance", 0.1)):
        if name in component.parameters:
            finer = type(component)(tuple(component.on), {**component.parameters, name: factor * component.parameters[name]})
            finer.u[0] = component.u[0]
            return finer
    return component
