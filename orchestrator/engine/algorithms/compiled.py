"""Many macro steps of Jacobi or Gauss-Seidel in one compiled loop, for components of this process and FMUs of FMI 2.0.

The same steps as `Jacobi.step` and `GaussSeidel.step`, in the same order and to the last bit, without Python between the units.
Their functions are called by address; addresses are data, so one compiled loop serves every unit. Inputs and outputs of a
component are written and read where they lie in memory.
Everything stands in this one file, because Numba looks at no other one to see whether its machine code on disk is fresh.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ....components.core.kernels import kernel, kernel_tuple
from ...units.call_table import COMPANIONS, DERIVATIVES, IN_MEMORY, MEAN

GET, SET, SET_DERIVATIVES, DO_STEP, INSTANCE, INPUT_REFERENCES, OUTPUT_REFERENCES, ORDERS = range(8)
FIRST_LINK, LINKS, FIRST_SIGNAL, SIGNALS, WAY, LATE, LED = range(7)
WARNING = 1
FAILED = 16  # times the status of a component: larger than any of an FMU
OUTPUTS, OUTPUTS_ARGUMENT, ROW = SET, SET_DERIVATIVES, INPUT_REFERENCES  # of a component, in the same places
part = partial(kernel, inner=True)
POINTER, INT, SIZE, DOUBLE = ir.IntType(8).as_pointer(), ir.IntType(32), ir.IntType(64), ir.DoubleType()


@kernel_tuple
class LoopLayout(NamedTuple):
    """What stays the same over a run. U units in the order of stepping, L links sorted by unit, P passes, D direct links."""

    calls: np.ndarray  # (U, 8) addresses; in the row of a component, from a row of its inputs to the next, bytes
    shape: np.ndarray  # (U, 7)
    inputs_at: np.ndarray  # (L,) addresses of the values of components' inputs
    outputs_at: np.ndarray  # (S,) addresses of components' outputs
    source: np.ndarray  # (L,) positions in the table of signals
    factor: np.ndarray  # (L,)
    offset: np.ndarray  # (L,)
    converted: np.ndarray  # (L,) bool
    feedthrough_schedule: np.ndarray  # (P,) units whose outputs follow their inputs within an instant
    direct: np.ndarray  # (D, 2) unit, link counted within the unit
    change: np.ndarray  # (D,) relative change of an input that is none
    inverse: np.ndarray  # (S,) 1 / nominal of every signal
    bonded: np.ndarray  # (B,) links whose polynomials are noted for the energy account
    watched: np.ndarray  # (W,) addresses of outputs of components that observers want of every step
    degree: int
    sequential: bool


@kernel_tuple
class LoopState(NamedTuple):
    """What changes: the table of signals and the histories of all links."""

    signals: np.ndarray  # (S,)
    present: np.ndarray  # (L,)
    before: np.ndarray  # (L,)
    earlier: np.ndarray  # (L,)
    reached: np.ndarray  # (L,)
    known: np.ndarray  # (L,)
    inputs: np.ndarray  # (3 L,) what is handed to the FMUs
    given: np.ndarray  # (L, 4) value, slope, half of the second derivative, degree over the last step
    samples: np.ndarray  # (U,) in the history
    spacing: np.ndarray  # (U, 2) s
    interpolates: np.ndarray  # (U,) bool: inputs were interpolated to values known already
    no_return: np.ndarray  # (U,) int32, as of `call_step`
    taken: np.ndarray  # (U,) steps
    time: np.ndarray  # (U,) s, that each unit has reached


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
def call_hook(typing, address, t, h, argument):
    """A function of `entries.Entry`; returns its status, int32."""
    def generate(context, builder, signature, arguments):
        return _call(builder, arguments[0], [DOUBLE, DOUBLE, POINTER], arguments[1:])

    return types.int32(types.int64, types.float64, types.float64, types.int64), generate


@intrinsic
def load(typing, address):
    """The number at an address."""
    def generate(context, builder, signature, arguments):
        return builder.load(builder.inttoptr(arguments[0], DOUBLE.as_pointer()))

    return types.float64(types.int64), generate


@intrinsic
def store(typing, address, value):
    """Write a number to an address."""
    def generate(context, builder, signature, arguments):
        builder.store(arguments[1], builder.inttoptr(arguments[0], DOUBLE.as_pointer()))
        return context.get_dummy_value()

    return types.void(types.int64, types.float64), generate


@part
def _gather(plan, now, unit, values):
    """Present values of a unit's inputs, into values[first link ...]."""
    first, n = plan.shape[unit, FIRST_LINK], plan.shape[unit, LINKS]
    for k in range(first, first + n):
        v = now.signals[plan.source[k]]
        values[k] = plan.factor[k] * v + plan.offset[k] if plan.converted[k] else v


@part
def _terms(plan, now, unit, late, h):
    """Inputs over the coming step, into now.inputs (values, slopes, halves one behind the other); returns their degree."""
    first, n = plan.shape[unit, FIRST_LINK], plan.shape[unit, LINKS]
    count, h1, h2 = now.samples[unit], now.spacing[unit, 0], now.spacing[unit, 1]
    value, slope, half = 3 * first, 3 * first + n, 3 * first + 2 * n
    highest = 0
    for k in range(n):
        i = first + k
        present, degree, s, c = now.present[i], 0, 0.0, 0.0
        if k < late:
            if count >= 2:
                degree, s = 1, (present - now.before[i]) / h1
            if count >= 3:
                older = (now.before[i] - now.earlier[i]) / h2
                c = (s - older) / (h1 + h2)
                degree, s = 2, s + h1 * c
        elif plan.degree == 0:
            present = now.known[i]
        else:
            degree, s = 1, (now.known[i] - present) / h
            if plan.degree == 2 and count > 1:
                older = (present - now.before[i]) / h1
                c = (s - older) / (h + h1)
                degree, s = 2, s + -h * c
        now.inputs[value + k], now.inputs[slope + k], now.inputs[half + k] = present, s, c
        highest = max(highest, degree)
    return highest


@part
def _drive(plan, now, unit, degree, h):
    """Hand the polynomials of `_terms` to the unit; returns the status of an FMU."""
    calls, shape = plan.calls[unit], plan.shape[unit]
    first, n, way = shape[FIRST_LINK], shape[LINKS], shape[WAY]
    base, address = 3 * first, now.inputs.ctypes.data
    for k in range(n):
        i = first + k
        v, s, c = now.inputs[base + k], now.inputs[base + n + k], now.inputs[base + 2 * n + k]
        now.given[i, 0], now.given[i, 1], now.given[i, 2], now.given[i, 3] = v, s, c, degree
        if way == IN_MEMORY:
            store(plan.inputs_at[i], v)
            if degree > 0:
                store(plan.inputs_at[i] + calls[ROW], s)
            if degree > 1:
                store(plan.inputs_at[i] + 2 * calls[ROW], c)
        if degree == 2:
            now.reached[i] = v + h * (s + h * c)
            now.inputs[base + 2 * n + k] = 2.0 * c
        else:
            now.reached[i] = v + h * s if degree == 1 else v
        if way == MEAN and degree > 0:
            now.inputs[base + k] = v + h * (s / 2.0 + h * c / 3.0)
    if way == IN_MEMORY:
        return 0
    references, values = calls[INPUT_REFERENCES], address + 8 * base
    if way == COMPANIONS:
        return call_values(calls[SET], calls[INSTANCE], references, n * (degree + 1), values)
    status = call_values(calls[SET], calls[INSTANCE], references, n, values)
    if way == DERIVATIVES:
        for order in range(degree):
            if status <= WARNING:
                status = call_derivatives(calls[SET_DERIVATIVES], calls[INSTANCE], references, n, calls[ORDERS] + 4 * order * n,
                                          values + 8 * (order + 1) * n)
    return status


@part
def _step(plan, now, unit, t, h):
    """Step one unit; returns its status."""
    calls = plan.calls[unit]
    now.taken[unit] += 1
    if plan.shape[unit, WAY] != IN_MEMORY:
        return call_step(calls[DO_STEP], calls[INSTANCE], t, h, now.no_return[unit])
    status = FAILED * call_hook(calls[DO_STEP], t, h, calls[INSTANCE])
    if status == 0:
        now.time[unit] = t + h
    return status


@part
def _read(plan, now, unit):
    """Outputs of a unit into the table of signals; returns the status of an FMU."""
    first, n = plan.shape[unit, FIRST_SIGNAL], plan.shape[unit, SIGNALS]
    if plan.shape[unit, WAY] == IN_MEMORY:
        for k in range(first, first + n):
            now.signals[k] = load(plan.outputs_at[k])
        return 0
    if n == 0:
        return 0
    calls = plan.calls[unit]
    return call_values(calls[GET], calls[INSTANCE], calls[OUTPUT_REFERENCES], n, now.signals.ctypes.data + 8 * first)


@part
def _stands(plan, now, unit):
    """Whether the outputs hold for the inputs as they are, as `Node.outputs_hold`; the inputs are in now.known."""
    if now.interpolates[unit]:
        return False
    for d in range(plan.direct.shape[0]):
        if plan.direct[d, 0] == unit:
            i = plan.shape[unit, FIRST_LINK] + plan.direct[d, 1]
            if not abs(now.known[i] - now.reached[i]) <= plan.change[d] * abs(now.known[i]):
                return False
    return True


@part
def _follow(plan, now):
    """Outputs follow their inputs within the instant, unit by unit; returns (a unit that failed, its status)."""
    updated = False
    for unit in plan.feedthrough_schedule:
        if now.interpolates[unit] and not updated:
            continue
        _gather(plan, now, unit, now.known)
        if _stands(plan, now, unit):
            continue
        first, n, calls = plan.shape[unit, FIRST_LINK], plan.shape[unit, LINKS], plan.calls[unit]
        if plan.shape[unit, WAY] == IN_MEMORY:
            for i in range(first, first + n):
                store(plan.inputs_at[i], now.known[i])
            status = FAILED * call_hook(calls[OUTPUTS], now.time[unit], 0.0, calls[OUTPUTS_ARGUMENT])
        else:
            for k in range(n):
                now.inputs[3 * first + k] = now.known[first + k]
            status = call_values(calls[SET], calls[INSTANCE], calls[INPUT_REFERENCES], n, now.inputs.ctypes.data + 24 * first)
        if status <= WARNING:
            status = _read(plan, now, unit)
        if status > WARNING:
            return unit, status
        updated = True
    return -1, 0


@part
def _push(plan, now, h):
    """Keep the inputs of the new instant."""
    for unit in range(plan.shape.shape[0]):
        first, n = plan.shape[unit, FIRST_LINK], plan.shape[unit, LINKS]
        for i in range(first, first + n):
            now.earlier[i], now.before[i] = now.before[i], now.present[i]
        _gather(plan, now, unit, now.present)
        now.spacing[unit, 1] = now.spacing[unit, 0]
        now.spacing[unit, 0] = h
        if now.samples[unit] <= plan.degree:
            now.samples[unit] += 1


@kernel
def run_steps(plan, now, times, h, limit, halt, rows, given, inputs, outputs):
    """Macro steps of length h from each of `times` (n,); the signals behind each go to rows (n, S), `bonded` to given (n, B, 4),
    all inputs and where they were led to to inputs (n, 2, L), `watched` to outputs (n, W).

    A number other than 0 in halt (1,) ends the march behind the present step. Returns (steps done, unit, status): a status above
    1 is that of the unit whose call failed; unit -2 says that the sum of the signals, each relative to its nominal value, has
    left `limit`.
    """
    units = plan.shape.shape[0]
    for step in range(times.size):
        for unit in range(units):
            shape = plan.shape[unit]
            if shape[LINKS] > 0:
                now.interpolates[unit] = plan.sequential and shape[LED] == 1
                if plan.sequential and shape[LATE] < shape[LINKS]:
                    _gather(plan, now, unit, now.known)
                status = _drive(plan, now, unit, _terms(plan, now, unit, shape[LATE], h), h)
                if status > WARNING:
                    return step, unit, status
            status = _step(plan, now, unit, times[step], h)
            if status <= WARNING and plan.sequential:
                status = _read(plan, now, unit)
            if status > WARNING:
                return step, unit, status
        if not plan.sequential:
            for unit in range(units):
                status = _read(plan, now, unit)
                if status > WARNING:
                    return step, unit, status
        unit, status = _follow(plan, now)
        if status > WARNING:
            return step, unit, status
        _push(plan, now, h)
        for i in range(plan.source.size):
            inputs[step, 0, i], inputs[step, 1, i] = now.present[i], now.reached[i]
        for k in range(plan.bonded.size):
            for d in range(4):
                given[step, k, d] = now.given[plan.bonded[k], d]
        for k in range(plan.watched.size):
            outputs[step, k] = load(plan.watched[k])
        total = 0.0
        for k in range(now.signals.size):
            rows[step, k] = now.signals[k]
            total += now.signals[k] * plan.inverse[k]
        if not abs(total) < limit:
            return step + 1, -2, 0
        if halt[0] != 0:
            return step + 1, -1, 0
    return times.size, -1, 0
