"""What several commands share: the application, options, tables on the terminal, changes of a scene given as text."""

from __future__ import annotations

import json
import re
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from ...components.core.errors import BadInput, nearest
from .completion import parameters, presets

if TYPE_CHECKING:
    from ..judgement.verification import Wish
    from ..scene.scene import Scene

FAILED_CHECK, BAD_INPUT, FAILED_RUN = 1, 2, 3
STOPPED = 128  # and the signal's number: 130 Ctrl-C, 143 SIGTERM, 129 SIGHUP, as shells give it
NAMED = 5  # changes that a title names
COMPONENT = "component:"  # before the name of a component that is studied alone

app = typer.Typer(no_args_is_help=True, pretty_exceptions_enable=False, add_completion=True, rich_markup_mode=None)


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"cosimo {version('cosimo')}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=_print_version, help=("Print the version and end."))
    ] = False,
) -> None:
    """Mechanical components as FMUs, coupled simulations of them, and validation against published tables."""


AsJson = Annotated[bool, typer.Option("--json", help="Print JSON for programs.")]
InProcess = Annotated[
    bool, typer.Option("--in-process", help=("Run components in this process, not as FMUs: bit-identical results, faster."))
]
Native = Annotated[
    bool, typer.Option("--native", help=("Components as native FMUs, which need no Python; built for the scene, and kept."))
]
NoVerify = Annotated[bool, typer.Option("--no-verify", help="Repeat nothing: numbers have no error.")]
Output = Annotated[Path | None, typer.Option("-o", "--output", help="Directory for the results.")]

Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="UNIT.PARAMETER=VALUE",
        autocompletion=parameters,
        help=("Change a parameter, in its SI unit, an array as [1, 2, 3], or analysis.key; may be repeated."),
    ),
]
Presets = Annotated[
    list[str] | None,
    typer.Option(
        "--preset",
        metavar="[UNIT=]NAME",
        autocompletion=presets,
        help=(
            "Published parameters of a scene's component, instead of the scene's own, or of a component alone; may be repeated."
        ),
    ),
]


def wish_of(verify: str | None, no_verify: bool, choices: Sequence[str]) -> Wish:
    """How numbers are to be verified, by the options --verify, one of the choices, and --no-verify; raises `BadInput`."""
    if verify is not None and no_verify:
        raise BadInput("--verify", f"{verify!r} and --no-verify", "one of them", "Remove one of them.")
    if verify is not None and verify not in choices:
        raise BadInput("--verify", repr(verify), " or ".join(choices))
    return "no" if no_verify else cast("Wish", verify or "auto")


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """A table on standard output; real numbers with four digits."""
    from rich.console import Console
    from rich.table import Table

    table = Table(*columns, title=title or None, title_justify="left")
    for row in rows:
        table.add_row(*(f"{cell:.4g}" if isinstance(cell, float) else str(cell) for cell in row))
    Console(width=output_width()).print(table, markup=False)


def output_width() -> int:
    """Width of what is printed; where there is no terminal wide enough for names, which would be cut."""
    return shutil.get_terminal_size().columns if sys.stdout.isatty() else 160


@contextmanager
def status_spinner() -> Iterator[Callable[[str], None]]:
    """A function that shows what is being done, on a terminal."""
    if not sys.stderr.isatty():
        yield lambda text: None
        return
    from rich.console import Console

    with Console(stderr=True).status("") as status:
        yield status.update


Resume = Annotated[bool, typer.Option("--resume", help="Go on with a study that was stopped: what it has computed is kept.")]


@contextmanager
def study(output: Path, resume: bool) -> Iterator[None]:
    """A study into a directory: a signal ends it with the exit code of the signal, and what it has computed is kept."""
    from ..harness.journal import Stopped, kept_study

    try:
        with kept_study(output, resume=resume):
            yield
    except Stopped as stopped:
        print(
            f"cosimo: stopped by {stopped.signal.name}; {stopped.kept} of its runs, solutions or limits are kept, and the same "
            "command with --resume goes on with them",
            file=sys.stderr,
        )
        raise SystemExit(STOPPED + stopped.signal) from None


def warn(warnings: Sequence[str]) -> None:
    """Each on a line of standard error."""
    for warning in warnings:
        print(f"cosimo: warning: {warning}", file=sys.stderr)


def listed(option: str, texts: Sequence[str]) -> list[str]:
    """Names separated by commas, but for those inside the brackets of an element."""
    names = [name.strip() for text in texts for name in re.split(r",(?![^\[]*\])", text)]
    if not all(names):
        raise BadInput(option, repr(",".join(texts)), "names separated by commas")
    return names


def switched_on(scene: Scene, texts: Sequence[str]) -> dict[str, Any]:
    """Changes of a scene that switch on effects, each given as "unit.effect"."""
    changes: dict[str, Any] = {}
    for text in listed("--effects", texts) if texts else []:
        unit, effect = scene.split(text)
        if not effect:
            raise BadInput("--effects", repr(text), "unit.effect")
        if unit not in scene.units:
            raise BadInput("--effects", f"unit {unit!r}", "a unit of the scene", nearest(unit, scene.units))
        place = f"units.{unit}.effects"
        on = changes.setdefault(place, list(scene.units[unit].effects))
        if effect in on or scene.coupling.interfaces[unit].effects.get(effect):
            raise BadInput("--effects", repr(text), "an effect that is not on already")
        on.append(effect)
    return changes


def change(scene: Scene, text: str) -> tuple[str, Any]:
    """(dotted place in the scene, value) of "unit.parameter=value" or "analysis.key=value"."""
    name, equals, value = text.partition("=")
    unit, parameter = scene.split(name.strip())
    if not equals or not parameter or not value:
        raise BadInput("--set", repr(text), "unit.parameter=value")
    return f"analysis.{parameter}" if unit == "analysis" else f"units.{unit}.parameters.{parameter}", value_of(value)


def value_of(text: str) -> Any:
    """A value given as text: a number, true or false, an array as [1, 2, 3], or the text itself."""
    for read in (int, float):
        try:
            return read(text)
        except ValueError:
            pass
    if text.startswith("["):
        try:
            return json.loads(text)
        except (ValueError, RecursionError):
            raise BadInput("--set", repr(text), "an array of numbers as [1, 2, 3]") from None
    return {"true": True, "false": False}.get(text, text)


def with_presets(scene: Scene, texts: Sequence[str]) -> dict[str, Any]:
    """Changes of a scene that give units published parameters, each given as "unit=preset"."""
    from ...components.catalogue import component_class

    changes = {}
    for text in texts:
        unit, equals, preset = (part.strip() for part in text.partition("="))
        if not (equals and preset):
            raise BadInput("--preset", repr(text), "unit=preset", "As in pantograph=DSA380.")
        if unit not in scene.units or not scene.units[unit].component:
            components = [name for name, u in scene.units.items() if u.component]
            raise BadInput("--preset", f"unit {unit!r}", "a component of the scene", nearest(unit, components))
        presets = component_class(scene.units[unit].component).presets
        if preset not in presets:
            raise BadInput("--preset", repr(preset), f"a preset of {scene.units[unit].component}", nearest(preset, presets))
        changes[f"units.{unit}.preset"] = preset
    return changes


def preset_of(texts: Sequence[str] | None) -> str:
    """The preset of a component alone; "" where none is given."""
    if len(texts or []) > 1 or any("=" in text for text in texts or []):
        raise BadInput("--preset", repr(",".join(texts or [])), "one preset of a component alone", "As in --preset DSA380.")
    return texts[0].strip() if texts else ""


def changes_of(scene: Scene, values: Sequence[str] | None, presets: Sequence[str] | None) -> dict[str, Any]:
    """Changes of a scene by --preset and --set."""
    return with_presets(scene, presets or []) | dict(change(scene, text) for text in values or [])


def loaded_scene(name: str) -> Scene:
    """A scene as `load_scene` reads it, for a person: with a warning where the schema of its editor is stale."""
    from ..systems import load_scene
    from .schema_file import stale

    scene = load_scene(name)
    warn(stale(name, [unit.component for unit in scene.units.values()]))
    return scene


def scene_of(
    name: str, values: Sequence[str] | None, presets: Sequence[str] | None, more: Mapping[str, Any] | None = None
) -> Scene:
    """A scene with the changes of the command line; more: those of other options."""
    loaded = loaded_scene(name)
    return changed(loaded, {**changes_of(loaded, values, presets), **(more or {})})


def changed(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """The scene with changes from the command line.

    The title of a scene may say what no longer holds; where what is simulated changes, another one names the changes.
    """
    if not changes:
        return scene
    named = [
        _named(place, value)
        for place, value in changes.items()
        if place.startswith("units.") and not place.endswith(".isolation")
    ]
    rest = f" and {len(named) - NAMED} more changes" if len(named) > NAMED else ""
    title = {"title": f"{scene.name}, changed: {', '.join(named[:NAMED])}{rest}"} if named else {}
    return scene.with_changes({**changes, **title})


def _named(place: str, value: Any) -> str:
    """A change as "unit.parameter = value", or "unit: effects a, b"."""
    unit, _, parameter = place.removeprefix("units.").partition(".parameters.")
    if unit.endswith(".preset"):
        return f"{unit.removesuffix('.preset')}: {value}"
    if parameter:
        return f"{unit}.{parameter} = {value:.6g}" if isinstance(value, float) else f"{unit}.{parameter} = {value}"
    return f"{unit.removesuffix('.effects')}: effects {', '.join(value) or 'none'}"


def share(option: str, text: str) -> float:
    """A share given as "1%" or "0.01"; raises `BadInput` for one above 100 % or not above 0.

    A number of 1 or more without a percent sign could mean either, and is refused with both spellings.
    """
    number, percent, rest = text.strip().partition("%")
    try:
        value = float(number)
    except ValueError:
        value = nan
    if not percent and 1.0 <= value <= 100.0:
        raise BadInput(
            option,
            repr(text),
            "a share with its percent sign, or below 1",
            f"{value:g} percent is written {value:g}% or {value / 100.0:g}.",
        )
    value /= 100.0 if percent else 1.0
    if rest or not 0.0 < value <= 1.0:
        raise BadInput(option, repr(text), "a share above 0 % and at most 100 %", "As in 1% or 0.01.")
    return value


def parameters_of(texts: Sequence[str]) -> dict[str, Any]:
    """Parameters of a component alone, each given as "parameter=value", by the names of their elements."""
    values: dict[str, Any] = {}
    for text in texts:
        parameter, equals, value = text.partition("=")
        if not (parameter and equals and value):
            raise BadInput("--set", repr(text), "parameter=value")
        given = value_of(value)
        elements = enumerate(given, 1) if isinstance(given, list) else ()
        values |= {f"{parameter.strip()}[{k}]": v for k, v in elements} or {
            parameter.strip(): float(given) if isinstance(given, int) and not isinstance(given, bool) else given
        }
    return values


def range_of(text: str) -> tuple[str, Any]:
    """("unit.parameter", range) of "unit.parameter=from:to:points"."""
    place, _, values = text.partition("=")
    try:
        first, last, points = values.split(":")
        return place.strip(), {"from": float(first), "to": float(last), "points": int(points)}
    except ValueError:
        raise BadInput("--over", repr(text), "unit.parameter=from:to:points", "As in --over bearing.speed=100:400:31.") from None
