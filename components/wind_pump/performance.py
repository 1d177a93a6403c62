"""A wind turbine's own curve: coefficients over the tip speed ratio, and over the pitch, from a table."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..core.columns import Columns, table_of
from ..core.errors import BadInput
from ..core.kernels import kernel, kernel_tuple
from ..core.table_curve import curve_at, read_curve, read_grid, row_before, sloped_rates
from .curves import BETZ

PLACE = "performance_table.table"
RATIO, PITCH, POWER, TORQUE = "tip_speed_ratio", "pitch", "power_coefficient", "torque_coefficient"


@kernel_tuple
class Performance(NamedTuple):
    """Torque coefficients over n ratios, ascending, for m pitches, degrees, ascending: `coefficients` and their `rates`, (m, n)."""

    ratios: Any
    pitches: Any
    coefficients: Any
    rates: Any


def performance_of(text: str, with_pitch: bool, name: str) -> Performance:
    """The curve of a table as `PerformanceTable` describes it; its `rates` are 0 still.

    Raises `BadInput` for a table that has no such columns, misses runaway, exceeds Betz's limit, or has other ratios for another pitch.
    """
    where = f"{name}: {PLACE}"
    whole = table_of(text, where)
    column = _coefficient(whole)
    if whole.place(PITCH) is None:
        if with_pitch:
            remedy = "Add a column 'pitch [deg]', or leave the effect off."
            raise BadInput(where, "no column of pitch, with the effect 'pitch'", "a table over the pitch, too", remedy)
        table, rows = read_curve(text, where, {RATIO: "1", column: "1"})
        return _of_rows(table, rows[0], np.zeros(1), rows[1:], column)
    whole, ratios, pitches, grid = read_grid(text, where, (RATIO, "1"), (PITCH, "deg"), (column, "1"))
    if not with_pitch and not pitches[0] <= 0.0 <= pitches[-1]:
        raise BadInput(
            where, f"pitches from {pitches[0]:g} to {pitches[-1]:g} deg", "a pitch of 0", "Switch the effect 'pitch' on."
        )
    return _of_rows(whole, ratios, pitches, grid, column)


def _coefficient(table: Columns) -> str:
    """Name of the column of the coefficient."""
    there = [name for name in (POWER, TORQUE) if table.place(name) is not None]
    if len(there) != 1:
        raise BadInput(
            table.where, f"columns {', '.join(map(repr, table.header))}", f"one column {POWER!r} or {TORQUE!r} over {RATIO!r}"
        )
    return there[0]


def _of_rows(table: Columns, ratios: np.ndarray, pitches: np.ndarray, values: np.ndarray, column: str) -> Performance:
    """ratios: (n,); pitches: (m,) degrees; values: (m, n) of the column."""
    if ratios[0] < 0.0:
        raise BadInput(table.where, f"{RATIO} {ratios[0]:g}", "ratios of 0 or more")
    powers = values if column == POWER else values * ratios
    if powers.max() > BETZ:
        raise BadInput(table.where, f"a power coefficient of {powers.max():.4g}", "at most 16/27, Betz's limit")
    if (last := powers[:, -1].max()) > 0.0:
        raise BadInput(
            table.where,
            f"a power coefficient of {last:.4g} in the last row",
            "a table that ends at runaway, where no power is left",
            "Add a row with the ratio at which the unloaded rotor turns, and a coefficient of 0.",
        )
    if column == POWER and ratios[0] == 0.0:
        if np.any(values[:, 0] != 0.0):
            raise BadInput(table.where, f"a power coefficient of {values[0, 0]:g} at standstill", "0")
        ratios, values = ratios[1:], values[:, 1:]
    if ratios.size < 2:
        raise BadInput(table.where, "one row behind standstill", "at least two")
    coefficients = values / ratios if column == POWER else values
    return Performance(ratios.copy(), pitches, np.ascontiguousarray(coefficients), np.zeros_like(coefficients))


@kernel
def prepare(table):
    """The rates of a curve's cubics."""
    for i in range(table.pitches.size):
        sloped_rates(table.ratios, table.coefficients[i], table.rates[i])


@kernel
def coefficient_of_table(ratio, degrees, table):
    """Torque coefficient at a tip speed ratio and a pitch in degrees."""
    if table.pitches.size == 1:
        return curve_at(ratio, table.ratios, table.coefficients[0], table.rates[0])
    i = row_before(degrees, table.pitches)
    share = (degrees - table.pitches[i]) / (table.pitches[i + 1] - table.pitches[i])
    share = min(max(share, 0.0), 1.0)
    below = curve_at(ratio, table.ratios, table.coefficients[i], table.rates[i])
    return below + share * (curve_at(ratio, table.ratios, table.coefficients[i + 1], table.rates[i + 1]) - below)
