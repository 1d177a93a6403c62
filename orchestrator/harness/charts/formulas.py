"""Formulas of signals, found by computing with symbols in place of arrays: a page has them as data and computes them anew.

A function that draws a machine from arrays of numbers gives formulas where it gets arrays of `Formula`: NumPy calls the methods
of objects. What NumPy would decide by comparing stands here as functions that take both.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np


class Formula:
    """An operation on others, on signals, parameters and numbers. operation: its name in a page.

    of: what it is applied to; of "signal" and "parameter" the name.
    """

    def __init__(self, operation: str, *of: Any):
        self.operation, self.of = operation, of

    def __add__(self, other: Any) -> Formula:
        return Formula("+", self, other)

    def __radd__(self, other: Any) -> Formula:
        return Formula("+", other, self)

    def __sub__(self, other: Any) -> Formula:
        return Formula("-", self, other)

    def __rsub__(self, other: Any) -> Formula:
        return Formula("-", other, self)

    def __mul__(self, other: Any) -> Formula:
        return Formula("*", self, other)

    def __rmul__(self, other: Any) -> Formula:
        return Formula("*", other, self)

    def __truediv__(self, other: Any) -> Formula:
        return Formula("/", self, other)

    def __rtruediv__(self, other: Any) -> Formula:
        return Formula("/", other, self)

    def __neg__(self) -> Formula:
        return Formula("-", 0.0, self)

    def __abs__(self) -> Formula:
        return Formula("abs", self)

    def sin(self) -> Formula:  # NumPy asks for these by name
        return Formula("sin", self)

    def cos(self) -> Formula:
        return Formula("cos", self)


def _is_symbolic(x: Any) -> bool:
    return np.asarray(x).dtype == object


def symbol(operation: str, name: str) -> np.ndarray:
    """A signal or a parameter, (1,), as an array of one instant."""
    return np.array([Formula(operation, name)], dtype=object)


def _of_all(operation: str, x: Any) -> np.ndarray:
    return np.array([Formula(operation, np.asarray(x).item())], dtype=object)


def largest(x: Any) -> Any:
    """The largest number over all instants that a picture shows; x: (k,)."""
    return _of_all("largest", x) if _is_symbolic(x) else np.nanmax(x)


def smallest(x: Any) -> Any:
    """The smallest number over all instants that a picture shows; x: (k,)."""
    return _of_all("smallest", x) if _is_symbolic(x) else np.nanmin(x)


def last(x: Any) -> Any:
    """The number at the last instant; x: (k,)."""
    return _of_all("last", x) if _is_symbolic(x) else np.asarray(x)[-1]


def not_above(x: Any, limit: Any) -> Any:
    """The smaller one of a number and its limit, whichever is known."""
    return _paired("not above", x, limit) if _is_symbolic(x) or _is_symbolic(limit) else np.fmin(x, limit)


def not_below(x: Any, limit: Any) -> Any:
    """The larger one of a number and its limit, whichever is known."""
    return _paired("not below", x, limit) if _is_symbolic(x) or _is_symbolic(limit) else np.fmax(x, limit)


def known_below(x: Any, limit: float) -> Any:
    """A number below the limit, else NaN."""
    return _paired("known below", x, limit) if _is_symbolic(x) else np.where(x < limit, x, np.nan)


def _paired(operation: str, x: Any, y: Any) -> np.ndarray:
    return np.asarray(np.frompyfunc(lambda a, b: Formula(operation, a, b), 2, 1)(x, y))


class Program:
    """Formulas as steps that a page takes one after the other, each once: numbers, names, and operations on earlier steps."""

    def __init__(self) -> None:
        self.steps: list[Any] = []
        self._places: dict[Any, int] = {}

    def place(self, of: Any) -> int:
        """The number of the step that has a formula or a number."""
        if not isinstance(of, Formula):
            return self._step(("number", float(of)), float(of))
        if of.operation in ("signal", "parameter"):
            return self._step((of.operation, of.of[0]), [of.operation, of.of[0]])
        step = (of.operation, *(self.place(part) for part in of.of))
        return self._step(step, list(step))

    def places(self, of: Iterable[Any]) -> list[int]:
        """The steps of several."""
        return [self.place(one) for one in of]

    def _step(self, key: Any, step: Any) -> int:
        if key not in self._places:
            self._places[key] = len(self.steps)
            self.steps.append(step)
        return self._places[key]
