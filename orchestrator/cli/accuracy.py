"""What accuracy costs: a scene or a component at many settings, and a run at the cheapest one that holds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...components.core.errors import BadInput
from .common import (
    COMPONENT,
    AsJson,
    Changes,
    Presets,
    Resume,
    app,
    listed,
    parameters_of,
    preset_of,
    print_table,
    scene_of,
    status_spinner,
    study,
)
from .completion import scenes

if TYPE_CHECKING:
    from ..harness.studies.accuracy import Accuracy


@app.command()
def accuracy(
    what: Annotated[
        str,
        typer.Argument(
            metavar="SCENE|component:NAME",
            autocompletion=scenes,
            help=("name of a shipped scene, a scene file, or a component of the catalogue alone"),
        ),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="Directory for accuracy.csv and the report.")] = Path("accuracy"),
    budget: Annotated[
        float | None,
        typer.Option(
            "--budget",
            metavar="SECONDS",
            help=("Time for measuring, beside that of the reference; default 60 s, 30 s for a component."),
        ),
    ] = None,
    stop: Annotated[float | None, typer.Option("--stop", help="End of the runs, s.")] = None,
    effects: Annotated[
        list[str] | None,
        typer.Option("--effects", metavar="EFFECT[,...]", help=("Effects of a component that is measured alone.")),
    ] = None,
    values: Changes = None,
    presets: Presets = None,
    as_json: AsJson = False,
    resume: Resume = False,
) -> None:
    """Measure what accuracy costs in time and counted work. Example: cosimo accuracy en50318-2002 -o out --budget 120

    What is found is kept for cosimo run --accuracy.
    """
    from ..harness.report.studies.accuracy import for_accuracy
    from ..harness.studies.accuracy_table import write_points

    if budget is not None and not budget > 0.0:
        raise BadInput("--budget", f"{budget:g} s", "more than 0 s")
    kept: Path | None = None
    with study(output, resume), status_spinner() as on_message:  # the directory now, not after a long measurement
        if what.startswith(COMPONENT):
            measured = _alone(what.removeprefix(COMPONENT), budget, stop, effects, values, presets, on_message)
        else:
            measured, kept = _of_scene(what, budget, stop, effects, values, presets, on_message)
        written = [write_points(measured, output), for_accuracy(measured, output), *([kept] if kept else [])]
    if as_json:
        import json

        print(json.dumps(summary(measured), indent=2))
        return
    print_front(measured)
    print(f"wrote {', '.join(map(str, written))}")


def _alone(
    name: str,
    budget: float | None,
    stop: float | None,
    effects: list[str] | None,
    values: list[str] | None,
    presets: list[str] | None,
    on_message: Callable[[str], None],
) -> Accuracy:
    from ..harness.studies.component_accuracy import BUDGET, component_accuracy

    on = tuple(listed("--effects", effects)) if effects else ()
    return component_accuracy(
        name,
        on,
        parameters_of(values or []),
        preset=preset_of(presets),
        stop=stop,
        budget=budget or BUDGET,
        on_message=on_message,
    )


def _of_scene(
    name: str,
    budget: float | None,
    stop: float | None,
    effects: list[str] | None,
    values: list[str] | None,
    presets: list[str] | None,
    on_message: Callable[[str], None],
) -> tuple[Accuracy, Path]:
    from ..harness.studies.accuracy import BUDGET
    from ..harness.studies.accuracy import accuracy as measure
    from ..harness.studies.fronts import keep, marked

    if effects:
        raise BadInput("--effects", repr(",".join(effects)), "none for a scene, which names its own", "Remove it.")
    scene = scene_of(name, values, presets, {} if stop is None else {"stop_time": stop})
    measured = marked(scene, measure(scene, budget=budget or BUDGET, on_message=on_message))
    return measured, keep(scene, measured)


def summary(measured: Accuracy) -> dict[str, Any]:
    """The fronts as plain data."""
    return {
        "name": measured.name,
        "reference": measured.reference,
        "second_solution": measured.second_solution,
        "shared_with_reference": measured.shares,
        "agreement": dict(measured.agreement),
        "mesh_error": dict(measured.mesh_error),
        "machine": measured.machine,
        "versions": measured.versions,
        "fronts": {
            cost: [
                {
                    "series": p.series,
                    "size": p.size,
                    "changes": dict(p.changes),
                    "error": p.error,
                    "error_with_finer": p.error_with_finer,
                    "largest": p.largest,
                    "seconds": p.seconds,
                    "work": dict(p.work),
                }
                for p in measured.front(cost)
            ]
            for cost in ("seconds", "calls")
        },
        "outcomes": {o: sum(p.outcome == o for p in measured.points) for o in dict.fromkeys(p.outcome for p in measured.points)},
        "refused_times": measured.refused_times,
    }


def print_front(measured: Accuracy) -> None:
    """The front over CPU time, the scene's own settings, and how well the reference is known."""
    from ..harness.studies.quantities import percent

    front, own = measured.front(), measured.own
    rows = [own, *(p for p in front if p is not own)]
    print_table(
        f"{measured.title}: what accuracy costs",
        ("setting", "size", "error", "CPU time, s", "calls", "front"),
        [
            (
                p.series,
                f"{p.size:.3g}",
                percent(p.error_with_finer),
                p.seconds,
                p.work.get("calls", ""),
                ", ".join(name for name, cost in (("time", "seconds"), ("work", "calls")) if p in measured.front(cost)),
            )
            for p in rows
        ],
    )
    print(f"reference: {measured.reference}; it shares {measured.shares} with the runs")
    print(
        f"  its own error, part of every error above: {percent(max(measured.agreement.values()))} by {measured.second_solution}"
        + (f", {percent(max(measured.mesh_error.values()))} of the mesh (Richardson)" if measured.mesh_error else "")
    )
    bad = [p for p in measured.points if p.outcome != "done"]
    for outcome in dict.fromkeys(p.outcome for p in bad):
        print(f"{sum(p.outcome == outcome for p in bad)} settings {outcome}")
    if measured.refused_times:
        print(f"{measured.refused_times} times refused, as no two measurements agree: the machine is busy, or throttles")
