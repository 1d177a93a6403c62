"""Fixed-point methods for a repeated macro step: the next guess from the last guess and its response.

A loop of units is cut at n signals. `respond` maps guesses of their values at the end of the step, (n,), to the values that the
units then give. The solution is the guess that equals its response. Norms are of numbers divided by their sizes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

Respond = Callable[[np.ndarray], np.ndarray]
Memory = list[list[float]]  # what is carried from one macro step to the next, as plain numbers

CAUTIOUS = 0.1  # share of the first residual that a guess without any experience follows: stiff contacts answer strongly
HALF = 0.5  # the same for the relaxed fixed point, whose second guess is a secant already
NOISE = 1e-12  # changes of a residual below it are rounding, and tell nothing of a slope
INDEPENDENT = 1e-2  # part of a column that must not be explained by newer ones
CONTRACTION = 0.3  # an older Jacobian is good as long as every correction leaves less than this of the residual
INCREMENT = 2.0**-20  # of finite differences, relative to a size: halves the digits between rounding and curvature


class Acceleration(Protocol):
    """What an iteration asks of a method."""

    def begin(self, sizes: np.ndarray) -> None:
        """A new macro step, with signals of these sizes, (n,)."""

    def following(self, guess: np.ndarray, residual: np.ndarray, respond: Respond) -> np.ndarray:
        """The next guess, (n,); residual = respond(guess) - guess.

        Raises `numpy.linalg.LinAlgError` where no correction exists.
        """

    @property
    def memory(self) -> Memory:
        """What is carried over from earlier macro steps."""

    @memory.setter
    def memory(self, memory: Memory) -> None: ...


class Aitken:
    """Relaxed fixed point: guess + w residual, with w from the last two residuals (Irons and Tuck 1969).

    One signal: the secant method. Several: one w must serve all, which is slow where they answer differently.
    """

    def __init__(self) -> None:
        self._weight = HALF
        self._before: np.ndarray | None = None

    def begin(self, sizes: np.ndarray) -> None:
        self._sizes, self._before = sizes, None
        if not 0.0 < self._weight <= 1.0:
            self._weight = HALF

    def following(self, guess: np.ndarray, residual: np.ndarray, respond: Respond) -> np.ndarray:
        if self._before is not None:
            change = (residual - self._before) / self._sizes
            if (square := float(change @ change)) > NOISE**2:
                self._weight *= -float(self._before / self._sizes @ change) / square
        self._before = residual
        return guess + self._weight * residual

    @property
    def memory(self) -> Memory:
        return [[self._weight]]

    @memory.setter
    def memory(self, memory: Memory) -> None:
        [[self._weight]] = memory


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
        self._sizes, self._before = sizes, None

    def following(self, guess: np.ndarray, residual: np.ndarray, respond: Respond) -> np.ndarray:
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
        return [column.tolist() for column in (*self._residuals, *self._responses)]

    @memory.setter
    def memory(self, memory: Memory) -> None:
        columns = [np.array(column) for column in memory]
        self._residuals, self._responses = columns[: len(columns) // 2], columns[len(columns) // 2 :]


class Newton:
    """Newton's method with the Jacobian of the response; a linear circle needs one correction.

    The Jacobian comes from finite differences, n responses. It is kept, over the steps too, and corrected by what each guess
    tells (Broyden 1965), as long as a guess leaves less than CONTRACTION of the residual. `known`: gives the derivatives of
    the response, (n, n), as far as they are known without it, or None; they are tried before the first differences.
    """

    def __init__(self, known: Callable[[], np.ndarray | None] | None = None) -> None:
        self._known = known
        self._jacobian: np.ndarray | None = None  # of the residual, never changed in place
        self._before: tuple[np.ndarray, np.ndarray, float] | None = None  # guess, residual, its length

    def begin(self, sizes: np.ndarray) -> None:
        self._sizes, self._before = sizes, None

    def following(self, guess: np.ndarray, residual: np.ndarray, respond: Respond) -> np.ndarray:
        length = float(np.linalg.norm(residual / self._sizes))
        jacobian = self._jacobian
        if jacobian is None and self._known is not None and (derivatives := self._known()) is not None:
            jacobian = derivatives - np.eye(guess.size)
        elif jacobian is None or (self._before is not None and length > CONTRACTION * self._before[2]):
            jacobian = differences(guess, residual, respond, INCREMENT * self._sizes)
        elif self._before is not None:
            step, change = guess - self._before[0], residual - self._before[1]
            direction = step / self._sizes**2
            jacobian = jacobian + np.outer(change - jacobian @ step, direction / (direction @ step))
        self._jacobian, self._before = jacobian, (guess, residual, length)
        return guess - np.linalg.solve(jacobian, residual)

    @property
    def memory(self) -> Memory:
        return [] if self._jacobian is None else self._jacobian.tolist()

    @memory.setter
    def memory(self, memory: Memory) -> None:
        self._jacobian = np.array(memory) if memory else None


def differences(guess: np.ndarray, residual: np.ndarray, respond: Respond, increments: np.ndarray) -> np.ndarray:
    """Jacobian of the residual, (n, n), by forward differences with these increments, (n,)."""
    response, n = guess + residual, guess.size
    jacobian = -np.eye(n)
    for k in range(n):
        moved = guess.copy()
        moved[k] += increments[k]
        jacobian[:, k] += (respond(moved) - response) / (moved[k] - guess[k])
    return jacobian


def accelerated(method: str, known: Callable[[], np.ndarray | None]) -> Acceleration:
    """The method that a scene calls by this name; `known`: as for `Newton`."""
    if method == "newton":
        return Newton(known)
    return Aitken() if method == "aitken" else QuasiNewton()
