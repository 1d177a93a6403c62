"""Measured signals in CSV files, as settings name them: the one reader of cases, fits and estimates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isclose
from pathlib import Path

import numpy as np

from ...components.core.columns import Columns, read_table
from ...components.core.errors import BadInput, counted, decimal_point
from ...components.core.measure import conversion_of, is_quantity, number_in
from ..settings.answers import FittedCurve
from ..settings.case import CurveSettings
from ..settings.measured import MeasuredColumn, MeasuredSeries
from .scene import Scene

FEWEST = 8  # samples of a measured signal


@dataclass(frozen=True)
class Measured:
    """A measured signal. x: (n,) time, position or frequency, rising.  y: (n,) values.  empty: lines of the file that have no number.
    noise: standard deviation of the values; None: not known."""

    x: np.ndarray
    y: np.ndarray
    empty: int = 0
    noise: float | None = None


def units_of(scene: Scene) -> dict[str, str]:
    """Units of measure of all outputs, by "unit.output"."""
    return {f"{u}.{n}": s.unit for u, i in scene.coupling.interfaces.items() for n, s in i.outputs.items()}


def read_curve(curve: CurveSettings, folder: Path, units: Mapping[str, str]) -> Measured:
    """A curve over time, or over another signal; faults are one `BadInput` with file, line and column.

    units: of the signals of the run.
    """
    along = (curve.over_column or curve.over, units.get(curve.over, "")) if curve.over else (curve.time, "s")
    unit, noise = units.get(curve.signal, ""), None
    if isinstance(curve, FittedCurve) and curve.noise is not None:
        noise = positive(curve.noise, unit, f"curve {curve.file}: noise", least=1e-300)
    return read_columns(curve, folder, along, unit, "curve", noise)


def read_columns(
    settings: MeasuredColumn, folder: Path, along: tuple[str, str], unit: str, where: str, noise: float | None = None
) -> Measured:
    """Two columns of a file: `along`, a name and a unit, which rises, and that of the signal, in `unit`. Faults are one `BadInput`
    with file, line and column.

    A line whose cell is empty or NaN in either column is left out and counted: loggers write so what they have not measured.
    """
    path = folder / settings.file
    table = read_table(path, where, settings.separator)
    column = settings.column or settings.signal
    x, y = table.numbers(*along), table.numbers(column, _unit(table, column, unit, settings))
    line, kept = np.array([number for number, _ in table.rows]), ~np.isnan(x + y)
    line, x, y = line[kept], x[kept], y[kept]
    if (back := np.flatnonzero(np.diff(x) <= 0.0)).size:
        k = int(back[0]) + 1
        what = f"a number that does not rise: {x[k]:.9g} behind {x[k - 1]:.9g} of line {line[k - 1]}"
        raise BadInput(f"{path}, line {line[k]}, column {along[0]!r}", what, "rising numbers")
    if len(x) < FEWEST:
        raise BadInput(str(path), f"{counted(len(x), 'line')} of numbers", f"{FEWEST} or more")
    x, y = (x - settings.lag, settings.scaled(y)) if isinstance(settings, MeasuredSeries) else (x, settings.scale * y)
    return Measured(x, y, int((~kept).sum()), noise)


def _unit(table: Columns, name: str, unit: str, settings: MeasuredColumn) -> str:
    """The unit in which a column is read: that of the signal, or "" where the user's own factor leads there from that of the header."""
    written, own = table.unit(name, unit), settings.model_fields_set & {"scale", "offset"}
    if not own or not written or not unit:
        return unit
    where, shown = f"{table.where}, column {name!r}", f"scale = {settings.scale:g} beside the unit {written!r}"
    factor, zero = conversion_of(written, unit, where, shown)
    offset = getattr(settings, "offset", 0.0)
    if zero and isclose(offset, zero, rel_tol=1e-6) != ("scale" in own):  # a temperature that is converted by half, or twice
        both = f"scale = {factor:g} and offset = {zero:g}, which lead from {written} to {unit}, or neither"
        raise BadInput(where, f"scale = {settings.scale:g} and offset = {offset:g} beside the unit {written!r}", both)
    if "scale" not in own:
        return unit
    if not isclose(abs(settings.scale), factor, rel_tol=1e-6):
        raise BadInput(where, shown, f"scale = {factor:g}, which leads from {written} to {unit}, or no scale")
    return ""


def amount(given: float | str, unit: str, where: str, of: float = 0.0, finite: bool = True) -> float:
    """A number in SI units: as it is, of a text with its unit, or of a share of a value `of`; a share of 0 is refused."""
    if not isinstance(given, str):
        value = float(given)
    elif given.strip().endswith("%"):
        if not of:
            raise BadInput(where, f"{given} of 0", f"a number in {unit or '1'}")
        value = number_in(given, "1", where) * abs(of)
    elif is_quantity(given):
        value = number_in(given, unit or "1", where, relative=True)
    else:
        raise BadInput(where, repr(given), f"a number in {unit or '1'}, or a text with its unit", decimal_point(given))
    if finite and not np.isfinite(value):
        raise BadInput(where, f"{value}", "a finite number")
    return value


def positive(given: float | str, unit: str, where: str, of: float = 0.0, least: float = 0.0) -> float:
    """As `amount`, of a number of at least 0, or above it with `least`."""
    if (value := amount(given, unit, where, of)) < 0.0 or value < least:
        raise BadInput(where, f"{given}", "a positive number" if least else "a number of at least 0")
    return value
