"""What concerns pantographs and overhead lines only: the lumped catenary of a line, a pantograph from its frequency response."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from ...components.core.errors import BadInput
from ..output import ensure_directory
from .common import group, loaded_scene, print_table, print_written, status_spinner, warn
from .options import OptionalOutput, Output, listed, number_given, parameters_of, reports, share

if TYPE_CHECKING:
    from ...components.railway.line.form import Form

railway = group("railway", "Fit pantographs and lines; draw a line from its table.")


@railway.command()
@reports
def lumped(
    scene: Annotated[str, Argument(help="Name or file of a scene with one pantograph under a distributed catenary.")],
    speeds: Annotated[str, Option(metavar="SPEED[,...]", help='Speeds at which both are run, as in "100 km/h,200 km/h".')] = (
        "20 km/h,50 km/h,100 km/h,150 km/h,200 km/h,250 km/h,300 km/h"
    ),
    force: Annotated[
        str | None,
        Option(help="Force of the static elasticity, in N or with a unit. Default: the mean force at the lowest speed."),
    ] = None,
    span: Annotated[int | None, Option(help="Span to fit, counted from 1. Default: the middle span.")] = None,
    inerter: Annotated[bool, Option("--inerter", help="Use an inerter instead of the mass.")] = False,
    tolerance: Annotated[str, Option(metavar="SHARE", help="Largest allowed error.")] = "10%",
    output: Output = Path("lumped"),
) -> None:
    """Derive a lumped catenary from a line, with its error over the speed. Example: cosimo railway lumped en50318-2002 -o out"""
    from ..systems.railway.lumped_domain import ERRORS, domain_text, lumped_domain, report

    allowed, loaded = share("--tolerance", tolerance), loaded_scene(scene)
    values = [round(3.6 * number_given(text, "m/s", "--speeds", bare=False), 9) for text in listed("--speeds", [speeds])]
    at = None if force is None else number_given(force, "N", "--force")
    ensure_directory(output)  # now, not after many runs
    with status_spinner("running the line and its lumped catenary"):
        domain = lumped_domain(loaded, values, at, span, inerter)
    written = [*domain.save(output), report(domain, allowed, output)]
    print_table(
        f"Errors of the lumped catenary of {domain.name}",
        ("quantity", *(f"{v:g} km/h" for v in domain.speeds), f"within {tolerance} up to"),
        [
            (text, *(f"{100.0 * e:+.3g} %" for e in domain.errors[name]), domain_text(domain, name, allowed))
            for name, text in ERRORS.items()
        ],
    )
    print_written(written)


@railway.command("line")
def line_(
    table: Annotated[Path | None, Argument(help="TOML table of the line.")] = None,
    values: Annotated[
        list[str] | None,
        Option(
            "--set",
            metavar="PARAMETER=VALUE",
            help="Parameter of Catenary that is not in the table, for example messenger_tension=16000. May be repeated.",
        ),
    ] = None,
    droppers: Annotated[
        Path | None, Option(help="CSV file of droppers that replaces the table's, for example a droppers.csv of this command.")
    ] = None,
    temperature: Annotated[
        float | None,
        Option(
            metavar="K", help="Temperature difference from the table. It changes tensions and heights of wires with fixed = true."
        ),
    ] = None,
    wear: Annotated[
        str, Option(metavar="SHARE", help="Share of the contact wires' section gone since the droppers were cut, as in 20%.")
    ] = "",
    schema: Annotated[bool, Option("--schema", help="Print the JSON schema of a table for editors.")] = False,
    output: OptionalOutput = None,
) -> None:
    """Find the form of a line: dropper lengths, preloads, reactions. Example: cosimo railway line my-line.toml -o out"""
    from ...components.railway.line.table import schema as line_schema
    from ..systems.railway import line

    if schema:
        print(json.dumps(line_schema(), indent=2))
        return
    if table is None:
        raise BadInput("railway line", "no table", "the path of one", "Such as my-line.toml; --schema prints its keys.")
    form, title = line.read(table, parameters_of(values), droppers, temperature, share("--wear", wear) if wear else None)
    show_line(form, title)
    if output is not None:
        print_written(line.save(form, title, output))


def show_line(form: Form, title: str) -> None:
    """A line's drawing and its dropper table on the terminal."""
    from ..systems.railway import line

    print(title, line.text_drawing(form), sep="\n\n", end="\n\n")
    print_table("droppers", line.CREW, line.shown(line.dropper_rows(form), line.CREW))
    print_table("supports", line.SUPPORT_COLUMNS, line.shown(line.support_rows(form), line.SUPPORT_COLUMNS))


@railway.command("fit-pantograph")
@reports
def fit_pantograph(
    response: Annotated[
        Path,
        Argument(
            help=(
                "CSV file with a header that names columns and units: frequency [Hz], then real [m/N] and imaginary [m/N], or "
                "magnitude [m/N] and phase [deg]."
            )
        ),
    ],
    masses: Annotated[int, Option(help="Number of masses: 2 or 3.")] = 3,
    fixed: Annotated[
        list[str] | None,
        Option(
            "--fix", metavar="PARAMETER=VALUE", help="Known parameter, for example lower_frame_stiffness=160. May be repeated."
        ),
    ] = None,
    output: Output = Path("pantograph"),
) -> None:
    """Lumped parameters of a pantograph from its frequency response. Example: cosimo railway fit-pantograph head.csv -o out

    The response is that of the head on a fixed base. Parameters that the data do not determine are named with the range that
    explains the data as well.
    """
    from ..systems.railway.frequency_response import UNITS, read_response, save
    from ..systems.railway.frequency_response import fit_pantograph as fit

    known = parameters_of(fixed)
    for name, value in known.items():
        unit = UNITS.get(name.rpartition("_")[2], "1")
        known[name] = value if isinstance(value, float) else number_given(str(value), unit, f"--fix {name}")
    result = fit(read_response(response), masses, known)
    deviations = dict(zip(result.fit.names, result.fit.deviations, strict=True))
    print_table(
        f"Pantograph of {masses} masses fitted to {response.name}",
        ("parameter", "value", "standard deviation"),
        [
            (
                name,
                value,
                "given"
                if name in result.fixed
                else f"{100.0 * deviations[name]:.2g} %"
                if name in result.identified
                else "not identified",
            )
            for name, value in result.values.items()
        ],
    )
    written = save(result, output)
    misfit = f"misfit {100.0 * result.magnitude:.3g} % of the magnitude, {result.phase:.3g} rad of the phase (rms); "
    print_written(written, misfit)
    warn(result.messages)
