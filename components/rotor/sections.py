"""Sections of a shaft from a table."""

from __future__ import annotations

import numpy as np

from ..core.columns import table_of
from ..core.errors import BadInput

UNITS = {
    "length": "m",
    "outer_diameter": "m",
    "inner_diameter": "m",
    "youngs_modulus": "Pa",
    "shear_modulus": "Pa",
    "density": "kg/m3",
}


def sections_of(text: str, where: str) -> np.ndarray:
    """(n, 6) the numbers of `UNITS` for each section from the left end; a material that the table does not have is NaN.

    Raises `BadInput`, with the line, for unknown and missing columns, empty cells, and sections without a length or a wall.
    """
    table = table_of(text, where)
    table.only(UNITS, ", ".join(UNITS))
    rows = np.full((len(table.rows), len(UNITS)), np.nan)
    rows[:, 2] = 0.0
    for k, (name, unit) in enumerate(UNITS.items()):
        if k < 2 or table.place(name) is not None:
            rows[:, k] = table.numbers(name, unit, asked=True)
    if not len(rows):
        raise BadInput(where, "no row", "a row for each section")
    for (line, _), row in zip(table.rows, rows, strict=True):
        length, outer, inner = row[:3]
        if not (length > 0.0 and 0.0 <= inner < outer):
            raise BadInput(
                f"{where}, line {line}",
                f"a section {length:g} m long, {inner:g} m within and {outer:g} m without",
                "a positive length, and a wall",
            )
        if np.any(row[3:] <= 0.0):
            raise BadInput(f"{where}, line {line}", "a modulus or a density of 0 or less", "positive ones")
    return rows
