"""What accuracy costs: a scene or a component at many settings, and a run at the cheapest one that holds."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...components.core.errors import BadInput
from .common import COMPONENT, AsJson, Changes, app, change, listed, parameters_of, print_table, shown

if TYPE_CHECKING:
    from ..harness.studies.accuracy import Accuracy
    from ..scene.scene import Scene


@app.command()
def accuracy(
    what: Annotated[str, typer.Argument(metavar="SCENE|component:NAME", help=(
        "name of a shipped scene, a scene file, or a component of the catalogue alone"))],
    output: Annotated[Path, typer.Option("-o", "--output", help="Directory for accuracy.csv and the report.")] = Path("accuracy"),
    budget: Annotated[float | None, typer.Option("--budget", metavar="SECONDS", help=(
        "Time for measuring, beside that of the reference; default 60 s, 30 s for a component."))] = None,
    stop: Annotated[float | None, typer.Option("--stop", help="End of the runs, s.")] = None,
    effects: Annotated[list[str] | None, typer.Option("--effects", metavar="EFFECT[,...]", help=(
        "Effects of a component that is measured alone."))] = None,
    values: Changes = None,
    as_json: AsJson = False,
) -> None:
    """Measure what accuracy costs in time and counted work. Example: cosimo accuracy en50318-2002 -o out --budget 120

    What is found is kept for cosimo run --accuracy.
    """
    from ..harness.report.studies.accuracy import for_accuracy
    from ..results import made

    if budget is not None and not budget > 0.0:
        raise BadInput("--budget", f"{budget:g} s", "more than 0 s")
    made(output)  # now, not after a long measurement
    kept: Path | None = None
    with shown() as told:
        if what.startswith(COMPONENT):
            measured = _alone(what.removeprefix(COMPONENT), budget, stop, effects, values, told)
        else:
            measured, kept = _of_scene(what, budget, stop, effects, values, told)
    written = [measured.save(output), for_accuracy(measured, output), *([kept] if kept else [])]
    if as_json:
        import json

        print(json.dumps(summary(measured), indent=2))
        return
    print_front(measured)
    print(f"wrote {', '.join(map(str, written))}")


def _alone(name: str, budget: float | None, stop: float | None, effects: list[str] | None, values: list[str] | None,
           told: Callable[[str], None]) -> Accuracy:
    from ..harness.studies.alone import BUDGET, alone

    on = tuple(listed("--effects", effects)) if effects else ()
    return alone(name, on, parameters_of(values or []), stop=stop, budget=budget or BUDGET, told=told)


def _of_scene(name: str, budget: float | None, stop: float | None, effects: list[str] | None, values: list[str] | None,
              told: Callable[[str], None]) -> tuple[Accuracy, Path]:
    from ..harness.studies.accuracy import BUDGET
    from ..harness.studies.accuracy import accuracy as measure
    from ..harness.studies.fronts import keep, marked
    from ..scene.scene import load_scene

    if effects:
        raise BadInput("--effects", repr(",".join(effects)), "none for a scene, which names its own", "Remove it.")
    scene = load_scene(name)
    changes: dict[str, Any] = dict(change(scene, text) for text in values or [])
    changes |= {} if stop is None else {"stop_time": stop}
    scene = scene.with_changes(changes) if changes else scene
    measured = marked(scene, measure(scene, budget=budget or BUDGET, told=told))
    return measured, keep(scene, measured)


def summary(measured: Accuracy) -> dict[str, Any]:
    """The fronts as plain data."""
    return {
        "name": measured.name, "reference": measured.how, "witness": measured.witness, "agreement": dict(measured.floor),
        "machine": measured.machine, "versions": measured.versions,
        "fronts": {cost: [{"line": p.line, "size": p.size, "changes": dict(p.changes), "error": p.error, "held": p.held,
                           "seconds": p.seconds, "work": dict(p.work)} for p in measured.front(cost)]
                   for cost in ("seconds", "calls")},
        "outcomes": {o: sum(p.outcome == o for p in measured.points) for o in dict.fromkeys(p.outcome for p in measured.points)},
    }


def print_front(measured: Accuracy) -> None:
    """The front over seconds, the setting as it is, and what the reference is worth."""
    from ..harness.studies.quantities import percent

    front, own = measured.front(), measured.own
    rows = [own, *(p for p in front if p is not own)]
    print_table(f"{measured.title}: what accuracy costs", ("setting", "size", "error", "seconds", "calls", "front"), [
        (p.line, f"{p.size:.3g}", percent(p.held), p.seconds, p.work.get("calls", ""),
         ", ".join(name for name, cost in (("time", "seconds"), ("work", "calls")) if p in measured.front(cost)))
        for p in rows
    ])
    print(f"reference: {measured.how}; against {measured.witness}: they agree to {percent(measured.least)}")
    bad = [p for p in measured.points if p.outcome != "done"]
    for outcome in dict.fromkeys(p.outcome for p in bad):
        print(f"{sum(p.outcome == outcome for p in bad)} settings {outcome}")


def chosen(scene: Scene, tolerance: float) -> tuple[Scene, dict[str, Any]]:
    """The scene at the quickest setting known to keep the tolerance, and what run.json says of it; measured first if need be."""
    from ..harness.studies.accuracy import accuracy as measure
    from ..harness.studies.fronts import choose, keep, known, why
    from ..harness.studies.quantities import percent

    found = known(scene)
    if found is None:
        print(f"nothing is known of the accuracy of {scene.name} with these settings: measuring first", file=sys.stderr)
        with shown() as told:
            keep(scene, measure(scene, told=told))
        found = known(scene)
        assert found is not None
    point = choose(found.measured, tolerance)
    reason = why(point, found, tolerance)
    print(f"accuracy {percent(tolerance)}: {point.line}, {point.size:.3g}, error {percent(point.held)}; {reason['reason']}")
    print(f"  from: {found.origin}")
    return (scene.with_changes(point.changes) if point.changes else scene), reason


def verified(scene: Scene, tolerance: float) -> bool:
    """Print how far a finer run differs, quantity by quantity, and whether all stay within the tolerance."""
    from ..harness.studies.fronts import verify
    from ..harness.studies.quantities import percent

    found = verify(scene)
    print_table("against half the macro step and half the internal steps", ("quantity", "difference"),
                [(name, percent(value)) for name, value in found.items()])
    worst = max(found.values())
    print(f"verified: {percent(worst)} is within {percent(tolerance)}" if worst <= tolerance else
          f"NOT verified: {percent(worst)} is more than {percent(tolerance)}")
    return worst <= tolerance

