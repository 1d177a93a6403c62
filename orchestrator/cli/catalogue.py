"""What there is: lists; FMUs built and checked."""

from __future__ import annotations

import json
import textwrap
from pathlib import Path
from typing import Annotated, Any

import typer

from ...components.core.errors import BadInput, nearest
from .common import FAILED_CHECK, AsJson, Presets, app, output_width, print_table
from .completion import components as component_names
from .completion import kinds_and_systems


@app.command("list")
def list_(
    what: Annotated[
        str,
        typer.Argument(
            metavar="[KIND|SYSTEM|WORD]",
            autocompletion=kinds_and_systems,
            help=("components, fmus, scenes or cases; a system; or a word of names and titles. Without it names only."),
        ),
    ] = "",
    as_json: AsJson = False,
) -> None:
    """What there is. Example: cosimo list scenes; also cosimo list, cosimo list bearings"""
    kinds = {"components": _components, "fmus": _fmus, "scenes": _scenes, "cases": _cases}
    listed = {name: entries() for name, entries in kinds.items() if what in ("", name) or what not in kinds}
    if what and what not in kinds:
        listed = _selected(listed, what)
    if as_json:
        print(json.dumps(listed, indent=2))
    elif what:
        for name, entries in listed.items():
            if entries and not (name == "fmus" and what not in kinds):  # which are those of the components
                print_table(name, ("name", "title"), [(e["name"], e["title"]) for e in entries])
    else:
        _print_names(listed)


def _selected(listed: dict[str, list[dict[str, Any]]], word: str) -> dict[str, list[dict[str, Any]]]:
    """Entries of a system, or with a word in name or title; raises `BadInput` where there is none."""
    systems = {e["system"] for entries in listed.values() for e in entries}
    low = word.lower()
    chosen = {
        kind: [e for e in entries if e["system"] == word or (word not in systems and low in f"{e['name']} {e['title']}".lower())]
        for kind, entries in listed.items()
    }
    if not any(chosen.values()):
        names = [*listed, *sorted(systems), *(e["name"] for entries in listed.values() for e in entries)]
        raise BadInput("list", repr(word), "a kind, a system, or a word of a name or title", nearest(word, names))
    return chosen


def _print_names(listed: dict[str, list[dict[str, Any]]]) -> None:
    """Names in rows by system, which fit a screen."""
    for kind in ("components", "scenes", "cases"):
        systems: dict[str, list[str]] = {}
        for entry in listed[kind]:
            systems.setdefault(entry["system"], []).append(entry["name"])
        print(f"{kind} ({len(listed[kind])})")
        for system, names in systems.items():
            print(
                textwrap.fill(
                    " ".join(names),
                    output_width(),
                    initial_indent=f"  {system:15} ",
                    subsequent_indent=" " * 18,
                    break_on_hyphens=False,
                    break_long_words=False,
                )
            )
    print("titles: cosimo list KIND, cosimo list SYSTEM, cosimo list WORD; more of one: cosimo show NAME")


def _components() -> list[dict[str, Any]]:
    from ...components.catalogue import CATALOGUE, component_class

    classes = {name: component_class(name) for name in CATALOGUE}
    return [
        {
            "name": name,
            "title": cls.title,
            "system": cls.system,
            "effects": list(cls.effects),
            "presets": list(cls.presets),
            "variables": [
                {"name": v.name, "causality": v.causality.value, "unit": v.unit, "start": v.start, "text": v.text}
                for v in cls.variables.values()
            ],
        }
        for name, cls in classes.items()
    ]


def _fmus() -> list[dict[str, Any]]:
    from ...components.catalogue import CATALOGUE, component_class

    return [{"name": name, "title": (cls := component_class(name)).title, "system": cls.system} for name in CATALOGUE]


def _scenes() -> list[dict[str, Any]]:
    from ..scene.scene import read_toml, scene_files

    return [
        {"name": name, "title": read_toml(path).get("title", ""), "system": path.parents[1].name}
        for name, path in scene_files().items()
    ]


def _cases() -> list[dict[str, Any]]:
    from ..systems import cases

    return [{"name": name, "title": case.title, "system": case.system} for name, case in cases().items()]


@app.command()
def build(
    names: Annotated[
        list[str] | None,
        typer.Argument(autocompletion=component_names, help="components, or module:Class; without it the catalogue"),
    ] = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Directory for the FMUs.")] = Path(),
    native: Annotated[bool, typer.Option("--native", help="FMUs without Python; effects and parameters are constants.")] = False,
    target: Annotated[
        str, typer.Option(help=("With --native: linux64, win64, linux-arm64, separated by commas; default: this machine."))
    ] = "",
    fmi: Annotated[str, typer.Option(help="With --native: 2, 3 or both; default: 2.")] = "",
    effects: Annotated[str, typer.Option(help="With --native: effects that are on, separated by commas.")] = "",
    values: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="PARAMETER=VALUE",
            help=("With --native: a parameter, or the start value of an input; may be repeated."),
        ),
    ] = None,
    presets: Presets = None,
    scene: Annotated[str, typer.Option(help="With --native: units of this scene, as it configures and starts them.")] = "",
    derivatives: Annotated[
        bool,
        typer.Option(
            "--derivatives", help=("List the inputs der(v) and der(v,2) of each input v, for masters that extrapolate.")
        ),
    ] = False,
) -> None:
    """Build FMUs. Example: cosimo build Pantograph -o fmus-out"""
    from ...components.catalogue import CATALOGUE
    from ...fmus.build import build as build_fmu

    given = [
        option
        for option, value in (
            ("--target", target),
            ("--fmi", fmi),
            ("--effects", effects),
            ("--set", values),
            ("--preset", presets),
            ("--scene", scene),
        )
        if value
    ]
    if native:
        from .native import build_native_fmus

        build_native_fmus(names or [], output, target, fmi, effects, values or [], presets, scene, derivatives)
        return
    if given:
        raise BadInput(
            "build",
            f"{given[0]} without --native",
            "no such option: other FMUs are configured by their host",
            "Add --native, or leave it out.",
        )
    for name in names or CATALOGUE:
        print(build_fmu(name, output, derivatives=derivatives))


@app.command()
def check(
    fmu: Annotated[str, typer.Argument(help="an FMU file; or a component or module:Class, whose FMU is built")],
    as_json: AsJson = False,
) -> None:
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
