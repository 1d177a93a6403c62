"""What an FMU carries as evidence: reference results of an experiment, and what steps cost in accuracy, from studies of a few seconds.

Of a scene the macro step is varied, of a component alone the communication step, over which a master holds its inputs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from math import ceil, inf, isfinite, isnan
from typing import Any

import numpy as np

from ...components.core.component import Component
from ...components.core.errors import BadInput, StepFailed
from ...fmus.evidence import Evidence, Step
from ..judgement.growth import limit_text
from ..scene.scene import Scene
from ..scene_fmu.variables import names_of
from .studies.accuracy import versions
from .studies.component_accuracy import SHARE, WAVES, integrated, parabolas, waves
from .studies.quantities import Quantity, TimeHistory, errors, quantities_to_judge, recording
from .studies.stability import stability
from .studies.trial import trial

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
    quantities = quantities_to_judge(scene)
    if scene.start_time:
        raise BadInput(
            f"{scene.name}: --evidence", f"start_time = {scene.start_time:g} s", "a scene that starts at 0", "Leave it out."
        )
    runs = {factor: trial(whole, {"master.step": factor * step}, repeats=1) for factor in (*FACTORS, FINEST)}
    if failed := [run for factor, run in runs.items() if factor in (1.0, 0.5, 2.0 * FINEST, FINEST) and not run.done]:
        raise BadInput(
            f"{scene.name}: --evidence", f"a run that does not end ({failed[0].reason})", "a scene that runs to its end"
        )
    reference, own, finer = (runs[factor].history for factor in (FINEST, 1.0, 0.5))
    uncertainty = errors(quantities, runs[2.0 * FINEST].history, reference)
    steps = []
    for factor in FACTORS:
        run, length = runs[factor], factor * step
        if run.done:
            steps.append(
                _measured(length, errors(quantities, run.history, reference), run.seconds / scene.stop_time, uncertainty)
            )
        else:
            steps.append(Step(length, inf, run.seconds / max(run.history.time[-1], length) if run.times else inf, run.outcome))
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


def _measured(length: float, distances: Mapping[str, float], seconds: float, uncertainty: Mapping[str, float]) -> Step:
    """A step with its largest error: a distance from a reference and, added, the reference's own error."""
    error, name = max((distance + uncertainty.get(name, 0.0), name) for name, distance in distances.items())
    return Step(length, error, seconds, of=name)


def _tolerance(values: np.ndarray, others: np.ndarray) -> float:
    """Of a reference result: how far a finer solution is from it, and rounding."""
    return max(float(np.abs(values - others).max()), ROUNDING * float(np.ptp(values) or np.abs(values).max() or 1.0))


def _stable(scene: Scene) -> str:
    scheme = scene.master.algorithm, scene.master.extrapolation
    try:
        (limit,) = stability(scene.with_changes({"study.stability": {}}), [scheme]).limits
    except BadInput as error:
        return f"Longest stable macro step: not examined ({error.actual})."
    if isnan(limit.longest):
        return f"Longest stable macro step: not examined ({limit.seen})."
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
    input_waves = partial(waves, first.u[0].copy(), np.array([SHARE * first.variables[n].nominal for n in first.inputs]), stop)

    def solved(component: Component, step: float, n: int, *, held: bool = True) -> tuple[np.ndarray, float]:
        """Outputs of n steps, (n + 1, outputs), and CPU seconds; raises `StepFailed`."""
        inputs = parabolas(input_waves(0.5 * step * np.arange(2 * n + 1)), step)
        if held:
            inputs[:, 1:] = 0.0
        return integrated(component, inputs, step)

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
            steps.append(_measured(step, errors(quantities, history(rows, step), reference), seconds / stop, {}))
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
        inputs=dict(zip(first.inputs, input_waves(times).T, strict=True)),
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
