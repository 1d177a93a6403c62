"""What there is: lists; FMUs built and checked."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from ...components.core.errors import BadInput, nearest
from .common import FAILED_CHECK, AsJson, app, print_table


@app.command("list")
def list_(
    kind: Annotated[str, typer.Argument(help="components, fmus, scenes or cases; all of them without it")] = "",
    as_json: AsJson = False,
    schema: Annotated[bool, typer.Option("--schema", help="Print the JSON schema of a scene file, for editors.")] = False,
) -> None:
    """What there is. Example: cosimo list components"""
    if schema:
        from ..scene.scene import Scene

        print(json.dumps(Scene.model_json_schema(), indent=2))
        return
    kinds = {"components": _components, "fmus": _fmus, "scenes": _scenes, "cases": _cases}
    if kind and kind not in kinds:
        raise BadInput("list", repr(kind), "one of " + ", ".join(kinds), nearest(kind, kinds))
    listed = {name: entries() for name, entries in kinds.items() if kind in ("", name)}
    if as_json:
        print(json.dumps(listed, indent=2))
        return
    for name, entries in listed.items():
        print_table(name, ("name", "title"), [(e["name"], e["title"]) for e in entries])


def _components() -> list[dict[str, Any]]:
    from ...components.catalogue import CATALOGUE, component_class

    classes = {name: component_class(name) for name in CATALOGUE}
    return [{
        "name": name, "title": cls.title, "system": cls.system, "effects": list(cls.effects), "presets": list(cls.presets),
        "variables": [{"name": v.name, "causality": v.causality.value, "unit": v.unit, "start": v.start, "text": v.text}
                      for v in cls.variables.values()],
    } for name, cls in classes.items()]


def _fmus() -> list[dict[str, Any]]:
    from ...components.catalogue import CATALOGUE, component_class

    return [{"name": name, "title": component_class(name).title} for name in CATALOGUE]


def _scenes() -> list[dict[str, Any]]:
    from ..scene.scene import read_toml, scene_files

    return [{"name": name, "title": read_toml(path).get("title", "")} for name, path in scene_files().items()]


def _cases() -> list[dict[str, Any]]:
    from ..systems import cases

    return [{"name": name, "title": case.title} for name, case in cases().items()]


@app.command()
def build(
    names: Annotated[list[str] | None, typer.Argument(help="components, or module:Class; without it the catalogue")] = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Directory for the FMUs.")] = Path(),
    native: Annotated[bool, typer.Option("--native", help="FMUs without Python; effects and parameters are constants.")] = False,
    target: Annotated[str, typer.Option(help="With --native: linux64, win64 or both; default: this machine.")] = "",
    fmi: Annotated[str, typer.Option(help="With --native: 2, 3 or both; default: 2.")] = "",
    effects: Annotated[str, typer.Option(help="With --native: effects that are on, separated by commas.")] = "",
    values: Annotated[list[str] | None, typer.Option("--set", metavar="PARAMETER=VALUE", help=(
        "With --native: a parameter, or the start value of an input; may be repeated."))] = None,
    scene: Annotated[str, typer.Option(help="With --native: units of this scene, as it configures and starts them.")] = "",
    derivatives: Annotated[bool, typer.Option("--derivatives", help=(
        "List the inputs der(v) and der(v,2) of each input v, for masters that extrapolate."))] = False,
) -> None:
    """Build FMUs. Example: cosimo build Pantograph -o fmus-out"""
    from ...components.catalogue import CATALOGUE
    from ...fmus.build import build as build_fmu

    given = [option for option, value in (("--target", target), ("--fmi", fmi), ("--effects", effects), ("--set", values),
                                          ("--scene", scene)) if value]
    if native:
        from .native import build_native_fmus

        build_native_fmus(names or [], output, target, fmi, effects, values or [], scene, derivatives)
        return
    if given:
        raise BadInput("build", f"{given[0]} without --native", "no such option: other FMUs are configured by their host",
                       "Add --native, or leave it out.")
    for name in names or CATALOGUE:
        print(build_fmu(name, output, derivatives=derivatives))


@app.command()
def check(fmu: Annotated[str, typer.Argument(help="an FMU file; or a component or module:Class, whose FMU is built")],
          as_json: AsJson = False) -> None:
    """Check an FMU against FMI 2.0. Example: cosimo check Pantograph.fmu"""
    from ...components.catalogue import CATALOGUE
    from ...fmus.build import built
    from ...fmus.check import check as check_fmu

    path = Path(fmu)
    if not path.is_file():
        if fmu not in CATALOGUE and (":" not in fmu or path.suffix):
            raise BadInput("check", repr(fmu), "an FMU file, a component or module:Class", nearest(fmu, CATALOGUE))
        path = built(fmu)
    findings = check_fmu(path)
    if as_json:
        records = [{"name": f.name, "ok": f.ok, "detail": f.detail} for f in findings]
        print(json.dumps({"fmu": fmu, "findings": records}, indent=2))
    else:
        print_table(fmu, ("check", "ok", "detail"), [(f.name, "yes" if f.ok else "NO", f.detail) for f in findings])
    if not all(f.ok for f in findings):
        raise SystemExit(FAILED_CHECK)
