"""Scenes packed for other tools."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from .common import FAILED_CHECK, Changes, Native, Presets, app, print_table, scene_of, share, status_spinner, warn
from .completion import scenes

if TYPE_CHECKING:
    from ..harness.other_masters import Comparison
    from ..scene.scene import Scene


@app.command()
def ssp(
    scene: Annotated[str, typer.Argument(autocompletion=scenes, help="name of a shipped scene, or a scene file")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="File to write; default: the scene's name.")] = None,
    values: Changes = None,
    presets: Presets = None,
    step: Annotated[float | None, typer.Option("--step", help="Macro step, s, that the package tells other masters.")] = None,
    tolerance: Annotated[
        str,
        typer.Option(
            "--tolerance",
            help=(
                "How far other masters may be from the scene, relative to the range of each quantity, or to the standard deviation of a "
                "low-pass-filtered one."
            ),
        ),
    ] = "5%",
    native: Native = False,
    force: Annotated[bool, typer.Option("--force", help="Write the package however far other masters will be.")] = False,
) -> None:
    """Pack a scene with its FMUs for other tools (SSP 1.0). Example: cosimo ssp mass-on-spring --step 0.0025 -o mass.ssp

    Other masters exchange values once per step with held inputs. A run shows what they will get; where that is farther from
    the scene than the tolerance, nothing is written (exit code 1) unless --force is given.
    """
    from ..native import initial_inputs
    from ..scene.ssp.write import check, write

    loaded = scene_of(scene, values, presets)
    packed = loaded if step is None else loaded.with_changes({"master.step": step})
    warn(loaded.remarks)
    path = output or Path(f"{loaded.name}.ssp")
    limit = share("--tolerance", tolerance)
    check(packed, path)
    if not _close_enough(loaded, step, limit) and not force:
        print(
            f"cosimo: {path} is not written: other masters would be farther than {100.0 * limit:g} % from the scene. "
            "--force writes it all the same",
            file=sys.stderr,
        )
        raise SystemExit(FAILED_CHECK)
    starts = initial_inputs(packed) if packed.connections else None
    if native:
        from ..native import with_native_fmus

        with status_spinner() as progress:
            progress("building native FMUs")
            packed = with_native_fmus(packed)
    print(f"wrote {write(packed, path, starts)}")


def _close_enough(scene: Scene, step: float | None, limit: float) -> bool:
    """Show what other masters will get; whether it is within the limit."""
    from ..harness.other_masters import OtherMasters

    if not scene.connections:
        return True  # each unit alone: no master matters
    with status_spinner() as progress:
        progress("running the scene as other masters step it")
        masters = OtherMasters(scene)
        comparison = masters.compare(step)
    _print(comparison)
    if comparison.difference <= limit:
        return True
    with status_spinner() as progress:
        progress("looking for a step that keeps the tolerance")
        better = masters.step_within(limit)
    if better is not None and better.step < comparison.step:
        print(f"With --step {better.step:g} other masters are within {100.0 * better.difference:.2g} %.")
    else:
        print("No macro step that was tried brings them within the tolerance.")
    return False


def _print(comparison: Comparison) -> None:
    print_table(
        f"held inputs, exchanged once per step of {comparison.step:g} s",
        ("quantity", "unit", "this scene", "other masters", "difference / scale"),
        [(row.quantity.name, row.quantity.unit, row.here, row.there, row.difference) for row in comparison.rows],
    )
    if comparison.failure:
        print(f"cosimo: warning: other masters will not reach the end: {comparison.failure}", file=sys.stderr)
