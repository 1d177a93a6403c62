"""Tables over time as parameters of a component, in kernels: arrays with more rows than a course may need."""

from __future__ import annotations

from .kernels import kernel


@kernel
def rows_in_use(time):
    """Number of rows before the time falls; those behind are unused, and zero."""
    n = 1
    while n < time.size and not time[n] < time[n - 1]:
        n += 1
    return n


@kernel
def is_zero_behind(column, rows):
    """Whether a column of a table is zero behind the rows in use."""
    largest = 0.0
    for i in range(rows, column.size):
        largest = max(largest, abs(column[i]))
    return largest == 0.0
