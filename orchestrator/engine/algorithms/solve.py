"""Equations x = G(x) between units: Newton's method for algebraic loops, quasi-Newton for repeated macro steps.

Both measure a residual G(x) - x by the size of what it is a residual of. The kernels that initialize groups have a third, Anderson's
method with full memory (`initial_kernels.py`), with the same bounds.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .records import ABOUT_ZERO, CONVERGED, STALLED

CONTRACTION = 0.3  # what a Jacobian may leave of a residual before it is taken anew
LIMIT = 50  # corrections at one point
HALVINGS = 12  # of a correction that makes the residual larger
SINGULAR = 1e-7  # smallest over largest singular value of I - dG/dx, equilibrated; below it no answer is certain
CAUTIOUS = 0.1  # share of the first residual that a guess without any experience follows: stiff contacts answer strongly
NOISE = 1e-12  # changes of a residual below it are rounding, and tell nothing of a slope
INDEPENDENT = 1e-2  # part of a column that must not be explained by newer ones

Answer = Callable[[np.ndarray], np.ndarray]  # G
Memory = list[list[float]]  # what is carried from one macro step to the next, as plain numbers


class Unsolved(Exception):
    """No solution is found. residual: relative, what is left; singular: the gain is 1 there."""

    def __init__(self, residual: float, singular: bool):
        super().__init__(residual)
        self.residual, self.singular = residual, singular


class Newton:
    """Newton's method, whose Jacobian is kept from point to point as long as it reduces the residual enough.

    A linear loop costs two evaluations a point.
    """

    def __init__(self, nominals: np.ndarray):
        """nominals: (n,), of the unknowns."""
        self._nominals = nominals
        self.jacobian: np.ndarray | None = None  # dG/dx, (n, n); never changed in place
        self.jacobians, self.residual = 0, 0.0  # how many, and the largest residual that was left

    def solve(self, x: np.ndarray, answer: Answer, derivatives: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> None:
        """Find x, beginning with the present one; the last `answer` is that of the solution. Raises `Unsolved`.

        derivatives: dG/dx at an x with its answer. Where the first answer is not finite, nothing is done.
        """
        given = answer(x)
        residual = self._residual(x, given)
        if residual == np.inf:
            return
        for _ in range(LIMIT):
            if residual <= CONVERGED:
                break
            first_time = self.jacobian is None
            if self.jacobian is None:
                self.jacobian = derivatives(x, given)
                self.jacobians += 1
            tried, tried_answer, contraction = self._corrected(x, given, residual, answer, HALVINGS if first_time else 1)
            left = self._residual(tried, tried_answer)
            stalled = left <= STALLED and contraction > 0.5
            if contraction > CONTRACTION and not stalled:
                self.jacobian = None
            if contraction < 1.0 or stalled:
                x, given, residual = tried, tried_answer, left
            elif first_time:
                raise Unsolved(left, singular=False)
            if stalled:
                break
        else:
            raise Unsolved(residual, singular=False)
        self.residual = max(self.residual, residual)

    def _corrected(
        self, x: np.ndarray, given: np.ndarray, residual: float, answer: Answer, halvings: int
    ) -> tuple[np.ndarray, np.ndarray, float]:
        """The next x, its answer and what share of the residual is left; a correction that leads astray is shortened.

        `halvings`: how often it is tried at most.
        """
        sizes = self._sizes(x, given)
        assert self.jacobian is not None
        scaled = np.eye(len(x)) - self.jacobian * (sizes / sizes[:, None])
        spread = np.linalg.svd(_equilibrated(scaled), compute_uv=False) if np.isfinite(scaled).all() else np.zeros(1)
        if not spread[-1] > SINGULAR * spread[0]:
            raise Unsolved(residual, singular=True)
        missed = given - x
        change = sizes * np.linalg.solve(scaled, missed / sizes)
        for halving in range(halvings):
            tried = x + change * 0.5**halving
            given = answer(tried)
            sizes = self._sizes(tried, given)
            left = float(np.max(np.abs(given - tried) / sizes) / np.max(np.abs(missed) / sizes))
            if left < 1.0:
                break
        return tried, given, left if np.isfinite(left) else np.inf

    def _sizes(self, x: np.ndarray, given: np.ndarray) -> np.ndarray:
        """What changes of the unknowns are compared with, (n,)."""
        return np.maximum(np.maximum(np.abs(x), np.abs(given)), ABOUT_ZERO * self._nominals)

    def _residual(self, x: np.ndarray, given: np.ndarray) -> float:
        """Largest change from x to its answer, relative to their size; infinite where it is no number."""
        worst = float(np.max(np.abs(given - x) / self._sizes(x, given)))
        return worst if np.isfinite(worst) else np.inf


def _equilibrated(matrix: np.ndarray) -> np.ndarray:
    """Rows and columns divided by their largest entries: an output that is near zero now makes no matrix singular."""
    for axis in (1, 0, 1, 0):
        largest = np.abs(matrix).max(axis=axis, keepdims=True)
        matrix = matrix / np.where(largest > 0.0, largest, 1.0)
    return matrix


class QuasiNewton:
    """Interface quasi-Newton with least squares, IQN-ILS (Degroote, Bathe and Vierendeels 2009).

    Columns are differences of residuals and of responses from iteration to iteration, newest first, of this step and of
    those before; the combination of them that best cancels the residual corrects the response. A column that newer ones
    explain is dropped (the QR2 filter of preCICE). One signal: the secant method, with the secant of the step before.
    """

    def __init__(self) -> None:
        self._residuals: list[np.ndarray] = []  # columns, newest first
        self._responses: list[np.ndarray] = []
        self._before: tuple[np.ndarray, np.ndarray] | None = None

    def begin(self, sizes: np.ndarray) -> None:
        """A new macro step, with signals of these sizes, (n,)."""
        self._sizes, self._before = sizes, None

    def following(self, guess: np.ndarray, residual: np.ndarray) -> np.ndarray:
        """The next guess, (n,); residual = G(guess) - guess."""
        response = guess + residual
        if self._before is not None:
            change = residual - self._before[0]
            if np.linalg.norm(change / self._sizes) > NOISE:
                self._residuals.insert(0, change)
                self._responses.insert(0, response - self._before[1])
        self._before = residual, response
        q, r = self._filtered()
        if not self._residuals:
            return guess + CAUTIOUS * residual
        shares = np.linalg.solve(r, -(q.T @ (residual / self._sizes)))
        return response + shares @ np.array(self._responses)

    def _filtered(self) -> tuple[np.ndarray, np.ndarray]:
        """Q (n, m) and R (m, m) of the scaled columns that are worth keeping, at most n; the others are forgotten."""
        directions: list[np.ndarray] = []
        rows: list[np.ndarray] = []
        kept: list[int] = []
        for k, column in enumerate(self._residuals):
            if len(kept) == column.size:
                break
            rest, along = column / self._sizes, np.zeros(column.size)
            whole = float(np.linalg.norm(rest))
            for i, direction in enumerate(directions):
                along[i] = direction @ rest
                rest = rest - along[i] * direction
            length = float(np.linalg.norm(rest))
            if length > INDEPENDENT * whole:
                along[len(kept)] = length
                directions.append(rest / length)
                rows.append(along)
                kept.append(k)
        self._residuals = [self._residuals[k] for k in kept]
        self._responses = [self._responses[k] for k in kept]
        m = len(kept)
        return np.array(directions).T, np.array(rows).T[:m, :m] if m else np.zeros((0, 0))

    @property
    def memory(self) -> Memory:
        """What is carried over from earlier macro steps."""
        return [column.tolist() for column in (*self._residuals, *self._responses)]

    @memory.setter
    def memory(self, memory: Memory) -> None:
        columns = [np.array(column) for column in memory]
        self._residuals, self._responses = columns[: len(columns) // 2], columns[len(columns) // 2 :]
