"""Runs beside one another."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from ..output import write_json
from .common import FAILED_CHECK, app, fail, print_cells, print_written, warn
from .completion import scenes
from .options import AsJson, NoVerify, OptionalOutput, listed, refuse, reports, share, verify_mode

if TYPE_CHECKING:
    from ..harness.compare import Comparison

MOST_SIGNALS = 12  # on the terminal


@app.command()
@reports
def compare(
    runs: Annotated[
        list[str],
        Argument(
            autocompletion=scenes, help="Two or more result directories or scenes (names or files). cosimo runs the scenes."
        ),
    ],
    within: Annotated[
        str | None,
        Option(metavar="SHARE", help="Exit code 1 if key results differ by more than this share, for example 1% or 0.01."),
    ] = None,
    signals: Annotated[
        list[str] | None,
        Option(
            "--signal",
            metavar="UNIT.OUTPUT[,...]",
            help="With --within: signals whose difference (rms, as a share of the standard deviation) counts, too. Default: all "
            "if the runs have no key results.",
        ),
    ] = None,
    output: OptionalOutput = None,
    no_verify: NoVerify = False,
    as_json: AsJson = False,
) -> None:
    """What differs between runs, and whether by more than their errors. Example: cosimo compare before after --within 1%

    cosimo compare en50318-2002 my-line.toml -o out runs both scenes and writes a page with their curves.
    """
    from ..systems import compare as compare_runs

    tolerance = share("--within", within) if within is not None else None
    wanted = listed("--signal", signals)
    if tolerance is None:
        refuse({"--signal": wanted}, "no effect without --within")
    comparison = compare_runs(*runs, verify=verify_mode(None, no_verify, ()), progress=not as_json)
    beyond = comparison.beyond(tolerance, wanted) if tolerance is not None else []
    undecided = comparison.undecided(tolerance) if tolerance is not None else []
    if as_json:
        print(json.dumps(comparison.to_json() | ({"beyond": beyond} if tolerance is not None else {})))
    else:
        _print(comparison)
    if output is not None:
        output.mkdir(parents=True, exist_ok=True)
        write_json(output / "compare.json", comparison.to_json())
        page = comparison.report(output)
        if not as_json:
            print_written([output / "compare.json", page])
    if not as_json:
        warn(comparison.warnings())
    if undecided:
        warn([f"their numerical errors leave open whether these differ by more than {within}: {', '.join(undecided)}"])
    if beyond:
        raise fail(f"more than {within} apart: {'; '.join(beyond)}", FAILED_CHECK)


def _print(comparison: Comparison) -> None:
    """The tables of the page; of signals those that differ most."""
    print_cells(comparison.setting_cells())
    if comparison.figures:
        print_cells(comparison.figure_cells())
    if comparison.signals:
        print_cells(comparison.signal_cells(MOST_SIGNALS))
    if costs := comparison.costs():
        print(costs)
