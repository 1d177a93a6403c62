"""What sensors have measured: samples of several signals at their own instants, in one order of time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...components.core.errors import BadInput, counted, nearest
from ..scene.measured import FEWEST, positive, read_columns
from ..scene.scene import Scene
from ..settings.estimate import EstimateSettings, MeasuredSettings

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
        time, values = _given(one, data[one.signal], place) if one.signal in data else _read(one, unit, folder, place)
        parts.append((time, np.full(time.size, k), values))
    time, which, values = (np.concatenate(column) for column in zip(*parts, strict=True))
    order = np.argsort(time, kind="stable")
    return replace(sensors, time=time[order], which=which[order], values=values[order])


def _read(one: MeasuredSettings, unit: str, folder: Path, where: str) -> tuple[np.ndarray, np.ndarray]:
    if not one.file:
        raise BadInput(f"{where}.file", "nothing", "a CSV file", f"Or give data = {{{one.signal!r}: (time, values)}} in Python.")
    measured = read_columns(one, folder, (one.time, "s"), unit, where)
    return measured.x, measured.y


def _given(
    one: MeasuredSettings, pair: tuple[Sequence[float] | np.ndarray, Sequence[float] | np.ndarray], where: str
) -> tuple[np.ndarray, np.ndarray]:
    time, values = (np.asarray(column, dtype=float) for column in pair)
    if time.shape != values.shape or time.ndim != 1 or not np.isfinite(time).all() or not (np.diff(time) > 0.0).all():
        raise BadInput(f"{where}: data", f"shapes {time.shape} and {values.shape}", "finite rising times and as many values")
    if np.isinf(values).any():
        k = int(np.argmax(np.isinf(values)))
        raise BadInput(f"{where}: data", f"{values[k]:g} at {time[k]:g} s", "finite numbers, or NaN for a gap")
    kept = ~np.isnan(values)
    if kept.sum() < FEWEST:
        raise BadInput(f"{where}: {one.signal}", f"{counted(kept.sum(), 'number')}", f"{FEWEST} or more")
    return time[kept] - one.lag, one.scaled(values[kept])
