"""Runs beside one another."""

from __future__ import annotations

import json
from math import isfinite
from typing import TYPE_CHECKING, Annotated

from typer import Argument, Option

from .common import FAILED_CHECK, app, fail, print_table, print_written, warn
from .completion import scenes
from .options import AsJson, NoVerify, OptionalOutput, listed, refuse, reports, share, verify_mode

if TYPE_CHECKING:
    from ..harness.compare import Comparison

MOST_SIGNALS = 12  # of the terminal


@app.command()
@reports
def compare(
    runs: Annotated[
        list[str],
        Argument(autocompletion=scenes, help="two or more: directories of results, or scenes by name or file, which are run"),
    ],
    within: Annotated[
        str | None, Option(metavar="SHARE", help="Exit code 1 where figures differ by more than this, as in 1% or 0.01.")
    ] = None,
    signals: Annotated[
        list[str] | None,
        Option(
            "--signal",
            metavar="UNIT.OUTPUT[,...]",
            help="With --within: signals that must not differ by more than this, rms, in parts of their deviation. Default: all "
            "where the runs have no figures.",
        ),
    ] = None,
    output: OptionalOutput = None,
    no_verify: NoVerify = False,
    as_json: AsJson = False,
) -> None:
    """What differs between runs, and whether by more than their errors. Example: cosimo compare before after --within 1%

    cosimo compare en50318-2002 my-line.toml -o out runs both scenes and writes a page with their curves.
    """
    from ..output import write_json
    from ..systems import compare as compare_runs

    tolerance = share("--within", within) if within is not None else None
    wanted = listed("--signal", signals)
    if tolerance is None:
        refuse({"--signal": wanted}, "none without --within; it would have no effect")
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
    if undecided:
        warn([f"their numerical errors leave open whether these differ by more than {within}: {', '.join(undecided)}"])
    if beyond:
        raise fail(f"more than {within} apart: {'; '.join(beyond)}", FAILED_CHECK)


def _print(comparison: Comparison) -> None:
    names = comparison.names
    if comparison.settings:
        print_table("", ("setting", *names), [(place, *texts) for place, texts in comparison.settings.items()])
    else:
        print("all settings are the same")
    rows = [
        (
            one.name,
            one.unit if one.unit != "1" else "",
            *(one.shown(k) for k in range(len(names))),
            f"{100.0 * one.share:.3g} %" if isfinite(one.share) else "",
            "the errors are as large" if one.within_errors and one.share else "",
        )
        for one in comparison.figures
    ]
    if rows:
        print_table("", ("figure", "unit", *names, "difference", ""), rows)
    others = [(f"{name}, rms", f"{name}, largest") for name in names[1:]] if len(names) > 2 else [("rms", "largest")]
    parts = [
        (one.name, *(f"{100.0 * x:.3g} %" for pair in zip(one.rms, one.largest, strict=True) for x in pair))
        for one in comparison.signals
        if one.share
    ]
    if parts:
        title = f"differences from {names[0]}, in parts of each signal's deviation"
        print_table(title, ("signal", *(text for pair in others for text in pair)), parts[:MOST_SIGNALS])
    if len(parts) > MOST_SIGNALS:
        print(f"{len(parts) - MOST_SIGNALS} more signals differ; --json has all")
    elif comparison.signals and not parts:
        print("all signals are the same")
    times = [f"{name} {s:.3g} s" for name, s in zip(names, comparison.seconds, strict=True) if isfinite(s)]
    if times:
        print(f"CPU time of the steps: {', '.join(times)}")
