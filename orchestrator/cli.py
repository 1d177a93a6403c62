"""The command `cosimo`. Heavy imports stand inside the commands, so that --help is quick.

Exit codes: 0 done, 1 a check or a validation failed, 2 bad input, 3 the simulation failed (its partial result is kept).
"""

from __future__ import annotations

import json
import logging
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from components.core.errors import BadInput, nearest

if TYPE_CHECKING:
    from .scene import Scene

FAILED_CHECK, BAD_INPUT, FAILED_RUN = 1, 2, 3

app = typer.Typer(no_args_is_help=True, pretty_exceptions_enable=False, add_completion=False, rich_markup_mode=None,
                  help="Mechanical components as FMUs, coupled simulations of them, and validation against published tables.")
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON for programs.")]
InProcess = Annotated[bool, typer.Option("--in-process", help="Run components in this process, not as FMUs: same bits, faster.")]
Output = Annotated[Path | None, typer.Option("-o", "--output", help="Directory for the results.")]

Changes = Annotated[list[str] | None, typer.Option("--set", metavar="UNIT.PARAMETER=VALUE", help=(
    "Change a parameter, in its SI unit, or analysis.key; may be repeated."))]
CHECKPOINT = "checkpoint"  # file in the output directory


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line; ends in SystemExit with the exit code."""
    logging.getLogger("cosimo").addHandler(logging.NullHandler())  # our FMUs log there; a failed step carries the same text
    try:
        app(arguments)
    except BadInput as error:
        print(f"cosimo: {error}", file=sys.stderr)
        raise SystemExit(BAD_INPUT) from None
    except OSError as error:  # a full disk, a folder that is a file ...: nothing the code could do better
        place = repr(str(error.filename)) if error.filename is not None else "output"
        print(f"cosimo: {place}: {error.strerror or error}; expected a place that can be read and written", file=sys.stderr)
        raise SystemExit(BAD_INPUT) from None


def _print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(*columns, title=title or None, title_justify="left")
    for row in rows:
        table.add_row(*(f"{cell:.4g}" if isinstance(cell, float) else str(cell) for cell in row))
    # rich takes 80 columns where there is no terminal, and cuts names
    Console(width=None if sys.stdout.isatty() else 160).print(table, markup=False)


@app.command("list")
def list_(
    kind: Annotated[str, typer.Argument(help="components, fmus, scenes or cases; all of them without it")] = "",
    as_json: AsJson = False,
    schema: Annotated[bool, typer.Option("--schema", help="Print the JSON schema of a scene file, for editors.")] = False,
) -> None:
    """What there is. Example: cosimo list components"""
    if schema:
        from .scene import Scene

        print(json.dumps(Scene.model_json_schema(), indent=2))
        return
    kinds = {"components": _components, "fmus": _fmus, "scenes": _scenes, "cases": _cases}
    if kind and kind not in kinds:
        raise BadInput("list", repr(kind), "one of " + ", ".join(kinds), nearest(kind, kinds))
    found = {name: entries() for name, entries in kinds.items() if kind in ("", name)}
    if as_json:
        print(json.dumps(found, indent=2))
        return
    for name, entries in found.items():
        _print_table(name, ("name", "title"), [(e["name"], e["title"]) for e in entries])


def _components() -> list[dict[str, Any]]:
    from components.catalogue import CATALOGUE, component_class

    classes = {name: component_class(name) for name in CATALOGUE}
    return [{
        "name": name, "title": cls.title, "system": cls.system, "effects": list(cls.effects), "presets": list(cls.presets),
        "variables": [{"name": v.name, "causality": v.causality.value, "unit": v.unit, "start": v.start, "text": v.text}
                      for v in cls.variables.values()],
    } for name, cls in classes.items()]


def _fmus() -> list[dict[str, Any]]:
    from components.catalogue import CATALOGUE, component_class

    return [{"name": name, "title": component_class(name).title} for name in CATALOGUE]


def _scenes() -> list[dict[str, Any]]:
    from .scene import read_toml, scene_files

    return [{"name": name, "title": read_toml(path).get("title", "")} for name, path in scene_files().items()]


def _cases() -> list[dict[str, Any]]:
    from .validation.cases import CASES

    return [{"name": name, "title": case.title} for name, case in CASES.items()]


@app.command()
def build(
    names: Annotated[list[str] | None, typer.Argument(help="components; all of them without it")] = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Directory for the FMUs.")] = Path(),
) -> None:
    """Build FMUs. Example: cosimo build Pantograph -o fmus-out"""
    from components.catalogue import CATALOGUE
    from fmus.build import build as build_fmu

    for name in names or CATALOGUE:
        print(build_fmu(name, output))


@app.command()
def check(fmu: Annotated[Path, typer.Argument(help="an FMU file")], as_json: AsJson = False) -> None:
    """Check an FMU against FMI 2.0. Example: cosimo check Pantograph.fmu"""
    from fmus.check import check as check_fmu

    if not fmu.is_file():
        raise BadInput("check", repr(str(fmu)), "an FMU file")
    findings = check_fmu(fmu)
    if as_json:
        found = [{"name": f.name, "ok": f.ok, "detail": f.detail} for f in findings]
        print(json.dumps({"fmu": str(fmu), "findings": found}, indent=2))
    else:
        _print_table(str(fmu), ("check", "ok", "detail"), [(f.name, "yes" if f.ok else "NO", f.detail) for f in findings])
    if not all(f.ok for f in findings):
        raise SystemExit(FAILED_CHECK)


@app.command()
def run(
    scene: Annotated[str, typer.Argument(help="name of a shipped scene, or a scene file")],
    in_process: InProcess = False,
    output: Output = None,
    values: Changes = None,
    effects: Annotated[list[str] | None, typer.Option("--effects", metavar="UNIT.EFFECT[,...]", help=(
        "Switch on effects beside those of the scene; may be repeated."))] = None,
    algorithm: Annotated[str | None, typer.Option("--algorithm", help=(
        "jacobi, gauss-seidel, iterative or interface-model"))] = None,
    step: Annotated[float | None, typer.Option("--step", help="Macro step, s.")] = None,
    stop: Annotated[float | None, typer.Option("--stop", help="End of the run, s.")] = None,
    record: Annotated[list[str] | None, typer.Option("--record", metavar="UNIT.OUTPUT[,...]", help=(
        "Outputs to keep instead of those of the scene; may be repeated."))] = None,
    checkpoint_every: Annotated[float | None, typer.Option("--checkpoint-every", metavar="SECONDS", help=(
        f"Write {CHECKPOINT} into the output directory, from which --resume goes on; s of simulated time."))] = None,
    resume: Annotated[Path | None, typer.Option("--resume", help="A checkpoint of the same scene, to go on from.")] = None,
    dry_run: Annotated[bool, typer.Option("--dry-run", help=(
        "Do not run: show how the scene is settled, how long its macro step may be, and what a run costs."))] = False,
) -> None:
    """Run a scene. Example: cosimo run scene.toml --set pantograph.speed=83.3 --effects pantograph.bump_stops -o out

    To see first what it would do: cosimo run scene.toml --step 2e-3 --dry-run. To go on after an interrupt: cosimo run
    scene.toml -o out --checkpoint-every 1, then cosimo run scene.toml -o out --resume out/checkpoint.
    """
    from .results import made
    from .run import run as run_scene
    from .scene import load_scene

    loaded = load_scene(scene)
    given = {"master.step": step, "stop_time": stop, "master.algorithm": algorithm,
             "record.signals": _listed("--record", record) if record else None}
    changes = {place: value for place, value in given.items() if value is not None}
    changes |= _effects(loaded, effects or []) | dict(_change(loaded, text) for text in values or [])
    if changes:
        loaded = loaded.with_changes(changes)
    if in_process and all(unit.fmu for unit in loaded.units.values()):
        raise BadInput("--in-process", "a scene of FMUs only", "components; it would have no effect", "Remove it.")
    if dry_run:
        for option, value in (("-o", output), ("--checkpoint-every", checkpoint_every), ("--resume", resume)):
            if value is not None:
                raise BadInput(option, repr(str(value)), "none with --dry-run; it would have no effect", "Remove one of them.")
        _dry_run(loaded, in_process)
        return
    if checkpoint_every is not None and output is None:
        raise BadInput("--checkpoint-every", f"{checkpoint_every:g} s without -o", "an output directory as well")
    if output is not None:
        made(output)  # now, not after a long run
    result = run_scene(loaded, in_process=in_process, progress=True, checkpoint_every=checkpoint_every,
                       checkpoint_to=None if output is None or checkpoint_every is None else output / CHECKPOINT, resume=resume)
    if output is not None:
        from . import report

        result.save(output)
        written = ["result.csv", "run.json"]
        if result.time.size > 1:
            written.append(report.for_run(result, output).name)
        print("wrote " + ", ".join(str(output / name) for name in written))
    _print_table(f"{loaded.title or loaded.name}: {result.outcome}", ("signal", "unit", "min", "max", "end"), [
        (name, result.measures[name], float(c.min()), float(c.max()), float(c[-1]))
        for name, c in result.columns.items() if c.size
    ])
    timing = result.info["timing"]
    print(f"{timing['simulated']:g} s simulated in {timing['run']:.3g} s, {timing['start']:.3g} s to start")
    _warn(result.info["warnings"])
    if result.outcome != "done":
        print(f"cosimo: {result.message}", file=sys.stderr)
        raise SystemExit(FAILED_RUN)


def _warn(warnings: Sequence[str]) -> None:
    for warning in warnings:
        print(f"cosimo: warning: {warning}", file=sys.stderr)


def _dry_run(scene: Scene, in_process: bool) -> None:
    from components.core.errors import StepFailed

    from .advice import advise
    from .advice.dry_run import lines, tables
    from .coupling import settle

    try:
        advice = advise(scene, in_process=in_process)
    except StepFailed as error:
        print(f"cosimo: {error}", file=sys.stderr)
        raise SystemExit(FAILED_RUN) from None
    coupling = settle(scene)
    for table in tables(scene, coupling, advice):
        _print_table(*table)
    for line in lines(scene, coupling, advice):
        print(line)
    _warn([*scene.remarks, *advice.warnings(scene)])


def _listed(option: str, texts: Sequence[str]) -> list[str]:
    """Names separated by commas, but for those inside the brackets of an element."""
    names = [name.strip() for text in texts for name in re.split(r",(?![^\[]*\])", text)]
    if not all(names):
        raise BadInput(option, repr(",".join(texts)), "names separated by commas")
    return names


def _effects(scene: Scene, texts: Sequence[str]) -> dict[str, Any]:
    """Changes of a scene that switch on effects, each given as "unit.effect"."""
    from .coupling import settle

    changes: dict[str, Any] = {}
    for text in _listed("--effects", texts) if texts else []:
        unit, effect = scene.split(text)
        if not effect:
            raise BadInput("--effects", repr(text), "unit.effect")
        if unit not in scene.units:
            raise BadInput("--effects", f"unit {unit!r}", "a unit of the scene", nearest(unit, scene.units))
        place = f"units.{unit}.effects"
        on = changes.setdefault(place, list(scene.units[unit].effects))
        if effect in on or settle(scene).interfaces[unit].effects.get(effect):
            raise BadInput("--effects", repr(text), "an effect that is not on already")
        on.append(effect)
    return changes


def _change(scene: Scene, text: str) -> tuple[str, Any]:
    """(dotted place in the scene, value) of "unit.parameter=value" or "analysis.key=value"."""
    name, equals, value = text.partition("=")
    unit, parameter = scene.split(name.strip())
    if not equals or not parameter or not value:
        raise BadInput("--set", repr(text), "unit.parameter=value")
    place = f"analysis.{parameter}" if unit == "analysis" else f"units.{unit}.parameters.{parameter}"
    for read in (int, float):
        try:
            return place, read(value)
        except ValueError:
            pass
    return place, {"true": True, "false": False}.get(value, value)


@app.command()
def sweep(
    scene: Annotated[str, typer.Argument(help="name of a shipped scene, or a scene file")],
    over: Annotated[list[str] | None, typer.Option("--over", metavar="UNIT.PARAMETER=FROM:TO:POINTS", help=(
        "Values of a parameter, instead of the scene's [sweep]; several make a grid."))] = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Directory for sweep.csv and the report.")] = Path("sweep"),
    values: Changes = None,
) -> None:
    """Run a scene over the values of parameters. Example: cosimo sweep scene.toml --over bearing.speed=100:400:31 -o out"""
    from . import report
    from .results import made
    from .scene import load_scene
    from .sweep import sweep as run_sweep

    loaded = load_scene(scene)
    changes: dict[str, Any] = dict(_change(loaded, text) for text in values or [])
    if over:
        changes["sweep"] = dict(map(_range_of, over))
    if changes:
        loaded = loaded.with_changes(changes)
    made(output)  # now, not after a long sweep
    found = run_sweep(loaded, progress=True)
    written = [found.save(output), report.for_sweep(found, output)]
    failed = [o for o in found.outcomes if o != "done"]
    print(f"{len(found.outcomes)} points, {len(failed)} failed; wrote {', '.join(map(str, written))}")
    for reason in dict.fromkeys(failed):
        print(f"cosimo: {reason}", file=sys.stderr)
    if failed:
        raise SystemExit(FAILED_RUN)


def _range_of(text: str) -> tuple[str, Any]:
    """("unit.parameter", range) of "unit.parameter=from:to:points"."""
    place, _, values = text.partition("=")
    try:
        first, last, points = values.split(":")
        return place.strip(), {"from": float(first), "to": float(last), "points": int(points)}
    except ValueError:
        raise BadInput("--over", repr(text), "unit.parameter=from:to:points", "As in --over bearing.speed=100:400:31.") from None


@app.command()
def ssp(
    scene: Annotated[str, typer.Argument(help="name of a shipped scene, or a scene file")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="File to write; default: the scene's name.")] = None,
    values: Changes = None,
) -> None:
    """Pack a scene with its FMUs for other tools (SSP 1.0). Example: cosimo ssp en50318-2002 -o en50318-2002.ssp"""
    from .scene import load_scene
    from .ssp.write import write

    loaded = load_scene(scene)
    if values:
        loaded = loaded.with_changes(dict(_change(loaded, value) for value in values))
    _warn(loaded.remarks)
    print(f"wrote {write(loaded, output or Path(f'{loaded.name}.ssp'))}")


@app.command()
def validate(
    cases: Annotated[list[str] | None, typer.Argument(help="names of cases, see cosimo list cases; all without it")] = None,
    in_process: InProcess = False,
    output: Annotated[Path, typer.Option("-o", "--output", help="Directory for the report.")] = Path("validation"),
    as_json: AsJson = False,
) -> None:
    """Run cases and hold them against their tables. Example: cosimo validate en50318-2018-ac-simple -o out"""
    from .report.style import number
    from .validation import validate as validate_cases
    from .validation.case import to_json

    results = validate_cases(cases or [], output, in_process=in_process, progress=not as_json)
    if as_json:
        print(to_json(results))
    else:
        for result in results:
            columns = ("quantity", "condition", "unit", "measured", "range", "margin", "standing", "inside")
            _print_table(result.case.title, columns, [
                (r["quantity"], r["condition"], r["unit"], number(row.measured, r["low"], r["high"]), _range(r["low"], r["high"]),
                 row.margin, r["standing"], "yes" if r["inside"] else "NO")
                for row in result.findings.rows for r in [row.to_json()]
            ])
            print(f"{result.case.name}: {result.verdict}")
        print(f"report: {results[0].report}")
    if any(result.outcome == "failed" for result in results):
        raise SystemExit(FAILED_CHECK)


def _range(low: float | None, high: float | None) -> str:
    """A range of a table, with the digits that its width asks for; an open end is left out."""
    from .report.style import number

    if low is None or high is None:
        return f"up to {high:.6g}" if low is None else f"from {low:.6g}"
    return f"{number(low, low, high)} ... {number(high, low, high)}"


if __name__ == "__main__":
    main()
