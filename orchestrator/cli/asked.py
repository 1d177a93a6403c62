"""`cosimo new` on a terminal asks in words for what it needs. The answers become arguments, which are shown, for scripts."""

from __future__ import annotations

import re
import shlex
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from typer.core import TyperGroup

from ...components.core.errors import BadInput, pick, refusal_text
from .common import first_sentence, is_scene
from .options import number_given

BARE = re.compile(r"\s*[-+]?\d+(?:[.,]\d+)?\s*")  # a number without its unit
PLACE = "answer"  # of messages


@dataclass(frozen=True)
class Question:
    """A question, the argument that the answer becomes, and its default: what an empty answer means.

    option: as "--speed"; "" for an argument by its place.  units: of a number, of which a bare one is asked for.
    check: raises `BadInput` for an answer that cannot be, and the question comes again.
    when: whether it is asked, by the answers so far, under their words.
    """

    words: str
    option: str = ""
    default: str = ""
    units: tuple[str, ...] = ()
    check: Callable[[str], object] = str
    when: Callable[[Mapping[str, str]], bool] = lambda answers: True
    optional: bool = False  # an empty answer is none, and there is no argument
    several: bool = False  # numbers or names, separated by commas where they have units, else by blanks


def refuse_name(name: str, where: str = "file") -> None:
    """Raises `BadInput` for the name of a new file that commands would take for an option, or that does not end in .toml."""
    if name.startswith("-"):
        raise BadInput(where, repr(name), "a name that no command takes for an option", f"As in ./{name}.")
    if Path(name).suffix != ".toml":
        raise BadInput(where, repr(name), "a name that ends with .toml")


def new_file(answer: str) -> None:
    """Refuses the name of a file that is there already, or that `refuse_name` does."""
    refuse_name(answer, PLACE)
    if Path(answer).exists():
        raise BadInput(PLACE, f"{answer}, which is there already", "a file that does not exist yet")


def file_of(*kinds: str) -> Callable[[str], None]:
    """A check of a file that is there and, where that can be told, of one of these kinds."""

    def check(answer: str) -> None:
        from ..scene.file_kinds import refuse_other

        if not Path(answer).is_file():
            raise BadInput(PLACE, repr(answer), "a file that exists")
        if kinds:
            refuse_other(answer, *kinds)

    return check


def some_scene(answer: str) -> None:
    """Refuses what is neither a shipped scene nor a file of one."""
    from ..scene.files import scene_files

    if is_scene(answer) and Path(answer).suffix == ".toml":
        file_of("scene")(answer)
    else:
        shipped_scene(answer, scene_files())


def shipped_scene(answer: str, names: Mapping[str, Any] | None = None) -> None:
    """Refuses another name than that of a shipped scene."""
    from ..scene.files import scene_files

    pick(answer, names or scene_files(), PLACE, "a shipped scene; cosimo list scenes shows them")


def component(answer: str) -> None:
    """Refuses what is no component; module:Class and FMUs are left to the command."""
    from ...components.catalogue import CATALOGUE

    for name in answer.split():
        name = name.rpartition("=")[2]
        if ":" not in name and not name.endswith(".fmu"):
            pick(name, CATALOGUE, PLACE, "a component; cosimo list components shows them")


def pantograph(answer: str) -> None:
    """Refuses what is neither a preset of pantographs nor a file."""
    from ...components.railway.pantograph import Pantograph

    if answer.endswith(".toml"):
        file_of()(answer)
    else:
        pick(answer, Pantograph.presets, PLACE, "a preset of Pantograph")


def limits(answer: str) -> None:
    """Refuses another name than that of a shipped table of limits, or of a file."""
    from ..harness.validation.reference import table_files

    if answer.endswith(".toml"):
        file_of()(answer)
    else:
        pick(answer, table_files(), PLACE, "a table of limits")


def one_of(*names: str) -> Callable[[str], None]:
    """A check of one of these words."""

    def check(answer: str) -> None:
        if answer not in names:
            raise BadInput(PLACE, repr(answer), f"one of {', '.join(names)}")

    return check


MADE_OF = "Made of: line (pantographs under yours), components, or copy (of a shipped scene)"
HEAD = "Pantograph: preset, or file of cosimo railway fit-pantograph"
COUNT = "How many pantographs"
UNDER_LINE: dict[str, Any] = {"when": lambda answers: answers[MADE_OF] == "line"}
FITTED: dict[str, Any] = {"when": lambda answers: answers.get(HEAD, "").endswith(".toml")}
FILE = Question("Name of the new file", "", "my-{kind}.toml", check=new_file)
SCENE = Question("Scene: a file, or the name of a shipped one", check=some_scene)
DOCUMENT = [
    Question("Title of its reports, or nothing", "--title", optional=True),
    Question("What is simulated, as in 'Line 7, type Re 250', or nothing", "--object", optional=True),
    Question("Author of the reports, or nothing", "--author", optional=True),
    Question("Organisation, or nothing", "--organisation", optional=True),
]
QUESTIONS: dict[str, list[Question]] = {
    "scene": [
        FILE,
        Question(MADE_OF, "", "line", check=one_of("line", "components", "copy")),
        Question("Table of the line, as cosimo new line writes it", "--line", check=file_of("line"), **UNDER_LINE),
        Question(HEAD, "--pantograph", "EN 50318:2018", check=pantograph, **UNDER_LINE),
        Question("Static force of the pantograph", "--static-force", "70 N", ("N", "kN"), **FITTED),
        Question("Speed of the train", "--speed", "250 km/h", ("km/h", "m/s"), **UNDER_LINE),
        Question(COUNT, "--pantographs", "1", check=one_of("1", "2", "3", "4"), **UNDER_LINE),
        Question("Distance between two pantographs", "--distance", "200 m", ("m",), when=lambda a: a.get(COUNT, "1") != "1"),
        Question(
            "Components, separated by blanks, as in Pantograph Catenary",
            check=component,
            when=lambda a: a[MADE_OF] == "components",
            several=True,
        ),
        Question("Name of the shipped scene", "--from", check=shipped_scene, when=lambda a: a[MADE_OF] == "copy"),
        Question("Limits to compare results with: en50367, a file, or nothing", "--limits", check=limits, optional=True),
        *DOCUMENT,
    ],
    "line": [
        FILE,
        Question("CSV of the supports, with a row for each", check=file_of()),
        Question("Tension of the contact wire", "--contact-tension", "20 kN", ("kN", "N")),
        Question("Mass per length of the contact wire", "--contact-mass", "1.35 kg/m", ("kg/m",)),
        Question("Tension of the messenger wire", "--messenger-tension", "16 kN", ("kN", "N")),
        Question("Mass per length of the messenger wire", "--messenger-mass", "1.08 kg/m", ("kg/m",)),
        Question("System height of supports without one in the CSV", "--system-height", "1.2 m", ("m", "mm")),
    ],
    "case": [
        FILE,
        SCENE,
        Question(
            "Speeds, separated by commas; nothing for the scene's own",
            "--speeds",
            "",
            ("km/h", "m/s"),
            optional=True,
            several=True,
        ),
        Question("Limits to compare results with: en50367 or a file", "--limits", "en50367", check=limits),
        *DOCUMENT,
    ],
    "table": [FILE, SCENE],
    "vehicle": [FILE, Question("File with the data of your vehicle", check=file_of())],
    "component": [Question("Name of the class, as in MassOnSpring")],
}


class Asking(TyperGroup):
    """A group of commands that asks on a terminal, if it is given nothing, or a command alone."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if on_terminal() and len(args) < 2 and (not args or args[0] in QUESTIONS):
            args = self._asked(*args)
        return super().parse_args(ctx, args)

    def _asked(self, kind: str = "") -> list[str]:
        if not kind:
            for name in QUESTIONS:
                print(f"  {name:10} {first_sentence(self.commands[name].help or '')}")
            kind = _answer(Question("What do you want to create", "", "scene", check=one_of(*QUESTIONS)))
        print("Enter takes the answer in brackets. Ctrl-C stops; nothing is written before the last answer.")
        args = [kind, *arguments_of(kind, QUESTIONS[kind])]
        print(f"Without questions: {shlex.join(['cosimo', 'new', *args])}")
        return args


def on_terminal() -> bool:
    """Whether a person answers."""
    return sys.stdin.isatty() and sys.stdout.isatty()


def arguments_of(kind: str, questions: Sequence[Question]) -> list[str]:
    """The arguments of a command of `cosimo new`, asked for one after another."""
    answers: dict[str, str] = {}
    places: list[str] = []
    options: list[str] = []
    for question in questions:
        if not question.when(answers):
            continue
        answer = answers[question.words] = _answer(question, question.default.format(kind=kind))
        if question.words == MADE_OF:
            continue
        if question.option:
            options += [question.option, answer] if answer else []
        else:
            places += answer.split() if question.several else [answer]
    return [*places, *options]


def _answer(question: Question, default: str | None = None) -> str:
    """The answer to a question, asked until it can be."""
    default = question.default if default is None else default
    while True:
        try:
            answer = input(f"{question.words}{f' [{default}]' if default else ''}: ").strip() or default
        except EOFError:
            print()
            raise BadInput("new", "no further answers", "an answer to each question", "Nothing was written.") from None
        try:
            if not answer and question.optional:
                return ""
            if not answer:
                raise BadInput(PLACE, "nothing", "an answer")
            if question.units:
                return ", ".join(_with_unit(part.strip(), question.units) for part in _parts(answer, question.several))
            question.check(answer)
            return answer
        except BadInput as error:
            print(f"  {refusal_text(error.actual, error.expected, error.remedy)}")


def _parts(answer: str, several: bool) -> list[str]:
    return [part for part in answer.split(",") if part.strip()] if several else [answer]


def _with_unit(answer: str, units: Sequence[str]) -> str:
    """A number with its unit; of a bare number the unit is asked for."""
    if BARE.fullmatch(answer) and "," not in answer:
        unit = units[0]
        if len(units) > 1:
            unit = _answer(Question(f"{answer} {' or '.join(units)}", "", units[0], check=one_of(*units)))
        answer = f"{answer} {unit}"
    number_given(answer, units[0], PLACE)
    return answer
