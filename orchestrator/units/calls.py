"""Calls by address and access to memory for kernels: what `CallTable`s hold is data, so one loop serves every unit.

The functions have no body: what they do follows from the types that stand before them. It is machine code where kernels are
compiled, and the same by ctypes where they run as plain Python.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cached_property, wraps
from typing import Any

from ...components.core.kernels import COMPILED

# types: an address is an int64 for kernels, `POINTER` where a C function gets it
DOUBLE, INT, LONG, POINTER = "double", "int32", "int64", "pointer"
C: dict[str, Any] = {DOUBLE: ctypes.c_double, INT: ctypes.c_int32, LONG: ctypes.c_int64, POINTER: ctypes.c_void_p}


class _ForKernels:
    """A function for kernels; the compiler gets it from `make` when it compiles one that calls it."""

    def __init__(self, function: Callable[..., Any], make: Callable[[], Any]) -> None:
        self.__doc__, self._make = function.__doc__, make

    @cached_property
    def _numba_type_(self) -> Any:
        from numba.core.registry import cpu_target

        intrinsic, context = self._make(), cpu_target.typing_context
        intrinsic._register()
        context.refresh()
        return context.resolve_value_type(intrinsic)


def _by_types(function: Callable[..., Any], result: str, kinds: tuple[str, ...], emit: Callable[..., Any]) -> Any:
    """A function for kernels; emit(builder, arguments): its instructions."""
    return _ForKernels(function, lambda: _intrinsic(function, result, kinds, emit))


def _intrinsic(function: Callable[..., Any], result: str, kinds: tuple[str, ...], emit: Callable[..., Any]) -> Any:
    from numba import types
    from numba.extending import intrinsic

    numba = {DOUBLE: types.float64, INT: types.int32, LONG: types.int64, POINTER: types.int64, "": types.void}
    signature = numba[result](*(numba[kind] for kind in kinds))

    @wraps(function)
    def typed(_: Any, *arguments: Any) -> Any:
        return signature, lambda context, builder, signature, given: emit(builder, given) or context.get_dummy_value()

    return intrinsic(typed)


def _llvm(kind: str) -> Any:
    from llvmlite import ir

    return {DOUBLE: ir.DoubleType(), INT: ir.IntType(32), LONG: ir.IntType(64), POINTER: ir.IntType(8).as_pointer()}[kind]


def calls(*kinds: str) -> Callable[[Callable[..., Any]], Any]:
    """A decorator: the function calls the C function at its first argument with the others, which are of these types."""

    def decorate(function: Callable[..., Any]) -> Any:
        if not COMPILED:
            prototype = ctypes.CFUNCTYPE(ctypes.c_int32, *(C[kind] for kind in kinds))
            return lambda address, *given: prototype(int(address))(
                *(float(v) if kind == DOUBLE else int(v) for kind, v in zip(kinds, given, strict=True))
            )

        def emit(builder: Any, given: Any) -> Any:
            from llvmlite import ir

            llvm = [_llvm(kind) for kind in kinds]
            called = builder.inttoptr(given[0], ir.FunctionType(_llvm(INT), llvm).as_pointer())
            return builder.call(
                called,
                [builder.inttoptr(v, to) if kind == POINTER else v for kind, to, v in zip(kinds, llvm, given[1:], strict=True)],
            )

        return _by_types(function, INT, (LONG, *kinds), emit)

    return decorate


def loads(kind: str) -> Callable[[Callable[..., Any]], Any]:
    """A decorator: the function gives the number of a type at its argument."""

    def decorate(function: Callable[..., Any]) -> Any:
        if not COMPILED:
            return lambda address: C[kind].from_address(int(address)).value
        return _by_types(
            function, kind, (LONG,), lambda builder, given: builder.load(builder.inttoptr(given[0], _llvm(kind).as_pointer()))
        )

    return decorate


def stores(function: Callable[..., Any]) -> Any:
    """A decorator: the function writes its second argument, a float, to the address that is its first."""
    if not COMPILED:

        def write(address: int, value: float) -> None:
            ctypes.c_double.from_address(int(address)).value = value

        return write

    def emit(builder: Any, given: Any) -> None:
        builder.store(given[1], builder.inttoptr(given[0], _llvm(DOUBLE).as_pointer()))

    return _by_types(function, "", (LONG, DOUBLE), emit)


@calls(POINTER, POINTER, LONG, POINTER)
def call_values(typing, address, instance, references, count, values):
    """fmi2GetReal or fmi2SetReal of `count` numbers; returns the status, int32."""


@calls(POINTER, POINTER, LONG, POINTER, POINTER)
def call_derivatives(typing, address, instance, references, count, orders, values):
    """fmi2SetRealInputDerivatives of `count` numbers; returns the status, int32."""


@calls(POINTER, DOUBLE, DOUBLE, INT)
def call_step(typing, address, instance, t, h, no_return):
    """fmi2DoStep from t over h; `no_return`: no state before t will be taken back, int32. Returns the status, int32."""


@calls(POINTER, POINTER)
def call_save(typing, address, instance, state):
    """fmi2GetFMUstate into the state at an address; returns the status, int32."""


@calls(POINTER)
def call_restore(typing, address, environment):
    """C's fesetenv; returns 0 where it is done, int32."""


@calls(DOUBLE, DOUBLE, POINTER)
def call_entry(typing, address, t, h, argument):
    """An entry of a component, or a callback: the status of a kernel, int32."""


@loads(DOUBLE)
def load(typing, address):
    """The float at an address."""


@loads(INT)
def load_int32(typing, address):
    """The int32 at an address."""


@loads(LONG)
def load_int64(typing, address):
    """The int64 at an address."""


@stores
def store(typing, address, value):
    """Write a float to an address."""
