"""Newton's method for states of very different size, on exact derivatives: its corrections do not depend on units of measure."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...components.core.errors import StepFailed

MOST, SHORTENED = 40, 12  # corrections; halvings of one
SETTLED = 1e-10  # of the sizes: the last correction, whose own error is its square
ROUNDING = 256.0 * np.finfo(float).eps  # of what a residual is made of
CLOSE = 1e-8  # of the sizes: corrections that need not fall any more, for rounding is in them
SINGULAR = 1e-12  # singular values below are none
ONCE = 1e-3  # of what an unknown has been: what is 0 in the end has a size, too
TINY = 1e-9  # the least size, in whatever unit: smaller numbers are what rounding leaves of 0
GAIN = 1e-9  # of what is left of equations that need not hold: less is rounding, and no correction follows it
UNKNOWN = 1e-6  # size of what nothing tells the size of

Equations = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


class Solution(NamedTuple):
    """x: (n,).  residual: (m,), that of x.  matrix: (m, n).  size: (n,), of the unknowns.  converged: whether the corrections vanish.

    steps: how many there were.
    """

    x: np.ndarray
    residual: np.ndarray
    matrix: np.ndarray
    size: np.ndarray
    converged: bool
    steps: int

    @property
    def left(self) -> np.ndarray:
        """Residuals over what a change of each unknown by its size does to them, (m,); infinite where nothing acts on one."""
        weight = np.abs(self.matrix) @ self.size
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(np.abs(self.residual) <= rounding(self.matrix, self.size), 0.0, np.abs(self.residual) / weight)


def rounding(matrix: np.ndarray, size: np.ndarray) -> np.ndarray:
    """What rounding makes of residuals, (m,), of unknowns of such sizes; the first ones are differences of the unknowns themselves."""
    own = np.zeros(len(matrix))
    own[: size.size] = size[: len(matrix)]
    return ROUNDING * (np.abs(matrix) @ size + own)  # type: ignore[no-any-return]


def sizes(matrix: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Of unknowns (n,): what they are; of those that are 0, what changes a residual as the others do."""
    size, weights = np.abs(x), np.abs(matrix)
    for _ in range(5):
        unknown = size < 1e-15
        if not unknown.any():
            return size
        rows = weights @ np.where(unknown, 0.0, size)
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = np.where((weights > 0.0) & (rows > 0.0)[:, None], rows[:, None] / weights, np.inf)
        least = reach.min(axis=0, initial=np.inf)
        size = np.where(unknown & np.isfinite(least), least, size)
    return np.where(size < 1e-15, UNKNOWN, size)


def correction(matrix: np.ndarray, residual: np.ndarray, size: np.ndarray, primary: np.ndarray | None = None) -> np.ndarray:
    """The smallest one, (n,), that takes the residual (m,) away, of those the one that does most for what is not primary, (m,) of bool."""
    scaled = matrix * size
    weight = np.abs(scaled).sum(axis=1)
    weight[weight == 0.0] = 1.0
    scaled, wanted = scaled / weight[:, None], -residual / weight
    acting = (np.abs(scaled) > SINGULAR).any(axis=0)
    scaled = scaled[:, acting]
    kept = np.ones(len(scaled), dtype=bool) if primary is None else primary
    first, free = _least(scaled[kept], wanted[kept])
    further, rest = scaled[~kept] @ free, wanted[~kept] - scaled[~kept] @ first
    second = _least(further, rest)[0]
    gain = np.abs(further @ second).max(initial=0.0)
    change = np.zeros(size.size)
    change[acting] = first + (free @ second if gain > GAIN * np.abs(rest).max(initial=0.0) else 0.0)
    return change * size


def _least(matrix: np.ndarray, wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The smallest least squares solution, (n,), of rows of size 1, and what may be added to it, (n, k) with orthogonal columns."""
    if not matrix.size:
        return np.zeros(matrix.shape[1]), np.eye(matrix.shape[1])
    left, values, right = np.linalg.svd(matrix)
    rank = int((values > SINGULAR).sum())
    return right[:rank].T @ (left[:, :rank].T @ wanted / values[:rank]), right[rank:].T


def newton(
    equations: Equations, x: np.ndarray, primary: Callable[[np.ndarray], np.ndarray] | None = None, most: int = MOST
) -> Solution:
    """A root of equations x -> (residual (m,), matrix (m, n)) from x, (n,), by shortened steps.

    primary: matrix -> the equations, (m,) of bool, that have to hold; the others are met where there is room. A step is shortened
    until the next correction by the same matrix is smaller (natural monotonicity, Deuflhard). Raises `StepFailed` where x has none.
    """
    x = np.array(x, dtype=float)
    residual, matrix = equations(x)
    largest = np.abs(x)
    size = sizes(matrix, x)

    def change(residual: np.ndarray) -> np.ndarray:
        held = np.where(np.abs(residual) <= 0.01 * rounding(matrix, size), 0.0, residual)
        return correction(matrix, held, size, None if primary is None else primary(matrix))

    for step in range(most):
        largest = np.maximum(largest, np.abs(x))
        size = np.maximum(np.maximum(sizes(matrix, x), ONCE * largest), TINY)
        dx = change(residual)
        if np.abs(dx / size).max(initial=0.0) <= SETTLED:
            return Solution(x, residual, matrix, size, True, step)
        scale = np.maximum(size, largest)  # what goes to 0 is not to be judged by what is left of it
        length = float(np.abs(dx / scale).max(initial=0.0))
        for halving in range(SHORTENED):
            part = 0.5**halving
            try:
                trial_residual, trial_matrix = equations(x + part * dx)
            except StepFailed:
                continue
            if np.isfinite(trial_residual).all() and np.isfinite(trial_matrix).all():
                after = float(np.abs(change(trial_residual) / scale).max(initial=0.0))
                if after <= max((1.0 - 0.25 * part) * length, CLOSE):
                    break
        else:
            return Solution(x, residual, matrix, size, False, step)
        x, residual, matrix = x + part * dx, trial_residual, trial_matrix
    return Solution(x, residual, matrix, size, False, most)
