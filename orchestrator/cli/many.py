"""Many runs of one scene: sweeps by plans, and what follows from them."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ...components.core.errors import BadInput
from .common import FAILED_RUN, STOPPED, Changes, NoVerify, Presets, app, range_of, scene_of, warn
from .completion import scenes

if TYPE_CHECKING:
    from ..harness.sweep import Sweep

Plan_ = Annotated[
    Path | None, typer.Option("--plan", help=("TOML file: what varies, how points are chosen, what is kept of each run."))
]
Jobs = Annotated[
    int | None,
    typer.Option("--jobs", help=("Processes; default: one for each core, where the points need longer than those to start.")),
]
Scheduler = Annotated[str, typer.Option("--scheduler", metavar="tcp://HOST:PORT", help="Workers of a Dask cluster instead.")]
Limits = Annotated[
    str,
    typer.Option(
        "--limits",
        metavar="TABLE",
        help=("A validation table whose rows are limits: en50367, en50318-2002, ..., or a TOML file with sources and rows."),
    ),
]
Conditions = Annotated[list[str] | None, typer.Option("--condition", help="Of the table's rows; may be repeated. Default: all.")]
SceneName = Annotated[str, typer.Argument(autocompletion=scenes, help="name of a shipped scene, or a scene file")]


@app.command()
def sweep(
    scene: SceneName,
    plan: Plan_ = None,
    over: Annotated[
        list[str] | None,
        typer.Option(
            "--over",
            metavar="UNIT.PARAMETER=FROM:TO:POINTS",
            help=("Values of a parameter, instead of the scene's [sweep]; several make a grid."),
        ),
    ] = None,
    output: Annotated[
        Path,
        typer.Option(
            "-o",
            "--output",
            help=("Directory for sweep.csv, the data set and the report; points that are there are not run again."),
        ),
    ] = Path("sweep"),
    values: Changes = None,
    presets: Presets = None,
    jobs: Jobs = None,
    scheduler: Scheduler = "",
    add: Annotated[int, typer.Option("--add", help="Further points of a plan by Sobol's sequence or at random.")] = 0,
    retry: Annotated[bool, typer.Option("--retry", help="Run points that have failed again.")] = False,
    limits: Limits = "",
    condition: Conditions = None,
    no_verify: NoVerify = False,
) -> None:
    """Run a scene over the values of parameters. Example: cosimo sweep scene.toml --over bearing.speed=100:400:31 -o out"""
    from ..harness import report
    from ..harness.sweep import NOT_RUN
    from ..output import locked
    from ..systems import many

    if plan is not None and over:
        raise BadInput("sweep", "--plan and --over", "one of them")
    loaded = scene_of(scene, values, presets, {"sweep": dict(map(range_of, over))} if over else {})
    with locked(output):  # now, not after a long sweep
        results = many.sweep(
            loaded,
            plan,
            output,
            jobs=jobs,
            scheduler=scheduler,
            add=add,
            retry=retry,
            progress=True,
            limits=limits,
            conditions=condition or (),
            verify=not no_verify,
        )
        written = [*results.files, *([report.for_sweep(results, output)] if "done" in results.outcomes else [])]
    warn(results.remarks)
    failed = [o for o in results.outcomes if o not in ("done", NOT_RUN)]
    left = results.outcomes.count(NOT_RUN)
    earlier = len(results.outcomes) - results.computed
    kept = f", {earlier} of an earlier call" if earlier else ""
    print(f"{len(results.outcomes)} points{kept}, {len(failed)} failed; wrote {', '.join(map(str, written))}")
    print(verified(results))
    for reason in list(dict.fromkeys(failed))[:20]:
        print(f"cosimo: {reason}", file=sys.stderr)
    stopped_early(results, left)
    if failed:
        raise SystemExit(FAILED_RUN)


def verified(results: Sweep) -> str:
    """How far the numbers can be trusted."""
    return results.repeated.summary(len(results.outcomes)) if results.repeated is not None else "no point was repeated: no errors"


def stopped_early(results: Sweep, left: int) -> None:
    """End with the signal's exit code where one has ended the sweep."""
    if results.stopped is not None:
        print(
            f"cosimo: stopped by {results.stopped.name}, {left} points were not run; the same command runs them", file=sys.stderr
        )
        raise SystemExit(STOPPED + results.stopped)
