"""Numbers of the undisturbed run, with which rules write partial derivatives: each operation is an instruction."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .grammar import lanes


class Number:
    """A number of the undisturbed run, with which partial derivatives are written."""

    def __init__(self, emit: Callable[[str], str], kind: str, value: str):
        self.emit, self.kind, self.value = emit, kind, value

    def _with(self, op: str, left: Any, right: Any) -> Number:
        a, b = (x.value if isinstance(x, Number) else constant(self.kind, x) for x in (left, right))
        return Number(self.emit, self.kind, self.emit(f"{op} {self.kind} {a}, {b}"))

    def __add__(self, other: Any) -> Number:
        return self._with("fadd", self, other)

    def __radd__(self, other: Any) -> Number:
        return self._with("fadd", other, self)

    def __sub__(self, other: Any) -> Number:
        return self._with("fsub", self, other)

    def __rsub__(self, other: Any) -> Number:
        return self._with("fsub", other, self)

    def __mul__(self, other: Any) -> Number:
        return self._with("fmul", self, other)

    def __rmul__(self, other: Any) -> Number:
        return self._with("fmul", other, self)

    def __truediv__(self, other: Any) -> Number:
        return self._with("fdiv", self, other)

    def __rtruediv__(self, other: Any) -> Number:
        return self._with("fdiv", other, self)

    def __neg__(self) -> Number:
        return Number(self.emit, self.kind, self.emit(f"fneg {self.kind} {self.value}"))

    def call(self, name: str, *others: Number) -> Number:
        """A function of it."""
        return Number(self.emit, self.kind, self.emit(intrinsic(name, self.kind, self.value, *(o.value for o in others))))


def intrinsic(name: str, kind: str, *values: str) -> str:
    """A call of one of LLVM's functions."""
    suffix = f"v{lanes(kind)}f64" if lanes(kind) else "f64"
    return f"call {kind} @llvm.{name}.{suffix}({', '.join(f'{kind} {v}' for v in values)})"


def constant(kind: str, value: float) -> str:
    """A number of a type."""
    return f"splat (double {value:.17e})" if lanes(kind) else f"{value:.17e}"
