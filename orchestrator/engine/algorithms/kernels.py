"""The loop: what a master does in a macro step, as kernels over its `records`. No other code does any of it.

A row of the program is one act on one unit: `START` it towards the end of the step, `READ` its outputs, `UPDATE` its outputs for the
inputs of the instant, let them `FOLLOW` if its inputs have changed, `PUSH` the samples of the new instant. Where outputs follow inputs
that jump, they do so twice, to the `LEFT` of the jump, which `LOOK` notes, and to its `RIGHT`; older samples `SHIFT` by what came
between, so that slopes behind a jump are those before it.
`run_steps` executes the rows of a macro step one after the other, and many macro steps. An algorithm that decides inside a step has it
execute the rows up to the decision.

A unit is called by address: functions of a component, of an FMU of FMI 2.0, or callbacks into Python for whatever else it is.
Inputs and outputs of a component are written and read where they lie in memory. A unit with a rate of its own has three records
`UNIT`. The first (`NOTED`) takes part in every macro step. The second steps; its inputs lie where those of the first end. The third
has the outputs that other units see between its steps.
"""

from __future__ import annotations

import numpy as np

from ....components.core.kernels import inlined_kernel, kernel
from ...units.call_names import COMPANIONS, DERIVATIVES, FAILED, IN_MEMORY, IN_PYTHON, MEAN, NOTED, OF_STEP
from ...units.calls import (
    call_derivatives,
    call_entry,
    call_restore,
    call_save,
    call_step,
    call_values,
    load,
    load_int32,
    load_int64,
    store,
)
from .polynomials import _degree, _extrapolate, _interpolate_to, end_of
from .records import (
    BEYOND,
    EXTRAPOLATED,
    FOLLOW,
    FORESEE,
    INTERPOLATED,
    JUMPS,
    LEFT,
    LOOK,
    PUSH,
    READ,
    RIGHT,
    SHIFT,
    SHIFTED,
    START,
    UNALTERED,
    UPDATE,
)

WARNING = 1
KNOWN = -1  # in the place of a degree
LIMIT = 1e12  # of the sum of all outputs, each relative to its nominal value: what is beyond is to be looked at
ROUNDED = 1e-12  # of a time: rounding of sums of steps


@kernel
def _mapped(link, signals, v):
    """What becomes of a value by the map of a link; not a number where the map has no entry for it."""
    for k in range(link.first_pair, link.first_pair + 2 * link.pairs, 2):
        if signals[k] == v:
            return signals[k + 1]
    return np.nan


@kernel
def _given(link, signals):
    """What a link hands over at this instant."""
    v = signals[link.source]
    if link.converted != 0:
        v = link.factor * v + link.offset if link.pairs == 0 else _mapped(link, signals, v)
    if link.fault != UNALTERED:
        v = v + link.alteration if link.fault == SHIFTED else link.alteration
    return v


@inlined_kernel
def _drive(unit, links, pasts, signals, buffer, h):
    """Hand a unit its inputs over the coming step, and note where they will end; returns the status of an FMU."""
    first, behind, extrapolated = unit.first_link, unit.first_link + unit.links, unit.first_link + unit.n_extrapolated
    degree = 0  # that of the most bent input
    for k in range(unit.first_past, unit.first_past + unit.pasts):
        degree = max(degree, _degree(unit, pasts[k]))
    if unit.pressed != 0:
        degree = max(degree, 1)
    given = 2 if unit.corrected != 0 else degree
    in_memory = unit.input_mode == IN_MEMORY and unit.lost == 0
    past = pasts[unit.first_past]
    for i in range(first, behind):
        link = links[i]
        if unit.pasts > 1:
            past = pasts[link.past]
        if i >= extrapolated:
            link.known = _given(link, signals)
            v, s, c = _interpolate_to(past, link, h)
        elif link.pressed != 0 and link.fault == UNALTERED:
            v, s, c = link.force, link.rate, 0.0
        else:
            v, s, c = _extrapolate(past, link)
        link.reached = end_of(v, s, c, degree, h)
        if given > degree:  # what is owed, as a parabola that vanishes at both ends of the step, where inputs stay true
            s += 6.0 * link.owed / (h * h)
            c -= 6.0 * link.owed / (h * (h * h))
        link.value, link.slope, link.quadratic, link.degree = v, s, c, given
        if in_memory:
            store(link.at, v)
            if given > 0:
                store(link.at + unit.row, s)
            if given > 1:
                store(link.at + 2 * unit.row, c)
    unit.ends = INTERPOLATED if unit.all_interpolated != 0 else EXTRAPOLATED
    if unit.input_mode >= IN_MEMORY or unit.lost != 0:
        return 0
    unit.degree = given
    return _drive_fmu(unit, links, buffer, h)


@kernel
def _restored(unit, status):
    """The status of a call of an FMU, behind which the floating-point environment is that of the start, see `units.environment`."""
    cells = unit.environment
    if cells != 0:
        one, little = load(cells + 16), load(cells + 24)
        ordinary = one + little == one and one - little == one
        if not (ordinary and load(cells + 32) - load(cells + 40) > 0.0 and load(cells + 48) > 0.0):
            call_restore(load_int64(cells), load_int64(cells + 8))
    return status


@kernel
def _hold(unit, links):
    """Hand an FMU the inputs that are set on change, if one has changed, as `_drive_fmu`; returns the status."""
    changed, at = False, unit.held_values
    for i in range(unit.first_link, unit.first_link + unit.links):
        link = links[i]
        if link.set_on_change != 0:
            v = link.known if unit.degree == KNOWN else link.value
            changed = changed or load(at) != v
            store(at, v)
            at += 8
    return call_entry(unit.hold, unit.time, 0.0, 0) if changed else 0


@kernel
def _drive_fmu(unit, links, buffer, h):
    """Hand an FMU the polynomials of its links, or the values that are known; returns its status."""
    degree = unit.degree
    first, n, mode = 3 * unit.first_link, unit.links - unit.n_set_on_change, unit.input_mode
    status = _hold(unit, links) if unit.n_set_on_change > 0 else 0
    if status > WARNING or n == 0:
        return status
    values, k = buffer.ctypes.data + 8 * first, first
    for i in range(unit.first_link, unit.first_link + unit.links):
        link = links[i]
        if link.set_on_change != 0:
            continue
        v, s, c = link.known if degree == KNOWN else link.value, link.slope, link.quadratic
        if mode == MEAN and degree > 0:
            v = v + h * (s / 2.0 + h * c / 3.0)
        buffer[k], buffer[k + n], buffer[k + 2 * n] = v, s, 2.0 * c
        k += 1
    if mode == COMPANIONS:
        return _restored(unit, call_values(unit.set, unit.instance, unit.input_references, n * (max(degree, 0) + 1), values))
    status = call_values(unit.set, unit.instance, unit.input_references, n, values)
    if mode == DERIVATIVES:
        for order in range(degree):
            if status <= WARNING:
                status = call_derivatives(
                    unit.set_derivatives,
                    unit.instance,
                    unit.input_references,
                    n,
                    unit.orders + 4 * order * n,
                    values + 8 * (order + 1) * n,
                )
    return _restored(unit, status)


@kernel
def _step(unit, t, h):
    """Step one unit; returns its status."""
    unit.taken += 1
    if unit.input_mode < IN_MEMORY:
        unit.time = t
        status = call_save(unit.save, unit.instance, unit.state) if unit.save != 0 else 0
        if status > WARNING:
            return status
        status = _restored(unit, call_step(unit.do_step, unit.instance, t, h, np.int32(unit.no_return)))
        if status == WARNING:
            unit.warned += 1
        return status if status <= WARNING else status + OF_STEP
    status = FAILED * call_entry(unit.step, t, h, unit.argument)
    if status == 0:
        unit.time = t + h
    return status


@inlined_kernel
def _start(unit, units, links, pasts, signals, buffer, t, h):
    """Drive a unit over the coming step and let it step; returns the status.

    One with a rate of its own steps in the last macro step of its own step, or of the run.
    """
    while True:
        status = _drive(unit, links, pasts, signals, buffer, h) if unit.links > 0 else 0
        if status > WARNING or unit.lost != 0:
            return status
        if unit.input_mode != NOTED:
            return _step(unit, t, h)
        own, first = units[unit.slow], unit.first_link  # the unit that steps; behind it, its outputs between its steps
        if unit.count == 0:
            for k in range(unit.links):
                signals[links[own.first_link + k].source] = links[first + k].value
            for k in range(2):
                _push(units[unit.slow + k], links, pasts, signals, unit.length, 1)
            unit.start = t
        unit.count += 1
        equal = unit.count == 1 or unit.length == (unit.count - 1) * h  # then no difference of times rounds the length
        unit.length = unit.count * h if equal else unit.length + h
        if unit.count < unit.every and unit.stop - (t + h) > ROUNDED * (abs(t) + h):
            return 0
        unit.count = 0
        for k in range(unit.links):
            signals[links[own.first_link + k].source] = links[first + k].reached
        t, h = unit.start, unit.length
        unit = own


@kernel
def _read(unit, outputs_at, signals):
    """Outputs of a unit into the table of signals; returns the status."""
    first, n = unit.first_signal, unit.signals
    if unit.input_mode == IN_MEMORY:
        for k in range(first, first + n):
            signals[k] = load(outputs_at[k])
        return 0
    if unit.input_mode == IN_PYTHON:
        return FAILED * call_entry(unit.read, unit.time, 0.0, 0)
    if unit.parts == 0:
        if n == 0:
            return 0
        return _restored(unit, call_values(unit.get, unit.instance, unit.output_references, n, signals.ctypes.data + 8 * first))
    cell = unit.part_cells
    for _ in range(unit.parts):  # as `call_table.output_parts` writes them
        whole, n = load_int64(cell + 32), load_int64(cell + 40)
        references, size, buffer = load_int64(cell + 8), load_int64(cell + 16), load_int64(cell + 24)
        status = _restored(unit, call_values(load_int64(cell), unit.instance, references, size, buffer))
        if status > WARNING:
            return status
        cell += 48
        for _ in range(n):
            row, at = first + load_int64(cell), load_int64(cell + 8)
            signals[row] = load_int32(at) if whole != 0 else load(at)
            cell += 16
    return 0


@inlined_kernel
def _read_any(unit, units, links, pasts, outputs_at, signals):
    """Outputs of a unit of any rate into the table of signals; returns the status. A lost unit's are what they were."""
    if unit.input_mode != NOTED:
        return _read(unit, outputs_at, signals)
    status = _read(units[unit.slow], outputs_at, signals) if unit.count == 0 else 0
    _show(unit, units, links, pasts, signals)
    return status


@kernel
def _show(unit, units, links, pasts, signals):
    """What the others go by: the outputs of a unit with a rate of its own, between its steps what their polynomials say."""
    seen = units[unit.slow + 1]
    for k in range(seen.links):
        link = links[seen.first_link + k]
        past, v = pasts[link.past], signals[link.source]
        if unit.count > 0:
            v, s, c = _extrapolate(past, link)
            v = end_of(v, s, c, past.samples - 1, unit.length)
        signals[seen.first_signal + k] = v


@inlined_kernel
def _stands(unit, links, signals, inside):
    """Whether the outputs hold for the inputs as they are: none that they depend on at once has moved. Notes these as known.

    inside: a step is under way, at whose end inputs jump that are held over it.
    """
    stands = unit.ends == EXTRAPOLATED
    for i in range(unit.first_link, unit.first_link + unit.links):
        link = links[i]
        link.known = v = link.value if inside and link.held == JUMPS else _given(link, signals)
        if link.direct != 0 and not abs(v - link.reached) <= link.change * abs(v):
            stands = False
    return stands


@kernel
def _update(unit, links, buffer):
    """Bring the outputs of a unit up to date for its known inputs; returns the status."""
    if unit.input_mode < IN_MEMORY:
        unit.degree = KNOWN
        return _drive_fmu(unit, links, buffer, 0.0)
    if unit.input_mode == IN_MEMORY:
        for i in range(unit.first_link, unit.first_link + unit.links):
            store(links[i].at, links[i].known)
    return FAILED * call_entry(unit.outputs, unit.time, 0.0, unit.argument)


@kernel
def _update_any(unit, units, links, buffer):
    """As `_update` for a unit of any rate: between its steps its outputs are what the polynomial says."""
    if unit.lost != 0 or (unit.input_mode == NOTED and unit.count > 0):
        return 0
    if unit.input_mode != NOTED:
        return _update(unit, links, buffer)
    own = units[unit.slow]
    for k in range(unit.links):
        links[own.first_link + k].known = links[unit.first_link + k].known
    return _update(own, links, buffer)


@inlined_kernel
def _push(unit, links, pasts, signals, h, updated):
    """Keep the inputs of the new instant, h behind the last one, of those links whose source has stepped.

    They are the values at which their polynomials end, unless outputs have been updated since.
    """
    known, past = unit.ends == INTERPOLATED and updated == 0, pasts[unit.first_past]
    for i in range(unit.first_link, unit.first_link + unit.links):
        link = links[i]
        link.now = link.known if known else _given(link, signals)
        if unit.pasts > 1:
            past = pasts[link.past]
        if past.left == 0:
            link.earlier = link.before
            link.before = link.present
            link.present = link.now
    for k in range(unit.first_past, unit.first_past + unit.pasts):
        past = pasts[k]
        if past.left > 0:
            past.elapsed += h
            past.left -= 1
        else:
            past.h2, past.h1 = past.h1, past.elapsed + h
            past.elapsed, past.left = 0.0, past.every - 1
            if past.samples <= past.degree:
                past.samples += 1


@kernel
def _shift(unit, links, signals):
    """Shift the samples that there are by the jump since the last `LOOK`."""
    for i in range(unit.first_link, unit.first_link + unit.links):
        link = links[i]
        link.jump = _given(link, signals) - link.looked
        link.present += link.jump
        link.before += link.jump


@kernel
def _look(unit, links, pasts, signals, h, foresee):
    """Note what the inputs are, or where extrapolation will have taken them after h."""
    for i in range(unit.first_link, unit.first_link + unit.links):
        link = links[i]
        if foresee:
            v, s, c = _extrapolate(pasts[link.past], link)
            link.foreseen = end_of(v, s, c, pasts[link.past].samples - 1, h)
        else:
            link.looked = _given(link, signals)


@kernel
def _keep(step, m):
    """What is wanted of a macro step."""
    request, links, n = m.request[0], m.links, m.inverse.size
    if request.rows != 0:
        for k in range(n):
            store(request.rows + 8 * (step * n + k), m.signals[k])
        for k in range(m.bonded.size):
            link, at = links[m.bonded[k]], request.given + 40 * (step * m.bonded.size + k)
            store(at, link.value)
            store(at + 8, link.slope)
            store(at + 16, link.quadratic)
            store(at + 24, link.degree)
            store(at + 32, link.jump)
        for k in range(request.watches):
            store(request.outputs + 8 * (step * request.watches + k), load(load_int64(request.watched + 8 * k)))
    if request.sampled_done < request.sampled_count and load_int64(request.sampled + 8 * request.sampled_done) == step:
        row, driven = 2 * request.sampled_done, request.driven
        for i in range(driven):
            store(request.inputs + 8 * (row * driven + i), links[i].now)
            store(request.inputs + 8 * ((row + 1) * driven + i), links[i].reached)
        request.sampled_done += 1


@kernel
def run_steps(t, h, m):
    """Take the rows of the program that the request names, in each of its macro steps of length h; see `records.REQUEST`."""
    request, units, links, pasts, signals = m.request[0], m.units, m.links, m.pasts, m.signals
    request.unit, request.status, request.done, request.sampled_done = -1, 0, 0, 0
    for step in range(request.steps):
        if request.times != 0:
            t = load(request.times + 8 * step)
        if request.whole != 0:
            request.updated = 0
        for row in range(request.first, request.last):
            act, place = m.program[row, 0], m.program[row, 1]
            unit, status, reads = units[place], 0, act == READ
            if act == START:
                status = _start(unit, units, links, pasts, signals, m.buffer, t, h)
            elif act == PUSH:
                _push(unit, links, pasts, signals, h, request.updated)
            elif act == SHIFT:
                _shift(unit, links, signals)
            elif act in (LOOK, FORESEE):
                _look(unit, links, pasts, signals, h, act == FORESEE)
            elif act == UPDATE or (act in (FOLLOW, LEFT, RIGHT) and (unit.ends != INTERPOLATED or request.updated != 0)):
                inside = act == LEFT or (act == UPDATE and h > 0.0)
                moved = not _stands(unit, links, signals, inside)  # which notes what is known
                if moved or act == UPDATE or (act == RIGHT and request.updated != 0):
                    status = _update_any(unit, units, links, m.buffer)
                    request.updated, reads = 1, act != UPDATE
            if status <= WARNING and reads:
                status = _read_any(unit, units, links, pasts, m.outputs_at, signals)
            if status > WARNING:
                request.row, request.unit, request.status = row, place, status
                return 0
        if request.whole == 0:
            continue
        _keep(step, m)
        total = 0.0
        for k in range(m.inverse.size):
            if m.inverse[k] != 0.0:  # 0: nothing depends on it
                total += signals[k] * m.inverse[k]
        request.done += 1
        if not abs(total) < LIMIT:
            request.unit = BEYOND
            return 0
        if request.halt != 0:
            return 0
    return 0
