"""A curve that users bring as a CSV table: read and checked, then a cubic between its rows that does not overshoot.

Source of the interpolation: Fritsch and Butland, SIAM Journal on Scientific and Statistical Computing 5 (1984) 300-304.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .columns import Columns, table_of
from .errors import BadInput, counted
from .kernels import kernel


def read_curve(text: str, where: str, units: Mapping[str, str], *, others: tuple[str, ...] = ()) -> tuple[Columns, np.ndarray]:
    """The table of a text and its columns, (k, n), in the units of `units`, which has their names.

    The first column has to rise. others: names of further columns that the table may have.
    Raises `BadInput` for unknown and missing columns, empty cells, fewer than two rows, and a first column that does not rise.
    """
    table = table_of(text, where)
    table.only((*units, *others), " and ".join(units) + (f", or {' and '.join(others)}" if others else ""))
    columns = np.array([table.numbers(name, unit, asked=True) for name, unit in units.items()])
    whole = ~np.isnan(columns).any(axis=0)
    if columns.shape[1] < 2 or not whole.all():
        raise BadInput(where, f"{whole.sum()} whole rows of {whole.size}", f"at least two rows, each with {' and '.join(units)}")
    refuse_order(columns[0], table, next(iter(units)))
    return table, columns


def read_grid(
    text: str, where: str, over: tuple[str, str], across: tuple[str, str], value: tuple[str, str]
) -> tuple[Columns, np.ndarray, np.ndarray, np.ndarray]:
    """The table of a text, and of its rows (n,) values of `over`, (m,) of `across`, both ascending, and the grid, (m, n).

    Each of over, across and value is a name and a unit. Rows may stand in any order. Raises `BadInput` for unknown and missing
    columns, empty cells, and rows that are no whole grid of at least two by two.
    """
    table = table_of(text, where)
    names = (over[0], across[0], value[0])
    table.only(names, f"{names[0]}, {names[1]} and {names[2]}")
    x, y, z = (table.numbers(name, unit, asked=True) for name, unit in (over, across, value))
    if np.isnan(x + y + z).any():
        raise BadInput(where, "a row with an empty cell", f"{names[0]}, {names[1]} and {names[2]} in each row")
    columns, rows = np.unique(x), np.unique(y)
    grid = np.full((rows.size, columns.size), np.nan)
    grid[np.searchsorted(rows, y), np.searchsorted(columns, x)] = z
    if x.size != grid.size or np.isnan(grid).any() or min(grid.shape) < 2:
        raise BadInput(
            where,
            f"{counted(x.size, 'row')} for {rows.size} values of {across[0]} and {columns.size} of {over[0]}",
            "a row for each pair of them, at least two of either",
        )
    return table, columns, rows, grid


def refuse_order(values: np.ndarray, table: Columns, name: str, falling: bool = False) -> None:
    """Raise `BadInput`, with the line, where a column, (n,), does not rise, or does not fall."""
    steps = -np.diff(values) if falling else np.diff(values)
    if np.any(steps <= 0.0):
        k = int(np.argmax(steps <= 0.0))
        raise BadInput(
            f"{table.where}, line {table.rows[k + 1][0]}",
            f"{name} {values[k + 1]:g} behind {values[k]:g}",
            f"a {name} that {'falls' if falling else 'rises'} from row to row",
        )


@kernel
def monotone_rates(places, table, rates):
    """Derivatives at the places, (n,), with which the cubics between them do not overshoot; zero at both ends.

    places, ascending, and table: (n,).
    """
    rates[0] = rates[-1] = 0.0
    for i in range(1, places.size - 1):
        step, next_step = places[i] - places[i - 1], places[i + 1] - places[i]
        before, after = (table[i] - table[i - 1]) / step, (table[i + 1] - table[i]) / next_step
        share = (1.0 + next_step / (step + next_step)) / 3.0  # weight of the secant before: the larger, the shorter its step
        rates[i] = before * after / (share * after + (1.0 - share) * before) if before * after > 0.0 else 0.0


@kernel
def end_rate(step, next_step, before, after):
    """Derivative at an end, by the parabola through three places, kept between 0 and 3 times the secant there.

    step, before: length and secant at the end; next_step, after: those of the next row.
    """
    rate = ((2.0 * step + next_step) * before - step * after) / (step + next_step)
    if rate * before <= 0.0:
        return 0.0
    return 3.0 * before if before * after <= 0.0 and abs(rate) > 3.0 * abs(before) else rate


@kernel
def sloped_rates(places, table, rates):
    """As `monotone_rates`, with a slope at both ends."""
    monotone_rates(places, table, rates)
    if places.size == 2:
        rates[:] = (table[1] - table[0]) / (places[1] - places[0])
        return
    for end, near, far in ((0, 1, 2), (places.size - 1, places.size - 2, places.size - 3)):
        step, next_step = places[near] - places[end], places[far] - places[near]
        rates[end] = end_rate(step, next_step, (table[near] - table[end]) / step, (table[far] - table[near]) / next_step)


@kernel
def row_before(position, places):
    """Number of the row behind which a position lies, from 0 to n - 2; places, ascending: (n,)."""
    low, high = 0, places.size - 1
    while high - low > 1:
        middle = (low + high) // 2
        if position > places[middle]:
            low = middle
        else:
            high = middle
    return low


@kernel
def between(share, h, table, rates, i):
    """Value of a cubic behind place i, at a share of the length h to the next."""
    a, b = share * share * (3.0 - 2.0 * share), share * (1.0 - share)
    return (1.0 - a) * table[i] + a * table[i + 1] + h * b * ((1.0 - share) * rates[i] - share * rates[i + 1])


@kernel
def curve_at(position, places, table, rates):
    """Value of the cubics at a position; the first value before the first place, the last behind the last."""
    i = row_before(position, places)
    h = places[i + 1] - places[i]
    return between(min(max((position - places[i]) / h, 0.0), 1.0), h, table, rates, i)
