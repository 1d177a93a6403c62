"""Signals of a stored run for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from typer import Argument, Option

from .common import app, print_written
from .options import listed


@app.command()
def export(
    directory: Annotated[Path, Argument(help="Directory of a run's results.")],
    output: Annotated[Path, Option("-o", "--output", help="File to write: .csv, .xlsx (needs openpyxl) or .mat (MAT 5).")],
    signals: Annotated[
        list[str] | None, Option("--signal", metavar="UNIT.OUTPUT[,...]", help="Signals to write. May be repeated. Default: all.")
    ] = None,
    separator: Annotated[str, Option(metavar="CHARACTER", help='Separator of a CSV file: ",", ";" or "tab".')] = ",",
    decimal: Annotated[str, Option(metavar="CHARACTER", help='Decimal sign of a CSV file: "." or ",".')] = ".",
) -> None:
    """Write a run's signals for other programs. Example: cosimo export out -o signals.csv --separator ";" --decimal ","

    Headers have the units of measure. result.parquet and result.csv of the run stay as they are.
    """
    from ..systems import read_result

    wanted = listed("--signal", signals)
    result = read_result(directory)
    print_written([result.export(output, wanted or None, separator="\t" if separator == "tab" else separator, decimal=decimal)])
