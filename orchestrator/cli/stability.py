"""What stays stable: limits of the macro step of a scene, and of the internal step of a component."""

from __future__ import annotations

import os
import sys
from math import inf, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ...components.core.errors import BadInput, nearest
from .common import (
    COMPONENT,
    FAILED_CHECK,
    Changes,
    Presets,
    Resume,
    app,
    listed,
    parameters_of,
    preset_of,
    print_table,
    range_of,
    scene_of,
    study,
)
from .completion import anything

if TYPE_CHECKING:
    from ..harness.studies.stability import Scheme
    from ..scene.scene import Scene


@app.command()
def stability(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SCENE|component:NAME|COMPONENT...",
            autocompletion=anything,
            help=("name of a shipped scene, a scene file, or a component of the catalogue alone; with --hard-cases components"),
        ),
    ] = None,
    hard: Annotated[
        bool,
        typer.Option(
            "--hard-cases",
            help=(
                "Run the hard cases that components declare, of those named or of all, and say how far each claim is from its limit. "
                "In plain Python: the compiler would take minutes over runs of moments."
            ),
        ),
    ] = False,
    over: Annotated[
        list[str] | None,
        typer.Option(
            "--over",
            metavar="UNIT.PARAMETER=FROM:TO:POINTS",
            help=("Values of a parameter, instead of the scene's [study]; two make a map."),
        ),
    ] = None,
    algorithm: Annotated[
        list[str] | None,
        typer.Option("--algorithm", metavar="NAME[,...]", help=("Only these algorithms; default: all that the scene can have.")),
    ] = None,
    extrapolation: Annotated[
        list[int] | None, typer.Option("--extrapolation", min=0, max=2, help=("Only this degree; may be repeated."))
    ] = None,
    steps: Annotated[
        int | None,
        typer.Option("--steps", help=("Steps of each run; more of them show slower growth. Default 1000, 600 for a component.")),
    ] = None,
    effects: Annotated[
        list[str] | None,
        typer.Option(
            "--effects",
            metavar="EFFECT[,...]",
            help=("Effects of a component that is measured alone; default: none, and each with what it needs."),
        ),
    ] = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Directory for the table and the report.")] = Path("stability"),
    values: Changes = None,
    presets: Presets = None,
    resume: Resume = False,
) -> None:
    """Measure how long steps may be. Example: cosimo stability mass-on-spring --algorithm jacobi --extrapolation 0 -o out

    A component alone: cosimo stability component:Pantograph. Without a map: cosimo stability lumped-catenary.
    Hard cases of all components: cosimo stability --hard-cases -o out; exit code 1 where one does not hold.
    """
    if hard:
        for option, given in {
            "--over": over,
            "--algorithm": algorithm,
            "--extrapolation": extrapolation,
            "--steps": steps,
            "--effects": effects,
            "--preset": presets,
            "--set": values,
        }.items():
            if given:
                raise BadInput(option, "a value", "none for hard cases, which have their own", "Remove it.")
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
        for option, given in (("--over", over), ("--algorithm", algorithm), ("--extrapolation", extrapolation)):
            if given:
                raise BadInput(option, "a value", "none for a component alone", "Remove it.")
        _internal_steps(what.removeprefix(COMPONENT), effects, values, preset_of(presets), steps, output, resume)
        return
    if effects:
        raise BadInput("--effects", repr(",".join(effects)), "none for a scene, which names its own", "Remove it.")
    _macro_steps(what, over, values, presets, algorithm, extrapolation, steps, output, resume)


def _macro_steps(
    what: str,
    over: list[str] | None,
    values: list[str] | None,
    presets: list[str] | None,
    algorithm: list[str] | None,
    extrapolation: list[int] | None,
    steps: int | None,
    output: Path,
    resume: bool,
) -> None:
    from ..harness.report.studies.stability import for_stability
    from ..harness.studies.stability import STEPS
    from ..harness.studies.stability import stability as measure

    scene = scene_of(what, values, presets, {"study.stability": dict(map(range_of, over))} if over else {})
    schemes = _schemes(scene, algorithm, extrapolation)
    with study(output, resume):  # the directory now, not after a long study
        measured = measure(scene, schemes, steps=steps or STEPS, progress=True)
        written = [measured.save(output), for_stability(measured, output)]
    names = list(measured.varied)
    print_table(
        f"{scene.title or scene.name}: longest stable macro step",
        (*names, "algorithm", "degree", "s", "closed form, s", "what the next longer step did"),
        [
            (
                *limit.point.values(),
                limit.algorithm,
                limit.extrapolation,
                _shown(limit.longest, limit.tried),
                "" if isnan(limit.closed) else limit.closed,
                limit.seen,
            )
            for limit in measured.limits
        ],
    )
    for remark in measured.remarks:
        print(remark)
    print("wrote " + ", ".join(map(str, written)))


def _schemes(scene: Scene, algorithm: list[str] | None, extrapolation: list[int] | None) -> list[Scheme]:
    from ..harness.studies.stability import schemes_of
    from ..settings.algorithms import ALGORITHMS

    names = listed("--algorithm", algorithm) if algorithm else []
    for name in names:
        if name not in ALGORITHMS:
            raise BadInput("--algorithm", repr(name), "one of " + ", ".join(ALGORITHMS), nearest(name, ALGORITHMS))
    return schemes_of(scene, names, extrapolation or [])


def _internal_steps(
    name: str, effects: list[str] | None, values: list[str] | None, preset: str, steps: int | None, output: Path, resume: bool
) -> None:
    from ..harness.report.studies.stability import for_internal_steps
    from ..harness.studies.internal_steps import STEPS, internal_steps

    chosen = listed("--effects", effects) if effects else None
    parameters = parameters_of(values or [])
    with study(output, resume):
        measured = internal_steps(name, effects=chosen, parameters=parameters, preset=preset, steps=steps or STEPS, progress=True)
        written = [measured.save(output), for_internal_steps(measured, output)]
    print_table(
        f"{measured.title}: longest stable internal step",
        ("effects", "s", "own limit, s", "margin", "what the next longer step did"),
        [
            (
                ", ".join(s.effects) or "none",
                _shown(s.longest, s.tried),
                "none" if s.own == inf else s.own,
                "" if isnan(s.margin) else s.margin,
                s.seen,
            )
            for s in measured.steps
        ],
    )
    print("wrote " + ", ".join(map(str, written)))


def _hard_cases(names: list[str], output: Path, resume: bool) -> None:
    if "numba" not in sys.modules:
        os.environ["NUMBA_DISABLE_JIT"] = "1"
    from ..harness.report.studies.hard_cases import for_hard_cases, margin_text
    from ..harness.studies.hard_cases import hard_cases

    with study(output, resume):
        judged = hard_cases(names, progress=True)
        written = [judged.save(output), for_hard_cases(judged, output)]
    print_table(
        "Hard cases",
        ("component", "case", "what holds", "reached", "limit", "margin", ""),
        [
            (
                v.component,
                v.case.name,
                v.claim,
                "" if isnan(v.reached) else v.reached,
                "" if isnan(v.limit) else v.limit,
                margin_text(v),
                "" if v.holds else "DOES NOT HOLD",
            )
            for v in judged.verdicts
        ],
    )
    for verdict in judged.failed:
        print(f"{verdict.component}, {verdict.case.name}: {verdict.message or 'beyond its limit'}")
    print(judged.summary)
    print("wrote " + ", ".join(map(str, written)))
    if judged.failed:
        raise SystemExit(FAILED_CHECK)


def _shown(longest: float, tried: float) -> str:
    if isnan(longest):
        return "not measured"
    return f"above {tried:.4g}" if longest == inf else f"none, down to {tried:.4g}" if longest == 0.0 else f"{longest:.4g}"
