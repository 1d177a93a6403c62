"""Which effects a scene calls for, and a run with exactly those."""

from __future__ import annotations

import json
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...components.core.errors import BadInput
from .choices import TOLERANCE
from .common import AsJson, Changes, Presets, Resume, app, listed, print_table, scene_of, share, status_spinner, study, warn
from .completion import scenes

if TYPE_CHECKING:
    from ..harness.studies.effects import Effects


@app.command()
def effects(
    scene: Annotated[str, typer.Argument(autocompletion=scenes, help="name of a shipped scene, or a scene file")],
    tolerance: Annotated[
        str,
        typer.Option(
            "--tolerance",
            metavar="SHARE",
            help=("Largest error of a quantity of interest against the scene with all effects, as in 1% or 0.01."),
        ),
    ] = TOLERANCE,
    output: Annotated[Path, typer.Option("-o", "--output", help="Directory for effects.csv and the report.")] = Path("effects"),
    write: Annotated[
        Path | None,
        typer.Option("--write", metavar="FILE", help=("Write the scene with the smallest set of effects; a .toml file.")),
    ] = None,
    more: Annotated[
        list[str] | None,
        typer.Option(
            "--with", metavar="UNIT.EFFECT[,...]", help=("Parts, defects, loads and the like to take into the full model, too.")
        ),
    ] = None,
    stop: Annotated[float | None, typer.Option("--stop", help="End of the runs, s.")] = None,
    values: Changes = None,
    presets: Presets = None,
    as_json: AsJson = False,
    resume: Resume = False,
) -> None:
    """Find the effects a scene calls for. Example: cosimo effects gimbal-scan --tolerance 1% --write small.toml -o out"""
    from ..harness.report.studies.effects import for_effects
    from ..harness.studies.chosen import keep
    from ..harness.studies.effects import effects as find
    from ..scene.text import write_scene

    allowed = share("--tolerance", tolerance)
    if write is not None and write.suffix != ".toml":
        raise BadInput("--write", repr(str(write)), "a .toml file")
    loaded = scene_of(scene, values, presets, {} if stop is None else {"stop_time": stop})
    with study(output, resume), status_spinner() as on_message:  # the directory now, not after many runs
        result = find(loaded, allowed, more=listed("--with", more) if more else (), on_message=on_message)
        written = [result.save(output), for_effects(result, output)]
    written += [write_scene(result.chosen, write, remarks(result))] if write is not None else []
    if not more:
        keep(result)
    if as_json:
        print(json.dumps(summary(result), indent=2))
        return
    print_effects(result)
    warn(result.remarks)
    print(f"wrote {', '.join(map(str, written))}")


def remarks(study: Effects) -> list[str]:
    """What stands above a scene that is written."""
    from ..harness.studies.chosen import reason
    from ..harness.studies.quantities import percent

    lines = [
        f"Of the scene {study.scene.name}: the effects whose absence shows by more than {percent(study.tolerance)};",
        f"error of this scene {percent(study.least.error)} against all effects.",
    ]
    return lines + [
        f"{'with' if f.chosen else 'without'} {f.name}: {' '.join(reason(f, study.tolerance).split())}"
        for f in study.findings
        if f.chosen or f.given
    ]


def summary(study: Effects) -> dict[str, Any]:
    """What was found as plain data."""
    from dataclasses import asdict

    from ..harness.studies.chosen import reason

    def plain(data: dict[str, Any]) -> dict[str, Any]:
        return {k: v if not isinstance(v, float) or isfinite(v) else None for k, v in data.items()}

    return {
        "scene": study.scene.name,
        "tolerance": study.tolerance,
        "quantities": list(study.quantities),
        "runs": study.runs,
        "full": plain(asdict(study.full)),
        "given": plain(asdict(study.given)),
        "chosen": plain(asdict(study.least)),
        "effects": [plain(asdict(f)) | {"why": reason(f, study.tolerance)} for f in study.findings],
    }


def print_effects(study: Effects) -> None:
    """Every effect that was measured or is required, then what the models cost."""
    from ..harness.studies.chosen import reason
    from ..harness.studies.quantities import percent

    order = sorted((f for f in study.findings if f.standing != "left out"), key=lambda f: (not f.chosen, -f.actual))
    print_table(
        f"{study.scene.title or study.scene.name}: effects within {percent(study.tolerance)}",
        ("effect", "in the scene", "predicted", "actual", "states", "calls", "chosen", "why"),
        [
            (
                f.name,
                "yes" if f.given else "no",
                percent(f.predicted),
                percent(f.actual),
                f.states,
                f.calls,
                "yes" if f.chosen else "no",
                reason(f, study.tolerance),
            )
            for f in order
        ],
    )
    if left := [f.name for f in study.findings if f.standing == "left out"]:
        print(f"not in the full model: {', '.join(left)}")
    for name, cost in (("all effects", study.full), ("the scene's own effects", study.given), ("smallest set", study.least)):
        print(f"{name}: error {percent(cost.error)}, {cost.calls} calls, {cost.seconds:.3g} s")
    print(f"{study.runs} models were run")
