"""What measurements can tell of what is not known, from linearised runs alone: before anything is estimated.

Along a run, each direction of what is not known moves the measured signals. J, (c, c), is the information of all measurements in
units of what was known before; disturbances make it less, so that it is an upper bound. At rest a stiffness acts on nothing. So the runs
are some of those that are expected: they start as the deviations say, and are disturbed as the walks say.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from ...components.core.errors import StepFailed
from .beliefs import Extended
from .measurements import Measurements
from .model import Model

TOLD = 1.0  # information of a direction: below, the measurements say less of it than was known before
APART = 0.98  # correlation of two, beyond which they can hardly be told apart
RUNS = 3  # that are drawn
PART = 0.3  # of a direction: the share from which on a name is a part of it


@dataclass(frozen=True)
class Observability:
    """names: of what is not known.  left: (c,) expected deviation over that before the measurement.  texts: what cannot be told."""

    names: tuple[str, ...]
    left: np.ndarray
    texts: tuple[str, ...]


def observability(model: Model, measured: Measurements, noise: np.ndarray) -> Observability:
    """Of unknowns, and of states that are not known at the start; noise: (k,) of the signals."""
    names = [*(u.name for u in model.unknowns), *(f"{d.name} at the start" for d in model.disturbed if d.deviation > 0.0)]
    y = np.array([model.y_rows[model.signals.index(n)] for n in measured.signals], dtype=np.intp)
    rng, information = np.random.default_rng(0), np.zeros((len(names), len(names)))
    for _ in range(RUNS):
        belief = Extended(model)
        dt, start, count = model.block.h, model.block.time, len(names)
        last = np.ceil((measured.time - start) / dt - 1e-9).astype(int)  # the step that each measurement lies in
        belief.take(rng.standard_normal(count), np.eye(count))
        with suppress(StepFailed):  # what is drawn may be too far off for the scene: what was seen until then counts
            for k in range(1, int(last[-1]) + 1 if last.size else 0):
                belief.predict(dt)
                disturbed = rng.standard_normal(belief.T.shape[1]) * (np.arange(belief.T.shape[1]) >= count)
                belief.take(disturbed, np.eye(belief.T.shape[1])[:, :count])
                some = measured.which[np.searchsorted(last, k) : np.searchsorted(last, k, side="right")]
                rows = belief.T[y][some] / noise[some, None]
                information += rows.T @ rows / RUNS
    values, directions = np.linalg.eigh(information)
    left = np.linalg.inv(np.eye(len(names)) + information)
    deviations = np.sqrt(np.diag(left))
    texts = []
    for value, direction in zip(values, directions.T, strict=True):
        parts = [names[k] for k in np.argsort(-np.abs(direction)) if abs(direction[k]) > PART]
        if value < TOLD and len(parts) == 1:
            texts.append(f"the measurement says less of {parts[0]} than was known before it")
        elif value < TOLD:
            texts.append(f"the measurement cannot tell apart {', '.join(parts)}: together they stay as unknown as before")
    correlation = left / np.outer(deviations, deviations)
    for i in range(len(names)):
        for j in range(i):
            if abs(correlation[i, j]) > APART:
                texts.append(f"{names[j]} and {names[i]} can hardly be told apart: expected correlation {correlation[i, j]:.3f}")
    return Observability(tuple(names), deviations, tuple(texts))
