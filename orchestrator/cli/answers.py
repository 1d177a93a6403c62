"""What follows from many runs of one scene: sensitivity, uncertainty, fits, designs."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import isnan
from pathlib import Path
from typing import Annotated

import typer

from .common import FAILED_CHECK, STOPPED, Changes, NoVerify, Presets, app, print_table, scene_of, status_spinner, warn
from .many import Conditions, Jobs, Limits, SceneName, Scheduler, stopped_early, verified

Quantities = Annotated[
    list[str] | None,
    typer.Option(
        "--quantity",
        help=('"unit.output, kind" or a figure of the summary; may be repeated. Default: those of the plan, or of [study].'),
    ),
]
PlanFile = Annotated[Path, typer.Option("--plan", help="TOML file with [vary]: distributions of the parameters.")]
Directory = Annotated[Path, typer.Option("-o", "--output", help="Directory for tables, data set and report.")]
Settings = Annotated[Path, typer.Option("--plan", help="TOML file: what varies, and what is wanted.")]


@app.command()
def sensitivity(
    scene: SceneName,
    plan: PlanFile,
    quantity: Quantities = None,
    method: Annotated[
        str, typer.Option("--method", help=("sobol: shares of the variance; morris: cheap, which matter at all."))
    ] = "sobol",
    samples: Annotated[
        int, typer.Option("--samples", help=("Blocks of as many runs as parameters, and 2 (sobol) or 1 more."))
    ] = 128,
    output: Directory = Path("sensitivity"),
    values: Changes = None,
    presets: Presets = None,
    jobs: Jobs = None,
    scheduler: Scheduler = "",
    no_verify: NoVerify = False,
) -> None:
    """Which parameters matter. Example: cosimo sensitivity scene.toml --plan plan.toml --quantity "mass.position, end" -o out"""
    from ..harness.report import answers
    from ..output import locked
    from ..systems import many

    loaded = scene_of(scene, values, presets)
    with locked(output):
        answer = many.sensitivity(
            loaded,
            plan,
            output,
            quantities=quantity or [],
            method=method,
            samples=samples,
            jobs=jobs,
            scheduler=scheduler,
            progress=True,
            verify=not no_verify,
        )
        stopped_early(answer.sweep, answer.sweep.outcomes.count("not run"))
        written = [answer.save(output), answers.for_sensitivity(answer, output)]
    first, total = answer.columns
    print_table(
        "",
        ["quantity", "parameter", first, "±", total, "±"],
        [(i.quantity, i.parameter, i.first, i.first_half, i.total, i.total_half) for i in answer.indices],
    )
    warn(answer.messages)
    print(verified(answer.sweep))
    print(f"{len(answer.sweep.outcomes)} runs; wrote {', '.join(map(str, written))}")


@app.command()
def uncertainty(
    scene: SceneName,
    plan: PlanFile,
    quantity: Quantities = None,
    effects: Annotated[
        bool,
        typer.Option(
            "--effects", help=("Which effects are needed so that the others change less than the parameters' uncertainty.")
        ),
    ] = False,
    share: Annotated[float, typer.Option("--share", help="Of the standard deviation that the others may change.")] = 1.0,
    limits: Limits = "",
    condition: Conditions = None,
    output: Directory = Path("uncertainty"),
    values: Changes = None,
    presets: Presets = None,
    jobs: Jobs = None,
    scheduler: Scheduler = "",
    no_verify: NoVerify = False,
) -> None:
    """Distributions and tolerance intervals. Example: cosimo uncertainty scene.toml --plan plan.toml --quantity mean -o out"""
    from ..harness.many.uncertainty import FOR_TOLERANCE
    from ..harness.report import answers
    from ..output import locked
    from ..systems import many

    loaded = scene_of(scene, values, presets)
    with locked(output):
        answer = many.uncertainty(
            loaded,
            plan,
            output,
            quantities=quantity or [],
            effects=effects,
            share=share,
            jobs=jobs,
            scheduler=scheduler,
            progress=True,
            limits=limits,
            conditions=condition or (),
            verify=not no_verify,
        )
        stopped_early(answer.sweep, answer.sweep.outcomes.count("not run"))
        written = [*answer.save(output), answers.for_uncertainty(answer, output)]
    too_few = f"needs {FOR_TOLERANCE} samples"
    errors = answer.sweep.repeated.errors if answer.sweep.repeated is not None else {}
    print_table(
        "",
        ["quantity", "mean", "standard deviation", "tolerance low", "tolerance high", "error of a run"],
        [
            (
                s.quantity,
                s.mean,
                s.deviation,
                *(too_few if isnan(end) else end for end in s.tolerance),
                errors.get(s.quantity, "not known"),
            )
            for s in answer.spreads
        ],
    )
    if answer.limits:
        print_table(
            "Probability of keeping the limits",
            ["limit", "low", "high", "provenance", "samples", "probability", "95 %"],
            answers.limit_rows(answer.limits),
        )
    if effects:
        print(
            f"effects that are needed: {', '.join(answer.needed) or 'none'}; the others change {answer.left_error:.3g} of a "
            "standard deviation at most"
        )
    warn(answer.messages)
    print(verified(answer.sweep))
    print(f"{len(answer.sweep.outcomes)} runs; wrote {', '.join(map(str, written))}")


@app.command()
def fit(
    scene: SceneName,
    plan: Settings,
    output: Directory = Path("fit"),
    values: Changes = None,
    presets: Presets = None,
    jobs: Jobs = None,
    scheduler: Scheduler = "",
    no_verify: NoVerify = False,
) -> None:
    """Parameters from measurements. Example: cosimo fit scene.toml --plan fit.toml -o out"""
    from ..harness.report import answers
    from ..output import locked
    from ..systems import many

    loaded = scene_of(scene, values, presets)
    with locked(output), _searched() as observe:
        answer = many.fit(loaded, plan, output, jobs=jobs, scheduler=scheduler, observe=observe, verify=not no_verify)
        written = [answer.save(output), answers.for_fit(answer, output)]
    print_table(
        "",
        ["parameter", "unit", "value", "standard deviation", "low (95 %)", "high (95 %)"],
        [(n, answer.units[n], *rest) for n, *rest in answer.fit.rows()],
    )
    warn(answer.fit.messages)
    print(f"{_runs(answer.runs, answer.computed)}; wrote {', '.join(map(str, written))}")
    if not answer.fit.converged:
        raise SystemExit(FAILED_CHECK)


@app.command()
def design(
    scene: SceneName,
    plan: Settings,
    limits: Limits = "",
    condition: Conditions = None,
    output: Directory = Path("design"),
    values: Changes = None,
    presets: Presets = None,
    jobs: Jobs = None,
    scheduler: Scheduler = "",
    no_verify: NoVerify = False,
) -> None:
    """Parameters for small or large quantities within limits. Example: cosimo design scene.toml --plan design.toml -o out"""
    from ..harness.many.limits import recalled
    from ..harness.many.repetition import shown
    from ..harness.report import answers
    from ..output import locked
    from ..systems import many

    loaded = scene_of(scene, values, presets)
    with locked(output), _searched() as observe:
        answer = many.design(
            loaded,
            plan,
            output,
            jobs=jobs,
            scheduler=scheduler,
            observe=observe,
            limits=limits,
            conditions=condition or (),
            verify=not no_verify,
        )
        written = [answer.save(output), answers.for_design(answer, loaded, output)]
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
    warn([*answer.messages, *recalled(answer.constraints)])
    print(f"{_runs(len(answer.steps), answer.computed)}; wrote {', '.join(map(str, written))}")
    if answer.best < 0:
        raise SystemExit(FAILED_CHECK)


def _runs(asked: int, computed: int) -> str:
    return f"{asked} runs" + (f", {asked - computed} of an earlier call" if asked > computed else "")


@contextmanager
def _searched() -> Iterator[Callable[[int], None]]:
    """A function that shows on a terminal how many runs there were; a signal ends the search with its exit code."""
    from ..harness.journal import Stopped

    try:
        with status_spinner() as show:
            yield lambda n: show(f"{n} runs")
    except Stopped as stopped:
        print(
            f"cosimo: stopped by {stopped.signal.name}; {stopped.kept} runs are kept, and the same command goes on with them",
            file=sys.stderr,
        )
        raise SystemExit(STOPPED + stopped.signal) from None
