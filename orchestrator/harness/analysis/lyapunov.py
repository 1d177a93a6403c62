"""Lyapunov exponents of a component of kernels.

After Benettin et al. (1980): tangents of the state are carried along by the derivatives of its steps and made orthogonal again after
every interval; their mean logarithmic growth rates are the exponents.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....components.core.component import Component
from ....components.core.errors import BadInput
from ...derivatives.component import TangentComponent


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

    count: how many of them, the largest first; all without it.

    states: the elements of the component's state that are disturbed; those that only drive the others, such as angles that
        are functions of time, stay out.
    scales: magnitude of each of these elements; the exponents settle sooner with good ones.
    interval: short enough that directions do not fall together in it.
    The component itself stays where it is. Raises `BadInput` for one without derivatives, and `StepFailed`.
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
    moved, start = TangentComponent(component, directions.shape[1]), component.t
    for k in range(transient + intervals):
        moved.seed(index, size[:, None] * directions)
        moved.step(start + k * interval, interval)
        directions, grown = _parted(moved.tangents[index] / size[:, None])
        growth[k] = np.log(grown)
    time = interval * np.arange(1, intervals + 1)
    history = np.cumsum(growth[transient:], axis=0) / time[:, None]
    order = np.argsort(history[-1])[::-1]
    return Lyapunov(history[-1][order], start + transient * interval + time, history[:, order])


def _parted(columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal directions that span the columns, (n, k), and by what each has grown, (k,).

    Of one direction without LAPACK, which takes ten times as long: as much as a step of a small component.
    """
    if columns.shape[1] == 1 and 0.0 < (length := math.hypot(*columns[:, 0].tolist())) < math.inf:
        return columns / length, np.array([length])
    directions, triangle = np.linalg.qr(columns)
    return directions, np.abs(np.diag(triangle))
