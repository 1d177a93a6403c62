"""The application, scenes with the changes of the command line, and what commands print."""

from __future__ import annotations

import os
import re
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from signal import SIGINT
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from ...components.core.errors import BadInput, nearest, pick, visible, visible_lines
from ..interrupts import Interrupted, interruptible
from .column_widths import column_widths
from .options import listed, value_of

if TYPE_CHECKING:
    from ..harness.charts.blocks import Cells
    from ..harness.validation.case import CaseResult
    from ..scene.scene import Scene

FAILED_CHECK, BAD_INPUT, FAILED_RUN = 1, 2, 3
STOPPED = 128  # and the signal's number: 130 Ctrl-C, 143 SIGTERM, 129 SIGHUP, as shells give it
NAMED = 5  # changes that a title names
NO_PART = re.compile(r"\.isolation$|\.tolerances\b")  # of what is simulated
OPTIONS = {
    "start_time": "--start",
    "stop_time": "--stop",
    "master.step": "--step",
    "master.algorithm": "--algorithm",
}  # of a scene, by options of their own
UNLIMITED = 10_000  # columns of what is no terminal: nothing is cut or folded
# of verdicts, where the terminal has colours
COLOURS = {
    "yes": "green",
    "NO": "bold red",
    "within": "green",
    "within, unconfirmed": "yellow",
    "outside": "bold red",
    "undecided": "yellow",
    "shown": "green",
    "contradicted": "bold red",
    "not shown": "yellow",
}


class Commands(TyperGroup):
    """All commands, in groups by what they are for. Signals are answered at any moment, and a closed pipe ends them quietly."""

    def __init__(self, **attributes: Any):
        super().__init__(**attributes)
        commands: list[Any] = list(self.commands.values())
        for command in commands:
            commands += getattr(command, "commands", {}).values()
            for argument in command.params:
                if (
                    getattr(argument, "type_descriptor", None)
                    and argument.type_descriptor.is_list
                    and not argument.opts[0].startswith("-")
                ):
                    argument.display_type = lambda context: ""  # the name has dots; typer adds a type of Python

    def invoke(self, ctx: Any) -> Any:
        try:
            with interruptible():
                value = super().invoke(ctx)
                sys.stdout.flush()
                return value
        except KeyboardInterrupt as stop:
            one = stop.signal if isinstance(stop, Interrupted) else SIGINT
            raise fail(f"stopped by {one.name}; what was written before stays", STOPPED + one) from None
        except BrokenPipeError:  # such as of `| head`
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise SystemExit(STOPPED + 13) from None

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        listed = set()
        for title, names in GROUPS.items():
            self._section(title, [n for n in names if n in self.commands], formatter)
            listed |= set(names)
        self._section("Others", [n for n in self.commands if n not in listed], formatter)

    def _section(self, title: str, names: Sequence[str], formatter: Any) -> None:
        if names:
            with formatter.section(title):
                formatter.write_dl([(n, first_sentence(self.commands[n].help or "")) for n in names])


def first_sentence(text: str) -> str:
    """The first sentence of a help text, on one line and whole."""
    line = " ".join(text.partition("\n\n")[0].split())
    return line.partition(" Example:")[0].partition(". ")[0].rstrip(".") + "."


# what commands are for, in the order of the help
GROUPS = {
    "Simulate": ("run", "show", "list", "compare", "explore", "new"),
    "Check": ("validate", "accuracy", "stability", "effects", "gradient", "modes", "trim", "orbit", "estimate"),
    "Many runs": ("sweep", "sensitivity", "uncertainty", "fit", "design"),
    "Export": ("build", "check", "ssp", "export"),
    "Railway": ("railway",),
    "Bearings": ("bearings",),
    "Housekeeping": ("open", "cache", "schema", "agents"),
}

app = typer.Typer(cls=Commands, no_args_is_help=True, pretty_exceptions_enable=False, add_completion=True, rich_markup_mode=None)


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"cosimo {version('cosimo')}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", is_eager=True, callback=_print_version, help="Print the version and exit.")
    ] = False,
) -> None:
    """Mechanical components as FMUs, coupled simulations of them, and validation against published tables."""


def group(name: str, text: str, cls: type[TyperGroup] = TyperGroup) -> typer.Typer:
    """A command with commands of its own, added to the application."""
    commands = typer.Typer(cls=cls, no_args_is_help=True, rich_markup_mode=None, help=text)
    commands.callback()(lambda: None)  # with a single command it stays a group
    app.add_typer(commands, name=name)
    return commands


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[Any]], named: bool = True) -> None:
    """A table on standard output; real numbers with four digits. named: the first column has names, which are best not folded."""
    from rich.console import Console
    from rich.table import Column, Table
    from rich.text import Text

    texts = [[f"{cell:.4g}" if isinstance(cell, float) else visible_lines(str(cell)) for cell in row] for row in rows]
    used = [k for k, column in enumerate(columns) if column or any(row[k] for row in texts)] if texts else range(len(columns))
    columns, texts = [columns[k] for k in used], [[row[k] for k in used] for row in texts]
    cells = [[visible(column), *(row[k] for row in texts)] for k, column in enumerate(columns)]
    name = max((len(line) for cell in cells[0] for line in cell.splitlines()), default=0)
    widths = column_widths(cells, output_width(), min(name, output_width() // 2) if named else 0)
    headers = [Column(Text(visible(c)), overflow="fold", width=width) for c, width in zip(columns, widths, strict=True)]
    # as Text: in a string, Rich takes [red] of a foreign name for markup
    table = Table(*headers, title=Text(visible_lines(title)) if title else None, title_justify="left")
    for row in texts:
        table.add_row(*(Text(cell, style=COLOURS.get(cell, "")) for cell in row))
    Console(file=getattr(sys.stdout, "stream", sys.stdout), width=output_width()).print(table)


def print_cells(cells: Cells) -> None:
    """A table of a page on standard output; of an empty one only its caption."""
    if cells.rows:
        print_table(cells.title, cells.header, cells.rows)
    if cells.caption:
        print(cells.caption)


def print_rows(result: CaseResult) -> None:
    """The rows of a case beside their ranges, as a table; as they stand on its page."""
    from ..harness.report.generic import range_row
    from ..harness.validation.case import FIRM

    lines: list[tuple[str, ...]] = []
    condition = ""
    for row in map(range_row, result.findings.rows):
        if row.condition != condition:
            lines.append((f"{row.condition}:", "", "", "", ""))
            condition = row.condition
        standing = "" if row.standing in FIRM else f", {row.standing}"
        value, comma, remark = row.simulated.partition(", ")
        simulated = f"{f'{value} {row.unit}'.rstrip()}{comma}{remark}"
        lines.append((row.quantity, simulated, row.range, row.margin, f"{row.verdict}{standing}"))
    print_table(result.case.title, ("quantity", "simulated", "limits", "margin", "verdict"), lines, named=False)


def output_width() -> int:
    """Width of the terminal, or COLUMNS; without both the lines of a table are as long as they are."""
    return shutil.get_terminal_size((UNLIMITED, 24)).columns if sys.stdout.isatty() or "COLUMNS" in os.environ else UNLIMITED


def print_written(paths: Sequence[object], before: str = "") -> None:
    """The last line of most commands: the files that were written."""
    print(f"{before}wrote {', '.join(map(str, paths))}")


@contextmanager
def status_spinner(text: str = "") -> Iterator[Callable[[str], None]]:
    """A function that shows on a terminal what is being done, at first `text`."""
    if not sys.stderr.isatty():
        yield lambda text: None
        return
    from rich.console import Console

    with Console(stderr=True).status(text) as status:
        yield status.update


def warn(warnings: Sequence[str]) -> None:
    """Each on a line of standard error."""
    for warning in warnings:
        print(f"cosimo: warning: {_indented(visible_lines(warning))}", file=sys.stderr)


def fail(message: object, code: int = FAILED_RUN) -> SystemExit:
    """The exception that ends the command with an exit code, after a message on standard error."""
    print(f"cosimo: {_indented(visible_lines(str(message)))}", file=sys.stderr)
    return SystemExit(code)


def _indented(text: str) -> str:
    """A text whose other lines cannot be taken for messages of this program: foreign code may have written them."""
    first, *others = text.split("\n")
    return "\n".join([first, *(line if line.startswith(" ") else f"  {line}" for line in others)])


class Shown:
    """Standard output that shows control characters of foreign texts as text, as in titles, names and paths; see `visible`.

    stream: the one behind it, for what writes such characters on purpose.
    """

    def __init__(self, stream: Any):
        self.stream = stream

    def write(self, text: str) -> int:
        """Write the text as it can be seen."""
        return self.stream.write(text if text.isprintable() else visible_lines(text))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


@contextmanager
def shown_output() -> Iterator[None]:
    """Within the context all that is printed can be seen, and written in any encoding."""
    stream = sys.stdout
    for each in (stream, sys.stderr):
        if hasattr(each, "reconfigure"):  # a name that is no UTF-8, a terminal of ASCII
            each.reconfigure(errors="backslashreplace")
    sys.stdout = Shown(stream)  # type: ignore[assignment]
    try:
        yield
    finally:
        sys.stdout = stream


@contextmanager
def study(output: Path, resume: bool) -> Iterator[None]:
    """A study into a directory: a signal ends it with the exit code of the signal, and its finished runs are kept."""
    from ..harness.journal import Stopped, kept_study

    try:
        with kept_study(output, resume=resume):
            yield
    except Stopped as stopped:
        raise fail(
            f"stopped by {stopped.signal.name}; {stopped.kept} of its runs, solutions or limits are kept, and the same "
            "command with --resume goes on with them",
            STOPPED + stopped.signal,
        ) from None


def switched_on(scene: Scene, texts: Sequence[str] | None) -> dict[str, Any]:
    """Changes of a scene that switch on effects, each given as "unit.effect"."""
    changes: dict[str, Any] = {}
    for text in listed("--effects", texts):
        unit, effect = scene.split(text)
        name = f"{unit}.effects.{effect}"
        if unit not in scene.units or not effect:
            raise BadInput("--effects", f"unit {unit!r}" if effect else repr(text), "unit.effect", nearest(unit, scene.units))
        if name in changes or scene.coupling.interfaces[unit].effects.get(effect):
            raise BadInput("--effects", repr(text), "an effect that is not on already")
        changes[name] = True
    return changes


def change(scene: Scene, text: str) -> tuple[str, Any]:
    """(name in the scene, value) of "unit.parameter=value" or "analysis.key=value"."""
    from ..scene.files import table_text
    from ..scene.names import parameter_of

    name, equals, value = assigned(scene, text)
    if option := OPTIONS.get(name):
        raise BadInput("--set", repr(text), f"{option} {value}".rstrip(), f"{name} is no parameter of a unit.")
    if equals and value and "." not in name:
        parameter_of(scene, name)  # refuses a parameter without its unit by its whole name
    if not equals or "." not in name or not value:
        raise BadInput("--set", repr(text), "unit.parameter=value")
    given, known = value_of(value), parameter_of(scene, name)
    if known is not None and (question := known.doubt(given)):
        raise BadInput("--set", repr(text), "a number with its unit", question)
    return name, table_text(given, Path(), f"--set {name}") if known is not None else given


def assigned(scene: Scene, text: str) -> tuple[str, str, str]:
    """("name", "=", "value") of "name=value": at the first "=" behind the name of a variable of an FMU, which may hold some itself."""
    from ..scene.names import declared

    parts = text.split("=")
    for k in range(1, len(parts)):
        for name in ("=".join(parts[:k]), "=".join(parts[:k]).strip()):
            unit, variable = scene.split(name)
            if variable in declared(scene, unit):
                return name, "=", "=".join(parts[k:])
    name, equals, value = text.partition("=")
    return name.strip(), equals, value


def with_presets(scene: Scene, texts: Sequence[str]) -> dict[str, Any]:
    """Changes of a scene that give units published parameters, each given as "unit=preset", or those of a row as "unit=file.csv:row"."""
    from ..scene.data_sheets import names_a_file, sheet_parameters

    changes: dict[str, Any] = {}
    classes = scene.component_classes
    given = set[str]()
    for text in texts:
        unit, equals, preset = (part.strip() for part in text.partition("="))
        if unit in given:
            raise BadInput("--preset", f"{unit} twice", "each unit once", "Give what differs from a preset by --set.")
        given.add(unit)
        if not (equals and preset):
            raise BadInput("--preset", repr(text), "unit=preset", "As in pantograph=DSA380.")
        if unit not in classes:
            raise BadInput("--preset", f"unit {unit!r}", "a component of the scene", nearest(unit, classes))
        if names_a_file(preset):
            on = [effect for effect, by in scene.coupling.interfaces[unit].effects.items() if by]
            values, remarks = sheet_parameters(preset, classes[unit], on)
            warn(remarks)
            changes |= {f"{unit}.{name}": value for name, value in values.items()}
            continue
        pick(preset, classes[unit].presets, "--preset", f"a preset of {scene.kinds[unit].label}")
        changes[f"units.{unit}.preset"] = preset
    return changes


def changes_of(scene: Scene, values: Sequence[str] | None, presets: Sequence[str] | None) -> dict[str, Any]:
    """Changes of a scene by --preset and --set."""
    return with_presets(scene, presets or []) | dict(change(scene, text) for text in values or [])


def loaded_scene(name: str, given: Mapping[str, Any] | None = None) -> Scene:
    """A scene as `load_scene` reads it, for a person: with a warning where the schema of its editor is stale.

    given: settings by options of the command line, by their places, of which None is no change.
    """
    from ..systems import load_scene
    from .schema import stale

    scene = load_scene(name, {place: value for place, value in (given or {}).items() if value is not None})
    warn(stale(name, [kind.value for kind in scene.kinds.values()]))
    return scene


def scene_of(
    name: str, values: Sequence[str] | None, presets: Sequence[str] | None, more: Mapping[str, Any] | None = None
) -> Scene:
    """A scene with the changes of the command line; more: those of other options, of which None is no change."""
    loaded = loaded_scene(name, more)
    return changed(loaded, changes_of(loaded, values, presets))


def is_scene(name: str) -> bool:
    """Whether a name is that of a shipped scene or a file of one."""
    from ..scene.files import scene_files

    return Path(name).suffix == ".toml" or name in scene_files()


def changed(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """The scene with changes from the command line.

    The title of a scene may say what no longer holds; where what is simulated changes, another one names the changes.
    """
    if not changes:
        return scene
    named = [_named(scene, name, value) for name, value in changes.items() if not NO_PART.search(name)]
    named = [text for text in named if text]
    rest = f" and {len(named) - NAMED} more changes" if len(named) > NAMED else ""
    title = {"title": f"{scene.name}, changed: {', '.join(named[:NAMED])}{rest}"} if named else {}
    return scene.with_changes({**changes, **title})


def _named(scene: Scene, name: str, value: Any) -> str:
    """A change of a unit as "unit.parameter = value", or "unit: effect a"; "" for one outside of units."""
    from ..scene.names import place_of

    place = place_of(scene, name)
    if place.parameter:
        if isinstance(value, str) and "\n" in value:
            return f"{place.unit}.{place.parameter} = a table of {len(value.splitlines())} lines"
        return f"{place.unit}.{place.parameter} = {f'{value:.6g}' if isinstance(value, float) else value}"
    if place.effect:
        return f"{place.unit}: {'' if value else 'without '}effect {place.effect}"
    return f"{place.unit}: {value}" if place.unit else ""
