"""Many runs of one scene: sweeps, and sensitivity, uncertainty, fits and designs that follow from them."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import wraps
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Option

from ...components.core.errors import counted, visible_lines
from ..output import locked
from .common import FAILED_CHECK, FAILED_RUN, STOPPED, app, fail, print_table, print_written, scene_of, status_spinner, warn
from .options import (
    Changes,
    Cluster,
    Conditions,
    FirstOrder,
    Jobs,
    Limits,
    NoVerify,
    OptionalPlanFile,
    Output,
    Over,
    PlanFile,
    Presets,
    Quantities,
    SceneName,
    Step,
    Stop,
    ranges_of,
    refuse,
    reports,
    times_of,
    with_options,
)

if TYPE_CHECKING:
    from ..harness.sweep import Sweep
    from ..scene.scene import Scene


@dataclass(frozen=True)
class Runs:
    """What the options give that all these commands have. how: who computes the runs, and whether some are repeated."""

    scene: Scene
    how: Mapping[str, Any]


def many_runs(command: Callable[..., None]) -> Callable[..., None]:
    """A command of many runs: it gets `Runs`, and has the options that change a scene and say how its runs are computed."""
    more = {
        "values": (Changes, None),
        "presets": (Presets, None),
        "step": (Step, None),
        "stop": (Stop, None),
        "jobs": (Jobs, None),
        "cluster": (Cluster, ""),
        "no_verify": (NoVerify, False),
    }

    @wraps(command)
    def running(*, scene: str, output: Path, **given: Any) -> None:
        values, presets, step, stop, jobs, cluster, no_verify = (given.pop(name) for name in more)
        over = given.get("over")
        if given["plan"] is not None:
            refuse({"--over": over}, "--plan and --over exclude each other", "Remove one.")
        loaded = scene_of(scene, values, presets, {**times_of(step, stop), "sweep": ranges_of(over) or None})
        with locked(output):  # now, not after many runs
            command(Runs(loaded, {"jobs": jobs, "cluster": cluster, "verify": not no_verify}), output=output, **given)

    _, *own = inspect.signature(command, eval_str=True).parameters.values()
    first = inspect.Parameter("scene", inspect.Parameter.POSITIONAL_OR_KEYWORD, annotation=SceneName)
    return with_options(running, [first, *own], more)


@app.command()
@reports
@many_runs
def sweep(
    runs: Runs,
    plan: OptionalPlanFile = None,
    over: Over = None,
    output: Output = Path("sweep"),
    add: Annotated[int, Option(help="Further points of a plan by Sobol's sequence or at random.")] = 0,
    retry: Annotated[bool, Option("--retry", help="Run points that have failed again.")] = False,
    limits: Limits = "",
    condition: Conditions = None,
) -> None:
    """Run a scene over the values of parameters. Example: cosimo sweep scene.toml --over bearing.speed=100:400:31 -o out

    Points that the directory has already are not run again.
    """
    from ..harness import report
    from ..harness.many.failures import failure_groups
    from ..systems import many

    results = many.sweep(
        runs.scene, plan, output, add=add, retry=retry, progress=True, limits=limits, conditions=condition or (), **runs.how
    )
    written = [*results.files, *([report.for_sweep(results, output)] if "done" in results.outcomes else [])]
    warn(results.remarks)
    failed = _failed(results)
    earlier = len(results.outcomes) - results.computed
    kept = f", {earlier} of an earlier call" if earlier else ""
    print_written(written, f"{counted(len(results.outcomes), 'point')}{kept}, {len(failed)} failed; ")
    print(verified(results))
    for sentence in failure_groups(results.outcomes)[:20]:
        print(f"cosimo: {visible_lines(sentence)}", file=sys.stderr)
    stopped_early(results)
    if failed:
        raise SystemExit(FAILED_RUN)


@app.command()
@reports
@many_runs
def sensitivity(
    runs: Runs,
    plan: PlanFile,
    quantity: Quantities = None,
    method: Annotated[str, Option(help="sobol: shares of the variance; morris: cheap, which matter at all.")] = "sobol",
    samples: Annotated[
        int, Option(help="Number of sample blocks; with d parameters a block has d + 2 runs (sobol) or d + 1 runs (morris).")
    ] = 128,
    output: Output = Path("sensitivity"),
) -> None:
    """Which parameters matter. Example: cosimo sensitivity scene.toml --plan plan.toml --quantity "mass.position, end" -o out"""
    from ..harness.report import answers
    from ..systems import many

    answer = many.sensitivity(
        runs.scene, plan, output, quantities=quantity or [], method=method, samples=samples, progress=True, **runs.how
    )
    stopped_early(answer.sweep)
    written = [answer.save(output), answers.for_sensitivity(answer, output)]
    first, total = answer.columns
    print_table(
        "",
        ["quantity", "parameter", first, "±", total, "±"],
        [(i.quantity, i.parameter, i.first, i.first_half, i.total, i.total_half) for i in answer.indices],
    )
    warn(answer.messages)
    print(verified(answer.sweep))
    print_written(written, f"{counted(len(answer.sweep.outcomes), 'run')}; ")


@app.command()
@reports
@many_runs
def uncertainty(
    runs: Runs,
    plan: OptionalPlanFile = None,
    quantity: Quantities = None,
    limits: Limits = "",
    condition: Conditions = None,
    first_order: FirstOrder = True,
    samples: Annotated[
        int | None, Option(min=8, help="Without --plan: samples of all tolerances and seeds of the scene. Default: 100.")
    ] = None,
    output: Output = Path("uncertainty"),
) -> None:
    """Distributions and tolerance intervals. Example: cosimo uncertainty scene.toml --plan plan.toml --quantity mean -o out

    Without a plan samples are drawn of the tolerances of the scene's units and of the seeds of their effects. With --limits the
    probability of keeping each limit, and all together, has its interval.
    """
    from ..harness.many.uncertainty import FOR_TOLERANCE
    from ..harness.report import answers
    from ..systems import many

    limited: dict[str, Any] = {"limits": limits, "conditions": condition or (), "first_order": first_order}
    if plan is not None:
        refuse({"--samples": samples}, "no effect with --plan, which has its own")
    limited |= {"samples": samples} if samples is not None else {}
    answer = many.uncertainty(runs.scene, plan, output, quantities=quantity or [], progress=True, **limited, **runs.how)
    stopped_early(answer.sweep)
    written = [*answer.save(output), answers.for_uncertainty(answer, output)]
    too_few = f"needs {FOR_TOLERANCE} samples"
    errors = answer.sweep.repeated.errors if answer.sweep.repeated is not None else {}
    rows = []
    for s in answer.spreads:
        ends = [too_few if isnan(end) else end for end in s.tolerance]
        rows.append((s.quantity, s.mean, s.deviation, *ends, errors.get(s.quantity, "not known")))
    print_table("", ["quantity", "mean", "standard deviation", "tolerance low", "tolerance high", "error of a run"], rows)
    if answer.limits:
        print_table("Probability of keeping the limits", answers.LIMIT_COLUMNS, answers.limit_rows(answer.limits))
    warn(answer.messages)
    print(verified(answer.sweep))
    print_written(written, f"{answer.origin}; ")


@app.command()
@reports
@many_runs
def fit(runs: Runs, plan: PlanFile, output: Output = Path("fit")) -> None:
    """Parameters from measurements. Example: cosimo fit scene.toml --plan fit.toml -o out"""
    from ..harness.many.fitting import FITTED
    from ..harness.report import answers
    from ..systems import many

    with _search() as observe:
        answer = many.fit(runs.scene, plan, output, observe=observe, **runs.how)
        written = [answer.save(output), output / FITTED, answers.for_fit(answer, output)]
    print_table(
        "",
        ["parameter", "unit", "value", "standard deviation", "low (95 %)", "high (95 %)", "derivatives"],
        [(n, answer.units[n], *rest, answer.derivatives[n].partition(" (")[0]) for n, *rest in answer.fit.rows()],
    )
    warn(answer.fit.messages)
    print_written(written, _runs(answer.runs, answer.computed))
    if not answer.fit.converged:
        raise SystemExit(FAILED_CHECK)


@app.command()
@reports
@many_runs
def design(
    runs: Runs, plan: PlanFile, limits: Limits = "", condition: Conditions = None, output: Output = Path("design")
) -> None:
    """Optimize parameters under constraints. Example: cosimo design scene.toml --plan design.toml -o out"""
    from ..harness.many.limits import unconfirmed
    from ..harness.many.repetition import shown
    from ..harness.report import answers
    from ..systems import many

    with _search() as observe:
        answer = many.design(runs.scene, plan, output, observe=observe, limits=limits, conditions=condition or (), **runs.how)
        written = [answer.save(output), answers.for_design(answer, runs.scene, output)]
    if len(answer.quantities) > 1:
        points = [answer.steps[k] for k in answer.front]
        print_table("Front", [*answer.names, *answer.quantities], [(*s.parameters, *s.quantities) for s in points])
    else:
        print_table("", ["parameter", "unit", "value"], [(n, answer.units[n], v) for n, v in answer.values.items()])
    if answer.best >= 0 and len(answer.quantities) == 1:
        active = f"; at their limits: {'; '.join(answer.active)}" if answer.active else ""
        print(f"{answer.quantity} = {shown(answer.steps[answer.best].quantity, answer.repeated, answer.quantity)}{active}")
    elif answer.best < 0:
        print("no run keeps all limits")
    warn([*answer.messages, *unconfirmed(answer.constraints)])
    print_written(written, _runs(len(answer.steps), answer.computed))
    if answer.best < 0:
        raise SystemExit(FAILED_CHECK)


def verified(results: Sweep) -> str:
    """How far the numbers can be trusted."""
    from ..harness.many.repetition import NONE_REPEATED

    return results.repeated.summary(len(results.outcomes)) if results.repeated is not None else NONE_REPEATED


def _failed(results: Sweep) -> list[str]:
    """The reasons of the points that have failed."""
    return [outcome for outcome in results.outcomes if outcome not in ("done", "not run")]


def stopped_early(results: Sweep) -> None:
    """End with the signal's exit code where one has ended the sweep."""
    if results.stopped is not None:
        left = results.outcomes.count("not run")
        points = f"{counted(left, 'point')} {'was' if left == 1 else 'were'}"
        raise fail(f"stopped by {results.stopped.name}, {points} not run; the same command runs them", STOPPED + results.stopped)


def _runs(asked: int, computed: int) -> str:
    return f"{counted(asked, 'run')}{f', {asked - computed} of an earlier call' if asked > computed else ''}; "


@contextmanager
def _search() -> Iterator[Callable[[int], None]]:
    """A function that shows on a terminal how many runs there were; a signal ends the search with its exit code."""
    from ..harness.journal import Stopped

    try:
        with status_spinner() as show:
            yield lambda n: show(counted(n, "run"))
    except Stopped as stopped:
        raise fail(
            f"stopped by {stopped.signal.name}; runs kept: {stopped.kept}; the same command goes on with them",
            STOPPED + stopped.signal,
        ) from None
