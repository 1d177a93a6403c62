"""Sweeps: one scene, many runs."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from .common import FAILED_RUN, STOPPED, Changes, app, change, changed, range_of

JOURNAL = "sweep.jsonl"  # file in the output directory: each point when it is done


@app.command()
def sweep(
    scene: Annotated[str, typer.Argument(help="name of a shipped scene, or a scene file")],
    over: Annotated[list[str] | None, typer.Option("--over", metavar="UNIT.PARAMETER=FROM:TO:POINTS", help=(
        "Values of a parameter, instead of the scene's [sweep]; several make a grid."))] = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Directory for sweep.csv and the report.")] = Path("sweep"),
    values: Changes = None,
    resume: Annotated[bool, typer.Option("--resume", help=(
        "Go on with a sweep that was stopped: points that are done are kept."))] = False,
) -> None:
    """Run a scene over the values of parameters. Example: cosimo sweep scene.toml --over bearing.speed=100:400:31 -o out"""
    from ..harness import report
    from ..harness.sweep import NOT_RUN
    from ..harness.sweep import sweep as run_sweep
    from ..output import locked
    from ..systems import load_scene

    loaded = load_scene(scene)
    changes: dict[str, Any] = dict(change(loaded, text) for text in values or [])
    if over:
        changes["sweep"] = dict(map(range_of, over))
    loaded = changed(loaded, changes)
    with locked(output) as directory:  # now, not after a long sweep
        results = run_sweep(loaded, progress=True, journal=directory / JOURNAL, resume=resume)
        written = [results.save(output), *([report.for_sweep(results, output)] if "done" in results.outcomes else [])]
    failed = [o for o in results.outcomes if o not in ("done", NOT_RUN)]
    left = results.outcomes.count(NOT_RUN)
    print(f"{len(results.outcomes)} points, {len(failed)} failed; wrote {', '.join(map(str, written))}")
    for reason in dict.fromkeys(failed):
        print(f"cosimo: {reason}", file=sys.stderr)
    if results.stopped is not None:
        print(f"cosimo: stopped by {results.stopped.name}, {left} points were not run; the same command with --resume runs them",
              file=sys.stderr)
        raise SystemExit(STOPPED + results.stopped)
    if failed:
        raise SystemExit(FAILED_RUN)
