"""Sweeps: one scene, many runs."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from .common import FAILED_RUN, Changes, app, change, changed, range_of


@app.command()
def sweep(
    scene: Annotated[str, typer.Argument(help="name of a shipped scene, or a scene file")],
    over: Annotated[list[str] | None, typer.Option("--over", metavar="UNIT.PARAMETER=FROM:TO:POINTS", help=(
        "Values of a parameter, instead of the scene's [sweep]; several make a grid."))] = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Directory for sweep.csv and the report.")] = Path("sweep"),
    values: Changes = None,
) -> None:
    """Run a scene over the values of parameters. Example: cosimo sweep scene.toml --over bearing.speed=100:400:31 -o out"""
    from ..harness import report
    from ..harness.sweep import sweep as run_sweep
    from ..output import ensure_directory
    from ..systems import load_scene

    loaded = load_scene(scene)
    changes: dict[str, Any] = dict(change(loaded, text) for text in values or [])
    if over:
        changes["sweep"] = dict(map(range_of, over))
    loaded = changed(loaded, changes)
    ensure_directory(output)  # now, not after a long sweep
    results = run_sweep(loaded, progress=True)
    written = [results.save(output), report.for_sweep(results, output)]
    failed = [o for o in results.outcomes if o != "done"]
    print(f"{len(results.outcomes)} points, {len(failed)} failed; wrote {', '.join(map(str, written))}")
    for reason in dict.fromkeys(failed):
        print(f"cosimo: {reason}", file=sys.stderr)
    if failed:
        raise SystemExit(FAILED_RUN)
