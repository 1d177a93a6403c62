"""Lyapunov exponents of a component that runs in this process.

After Benettin et al. (1980): perturbations of the state are integrated and made orthogonal again after every interval; their mean
logarithmic growth rates are the exponents. Finite differences of repeated steps (save, disturb, step, restore) give the
perturbations, so a component needs no equations for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....components.core.component import Component
from ....components.core.errors import BadInput

RELATIVE = 1e-6  # of the scales: half the difference of two steps has truncation 1e-12 of it, and rounding 1e-10


@dataclass(frozen=True)
class Lyapunov:
    """Exponents of a run."""

    exponents: np.ndarray  # (n,), per unit of time, the largest first
    time: np.ndarray  # (k,), end of each interval
    history: np.ndarray  # (k, n), means up to there

    @property
    def largest(self) -> float:
        """The largest exponent: positive in chaos, the rate of decay of small disturbances elsewhere."""
        return float(self.exponents[0])

    @property
    def sum(self) -> float:
        """Of all, the rate at which volumes in state space grow; for m x'' + c x' + f(x, t) = 0, it is -c/m for each x."""
        return float(self.exponents.sum())


def lyapunov_spectrum(
    component: Component,
    states: Sequence[int],
    scales: Sequence[float],
    *,
    interval: float,
    intervals: int,
    transient: int = 0,
    count: int | None = None,
) -> Lyapunov:
    """Exponents of an initialized component from `intervals` intervals of length `interval` after `transient` more, (n,).

    count: how many of them, the largest first; all without it. Each costs two steps an interval.

    states: the elements of the component's state that are disturbed; those that only drive the others, such as angles that
        are functions of time, stay out. An element that wraps round must not be among them.
    scales: magnitude of each of these elements. The result does not depend on them as long as a disturbance of a millionth
        is small, and not lost in rounding.
    interval: short enough that a disturbance of a millionth stays small in it.
    The component is left at the end of the run.
    """
    index, size = np.array(states, dtype=np.intp), np.array(scales, dtype=float)
    if index.shape != size.shape or index.size == 0 or not (size > 0.0).all():
        actual = f"{index.size} states with scales {size.tolist()}"
        raise BadInput("Lyapunov exponents", actual, "a positive scale for each state")
    if intervals < 1 or not interval > 0.0:
        raise BadInput("Lyapunov exponents", f"{intervals} intervals of {interval:g}", "at least one of a positive length")
    if count is not None and not 1 <= count <= index.size:
        raise BadInput("Lyapunov exponents", f"{count} of them", f"1 to {index.size}, the number of states")
    directions = np.linalg.qr(np.random.default_rng(1).normal(size=(index.size, count or index.size)))[0]
    growth = np.zeros((transient + intervals, directions.shape[1]))
    start = component.t
    for k in range(transient + intervals):
        t, before = start + k * interval, component.save()
        stretched = np.empty_like(directions)
        for i in range(directions.shape[1]):
            ends = []
            for sign in (1.0, -1.0):
                component.x[index] += sign * RELATIVE * size * directions[:, i]
                component.step(t, interval)
                ends.append(component.x[index])
                component.restore(before)
            stretched[:, i] = (ends[0] - ends[1]) / (2.0 * RELATIVE * size)
        directions, triangle = np.linalg.qr(stretched)
        growth[k] = np.log(np.abs(np.diag(triangle)))
        component.step(t, interval)
    time = interval * np.arange(1, intervals + 1)
    history = np.cumsum(growth[transient:], axis=0) / time[:, None]
    order = np.argsort(history[-1])[::-1]
    return Lyapunov(history[-1][order], start + transient * interval + time, history[:, order])
