"""Studies of a scene or a component: what accuracy costs, which effects matter, how long steps may be."""

from __future__ import annotations

import json
import os
import sys
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Argument, Option

from ...components.core.errors import BadInput, counted, pick
from .common import FAILED_CHECK, app, print_cells, print_table, print_written, scene_of, status_spinner, study, warn
from .completion import anything, scenes
from .options import (
    COMPONENT,
    TOLERANCE,
    AsJson,
    Changes,
    Output,
    Over,
    Presets,
    Resume,
    SceneName,
    Stop,
    listed,
    parameters_of,
    preset_of,
    ranges_of,
    refuse,
    reports,
    share,
)

if TYPE_CHECKING:
    from ..harness.studies.accuracy import Accuracy
    from ..harness.studies.effects import Effects

ComponentEffects = Annotated[
    list[str] | None, Option("--effects", metavar="EFFECT[,...]", help="Effects of a component without a scene.")
]


@app.command()
@reports
def accuracy(
    what: Annotated[
        str, Argument(metavar="SCENE|component:NAME", autocompletion=scenes, help="Shipped scene, scene file or component.")
    ],
    output: Output = Path("accuracy"),
    budget: Annotated[
        float | None,
        Option(
            metavar="SECONDS",
            help="Time for the measurement, without the reference solution. Default: 60 s, 30 s for a component.",
        ),
    ] = None,
    stop: Stop = None,
    effects: ComponentEffects = None,
    values: Changes = None,
    presets: Presets = None,
    as_json: AsJson = False,
    resume: Resume = False,
) -> None:
    """Measure what accuracy costs in time and counted work. Example: cosimo accuracy en50318-2002 -o out --budget 120

    The measurement is kept for cosimo run --accuracy.
    """
    from ..harness.report.studies.accuracy import for_accuracy
    from ..harness.studies import component_accuracy as alone
    from ..harness.studies import fronts
    from ..harness.studies.accuracy import BUDGET
    from ..harness.studies.accuracy import accuracy as measure

    if budget is not None and not budget > 0.0:
        raise BadInput("--budget", f"{budget:g} s", "more than 0 s")
    with study(output, resume), status_spinner() as on_message:  # the directory now, not after a long measurement
        if what.startswith(COMPONENT):
            measured = alone.component_accuracy(
                what.removeprefix(COMPONENT),
                tuple(listed("--effects", effects)),
                parameters_of(values),
                preset=preset_of(presets),
                stop=stop,
                budget=budget or alone.BUDGET,
                on_message=on_message,
            )
        else:
            refuse({"--effects": effects}, "no effect for a scene, which sets its own")
            scene = scene_of(what, values, presets, {"stop_time": stop})
            measured = measure(scene, budget=budget or BUDGET, on_message=on_message)
            fronts.keep(scene, measured)
        written = [measured.save(output), for_accuracy(measured, output)]
    if as_json:
        print(json.dumps(measured.to_json(), indent=2))
        return
    _print_front(measured)
    print_written(written)


def _print_front(measured: Accuracy) -> None:
    """The fronts, the scene's own settings, and how well the reference is known."""
    from ..harness.report.studies.accuracy import front_cells
    from ..harness.studies.quantities import percent

    print(measured.title)
    print_cells(front_cells(measured))
    print(f"reference: {measured.reference}; it shares {measured.shares} with the runs")
    print(
        f"  its own error, part of every error above: {percent(max(measured.agreement.values()))} by {measured.second_solution}"
        + (f", {percent(max(measured.mesh_error.values()))} of the mesh (Richardson)" if measured.mesh_error else "")
    )
    outcomes = [p.outcome for p in measured.points if p.outcome != "done"]
    for outcome in dict.fromkeys(outcomes):
        print(f"{counted(outcomes.count(outcome), 'setting')} {outcome}")
    if measured.refused_times:
        print(
            f"{counted(measured.refused_times, 'time')} refused, as no two measurements agree: the machine is busy, or throttles"
        )


@app.command()
@reports
def effects(
    scene: SceneName,
    tolerance: Annotated[
        str,
        Option(
            metavar="SHARE",
            help="Largest error of a quantity of interest against the scene with all effects, for example 1% or 0.01.",
        ),
    ] = TOLERANCE,
    output: Output = Path("effects"),
    write: Annotated[
        Path | None, Option(metavar="FILE", help="TOML file for the scene with the smallest set of effects.")
    ] = None,
    more: Annotated[
        list[str] | None, Option("--with", metavar="UNIT.EFFECT[,...]", help="Parts, defects or loads to add to the full model.")
    ] = None,
    stop: Stop = None,
    values: Changes = None,
    presets: Presets = None,
    as_json: AsJson = False,
    resume: Resume = False,
) -> None:
    """Find the smallest set of effects for a given error. Example: cosimo effects gimbal-scan --tolerance 1% --write small.toml -o out"""
    from ..harness.report.studies.effects import for_effects
    from ..harness.studies.chosen import keep
    from ..harness.studies.effects import effects as find
    from ..scene.scene import write_scene

    allowed = share("--tolerance", tolerance)
    if write is not None and write.suffix != ".toml":
        raise BadInput("--write", repr(str(write)), "a .toml file")
    loaded = scene_of(scene, values, presets, {"stop_time": stop})
    with study(output, resume), status_spinner() as on_message:  # the directory now, not after many runs
        result = find(loaded, allowed, more=listed("--with", more), on_message=on_message)
        written = [result.save(output), for_effects(result, output)]
    written += [write_scene(result.chosen, write, result.comments())] if write is not None else []
    if not more:
        keep(result)
    if as_json:
        print(json.dumps(result.to_json(), indent=2))
        return
    _print_effects(result)
    print_written(written)


def _print_effects(result: Effects) -> None:
    """Every effect that was measured or is required, then what the models cost."""
    from ..harness.report.studies.effects import effect_cells
    from ..harness.studies.quantities import percent

    print(f"{result.scene.title or result.scene.name}: effects within {percent(result.tolerance)}")
    print_cells(effect_cells(result))
    if left := [f.name for f in result.findings if f.status == "left out"]:
        print(f"not in the full model: {', '.join(left)}")
    for name, cost in (("all effects", result.full), ("the scene's own effects", result.given), ("smallest set", result.least)):
        print(f"{name}: error {percent(cost.error)}, {counted(cost.calls, 'call')}, {cost.seconds:.3g} s")
    print(f"models that were run: {result.runs}")


@app.command()
@reports
def stability(
    names: Annotated[
        list[str] | None,
        Argument(
            metavar="SCENE|component:NAME|COMPONENT...",
            autocompletion=anything,
            help="Shipped scene, scene file or component; components only with --hard-cases.",
        ),
    ] = None,
    hard: Annotated[
        bool,
        Option(
            "--hard-cases",
            help="Run the declared hard cases of the named components, or of all, and print the margin of each claim. They run in "
            "plain Python, as compiling would take minutes.",
        ),
    ] = False,
    over: Over = None,
    algorithm: Annotated[
        list[str] | None, Option(metavar="NAME[,...]", help="Algorithms to test. Default: jacobi and gauss-seidel.")
    ] = None,
    extrapolation: Annotated[
        list[int] | None, Option(metavar="0|1|2", min=0, max=2, help="Degree of extrapolation to test. May be repeated.")
    ] = None,
    effects: ComponentEffects = None,
    output: Output = Path("stability"),
    values: Changes = None,
    presets: Presets = None,
    resume: Resume = False,
) -> None:
    """Measure the longest stable macro step. Example: cosimo stability mass-on-spring --algorithm jacobi --extrapolation 0 -o out

    A component alone: cosimo stability component:Pantograph; without --effects it is measured with none and with each of its
    effects. Without a map: cosimo stability lumped-catenary.
    Hard cases of all components: cosimo stability --hard-cases -o out; exit code 1 where one does not hold.
    """
    of_scenes = {"--over": over, "--algorithm": algorithm, "--extrapolation": extrapolation}
    if hard:
        other = {**of_scenes, "--effects": effects, "--preset": presets, "--set": values}
        refuse(other, "no effect for hard cases, which have their own")
        _hard_cases(names or [], output, resume)
        return
    if not names or len(names) > 1:
        raise BadInput(
            "cosimo stability",
            " ".join(names or []) or "nothing",
            "one scene, or one component:NAME",
            "Several components: with --hard-cases.",
        )
    what = names[0]
    if what.startswith(COMPONENT):
        refuse(of_scenes, "no effect for a component alone")
        _internal_steps(what.removeprefix(COMPONENT), effects, values, preset_of(presets), output, resume)
        return
    refuse({"--effects": effects}, "no effect for a scene, which sets its own")
    from ..harness.report.studies.stability import for_stability, limit_cells
    from ..harness.studies.stability import schemes_of
    from ..harness.studies.stability import stability as measure
    from ..settings.algorithms import ALGORITHMS

    scene = scene_of(what, values, presets, {"study.stability": ranges_of(over) or None})
    algorithms = listed("--algorithm", algorithm)
    for name in algorithms:
        pick(name, ALGORITHMS, "--algorithm", "one of " + ", ".join(ALGORITHMS))
    with study(output, resume):  # the directory now, not after a long study
        measured = measure(scene, schemes_of(algorithms, extrapolation or []), progress=True)
        written = [measured.save(output), for_stability(measured, output)]
    print(scene.title or scene.name)
    print_cells(limit_cells(measured))
    for remark in measured.remarks:
        print(remark)
    print_written(written)


def _internal_steps(
    name: str, effects: list[str] | None, values: list[str] | None, preset: str, output: Path, resume: bool
) -> None:
    from ..harness.report.studies.stability import for_internal_steps, step_cells
    from ..harness.studies.internal_steps import internal_steps

    on = listed("--effects", effects) if effects else None
    parameters = parameters_of(values)
    with study(output, resume):
        measured = internal_steps(name, effects=on, parameters=parameters, preset=preset, progress=True)
        written = [measured.save(output), for_internal_steps(measured, output)]
    print(measured.title)
    print_cells(step_cells(measured))
    print_written(written)


def _hard_cases(names: list[str], output: Path, resume: bool) -> None:
    if not any(name.endswith(".components.core.kernels") for name in sys.modules):  # which decides it for this process
        os.environ["NUMBA_DISABLE_JIT"] = "1"
    from ..harness.report.studies.hard_cases import for_hard_cases, margin_text
    from ..harness.studies.hard_cases import hard_cases

    with study(output, resume):
        judged = hard_cases(names, progress=True)
        written = [judged.save(output), for_hard_cases(judged, output)]
    rows = [
        (v.component, v.case, v.claim, _number(v.reached), _number(v.limit), margin_text(v), "" if v.holds else "DOES NOT HOLD")
        for v in judged.verdicts
    ]
    print_table("Hard cases", ("component", "case", "what holds", "reached", "limit", "margin", ""), rows)
    for verdict in judged.failed:
        print(f"{verdict.component}, {verdict.case}: {verdict.message or 'beyond its limit'}")
    print(judged.summary)
    print_written(written)
    if judged.failed:
        raise SystemExit(FAILED_CHECK)


def _number(value: float) -> Any:
    return "" if isnan(value) else value


@app.command()
@reports
def gradient(
    scene: SceneName,
    of: Annotated[
        list[str] | None, Option(metavar="FIGURE", help='Figure of the summary, or "UNIT.OUTPUT, KIND". May be repeated.')
    ] = None,
    by: Annotated[
        list[str] | None, Option(metavar="UNIT.PARAMETER[,...]", help="Real parameters or free inputs. Default: all.")
    ] = None,
    differences: Annotated[
        float, Option(metavar="SHARE", help="Use differences of runs with this relative change, for scenes without derivatives.")
    ] = 0.0,
    output: Output = Path("gradient"),
    stop: Stop = None,
    values: Changes = None,
    presets: Presets = None,
    as_json: AsJson = False,
) -> None:
    """Find which parameters move a figure, and how far. Example: cosimo gradient en50318-2002 --of pantograph.std -o out

    Derivatives are exact for scenes of kernels; their errors are those of the steps. Elasticity: percent of the figure for one
    percent of the parameter.
    """
    from ..derivatives.gradient import gradient as find
    from ..harness.report.studies.gradient import for_gradient, gradient_cells

    loaded = scene_of(scene, values, presets, {"stop_time": stop})
    with status_spinner("derivatives"):
        measured = find(loaded, of or None, listed("--by", by) or None, differences=differences)
    warn(measured.remarks)
    written = [measured.save(output), for_gradient(measured, output)]
    if as_json:
        print(json.dumps(measured.to_json(), indent=2))
        return
    for figure in dict.fromkeys(s.figure for s in measured.slopes):
        print_cells(gradient_cells([s for s in measured.slopes if s.figure == figure]))
    for name, reason in measured.refused.items():
        print(f"{name}: no derivative: {reason}")
    print_written(written)
