"""Columns of a table over time as the outputs of a component: measured signals, commands, weather.

A table is the class, made by `signals_class`: its outputs are the columns, its rows lie in the block. Times never fall; a time that
stands twice is a jump, whose first row is the value before it and whose second the value behind it.

The index of the last row that was used is the state: from step to step the search for a time starts there and doubles its
stride, so that it costs the same for ten rows and for millions. What is found does not depend on where the search starts.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from decimal import Decimal
from typing import Any, ClassVar

import numpy as np

from .component import TABLES
from .contract import KernelComponent, Kernels, Refusal
from .errors import BadInput
from .kernels import DONE, OUT_OF_RANGE, OWN, kernel
from .store import digest_of
from .variables import Causality, Kind, Variable, choice, parameter

INTERPOLATIONS, OUTSIDE = ("linear", "hold", "pchip"), ("refuse", "hold", "repeat")
HOLD, PCHIP = 1, 2  # interpolation
REFUSED, HELD, REPEATED = range(3)  # outside
UNCERTAIN = 4.0 * sys.float_info.epsilon  # of a time, which masters form as differences and sums of times
LOOKED_AT = 200_000  # rows that show how far apart all are
MOST_JUMPS = 100_000  # in a run, at each of which a macro step ends
BEFORE, BEHIND = OWN + 1, OWN + 2
KNOWN: dict[str, type[Signals]] = {}  # the tables that this process has read, by the names of their classes


class Signals(KernelComponent):
    """Base of the classes that `signals_class` makes."""

    system = "signals"
    start_inputs = ()
    counters: ClassVar[tuple[str, ...]] = ("steps",)
    fixed_arrays = ("table",)
    table: ClassVar[np.ndarray]  # (n, 1 + columns): times, s, and values
    file: ClassVar[str] = ""

    interpolation = choice("linear", INTERPOLATIONS, "between two rows: straight, the earlier one, or a cubic without overshoot")
    outside = choice("refuse", OUTSIDE, "before the first row and behind the last: an error, the nearest row, or the table again")
    start = parameter(0.0, "s", "time at which the table's own time is 0", structural="instants of jumps, at which steps end")

    refusals = {
        BEFORE: Refusal(
            "{file} from {ends[0]} s on", "a table that covers the start of the run", 'Or outside = "hold" or "repeat".'
        ),
        BEHIND: Refusal(
            "{file} up to {ends[1]} s", "a table that covers the start of the run", 'Or outside = "hold" or "repeat".'
        ),
    }

    @classmethod
    def hosted(cls) -> type[Signals]:
        """The class for an FMU, whose steps end with the values behind a jump: its host lets none happen."""
        return signals_class(list(cls.columns()), list(cls.columns().values()), cls.table, cls.file, hosted=True)

    @classmethod
    def columns(cls) -> dict[str, str]:
        """Units of measure of the columns by their names."""
        return {v.name: v.unit for v in cls.own_variables if v.causality is Causality.OUTPUT}

    @classmethod
    def _memory_type(cls, fields: tuple[str, ...]) -> Any:
        """One for all tables, so that machine code is compiled once."""
        if Signals.Memory is None:
            Signals.Memory = KernelComponent._memory_type.__func__(Signals, fields)  # type: ignore[attr-defined]
        return Signals.Memory

    def is_active(self, variable: str) -> bool:
        """All are: a dot in the name of a column is no effect."""
        return True

    def is_discrete(self, output: str) -> bool:
        """All outputs are where rows are held."""
        return self.parameters["interpolation"] == "hold"

    @property
    def is_discontinuous(self) -> bool:
        """Whether outputs have two values where they jump: that of the end of a step, and behind it that of an update."""
        return self.parameters["interpolation"] != "hold"

    @classmethod
    def jump_times(cls, parameters: Mapping[str, Any], begin: float, end: float) -> list[float]:
        """Times behind `begin` and up to `end`, s, at which values change at once: of times that stand twice, of rows that hold,
        and where a table begins again with other values. Without an end two turns of a table that is repeated. No instance is
        needed, whose block would hold the table again.
        """
        given = {n: v.start for n, v in Signals.variables.items()} | dict(parameters)
        table, repeats, holds = cls.table, given["outside"] == "repeat", given["interpolation"] == "hold"
        rows = np.arange(1, len(table)) if holds else np.flatnonzero(table[1:, 0] == table[:-1, 0]) + 1
        own = table[rows[(table[rows, 1:] != table[rows - 1, 1:]).any(axis=1)], 0]
        first, last, shift = float(table[0, 0]), float(table[-1, 0]), float(given["start"])
        turns = range(1)
        if repeats:
            end = end if end < math.inf else begin + 2.0 * (last - first)
            again = table[-2 if holds else -1, 1:], table[1 if len(own) and own[0] == first else 0, 1:]
            own = own[own < last] if (again[0] == again[1]).all() else np.append(own[own < last], last)
            turns = range(*(math.floor((t - shift - first) / (last - first)) + k for t, k in ((begin, -1), (end, 2))))
        if len(own) * len(turns) > MOST_JUMPS:
            inside = own[(own + shift > begin) & (own + shift <= end)]
            if repeats or len(inside) > MOST_JUMPS:
                where, words = f"{cls.file} from {begin:g} to {end:g} s", f"more than {MOST_JUMPS} jumps"
                raise BadInput(where, words, "fewer, as a macro step ends at each jump", 'Or set interpolation = "linear".')
            own = inside
        period = Decimal(repr(last)) - Decimal(repr(first))
        times = {float(Decimal(repr(shift)) + Decimal(repr(t)) + k * period) for t in own.tolist() for k in turns}
        return sorted(t for t in times if begin < t <= end)

    def shapes(self) -> dict[str, Any]:
        """`x`: the last row used.  `table`: (n, 1 + columns).  `ends`: of the table, s.  `rates`: (n, columns) of pchip, or None."""
        n, k = self.table.shape
        if n < 2 and self.parameters["outside"] == "repeat":
            raise BadInput(self.name, f"{self.file} with one row and outside = 'repeat'", "at least two rows")
        rates = (n, k - 1) if self.parameters["interpolation"] == "pchip" else None
        return {"x": 1, "table": self.table, "ends": 2, "rates": rates}

    def left_range(self) -> str:
        """The time, and what the table covers."""
        start = self.get("start")
        return f"{self.file} covers {self.table[0, 0] + start:.9g} to {self.table[-1, 0] + start:.9g} s"


@kernel
def row_of(table, time, near):
    """The last row whose time is not behind `time`, -1 where there is none; near: where the search starts."""
    n, stride = table.shape[0], 1
    low = high = min(max(near, 0), n - 1)
    if table[low, 0] <= time:
        high = low + 1
        while high < n and table[high, 0] <= time:
            low, high, stride = high, high + stride, 2 * stride
        high = min(high, n)
    else:
        low = high - 1
        while low >= 0 and table[low, 0] > time:
            high, low, stride = low, low - stride, 2 * stride
        low = max(low, -1)
    while high - low > 1:
        middle = (low + high) // 2
        if table[middle, 0] <= time:
            low = middle
        else:
            high = middle
    return low


@kernel
def read_row(i, s):
    """The outputs are the values of a row."""
    for j in range(s.y.size):
        s.y[j] = s.table[i, j + 1]


@kernel
def read_table(t, before, keep, s, p):
    """The outputs at a time, at a jump the values before or behind it; the status. keep: note the row in the state."""
    table = s.table
    last = table.shape[0] - 1
    begin, end, time = table[0, 0], table[last, 0], t - p.start
    doubt = UNCERTAIN * (abs(t) + abs(p.start) + abs(time))
    if p.outside == REPEATED:
        time -= (end - begin) * math.floor((time - begin) / (end - begin))
        if time >= end - doubt:
            time = begin
        if before and time <= begin + doubt:
            read_row(last, s)
            return DONE
    elif p.outside == REFUSED and (time < begin - doubt or time > end + doubt):
        return OUT_OF_RANGE
    i = row_of(table, time + doubt, int(s.x[0]))
    if keep:
        s.x[0] = i
    if i < 0:
        read_row(0, s)
        return DONE
    if before and i > 0 and table[i - 1, 0] == table[i, 0] and time <= table[i, 0] + doubt:
        i -= 1
    if i == last or p.interpolation == HOLD or time <= table[i, 0]:
        read_row(i, s)
        return DONE
    h = table[i + 1, 0] - table[i, 0]
    a = (time - table[i, 0]) / h
    if s.rates is not None:
        for j in range(s.y.size):
            y, rise, b = table[i, j + 1], table[i + 1, j + 1] - table[i, j + 1], 1.0 - a
            bend = b * (h * s.rates[i, j] - rise) - a * (h * s.rates[i + 1, j] - rise)
            s.y[j] = y + a * rise + a * b * bend
    else:
        for j in range(s.y.size):
            s.y[j] = table[i, j + 1] + a * (table[i + 1, j + 1] - table[i, j + 1])
    return DONE


@kernel
def rate_at_end(h, next_h, slope, next_slope):
    """Derivative at an end of the data: of the parabola through three rows, as far as it does not overshoot."""
    rate = ((2.0 * h + next_h) * slope - h * next_slope) / (h + next_h)
    if rate * slope <= 0.0:
        return 0.0
    return 3.0 * slope if slope * next_slope <= 0.0 and abs(rate) > 3.0 * abs(slope) else rate


@kernel
def pchip_rates(table, first, last, rates):
    """Derivatives at the rows first to last, between which nothing jumps: Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5 (1984)."""
    for j in range(rates.shape[1]):
        rates[first, j] = 0.0
        h_before = slope_before = 0.0
        for i in range(first, last):
            h = table[i + 1, 0] - table[i, 0]
            slope = (table[i + 1, j + 1] - table[i, j + 1]) / h
            if i == first:
                rates[first, j] = rates[last, j] = slope
            else:
                if i == first + 1:
                    rates[first, j] = rate_at_end(h_before, h, slope_before, slope)
                w, v = 2.0 * h + h_before, h + 2.0 * h_before
                rates[i, j] = (w + v) / (w / slope_before + v / slope) if slope_before * slope > 0.0 else 0.0
                rates[last, j] = rate_at_end(h, h_before, slope, slope_before)
            h_before, slope_before = h, slope


@kernel
def signals_initialize(t, s, p, e):
    """Whether the table covers the start; derivatives of cubics; the first row that is used."""
    n = s.table.shape[0]
    s.ends[0], s.ends[1] = s.table[0, 0] + p.start, s.table[n - 1, 0] + p.start
    if s.rates is not None:
        first = 0
        for i in range(1, n + 1):
            if i == n or s.table[i, 0] == s.table[i - 1, 0]:
                pchip_rates(s.table, first, i - 1, s.rates)
                first = i
    status = read_table(t, False, True, s, p)
    if status != DONE:
        return BEFORE if t < s.ends[0] else BEHIND
    return DONE


@kernel
def signals_step(t, h, s, p, e):
    """The values before a jump at the end of the step, which the master lets happen there; held ones jump with the step."""
    s.counts[0] += 1
    return read_table(t + h, p.interpolation != HOLD, True, s, p)


@kernel
def hosted_step(t, h, s, p, e):
    """The values behind a jump at the end of the step: for hosts that know of no jumps."""
    s.counts[0] += 1
    return read_table(t + h, False, True, s, p)


@kernel
def signals_outputs(t, s, p, e):
    """The values at a time, at a jump those behind it."""
    return read_table(t, False, False, s, p)


Signals.kernels = Kernels(signals_initialize, signals_step, signals_outputs)
HOSTED = Kernels(signals_initialize, hosted_step, signals_outputs)


def signals_class(
    names: Sequence[str], units: Sequence[str], table: np.ndarray, file: str = "table", *, hosted: bool = False
) -> type[Signals]:
    """The class of a table, known by its name from then on.

    names, units: of the columns behind that of the time; "": not declared.  table: (n, 1 + columns), contiguous, times in s that
    never fall.  file: for messages.  hosted: for an FMU, which also gives the values behind a jump.
    """
    name = TABLES + digest_of(repr((tuple(names), tuple(units), table.shape)), np.ascontiguousarray(table).data.cast("B"))[:16]
    if not hosted and name in KNOWN:
        return KNOWN[name]
    for column in names:
        if column in Signals.variables:
            raise BadInput(file, f"column {column!r}", f"names that are none of {', '.join(Signals.variables)}", "Rename it.")
    spacing = np.diff(table[:LOOKED_AT, 0])
    spacing = spacing[spacing > 0.0]
    step = float(np.median(spacing)) if spacing.size else 1.0
    outputs = [
        Variable(
            Causality.OUTPUT, Kind.REAL, 0.0, unit, f"column {column!r} of {file}", nominal=_nominal(table[:, k]), name=column
        )
        for k, (column, unit) in enumerate(zip(names, units, strict=True), 1)
    ]
    cls: Any = type(
        name,
        (Signals,),
        {"table": table, "file": file, "title": f"Signals of {file}", "kernels": HOSTED if hosted else Signals.kernels},
    )
    cls.default_start, cls.default_step = float(table[0, 0]), step
    cls.default_stop = max(float(table[-1, 0]), cls.default_start + step)
    cls.own_variables = (*Signals.own_variables, *outputs)
    cls.variables = {v.name: v for v in cls.own_variables}
    cls.Values, cls.Present = Signals.Values, Signals.Present
    if not hosted:
        KNOWN[name] = cls
    return cls


def _nominal(values: np.ndarray) -> float:
    largest = float(max(-values.min(), values.max()))
    return 10.0 ** math.floor(math.log10(largest)) if largest > 0.0 else 1.0
