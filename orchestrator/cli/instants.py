"""A scene about an instant or a steady state: modes, linear systems, operating points."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from typer import Option

from ...components.core.errors import BadInput
from .common import app, print_cells, print_written, scene_of, status_spinner, warn
from .options import AsJson, Changes, Output, Over, Presets, SceneName, listed, ranges_of, reports

if TYPE_CHECKING:
    from ..scene.scene import Scene

At = Annotated[float | None, Option("--at", metavar="SECONDS", help="Time of the instant. Default: the start.")]
FreeInputs = Annotated[list[str] | None, Option(metavar="UNIT.INPUT[,...]", help="Free inputs, for frequency responses.")]
OfInputs = Annotated[
    list[str] | None, Option(metavar="UNIT.OUTPUT[,...]", help="Their outputs. Default: those that are recorded.")
]


def _axes(scene: Scene, over: list[str] | None, most: int = 1) -> list[tuple[str, list[float]]]:
    """The parameters of --over and their values."""
    from numpy import linspace

    from ..scene.written_units import axes_with_numbers

    varied = axes_with_numbers(ranges_of(over), scene.settings()["units"], "--over")
    if len(varied) > most:
        raise BadInput("--over", ", ".join(varied), "one parameter" if most == 1 else f"{most} parameters at most")
    return [(n, linspace(v["from"], v["to"], v["points"]).tolist() if isinstance(v, dict) else v) for n, v in varied.items()]


def _axis(scene: Scene, over: list[str] | None) -> tuple[str, list[float]] | None:
    return next(iter(_axes(scene, over)), None)


@app.command()
@reports
def modes(
    scene: SceneName,
    at: At = None,
    over: Over = None,
    inputs: FreeInputs = None,
    outputs: OfInputs = None,
    output: Output = Path("modes"),
    values: Changes = None,
    presets: Presets = None,
    as_json: AsJson = False,
) -> None:
    """Find eigenvalues about an instant, with frequency, damping and units. Example: cosimo modes mass-on-spring -o out

    The linear system is exact for scenes of kernels; it is written as linear.npz and linear.mat.
    """
    from ..harness.report.studies.modes import for_modes, mode_cells
    from ..harness.studies.modes import modes as find

    loaded = scene_of(scene, values, presets)
    with status_spinner("derivatives"):
        measured = find(loaded, at, _axis(loaded, over), listed("--inputs", inputs), listed("--outputs", outputs))
    written = [*measured.save(output), for_modes(measured, output)]
    if as_json:
        print(json.dumps(measured.to_json(), indent=2))
        return
    print_cells(mode_cells(measured))
    warn(list(dict.fromkeys(text for _, linear in measured.points for text in linear.remarks)))
    for value, reason in measured.refused:
        print(f"{measured.parameter} = {value:g}: {reason}")
    print_written(written)


@app.command()
@reports
def trim(
    scene: SceneName,
    free: Annotated[
        list[str] | None, Option(metavar="UNIT.PARAMETER[,...]", help="Parameters or free inputs to be found, as many as --want.")
    ] = None,
    want: Annotated[
        list[str] | None,
        Option(metavar="UNIT.OUTPUT=VALUE", help='A wanted output, as in "hull.surge=0.5 m/s". May be repeated.'),
    ] = None,
    moving: Annotated[
        list[str] | None, Option(metavar="NAME[,...]", help="States or outputs that may move on steadily beside angles; all.")
    ] = None,
    at: At = None,
    over: Over = None,
    inputs: FreeInputs = None,
    outputs: OfInputs = None,
    output: Output = Path("trim"),
    values: Changes = None,
    presets: Presets = None,
    as_json: AsJson = False,
) -> None:
    """Find a steady state and its modes. Example: cosimo trim rov-station-keeping --at 34 -o out

    Newton's method starts where the scene stands at --at. The linear system about the state is written as linear.npz and linear.mat.
    """
    from ..derivatives.trim import trim as find
    from ..harness.report.studies.trim import for_trim, trim_cells
    from ..session.session import Session

    loaded = scene_of(scene, values, presets)
    wanted: dict[str, Any] = {}
    for text in want or ():
        name, equals, value = text.partition("=")
        if not equals:
            raise BadInput("--want", repr(text), "unit.output=value")
        try:
            wanted[name.strip()] = float(value)
        except ValueError:
            wanted[name.strip()] = value.strip()
    with status_spinner("derivatives"), Session(loaded) as session:
        if at is not None:
            session.initialize()
            session.until(at)
        states = find(
            loaded,
            listed("--free", free),
            wanted,
            moving=listed("--moving", moving),
            over=_axis(loaded, over),
            inputs=listed("--inputs", inputs),
            outputs=listed("--outputs", outputs),
            at=session.place,
        )
    written = [*states.save(output), for_trim(states, output)]
    if as_json:
        print(json.dumps(states.to_json(), indent=2))
        return
    print_cells(trim_cells(states))
    warn(list(dict.fromkeys(text for _, state in states.points for text in state.remarks)))
    for place, reason in states.refused:
        print(f"{states.parameter} = {place:g}: {reason}")
    print_written(written)


@app.command()
@reports
def orbit(
    scene: SceneName,
    over: Over = None,
    period: Annotated[float, Option(metavar="SECONDS", help="Period of a forcing that depends on time.")] = 0.0,
    frequency: Annotated[str, Option(metavar="UNIT.PARAMETER", help="A parameter that is the frequency of a forcing.")] = "",
    angle: Annotated[str, Option(metavar="UNIT.OUTPUT", help="An angle that turns. Default: that of [analysis] section.")] = "",
    turns: Annotated[float, Option(help="Periods in a turn of the angle.")] = 1.0,
    multiple: Annotated[int, Option(min=1, help="Periods to an orbit.")] = 1,
    guess: Annotated[float, Option(metavar="SECONDS", help="Period of a free oscillation, about.")] = 0.0,
    after: Annotated[int, Option(min=0, help="Periods of the run from which an orbit is sought.")] = 100,
    steps: Annotated[int, Option(min=0, help="Macro steps in a period, at least.")] = 0,
    doublings: Annotated[int, Option(min=0, help="Follow branches from so many period doublings, one after another.")] = 0,
    exponents: Annotated[
        int,
        Option(
            min=0, metavar="PERIODS", help="Where no stable orbit is found, measure the largest Lyapunov exponent over so many."
        ),
    ] = 0,
    output: Output = Path("orbit"),
    values: Changes = None,
    presets: Presets = None,
    as_json: AsJson = False,
) -> None:
    """Find periodic orbits and their bifurcations. Example: cosimo orbit ball-bearing-clearance --over bearing.speed=60:300:13 -o out

    Without a period the scene tells it: an angle that turns, or a free oscillation. Branches pass folds; period doublings and
    Neimark-Sacker points are located. A second --over makes a map: which motions are chaotic.
    """
    from ..derivatives.continuation import orbits
    from ..derivatives.orbit import Forcing
    from ..derivatives.orbit_map import EXPONENTS, orbit_map
    from ..harness.report.studies.orbits import for_orbit_map, for_orbits, map_cells, orbit_cells

    loaded = scene_of(scene, values, presets)
    section = loaded.analysis.section
    if not (angle or period or frequency or guess) and section is not None:
        angle, turns = section.angle, section.turns
    forcing = Forcing(period, frequency, angle, turns, multiple)
    axes = _axes(loaded, over, 2)
    options: dict[str, Any] = {"after": after, "guess": guess, "steps": steps, "doublings": doublings}
    with status_spinner("orbits") as show:
        options |= {"progress": show, "exponents": exponents or (EXPONENTS if len(axes) > 1 else 0)}
        if len(axes) > 1:
            map_of_two = orbit_map(loaded, forcing, *axes, **options)
            written, studies, cells = (
                [*map_of_two.save(output), for_orbit_map(map_of_two, output)],
                map_of_two.rows,
                [map_cells(map_of_two)],
            )
        else:
            states = orbits(loaded, forcing, next(iter(axes), None), **options)
            written = [*states.save(output), for_orbits(states, output)]
            studies, cells = ((0.0, states),), orbit_cells(states)
    if as_json:
        print(json.dumps((map_of_two if len(axes) > 1 else states).to_json(), indent=2))
        return
    for table in cells:
        print_cells(table)
    for value, study in studies:
        at = f"{axes[1][0]} = {value:g}, " if len(axes) > 1 else ""
        for place, reason in study.gaps:
            print(f"{at}{study.parameter} = {place:g}: {reason}")
    print_written(written)
