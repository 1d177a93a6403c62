"""Cases compared with their tables."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from .common import FAILED_CHECK, app, print_rows, print_table, warn
from .completion import cases
from .options import AsJson, InProcess, NoVerify, Output, reports, verify_mode


@app.command()
@reports
def validate(
    cases: Annotated[
        list[str] | None,
        Argument(
            autocompletion=cases,
            help="Names of cases (cosimo list cases) or your own .toml files. papers: the statements of the papers. Default: all "
            "cases.",
        ),
    ] = None,
    in_process: InProcess = False,
    output: Output = Path("validation"),
    strict: Annotated[
        bool,
        Option(
            "--strict",
            help="Also count undecided rows and rows outside a range quoted from memory as failed. Default: a warning.",
        ),
    ] = False,
    verify: Annotated[
        str | None,
        Option(
            metavar="whole",
            help="whole: repeat each case with half the steps, regardless of cost. Default: repeat cases whose counted work "
            "allows it (about 5 s, the same on every machine).",
        ),
    ] = None,
    no_verify: NoVerify = False,
    as_json: AsJson = False,
) -> None:
    """Run cases and compare them with their tables. Example: cosimo validate en50318-2018-ac-simple -o out

    Exit code 1 where a row is outside of its range; a range that is only quoted from memory decides nothing without --strict.
    Each number has its numerical error (±); a row inside is undecided where an end of its range lies within the error.
    """
    from ..harness.validation.case import to_json
    from ..systems import validate as validate_cases

    mode = verify_mode(verify, no_verify, ("whole",))
    results = validate_cases(cases or [], output, in_process=in_process, progress=not as_json, verify=mode)
    if as_json:
        print(to_json(results))
    for result in results if not as_json else ():
        print_rows(result)
        if claims := result.findings.claims:
            print_table(
                "",
                ("claim", "announced", "measured", "verdict"),
                [(c.claim.number, c.claim.announced, c.rows_met, c.verdict) for c in claims],
            )
        print(f"{result.case.name}: {result.verdict}")
    if not as_json:
        print(f"report: {results[0].report}")
    warn([f"{result.case.name}: {warning}" for result in results for warning in result.warnings])
    if any(result.outcome == "failed" for result in results) or (strict and any(result.doubtful for result in results)):
        raise SystemExit(FAILED_CHECK)
