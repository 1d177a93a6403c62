"""Options that several commands have, declared once, and the meaning of their texts."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

from typer import Argument, BadParameter, Option

from ...components.core.errors import BadInput, decimal_point
from ...components.core.measure import OTHERWISE, bare_number, is_quantity, number_in, refuse_mixed
from ..delivery import PAPERS, PLACES, delivered
from .completion import parameters, presets, scenes

if TYPE_CHECKING:
    from ..judgement.verification import Wish

COMPONENT = "component:"  # before the name of a component that is studied alone
TOLERANCE = "1%"

SceneName = Annotated[str, Argument(autocompletion=scenes, help="Name of a shipped scene, a scene file, an FMU or a component.")]
Output = Annotated[Path, Option("-o", "--output", help="Directory for the tables and the report.")]
OptionalOutput = Annotated[Path | None, Option("-o", "--output", help="Directory for the results.")]


def _seconds(text: str | float) -> float:
    """A time of the command line in s, which may have its unit."""
    try:
        return number_given(str(text), "s", "time")
    except BadInput as error:
        raise BadParameter(f"{error}") from None  # with the name of the option before it


Stop = Annotated[float | None, Option(parser=_seconds, metavar="SECONDS", help="End of the run, in s or with a unit.")]
Step = Annotated[float | None, Option(parser=_seconds, metavar="SECONDS", help='Macro step, in s or with a unit: "10 ms".')]
Start = Annotated[float | None, Option(parser=_seconds, metavar="SECONDS", help="Start of the run, in s or with a unit.")]
AsJson = Annotated[bool, Option("--json", help="Print JSON for programs.")]
InProcess = Annotated[
    bool, Option("--in-process", help="Run components in this process instead of as FMUs: faster, bit-identical results.")
]
Native = Annotated[
    bool, Option("--native", help="Run components as native FMUs, which need no Python. cosimo builds and caches them.")
]
NoVerify = Annotated[bool, Option("--no-verify", help="Do not repeat the run; results have no error estimate.")]
Resume = Annotated[bool, Option("--resume", help="Continue a stopped study; cosimo does not repeat its finished runs.")]
Changes = Annotated[
    list[str] | None,
    Option(
        "--set",
        metavar="UNIT.PARAMETER=VALUE",
        autocompletion=parameters,
        help='Set a parameter to a number in SI units, a number with a unit ("250 km/h") or an array ([1, 2, 3]); or set analysis.key. '
        "May be repeated.",
    ),
]
Presets = Annotated[
    list[str] | None,
    Option(
        "--preset",
        metavar="[UNIT=]NAME|UNIT=FILE.csv[:ROW]",
        autocompletion=presets,
        help="Use published parameters of a component instead of the scene's own, or those of a row of a table. May be repeated.",
    ),
]
Over = Annotated[
    list[str] | None,
    Option(
        metavar="UNIT.PARAMETER=FROM:TO:POINTS|VALUE,VALUE",
        help='Values of a parameter, with or without a unit ("200 km/h"); they replace the scene\'s own table. '
        "Several parameters make a grid or a map.",
    ),
]
PlanFile = Annotated[Path, Option(help="TOML file with the varied parameters, the sampling method and the recorded results.")]
OptionalPlanFile = Annotated[
    Path | None, Option(help="TOML file with the varied parameters, the sampling method and the recorded results.")
]
Quantities = Annotated[
    list[str] | None,
    Option(
        "--quantity",
        metavar="NAME",
        help='Quantity of interest: "unit.output, kind" or a key result. May be repeated. Default: the '
        "quantities of the plan or of [study].",
    ),
]
Jobs = Annotated[
    int | None,
    Option("--jobs", help="Threads, or processes of Dask where steps need Python; default: one for each core, where it pays."),
]
Cluster = Annotated[
    str, Option("--cluster", metavar="tcp://HOST:PORT", help="Scheduler of a Dask cluster, whose workers run it.")
]
Limits = Annotated[
    str,
    Option(
        "--limits",
        metavar="TABLE",
        help="Table of limits for the run: en50367, en50318-2002, ..., or a TOML file with sources and rows.",
    ),
]
FirstOrder = Annotated[
    bool,
    Option(
        "--first-order/--all-samples",
        help="Samples follow from exact derivatives where some runs agree with these; or every sample is run.",
    ),
]
Conditions = Annotated[
    list[str] | None,
    Option(
        "--condition",
        metavar="NAME",
        help="Use only the rows of the table with this condition. May be repeated. Default: the conditions that "
        "apply to the run, else all rows.",
    ),
]


Plotly = Annotated[
    str,
    Option(
        "--plotly",
        metavar="|".join(PLACES),
        help="Where the report loads Plotly from: inside (one file), beside (plotly.min.js) or cdn (network).",
    ),
]
Pdf = Annotated[bool, Option("--pdf", help="Also write report.pdf. Needs Chromium, Chrome or Edge.")]
Paper = Annotated[
    str, Option("--paper", metavar="|".join(PAPERS), help="Sheet of the printed report. Default: that of the locale.")
]
Si = Annotated[
    bool, Option("--si", help="Print numbers in the units that components declare (m, rad/s) instead of mm, µm, km/h, rpm.")
]


def limits_of(table: str, conditions: Sequence[str] | None) -> dict[str, Any] | None:
    """The limits of a scene that --limits and --condition name; None without them. A file's path is that of the working directory."""
    if not table:
        refuse({"--condition": list(conditions or ())}, "needs a table of limits", "Add --limits TABLE.")
        return None
    place = str(Path(table).resolve()) if table.endswith(".toml") else table
    return {"table": place, "conditions": list(conditions or ())}


def times_of(step: float | None, stop: float | None) -> dict[str, Any]:
    """Changes of a scene by --step and --stop; None where one is not given."""
    return {"master.step": step, "stop_time": stop}


def reports(command: Callable[..., None]) -> Callable[..., None]:
    """A command that writes a report, with the options --plotly, --pdf, --paper and --si: how the report is delivered."""
    more = {"plotly": (Plotly, PLACES[0]), "pdf": (Pdf, False), "paper": (Paper, ""), "si": (Si, False)}

    @wraps(command)
    def delivering(*, plotly: str, pdf: bool, paper: str, si: bool, **given: Any) -> None:
        if plotly not in PLACES:
            raise BadInput("--plotly", repr(plotly), "one of " + ", ".join(PLACES))
        if given["output"] is None:
            refuse(
                {"--plotly": plotly if plotly != PLACES[0] else None, "--pdf": pdf, "--paper": paper},
                "needs a directory for the report",
                "Add -o DIR.",
            )
        try:
            with delivered(plotly, pdf, paper, si):
                command(**given)
        finally:  # of a failed check, too
            output = given["output"]
            if output is not None and (output / "report.html").is_file() and not given.get("as_json"):
                print(f"next: cosimo open {output}")

    return with_options(delivering, inspect.signature(command, eval_str=True).parameters.values(), more)


def with_options(
    command: Callable[..., None], own: Iterable[inspect.Parameter], more: Mapping[str, tuple[Any, Any]]
) -> Callable[..., None]:
    """A command whose options are its own and, by name, more: (annotation, default)."""
    added = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=kind)
        for name, (kind, default) in more.items()
    ]
    signature = inspect.Signature([*own, *added])
    command.__signature__ = signature  # type: ignore[attr-defined]
    command.__annotations__ = {name: p.annotation for name, p in signature.parameters.items()}
    return command


def refuse(given: Mapping[str, Any], reason: str, remedy: str = "Remove it.") -> None:
    """Raise `BadInput`, for a reason, for the first option, by name, that has a value: neither None nor False nor empty."""
    for option, value in given.items():
        if value is not None and value is not False and value not in ([], ""):
            raise BadInput(option, reason, "", remedy)


def verify_mode(verify: str | None, no_verify: bool, choices: Sequence[str]) -> Wish:
    """How numbers are verified, by the options --verify, one of the choices, and --no-verify; raises `BadInput`."""
    if verify is not None and no_verify:
        raise BadInput("--verify", "--verify and --no-verify exclude each other", "", "Remove one.")
    if verify is not None and verify not in choices:
        raise BadInput("--verify", repr(verify), " or ".join(choices))
    return "no" if no_verify else cast("Wish", verify or "auto")


def listed(option: str, texts: Sequence[str] | None) -> list[str]:
    """Names separated by commas, but for those inside the brackets of an element; empty where the option is not given."""
    names = [name.strip() for text in texts or () for name in re.split(r",(?![^\[]*\])", text)]
    if not all(names):
        raise BadInput(option, repr(",".join(texts or ())), "names separated by commas")
    return names


def number_given(text: str, unit: str, option: str, *, bare: bool = True) -> float:
    """The number of an option in a unit; raises `BadInput`, without `bare` also for one without its unit."""
    if is_quantity(text):
        return number_in(text, unit, option)
    try:
        value = bare_number(text)
    except ValueError:
        value = nan
    if not isfinite(value):
        raise BadInput(option, repr(text), f"a number in {unit}, or with its unit", decimal_point(text))
    if not bare and unit in OTHERWISE:
        raise BadInput(option, repr(text), "a number with its unit", f"{text} {OTHERWISE[unit]} or {text} {unit}?")
    return value


def numbers_given(text: str, unit: str, option: str) -> list[float]:
    """Numbers separated by commas, all in one unit, or each with its own; raises `BadInput`."""
    parts = listed(option, [text])
    values = [number_given(part, unit, option) for part in parts]
    refuse_mixed(parts, values, option)
    return values


def share(option: str, text: str) -> float:
    """A share given as "1%" or "0.01"; raises `BadInput` for one above 100 % or not above 0.

    A number of 1 or more without a percent sign could mean either, and is refused with both spellings.
    """
    number, percent, rest = text.strip().partition("%")
    try:
        value = bare_number(number)
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


def value_of(text: str) -> Any:
    """A value given as text: a number, true or false, an array as [1, 2, 3], or the text itself."""
    for read in (int, bare_number):
        try:
            return read(text.replace("_", "?"))
        except ValueError:
            pass
    if text.startswith("["):
        try:
            return json.loads(text)
        except (ValueError, RecursionError):
            raise BadInput("--set", repr(text), "an array of numbers as [1, 2, 3]") from None
    return {"true": True, "false": False}.get(text, text)


def parameters_of(texts: Sequence[str] | None) -> dict[str, Any]:
    """Parameters of a component alone, each given as "parameter=value", by the names of their elements."""
    from ..scene.files import table_text

    values: dict[str, Any] = {}
    for text in texts or ():
        parameter, equals, value = text.partition("=")
        if not (parameter and equals and value):
            raise BadInput("--set", repr(text), "parameter=value")
        given = table_text(value_of(value), Path(), f"--set {parameter}")
        elements = enumerate(given, 1) if isinstance(given, list) else ()
        values |= {f"{parameter.strip()}[{k}]": v for k, v in elements} or {
            parameter.strip(): float(given) if isinstance(given, int) and not isinstance(given, bool) else given
        }
    return values


def preset_of(texts: Sequence[str] | None) -> str:
    """The preset of a component alone; "" where none is given."""
    if len(texts or []) > 1 or any("=" in text for text in texts or []):
        raise BadInput("--preset", repr(",".join(texts or [])), "one preset of a component alone", "As in --preset DSA380.")
    return texts[0].strip() if texts else ""


def ranges_of(texts: Sequence[str] | None) -> dict[str, Any]:
    """ "unit.parameter" -> range or list, of each "unit.parameter=from:to:points" or "unit.parameter=value,value"."""
    ranges: dict[str, Any] = {}
    for text in texts or ():
        place, _, values = text.rpartition("=")  # a name may hold some, no value does
        if place.strip() in ranges:
            raise BadInput("--over", f"{place.strip()} twice", "each name once", "Write all its values in one --over.")
        ends = [part.strip() for part in values.split(":")]
        try:
            if len(ends) == 3:
                ranges[place.strip()] = {"from": _number(ends[0]), "to": _number(ends[1]), "points": int(ends[2])}
            elif len(ends) == 1:
                ranges[place.strip()] = [_number(value.strip()) for value in values.split(",")]
            else:
                raise ValueError
        except ValueError:
            raise BadInput(
                "--over",
                repr(text),
                "unit.parameter=from:to:points or unit.parameter=value,value",
                'As in --over bearing.speed=100:400:31, or --over pantograph.speed="200 km/h,250 km/h".',
            ) from None
        given = ranges[place.strip()]
        if twice := [value for value in given if isinstance(given, list) and given.count(value) > 1]:
            raise BadInput("--over", f"{text!r}, with {twice[0]} twice", "each value once")
    return ranges


def _number(text: str) -> float | str:
    """A number, or the text of one with its unit; raises `ValueError`."""
    return text if is_quantity(text) else bare_number(text)
