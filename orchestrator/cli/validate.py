"""Cases compared with their tables."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from .common import FAILED_CHECK, AsJson, InProcess, app, print_table, warn
from .completion import cases


@app.command()
def validate(
    cases: Annotated[list[str] | None, typer.Argument(autocompletion=cases, help=(
        "names of cases, see cosimo list cases, or .toml files of your own; papers: what each documented system's paper "
        "announces; all without it"))] = None,
    in_process: InProcess = False,
    output: Annotated[Path, typer.Option("-o", "--output", help="Directory for the report.")] = Path("validation"),
    strict: Annotated[bool, typer.Option("--strict", help=(
        "Count a row outside of a recalled range as failed, too; without it such rows are a warning."))] = False,
    as_json: AsJson = False,
) -> None:
    """Run cases and compare them with their tables. Example: cosimo validate en50318-2018-ac-simple -o out

    Exit code 1 where a row is outside of its range; a range that is only recalled from memory decides nothing without --strict.
    """
    from ..harness.charts.style import number
    from ..harness.validation.case import to_json
    from ..systems import validate as validate_cases

    results = validate_cases(cases or [], output, in_process=in_process, progress=not as_json)
    if as_json:
        print(to_json(results))
    else:
        for result in results:
            columns = ("quantity", "condition", "unit", "measured", "range", "margin", "standing", "inside")
            print_table(result.case.title, columns, [
                (r["quantity"], r["condition"], r["unit"], number(row.measured, r["low"], r["high"]), _range(r["low"], r["high"]),
                 row.margin, r["standing"], "yes" if r["inside"] else "NO")
                for row in result.findings.rows for r in [row.to_json()]
            ])
            if claims := result.findings.claims:
                print_table("", ("claim", "announced", "measured", "verdict"), [
                    (c.claim.number, c.claim.announced, c.measured, c.verdict) for c in claims])
            print(f"{result.case.name}: {result.verdict}")
        print(f"report: {results[0].report}")
    doubtful = [f"{result.case.name}: {warning}" for result in results for warning in result.warnings]
    warn(doubtful)
    if any(result.outcome == "failed" for result in results) or (strict and doubtful):
        raise SystemExit(FAILED_CHECK)


def _range(low: float | None, high: float | None) -> str:
    """A range of a table, with the digits that its width asks for; an open end is left out."""
    from ..harness.charts.style import number

    if low is None or high is None:
        return f"up to {high:.6g}" if low is None else f"from {low:.6g}"
    return f"{number(low, low, high)} ... {number(high, low, high)}"
