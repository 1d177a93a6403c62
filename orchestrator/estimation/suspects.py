"""Numbers of a scene that the verdict doubts: would another value of one explain the measurement better?

A filter that runs once gives, beside its innovations v, how these move by a number that it takes as known: by derivatives of the scene,
and of the filter with its gains held. If the number is wrong by d, v = G d + white noise. So d has an estimate and a deviation, and the
logarithm of the likelihood rises by half of (d / deviation)² (Friedland 1969; recalled). Offsets and delays of sensors are such numbers,
too. The innovations of a wrong model may have the right size: disturbances take the blame. Their sensitivities still tell.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from math import inf, isfinite

import numpy as np

from ...components.core.errors import BadInput, nearest
from ..derivatives.tangent_run import tangent_run
from ..scene.names import numerical_of
from .filtering import Innovations
from .model import Model

MOST = 24  # numbers that are doubted without being asked
OFFSET, DELAY = "offset of", "delay of"


@dataclass(frozen=True)
class Suspect:
    """at: its value now.  change, deviation: what the measurement says it is off.  low, high: values that it may have.

    gain: log units that the change explains better; where it would leave its limits, a change to the limit.
    """

    name: str
    unit: str
    at: float
    change: float
    deviation: float
    low: float = -inf
    high: float = inf

    @property
    def value(self) -> float:
        """What would explain the measurement best, within its limits."""
        return min(max(self.at + self.change, self.low), self.high)

    @property
    def gain(self) -> float:
        if not isfinite(self.deviation):
            return 0.0
        beyond = self.at + self.change - self.value
        return 0.5 * max(self.change**2 - beyond**2, 0.0) / self.deviation**2

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        now = "" if self.name.startswith((OFFSET, DELAY)) else f" instead of {self.at:.6g}"
        if self.value != self.at + self.change:
            text = f"{self.name} at its limit of {self.value:.4g}{unit}{now}"
        else:
            text = f"{self.name} = {self.value:.4g} ± {self.deviation:.2g}{unit}{now}"
        return f"{text} explains it better by {self.gain:.3g} log units"


@dataclass(frozen=True)
class Suspected:
    """names: of numbers of the scene, at values `at`, changed in steps of `scale`, (s,). cells, by: of what is held in a step, and
    how it moves, (f,) and (f, s + 2 k); offsets and delays of the k signals come last, and move nothing.  start: (l, s + 2 k)."""

    names: tuple[str, ...]
    at: np.ndarray
    scale: np.ndarray
    cells: np.ndarray
    by: np.ndarray
    start: np.ndarray


def suspected(model: Model, wanted: Sequence[str] | None, signals: Sequence[str], noise: np.ndarray, where: str) -> Suspected:
    """The numbers that a plan names, or those that the signals, with noise (k,), see most."""
    taken = {u.name for u in model.unknowns}
    known = [n for n in model.block.parameters() if n not in taken]
    numerical = numerical_of(model.scene, known)
    known = [n for n in known if n not in numerical]
    if wanted is None:
        names = [n for n in known if "[" not in n]
    else:
        names = [n for n in known if any(fnmatchcase(n, w) for w in wanted)]
        for pattern in wanted:
            if not any(fnmatchcase(n, pattern) for n in known):
                raise BadInput(
                    f"{where}: suspected",
                    repr(pattern),
                    "a parameter or a free input that is not estimated",
                    nearest(pattern, known),
                )
    at = np.array([model.block.value(n) for n in names])
    scale = np.where(at != 0.0, np.abs(at), 1.0)
    if wanted is None and len(names) > MOST:
        rows = tangent_run(model.block, names)
        y = [model.signals.index(s) for s in signals]
        seen = np.nan_to_num((np.square(rows.tangents[:, y]).mean(axis=0) / noise[:, None] ** 2).sum(axis=0)) * scale**2
        best = np.sort(np.argsort(-seen)[:MOST])
        names, at, scale = [names[k] for k in best if seen[k] > 0.0], at[best][seen[best] > 0.0], scale[best][seen[best] > 0.0]
    model.begin()
    own = model.block.places(names)
    _, moved = model.started(own)
    moved[own, np.arange(own.size)] = 1.0
    cells = np.setdiff1d(np.union1d(np.flatnonzero(model.stays & (moved != 0.0).any(axis=1)), own), model.live)
    none = np.zeros((1, 2 * len(signals)))
    by = np.hstack([moved[cells] * scale, none.repeat(cells.size, axis=0)])
    start = np.hstack([model.prior(own) * scale, none.repeat(model.live.size, axis=0)])
    return Suspected(tuple(names), at, scale, cells, by, start)


def judged(
    model: Model, some: Suspected, signals: Sequence[str], units: Sequence[str], innovations: Innovations
) -> list[Suspect]:
    """What the innovations say of each, those that explain most first."""
    G, v = np.array(innovations.sensitivities), np.array(innovations.normalised)
    names = [*some.names, *(f"{OFFSET} {s}" for s in signals), *(f"{DELAY} {s}" for s in signals)]
    variables, open_ = [model.variable(n) for n in some.names], [(-inf, inf)] * (2 * len(signals))
    own = [*(v.unit for v in variables), *units, *("s" for _ in signals)]
    limits = [*((v.low, v.high) for v in variables), *open_]
    at = np.concatenate([some.at, np.zeros(2 * len(signals))])
    scale = np.concatenate([some.scale, np.ones(2 * len(signals))])
    suspects = []
    for k, name in enumerate(names):
        size = float(G[:, k] @ G[:, k])
        if size > 0.0 and isfinite(size):
            change, deviation = float(scale[k] * (G[:, k] @ v) / size), float(scale[k] / np.sqrt(size))
            suspects.append(Suspect(name, own[k], float(at[k]), change, deviation, *limits[k]))
    return sorted(suspects, key=lambda s: -s.gain)
