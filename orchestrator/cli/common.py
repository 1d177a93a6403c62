"""What several commands share: the application, options, tables on the terminal, changes of a scene given as text."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...components.core.errors import BadInput, nearest

if TYPE_CHECKING:
    from ..scene.scene import Scene

FAILED_CHECK, BAD_INPUT, FAILED_RUN = 1, 2, 3
STOPPED = 128  # and the signal's number: 130 Ctrl-C, 143 SIGTERM, 129 SIGHUP, as shells give it
NAMED = 5  # changes that a title names
COMPONENT = "component:"  # before the name of a component that is studied alone

app = typer.Typer(no_args_is_help=True, pretty_exceptions_enable=False, add_completion=False, rich_markup_mode=None,
                  help="Mechanical components as FMUs, coupled simulations of them, and validation against published tables.")
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON for programs.")]
InProcess = Annotated[bool, typer.Option("--in-process", help=(
    "Run components in this process, not as FMUs: bit-identical results, faster."))]
Native = Annotated[bool, typer.Option("--native", help=(
    "Components as native FMUs, which need no Python; built for the scene, and kept."))]
Output = Annotated[Path | None, typer.Option("-o", "--output", help="Directory for the results.")]

Changes = Annotated[list[str] | None, typer.Option("--set", metavar="UNIT.PARAMETER=VALUE", help=(
    "Change a parameter, in its SI unit, or analysis.key; may be repeated."))]


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """A table on standard output; real numbers with four digits."""
    from rich.console import Console
    from rich.table import Table

    table = Table(*columns, title=title or None, title_justify="left")
    for row in rows:
        table.add_row(*(f"{cell:.4g}" if isinstance(cell, float) else str(cell) for cell in row))
    # rich takes 80 columns where there is no terminal, and cuts names
    Console(width=None if sys.stdout.isatty() else 160).print(table, markup=False)


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
        print(f"cosimo: stopped by {stopped.signal.name}; {stopped.kept} of its runs, solutions or limits are kept, and the same "
              "command with --resume goes on with them", file=sys.stderr)
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
    place = f"analysis.{parameter}" if unit == "analysis" else f"units.{unit}.parameters.{parameter}"
    for read in (int, float):
        try:
            return place, read(value)
        except ValueError:
            pass
    return place, {"true": True, "false": False}.get(value, value)


def changed(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """The scene with changes from the command line.

    The title of a scene may say what no longer holds; where what is simulated changes, another one names the changes.
    """
    if not changes:
        return scene
    named = [_named(place, value) for place, value in changes.items()
             if place.startswith("units.") and not place.endswith(".isolation")]
    rest = f" and {len(named) - NAMED} more changes" if len(named) > NAMED else ""
    title = {"title": f"{scene.name}, changed: {', '.join(named[:NAMED])}{rest}"} if named else {}
    return scene.with_changes({**changes, **title})


def _named(place: str, value: Any) -> str:
    """A change as "unit.parameter = value", or "unit: effects a, b"."""
    unit, _, parameter = place.removeprefix("units.").partition(".parameters.")
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
        raise BadInput(option, repr(text), "a share with its percent sign, or below 1",
                       f"{value:g} percent is written {value:g}% or {value / 100.0:g}.")
    value /= 100.0 if percent else 1.0
    if rest or not 0.0 < value <= 1.0:
        raise BadInput(option, repr(text), "a share above 0 % and at most 100 %", "As in 1% or 0.01.")
    return value


def parameters_of(texts: Sequence[str]) -> dict[str, Any]:
    """Parameters of a component alone, each given as "parameter=value"."""
    values: dict[str, Any] = {}
    for text in texts:
        parameter, equals, value = text.partition("=")
        if not (parameter and equals and value):
            raise BadInput("--set", repr(text), "parameter=value")
        try:
            values[parameter.strip()] = float(value)
        except ValueError:
            values[parameter.strip()] = {"true": True, "false": False}.get(value, value)
    return values


def range_of(text: str) -> tuple[str, Any]:
    """("unit.parameter", range) of "unit.parameter=from:to:points"."""
    place, _, values = text.partition("=")
    try:
        first, last, points = values.split(":")
        return place.strip(), {"from": float(first), "to": float(last), "points": int(points)}
    except ValueError:
        raise BadInput("--over", repr(text), "unit.parameter=from:to:points", "As in --over bearing.speed=100:400:31.") from None
