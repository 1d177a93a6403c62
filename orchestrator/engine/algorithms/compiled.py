"""Many macro steps of Jacobi or Gauss-Seidel in one compiled loop, for components of this process and FMUs of FMI 2.0.

The same steps as `Jacobi.step` and `GaussSeidel.step`, in the same order and to the last bit, without Python between the units.
Their functions are called by address; addresses are data, so one compiled loop serves every unit. Inputs and outputs of a
component are written and read where they lie in memory. Units, links and histories are records: functions get them by one
pointer each. A unit with a rate of its own is three of `UNIT`: the one that takes part in every macro step (`NOTED`), the one
that steps, whose inputs are where those of the first have been led to, and its outputs as the others see them in between.
"""

from __future__ import annotations

import numpy as np

from ....components.core.kernels import kernel
from ...units.call_names import COMPANIONS, DERIVATIVES, IN_MEMORY, MEAN, OF_COMPONENT, OF_FMU
from ...units.calls import call_derivatives, call_entry, call_step, call_values, load, load_int32, load_int64, store

WARNING = 1
FAILED = 16  # times the status of a component: larger than any of an FMU
UNALTERED, OVERRIDDEN, SHIFTED = range(3)  # by faults
AS_GIVEN, JUMPED, SMOOTH = range(3)  # inputs are as extrapolated; smoothed, but they have jumped; or start where they ended
CHANGES, JUMPS, CONSTANT = range(3)  # inputs follow the polynomial; jump between steps; are held beside a place that moves on
NOTED = IN_MEMORY + 1  # the way of inputs that a unit with a rate of its own gets when it steps

INTEGERS = (*OF_FMU, *OF_COMPONENT, "way", "first_link", "links", "late", "led", "first_signal", "signals", "first_past", "pasts",
            "smoothing", "interpolates", "no_return", "taken", "held", "every", "count", "slow")
# Units in the order of stepping. Addresses as in `CallTable`; first_link, links, late: the unit's links, of which the first
# `late` are extrapolated; led: all of them are interpolated to values that are known; first_signal, signals: in the table of
# signals; first_past, pasts: histories of its links; interpolates: what the last step did; taken: steps; held: links that are
# `apart`; every: macro steps to one of the unit, `count` of which are done since `start`, s, over `length`, s; slow: its other
# two records among the slow ones; time: s, reached, of an FMU the start of its last step.
UNIT = np.dtype([(name, np.int64) for name in INTEGERS] + [(name, np.float64) for name in ("start", "length", "time")])
# Links sorted by unit. at: address of a component's input; apart: whether an FMU is handed it only when it changes; source: in
# the table of signals; past: its history; direct: an output follows it within an instant; held: `JUMPS` or `CONSTANT`; fault:
# whether it is altered, by `alteration`; change: relative, that is none; now: its value; present, before, earlier: samples;
# known: what it is led to; value, slope, half of the second derivative, degree: given in the last step; reached: its end.
LINK = np.dtype([(name, np.int64) for name in ("at", "apart", "source", "past", "converted", "direct", "held", "fault")] + [
    (name, np.float64) for name in ("factor", "offset", "alteration", "change", "now", "present", "before", "earlier", "known",
                                    "value", "slope", "half", "degree", "reached")])
# Histories. degree, samples, h1, h2: as of `History`; every: macro steps from one sample to the next, `left` of which are to come
# before the step that ends at one; elapsed: s, since the last one.
PAST = np.dtype([(name, np.int64) for name in ("degree", "samples", "every", "left")] + [
    (name, np.float64) for name in ("h1", "h2", "elapsed")])


@kernel
def _given(link, signals):
    """What a link hands over at this instant."""
    v = signals[link.source]
    if link.converted != 0:
        v = link.factor * v + link.offset
    if link.fault != UNALTERED:
        v = v + link.alteration if link.fault == SHIFTED else link.alteration
    return v


@kernel
def _ahead(past, link, slow):
    """As `History.ahead`: (value, slope, half of the second derivative) over the coming step."""
    v = link.present
    if past.samples < 2:
        return v, 0.0, 0.0
    s = c = 0.0
    if link.held == 0:
        s = (v - link.before) / past.h1
        if past.samples > 2:
            c = (s - (link.before - link.earlier) / past.h2) / (past.h1 + past.h2)
            s += past.h1 * c
    return (v, s, c) if slow is None else _seen(past, v, s, c, past.samples > 2)


@kernel
def _towards(past, link, slow, h):
    """As `History.towards` the known value; the polynomial of a source that does not step goes on."""
    if slow is not None:
        if past.left != 0:
            return _ahead(past, link, slow)
        h += past.elapsed
    v, c = link.known if link.held == CONSTANT else link.present, 0.0
    if past.degree == 0:
        return v if link.held == JUMPS else link.known, 0.0, 0.0
    bent = past.degree == 2 and past.samples > 1
    s = 0.0 if link.held != 0 else (link.known - v) / h
    if bent and link.held == 0:
        c = (s - (v - link.before) / past.h1) / (h + past.h1)
        s += -h * c
    return (v, s, c) if slow is None else _seen(past, v, s, c, bent)


@kernel
def _seen(past, v, s, c, bent):
    """As `Part._seen`: the polynomial from the present instant instead of from the last sample."""
    e = past.elapsed
    if e == 0.0:
        return v, s, c
    return (v + e * (s + e * c), s + 2.0 * e * c, c) if bent else (v + e * s, s, c)


@kernel
def _end(v, s, c, degree, h):
    """As `Rows.end`: where the polynomial is after h."""
    if degree == 2:
        return v + h * (s + h * c)
    return v + h * s if degree == 1 else v


@kernel
def _degree(unit, slow, past):
    """Of the polynomials that a history gives a unit."""
    degree = past.samples - 1
    if unit.late < unit.links and past.degree > 0 and (slow is None or past.left == 0):
        degree = max(degree, 2 if past.degree == 2 and past.samples > 1 else 1)
    return degree


@kernel
def _drive(unit, slow, links, pasts, signals, buffer, h):
    """Hand a unit its inputs over the coming step, and note where they will end; returns the status of an FMU."""
    past = pasts[unit.first_past]
    first, behind, extrapolated = unit.first_link, unit.first_link + unit.links, unit.first_link + unit.late
    degree = _degree(unit, slow, past)
    if slow is not None:  # that of the most bent input
        for k in range(1, unit.pasts):
            degree = max(degree, _degree(unit, slow, pasts[unit.first_past + k]))
    held, smooth = degree == 0, unit.smoothing == SMOOTH
    if smooth:
        degree = max(degree, 1)
    for i in range(first, behind):
        link = links[i]
        if slow is not None:
            past = pasts[link.past]
        if i < extrapolated:
            v, s, c = _ahead(past, link, slow)
        else:
            link.known = _given(link, signals)
            v, s, c = _towards(past, link, slow, h)
        if smooth and link.held != JUMPS:
            back = (v - link.reached) / h
            v, s = link.reached, back if held else s + back
        link.value, link.slope, link.half, link.degree = v, s, c, degree
        link.reached = _end(v, s, c, degree, h)
        if unit.way == IN_MEMORY:
            store(link.at, v)
            if degree > 0:
                store(link.at + unit.row, s)
            if degree > 1:
                store(link.at + 2 * unit.row, c)
    unit.interpolates = unit.led
    if unit.smoothing == JUMPED:
        unit.smoothing = SMOOTH
    if buffer is None or unit.way >= IN_MEMORY:
        return 0
    return _drive_fmu(unit, links, buffer, degree, h, False)


@kernel
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
    return call_entry(unit.hold, unit.time, 0.0, 0) if changed else 0


@kernel
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


@kernel
def _step(unit, t, h):
    """Step one unit; returns its status."""
    unit.taken += 1
    if unit.way != IN_MEMORY:
        unit.time = t
        return call_step(unit.do_step, unit.instance, t, h, np.int32(unit.no_return))
    status = FAILED * call_entry(unit.step, t, h, unit.step_argument)
    if status == 0:
        unit.time = t + h
    return status


@kernel
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


@kernel
def _stands(unit, links, signals):
    """Whether the outputs hold for the inputs as they are, as `Node.outputs_hold`; the inputs are noted as known."""
    stands = unit.interpolates == 0
    for i in range(unit.first_link, unit.first_link + unit.links):
        link = links[i]
        link.known = v = _given(link, signals)
        if link.direct != 0 and not abs(v - link.reached) <= link.change * abs(v):
            stands = False
    return stands


@kernel
def _update(unit, links, outputs_at, signals, buffer):
    """Bring the outputs of a unit up to date for its known inputs; returns the status."""
    first, n = unit.first_link, unit.links
    if buffer is None or unit.way == IN_MEMORY:
        for i in range(first, first + n):
            store(links[i].at, links[i].known)
        status = FAILED * call_entry(unit.outputs, unit.time, 0.0, unit.outputs_argument)
    else:
        status = _drive_fmu(unit, links, buffer, 0, 0.0, True)
    return _read(unit, outputs_at, signals) if status <= WARNING else status


@kernel
def _note(past, h):
    """Count a sample, h behind the last one."""
    past.h2, past.h1 = past.h1, h
    if past.samples <= past.degree:
        past.samples += 1


@kernel
def _push(unit, slow, links, pasts, signals, h):
    """Keep the inputs of the new instant, h behind the last one, of those links whose source has stepped."""
    for i in range(unit.first_link, unit.first_link + unit.links):
        link = links[i]
        link.now = _given(link, signals)
        if slow is None or pasts[link.past].left == 0:
            link.earlier = link.before
            link.before = link.present
            link.present = link.now
    if slow is None:
        _note(pasts[unit.first_past], h)
        return
    for k in range(unit.first_past, unit.first_past + unit.pasts):
        past = pasts[k]
        past.elapsed += h
        if past.left == 0:
            _note(past, past.elapsed)
            past.elapsed = 0.0
            past.left = past.every
        past.left -= 1


@kernel
def _step_slow(unit, slow, links, pasts, signals, buffer, t, h):
    """As `MultirateUnit.step` and what its `drive` does."""
    own, seen = slow[unit.slow], slow[unit.slow + 1]  # the unit that steps, and its outputs between its steps
    if unit.count == 0:
        for k in range(unit.links):
            signals[links[own.first_link + k].source] = links[unit.first_link + k].value
        _push(own, slow, links, pasts, signals, unit.length)
        _push(seen, slow, links, pasts, signals, unit.length)
        unit.start = t
    unit.count += 1
    unit.length = unit.count * h
    if unit.count < unit.every:
        return 0
    unit.count = 0
    for k in range(unit.links):
        signals[links[own.first_link + k].source] = links[unit.first_link + k].reached
    status = _drive(own, slow, links, pasts, signals, buffer, unit.length) if unit.links > 0 else 0
    return _step(own, unit.start, unit.length) if status <= WARNING else status


@kernel
def _show(unit, slow, links, pasts, signals):
    """As the end of `MultirateUnit.get`: what others go by."""
    seen = slow[unit.slow + 1]
    for k in range(seen.links):
        link = links[seen.first_link + k]
        v = signals[link.source]
        if unit.count > 0:
            v, s, c = _ahead(pasts[link.past], link, slow)
            v = _end(v, s, c, pasts[link.past].samples - 1, unit.length)
        signals[seen.first_signal + k] = v


@kernel
def _read_all(unit, slow, links, pasts, outputs_at, signals):
    """Outputs of a unit of any rate into the table of signals; returns the status of an FMU."""
    if slow is None or unit.way != NOTED:
        return _read(unit, outputs_at, signals)
    status = _read(slow[unit.slow], outputs_at, signals) if unit.count == 0 else 0
    _show(unit, slow, links, pasts, signals)
    return status


@kernel
def _update_all(unit, slow, links, pasts, outputs_at, signals, buffer):
    """As `_update` for a unit of any rate: between its steps its outputs are what the polynomial says."""
    if slow is None or unit.way != NOTED:
        return _update(unit, links, outputs_at, signals, buffer)
    status = 0
    if unit.count == 0:
        own = slow[unit.slow]
        for k in range(unit.links):
            links[own.first_link + k].known = links[unit.first_link + k].known
        status = _update(own, links, outputs_at, signals, buffer)
    _show(unit, slow, links, pasts, signals)
    return status


@kernel
def run_steps(units, slow, links, pasts, following, outputs_at, inverse, bonded, watched, signals, buffer, sequential, times, h,
              limit, halt, looks, rows, given, inputs, outputs):
    """Macro steps of length h from each of `times` (n,), for U `UNIT`s, of those with rates of their own two more in `slow`,
    which is None without: then there is no code for them.

    links: of the units first, L of them, then of the slow ones; following: (P,) units whose outputs follow their inputs within an
    instant; outputs_at: (S,) addresses of components' outputs; inverse: (S,) 1 / nominal of every signal; bonded: (B,) links
    whose polynomials are noted for the energy account; watched: (W,) addresses of outputs of components that observers want of
    every step; signals: the table, S outputs, and behind them what slow units give to others and get; buffer: three numbers for
    each of the links, what is handed to FMUs, None without FMUs, and no code for them. The signals behind each step go to rows
    (n, S), what bonded inputs were given to given (n, B, 4), `watched` to outputs (n, W); behind the steps `looks` (m,), all
    inputs and where they were led to go to inputs (m, 2, L).

    A number other than 0 in halt (1,) ends the march behind the present step. Returns (steps done, unit, status): a status above
    1 is that of the unit whose call failed; unit -2 says that the sum of the signals, each relative to its nominal value, has
    left `limit`.
    """
    look = 0
    for step in range(times.size):
        for k in range(units.size):
            unit = units[k]
            status = _drive(unit, slow, links, pasts, signals, buffer, h) if unit.links > 0 else 0
            if slow is not None and status <= WARNING and unit.way == NOTED:
                status = _step_slow(unit, slow, links, pasts, signals, buffer, times[step], h)
            elif status <= WARNING:
                status = _step(unit, times[step], h)
            if status <= WARNING and sequential:
                status = _read_all(unit, slow, links, pasts, outputs_at, signals)
            if status > WARNING:
                return step, k, status
        if not sequential:
            for k in range(units.size):
                status = _read_all(units[k], slow, links, pasts, outputs_at, signals)
                if status > WARNING:
                    return step, k, status
        updated = False
        for k in following:
            unit = units[k]
            if (updated or unit.interpolates == 0) and not _stands(unit, links, signals):
                status = _update_all(unit, slow, links, pasts, outputs_at, signals, buffer)
                if status > WARNING:
                    return step, k, status
                updated = True
        for k in range(units.size):
            _push(units[k], slow, links, pasts, signals, h)
        if look < looks.size and looks[look] == step:
            for i in range(inputs.shape[2]):
                inputs[look, 0, i], inputs[look, 1, i] = links[i].now, links[i].reached
            look += 1
        for k in range(bonded.size):
            link = links[bonded[k]]
            given[step, k, 0], given[step, k, 1] = link.value, link.slope
            given[step, k, 2], given[step, k, 3] = link.half, link.degree
        for k in range(watched.size):
            outputs[step, k] = load(watched[k])
        total = 0.0
        for k in range(inverse.size):
            rows[step, k] = signals[k]
            total += signals[k] * inverse[k]
        if not abs(total) < limit:
            return step + 1, -2, 0
        if halt[0] != 0:
            return step + 1, -1, 0
    return times.size, -1, 0
