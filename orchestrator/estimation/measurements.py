"""What sensors have measured: samples of several signals at their own instants, in one order of time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...components.core.columns import read_table
from ...components.core.errors import BadInput, nearest
from ...components.core.measure import is_quantity, number_in
from ..scene.scene import Scene
from ..settings.estimate import EstimateSettings, MeasuredSettings

LEAST = 8  # samples of a signal
Data = Mapping[str, tuple[Sequence[float] | np.ndarray, Sequence[float] | np.ndarray]]  # signal -> time, values


@dataclass(frozen=True)
class Measurements:
    """Samples in the order of time.

    signals: their names.  units: of measure.  time: (n,) s, when the signal had the value.  which: (n,) place of the signal.
    values: (n,) in SI units.  noise: (k,) standard deviations; NaN: not known.
    """

    signals: tuple[str, ...]
    units: tuple[str, ...]
    time: np.ndarray
    which: np.ndarray
    values: np.ndarray
    noise: np.ndarray

    def within(self, first: float, last: float) -> Measurements:
        """Those behind the time `first` and up to `last`, s."""
        kept = (self.time > first) & (self.time <= last)
        return Measurements(self.signals, self.units, self.time[kept], self.which[kept], self.values[kept], self.noise)

    def rough_noise(self) -> np.ndarray:
        """(k,) noise, where it is not known from third differences, which a smooth signal hardly has."""
        noise = self.noise.copy()
        for k in np.flatnonzero(np.isnan(noise)):
            y = self.values[self.which == k]
            noise[k] = max(np.sqrt(np.mean(np.diff(y, 3) ** 2) / 20.0), 1e-9 * np.abs(y).max(), 1e-300)
        return noise


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
        raise BadInput(where, repr(given), f"a number in {unit or '1'}, or a text with its unit")
    if finite and not np.isfinite(value):
        raise BadInput(where, f"{value}", "a finite number")
    return value


def positive(given: float | str, unit: str, where: str, of: float = 0.0, least: float = 0.0) -> float:
    """As `amount`, of a number of at least 0, or above it with `least`."""
    if (value := amount(given, unit, where, of)) < 0.0 or value < least:
        raise BadInput(where, f"{given}", "a positive number" if least else "a number of at least 0")
    return value


def sensors_of(plan: EstimateSettings, scene: Scene, where: str) -> Measurements:
    """The signals of a plan, with no sample so far; raises `BadInput` for names and units."""
    coupling, noise, none = scene.coupling, [], np.zeros(0)
    known = {".".join(end): coupling.interfaces[end[0]].outputs[end[1]].unit for end in coupling.signals}
    for k, one in enumerate(plan.measured):
        place = f"{where}: measured[{k + 1}]"
        if one.signal not in known:
            outputs = [f"{u}.{n}" for u, i in coupling.interfaces.items() for n in i.outputs]
            if one.signal in outputs:
                raise BadInput(
                    f"{place}.signal", f"{one.signal!r}, which is not recorded", "a recorded output", "Add it to record.signals."
                )
            raise BadInput(f"{place}.signal", repr(one.signal), "a recorded output of the scene", nearest(one.signal, known))
        given = one.noise
        noise.append(np.nan if given is None else positive(given, known[one.signal], f"{place}.noise", least=1e-300))
    names = tuple(m.signal for m in plan.measured)
    return Measurements(names, tuple(known[n] for n in names), none, none.astype(np.intp), none, np.array(noise))


def measurements_of(plan: EstimateSettings, scene: Scene, folder: Path, data: Data, where: str) -> Measurements:
    """All of a plan; `data` take the place of files. Raises `BadInput` with file, line and column."""
    sensors, parts = sensors_of(plan, scene, where), []
    if strangers := sorted(data.keys() - set(sensors.signals)):
        remedy = nearest(strangers[0], sensors.signals)
        raise BadInput(f"{where}: data", ", ".join(strangers), "signals of [[measured]]", remedy)
    for k, (one, unit) in enumerate(zip(plan.measured, sensors.units, strict=True)):
        place = f"{where}: measured[{k + 1}]"
        time, values = _given(data[one.signal], place) if one.signal in data else _read(one, unit, folder, place)
        if time.size < LEAST:
            raise BadInput(f"{place}: {one.file or one.signal}", f"{time.size} numbers", f"{LEAST} or more")
        parts.append((time - one.delay, np.full(time.size, k), values))
    time, which, values = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(time, kind="stable")
    return replace(sensors, time=time[order], which=which[order], values=values[order])


def _given(pair: tuple[Sequence[float] | np.ndarray, Sequence[float] | np.ndarray], where: str) -> tuple[np.ndarray, np.ndarray]:
    time, values = (np.asarray(column, dtype=float) for column in pair)
    if time.shape != values.shape or time.ndim != 1 or not np.isfinite(time).all() or not (np.diff(time) > 0.0).all():
        raise BadInput(f"{where}: data", f"shapes {time.shape} and {values.shape}", "finite rising times and as many values")
    kept = ~np.isnan(values)
    return time[kept], values[kept]


def _read(one: MeasuredSettings, unit: str, folder: Path, where: str) -> tuple[np.ndarray, np.ndarray]:
    if not one.file:
        raise BadInput(f"{where}.file", "nothing", "a CSV file", f"Or give data = {{{one.signal!r}: (time, values)}} in Python.")
    path = folder / one.file
    table = read_table(path, where, one.separator)
    time, values = table.numbers(one.time, "s"), table.numbers(one.column or one.signal, unit)
    line, kept = np.array([number for number, _ in table.rows]), ~np.isnan(time + values)  # loggers leave cells empty
    line, time, values = line[kept], time[kept], values[kept]
    if (back := np.flatnonzero(np.diff(time) <= 0.0)).size:
        k = int(back[0])
        what = f"{time[k + 1]:.9g} s behind {time[k]:.9g} s of line {line[k]}"
        raise BadInput(f"{path}, line {line[k + 1]}, column {one.time!r}", what, "times that rise")
    return time, values
