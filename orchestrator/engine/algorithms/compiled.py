"""Many macro steps of Jacobi or Gauss-Seidel in one compiled loop, for components of this process and FMUs of FMI 2.0.

The same steps as `Jacobi.step` and `GaussSeidel.step`, in the same order and to the last bit, without Python between the units.
Their functions are called by address; addresses are data, so one compiled loop serves every unit. Inputs and outputs of a
component are written and read where they lie in memory. Units and links are records: functions get them by one pointer each.
Everything stands in this one file, because Numba looks at no other one to see whether its machine code on disk is fresh.
"""

from __future__ import annotations

from functools import partial

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ....components.core.kernels import kernel
from ...units.call_names import COMPANIONS, DERIVATIVES, IN_MEMORY, MEAN, OF_COMPONENT, OF_FMU

WARNING = 1
FAILED = 16  # times the status of a component: larger than any of an FMU
UNALTERED, OVERRIDDEN, SHIFTED = range(3)  # by faults
AS_GIVEN, JUMPED, SMOOTH = range(3)  # inputs are as extrapolated; smoothed, but they have jumped; or start where they ended
part = partial(kernel, inner=True)
POINTER, INT, SIZE, DOUBLE = ir.IntType(8).as_pointer(), ir.IntType(32), ir.IntType(64), ir.DoubleType()

INTEGERS = (*OF_FMU, *OF_COMPONENT, "way", "first_link", "links", "late", "led", "first_signal", "signals", "degree",
            "smoothing", "samples", "interpolates", "no_return", "taken", "held")
# Units in the order of stepping. Addresses as in `CallTable`; first_link, links, late: the unit's links, of which the first
# `late` are extrapolated; led: all of them are interpolated to values that are known; first_signal, signals: in the table of
# signals; degree, samples, h1, h2: of the history; interpolates: what the last step did; taken: steps; held: links that are
# `apart`; time: s, reached, of an FMU the start of its last step.
UNIT = np.dtype([(name, np.int64) for name in INTEGERS] + [(name, np.float64) for name in ("h1", "h2", "time")])
# Links sorted by unit. at: address of a component's input; apart: whether an FMU is handed it only when it changes; source: in
# the table of signals; direct: an output follows it within an instant; held: it jumps between steps; fault: whether it is
# altered, by `alteration`; change: relative, that is none; present, before, earlier: samples; known: what it is led to; value,
# slope, half of the second derivative, degree: given in the last step; reached: its end.
LINK = np.dtype([(name, np.int64) for name in ("at", "apart", "source", "converted", "direct", "held", "fault")] + [
    (name, np.float64) for name in ("factor", "offset", "alteration", "change", "present", "before", "earlier", "known", "value",
                                    "slope", "half", "degree", "reached")])


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


@part
def _given(link, signals):
    """What a link hands over at this instant."""
    v = signals[link.source]
    if link.converted != 0:
        v = link.factor * v + link.offset
    if link.fault != UNALTERED:
        v = v + link.alteration if link.fault == SHIFTED else link.alteration
    return v


@part
def _ahead(unit, link):
    """As `History.ahead`: (value, slope, half of the second derivative) over the coming step."""
    v = link.present
    if unit.samples < 2 or link.held != 0:
        return v, 0.0, 0.0
    s = (v - link.before) / unit.h1
    if unit.samples < 3:
        return v, s, 0.0
    c = (s - (link.before - link.earlier) / unit.h2) / (unit.h1 + unit.h2)
    return v, s + unit.h1 * c, c


@part
def _towards(unit, link, h):
    """As `History.towards` the known value."""
    v = link.present
    if link.held != 0:
        return v, 0.0, 0.0
    if unit.degree == 0:
        return link.known, 0.0, 0.0
    s = (link.known - v) / h
    if unit.degree == 1 or unit.samples < 2:
        return v, s, 0.0
    c = (s - (v - link.before) / unit.h1) / (h + unit.h1)
    return v, s + -h * c, c


@part
def _drive(unit, links, signals, buffer, h):
    """Hand a unit its inputs over the coming step, and note where they will end; returns the status of an FMU."""
    first, behind, extrapolated = unit.first_link, unit.first_link + unit.links, unit.first_link + unit.late
    degree = unit.samples - 1 if unit.late > 0 else 0
    if unit.late < unit.links and unit.degree > 0:
        degree = max(degree, 2 if unit.degree == 2 and unit.samples > 1 else 1)
    held, smooth = degree == 0, unit.smoothing == SMOOTH
    if smooth:
        degree = max(degree, 1)
    for i in range(first, behind):
        link = links[i]
        if i < extrapolated:
            v, s, c = _ahead(unit, link)
        else:
            link.known = _given(link, signals)
            v, s, c = _towards(unit, link, h)
        if smooth and link.held == 0:
            back = (v - link.reached) / h
            v, s = link.reached, back if held else s + back
        link.value, link.slope, link.half, link.degree = v, s, c, degree
        if degree == 2:
            link.reached = v + h * (s + h * c)
        else:
            link.reached = v + h * s if degree == 1 else v
        if unit.way == IN_MEMORY:
            store(link.at, v)
            if degree > 0:
                store(link.at + unit.row, s)
            if degree > 1:
                store(link.at + 2 * unit.row, c)
    unit.interpolates = unit.led
    if unit.smoothing == JUMPED:
        unit.smoothing = SMOOTH
    return 0 if unit.way == IN_MEMORY else _drive_fmu(unit, links, buffer, degree, h, False)


@part
def _hold(unit, links, known):
    """Hand an FMU its inputs that are apart, if one of them has changed, `known` or as of the step; returns the status."""
    changed, at = False, unit.held_values
    for i in range(unit.first_link, unit.first_link + unit.links):
        link = links[i]
        if link.apart != 0:
            v = link.known if known else link.value
            changed = changed or load(at) != v
            store(at, v)
            at += 8
    return call_hook(unit.hold, unit.time, 0.0, 0) if changed else 0


@part
def _drive_fmu(unit, links, buffer, degree, h, known):
    """Hand an FMU the polynomials of its links, or values that are `known`; returns its status."""
    first, n, way = 3 * unit.first_link, unit.links - unit.held, unit.way
    status = _hold(unit, links, known) if unit.held > 0 else 0
    if status > WARNING or n == 0:
        return status
    values, k = buffer.ctypes.data + 8 * first, first
    for i in range(unit.first_link, unit.first_link + unit.links):
        link = links[i]
        if link.apart != 0:
            continue
        v, s, c = link.known if known else link.value, link.slope, link.half
        if way == MEAN and degree > 0:
            v = v + h * (s / 2.0 + h * c / 3.0)
        buffer[k], buffer[k + n], buffer[k + 2 * n] = v, s, 2.0 * c
        k += 1
    if way == COMPANIONS:
        return call_values(unit.set, unit.instance, unit.input_references, n * (degree + 1), values)
    status = call_values(unit.set, unit.instance, unit.input_references, n, values)
    if way == DERIVATIVES:
        for order in range(degree):
            if status <= WARNING:
                status = call_derivatives(unit.set_derivatives, unit.instance, unit.input_references, n,
                                          unit.orders + 4 * order * n, values + 8 * (order + 1) * n)
    return status


@part
def _step(unit, t, h):
    """Step one unit; returns its status."""
    unit.taken += 1
    if unit.way != IN_MEMORY:
        unit.time = t
        return call_step(unit.do_step, unit.instance, t, h, np.int32(unit.no_return))
    status = FAILED * call_hook(unit.step, t, h, unit.step_argument)
    if status == 0:
        unit.time = t + h
    return status


@part
def _read(unit, outputs_at, signals):
    """Outputs of a unit into the table of signals; returns the status of an FMU."""
    first, n = unit.first_signal, unit.signals
    if unit.way == IN_MEMORY:
        for k in range(first, first + n):
            signals[k] = load(outputs_at[k])
        return 0
    if unit.parts == 0:
        return call_values(unit.get, unit.instance, unit.output_references, n, signals.ctypes.data + 8 * first) if n > 0 else 0
    cell = unit.part_cells
    for _ in range(unit.parts):  # as `call_table.output_parts` writes them
        whole, n = load_int64(cell + 32), load_int64(cell + 40)
        status = call_values(load_int64(cell), unit.instance, load_int64(cell + 8), load_int64(cell + 16), load_int64(cell + 24))
        if status > WARNING:
            return status
        cell += 48
        for _ in range(n):
            row, at = first + load_int64(cell), load_int64(cell + 8)
            signals[row] = load_int32(at) if whole != 0 else load(at)
            cell += 16
    return 0


@part
def _stands(unit, links, signals):
    """Whether the outputs hold for the inputs as they are, as `Node.outputs_hold`; the inputs are noted as known."""
    stands = unit.interpolates == 0
    for i in range(unit.first_link, unit.first_link + unit.links):
        link = links[i]
        link.known = v = _given(link, signals)
        if link.direct != 0 and not abs(v - link.reached) <= link.change * abs(v):
            stands = False
    return stands


@part
def _update(unit, links, outputs_at, signals, buffer):
    """Bring the outputs of a unit up to date for its known inputs; returns the status."""
    first, n = unit.first_link, unit.links
    if unit.way == IN_MEMORY:
        for i in range(first, first + n):
            store(links[i].at, links[i].known)
        status = FAILED * call_hook(unit.outputs, unit.time, 0.0, unit.outputs_argument)
    else:
        status = _drive_fmu(unit, links, buffer, 0, 0.0, True)
    return _read(unit, outputs_at, signals) if status <= WARNING else status


@part
def _push(unit, links, signals, h):
    """Keep the inputs of the new instant."""
    for i in range(unit.first_link, unit.first_link + unit.links):
        link = links[i]
        link.earlier = link.before
        link.before = link.present
        link.present = _given(link, signals)
    unit.h2 = unit.h1
    unit.h1 = h
    if unit.samples <= unit.degree:
        unit.samples += 1


@kernel
def run_steps(units, links, following, outputs_at, inverse, bonded, watched, signals, buffer, sequential, times, h, limit, halt,
              looks, rows, given, inputs, outputs):
    """Macro steps of length h from each of `times` (n,), for U `UNIT`s and L `LINK`s.

    following: (P,) units whose outputs follow their inputs within an instant; outputs_at: (S,) addresses of components' outputs;
    inverse: (S,) 1 / nominal of every signal; bonded: (B,) links whose polynomials are noted for the energy account; watched:
    (W,) addresses of outputs of components that observers want of every step; signals: (S,), the table; buffer: (3 L,), what is
    handed to FMUs. The signals behind each step go to rows (n, S), what bonded inputs were given to given (n, B, 4), `watched`
    to outputs (n, W); behind the steps `looks` (m,), all inputs and where they were led to go to inputs (m, 2, L).

    A number other than 0 in halt (1,) ends the march behind the present step. Returns (steps done, unit, status): a status above
    1 is that of the unit whose call failed; unit -2 says that the sum of the signals, each relative to its nominal value, has
    left `limit`.
    """
    look = 0
    for step in range(times.size):
        for k in range(units.size):
            unit = units[k]
            status = _drive(unit, links, signals, buffer, h) if unit.links > 0 else 0
            if status <= WARNING:
                status = _step(unit, times[step], h)
            if status <= WARNING and sequential:
                status = _read(unit, outputs_at, signals)
            if status > WARNING:
                return step, k, status
        if not sequential:
            for k in range(units.size):
                status = _read(units[k], outputs_at, signals)
                if status > WARNING:
                    return step, k, status
        updated = False
        for k in following:
            unit = units[k]
            if (updated or unit.interpolates == 0) and not _stands(unit, links, signals):
                status = _update(unit, links, outputs_at, signals, buffer)
                if status > WARNING:
                    return step, k, status
                updated = True
        for k in range(units.size):
            _push(units[k], links, signals, h)
        if look < looks.size and looks[look] == step:
            for i in range(links.size):
                inputs[look, 0, i], inputs[look, 1, i] = links[i].present, links[i].reached
            look += 1
        for k in range(bonded.size):
            link = links[bonded[k]]
            given[step, k, 0], given[step, k, 1] = link.value, link.slope
            given[step, k, 2], given[step, k, 3] = link.half, link.degree
        for k in range(watched.size):
            outputs[step, k] = load(watched[k])
        total = 0.0
        for k in range(signals.size):
            rows[step, k] = signals[k]
            total += signals[k] * inverse[k]
        if not abs(total) < limit:
            return step + 1, -2, 0
        if halt[0] != 0:
            return step + 1, -1, 0
    return times.size, -1, 0
