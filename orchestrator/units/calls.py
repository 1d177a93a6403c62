"""Calls by address and access to memory for compiled code: what `CallTable`s hold is data, so one loop serves every unit."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

POINTER, INT, SIZE, DOUBLE = ir.IntType(8).as_pointer(), ir.IntType(32), ir.IntType(64), ir.DoubleType()


def _call(builder, address, kinds, arguments):
    """Code that calls the function at `address`; addresses among the arguments become pointers."""
    function = builder.inttoptr(address, ir.FunctionType(INT, kinds).as_pointer())
    typed = [builder.inttoptr(a, POINTER) if kind is POINTER else a for kind, a in zip(kinds, arguments, strict=True)]
    return builder.call(function, typed)


@intrinsic
def call_values(typing, address, instance, references, count, values):
    """fmi2GetReal or fmi2SetReal of `count` numbers; all arguments are addresses or counts, int64; returns the status, int32."""
    def generate(context, builder, signature, arguments):
        return _call(builder, arguments[0], [POINTER, POINTER, SIZE, POINTER], arguments[1:])

    return types.int32(*[types.int64] * 5), generate


@intrinsic
def call_derivatives(typing, address, instance, references, count, orders, values):
    """fmi2SetRealInputDerivatives of `count` numbers; returns the status, int32."""
    def generate(context, builder, signature, arguments):
        return _call(builder, arguments[0], [POINTER, POINTER, SIZE, POINTER, POINTER], arguments[1:])

    return types.int32(*[types.int64] * 6), generate


@intrinsic
def call_step(typing, address, instance, t, h, no_return):
    """fmi2DoStep from t over h; `no_return`: no state before t will be taken back, int32. Returns the status, int32."""
    def generate(context, builder, signature, arguments):
        return _call(builder, arguments[0], [POINTER, DOUBLE, DOUBLE, INT], arguments[1:])

    return types.int32(types.int64, types.int64, types.float64, types.float64, types.int32), generate


@intrinsic
def call_entry(typing, address, t, h, argument):
    """An entry of a component, or a callback: the status of a kernel, int32."""
    def generate(context, builder, signature, arguments):
        return _call(builder, arguments[0], [DOUBLE, DOUBLE, POINTER], arguments[1:])

    return types.int32(types.int64, types.float64, types.float64, types.int64), generate


def _loader(kind, result):
    def load(typing, address):
        def generate(context, builder, signature, arguments):
            return builder.load(builder.inttoptr(arguments[0], kind.as_pointer()))

        return result(types.int64), generate

    return intrinsic(load)


load, load_int32, load_int64 = _loader(DOUBLE, types.float64), _loader(INT, types.int32), _loader(SIZE, types.int64)


@intrinsic
def store(typing, address, value):
    """Write a number to an address."""
    def generate(context, builder, signature, arguments):
        builder.store(arguments[1], builder.inttoptr(arguments[0], DOUBLE.as_pointer()))
        return context.get_dummy_value()

    return types.void(types.int64, types.float64), generate
