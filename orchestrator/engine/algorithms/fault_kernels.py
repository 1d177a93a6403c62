"""What faults do to a master's records at the instant at which some begin or end, as kernels.

`begin_change` alters inputs and loses units. Then the outputs follow within the instant, and `end_change` lets inputs that have jumped
begin their samples anew. Who calls them writes into the field `change` of each fault what becomes of it.
"""

from __future__ import annotations

from ....components.core.kernels import kernel
from ...units.call_names import NOTED
from .kernels import _given
from .records import BEGINS, DROPPED, ENDS, FROZEN, INTERPOLATED, LOST, OFFSET, OVERRIDDEN, SHIFTED, UNALTERED, UNKNOWN


@kernel
def _nodes(units):
    """How many units take part in the macro steps themselves; behind them are records of those with a rate of their own."""
    n = units.size
    for k in range(units.size):
        if units[k].input_mode == NOTED:
            n = min(n, units[k].slow)
    return n


@kernel
def begin_change(t, h, m):
    """Faults end and begin; inputs are altered by all that act, in the order of the scene."""
    units, links, signals = m.units, m.links, m.signals
    for k in range(_nodes(units)):
        unit = units[k]
        if unit.ends == INTERPOLATED:
            unit.ends = UNKNOWN
        for i in range(unit.first_link, unit.first_link + unit.links):
            links[i].seen = _given(links[i], signals)
    for k in range(m.faults.size):
        if m.faults[k].change == ENDS:
            m.faults[k].active = 0
    for k in range(m.faults.size):
        fault = m.faults[k]
        if fault.change != BEGINS:
            continue
        fault.active = 1
        if fault.kind == LOST:
            _lose(units[fault.unit], units, links, m.pasts, signals)
        for i in range(fault.first, fault.last):
            end = m.fault_ends[i]
            held = _given(links[end.link], signals) if fault.kind == FROZEN else end.start
            end.held = held if fault.kind in (FROZEN, DROPPED) else fault.value
    for k in range(_nodes(units)):
        for i in range(units[k].first_link, units[k].first_link + units[k].links):
            links[i].fault = UNALTERED
    for k in range(m.faults.size):
        fault = m.faults[k]
        if fault.active == 0:
            continue
        for i in range(fault.first, fault.last):
            end = m.fault_ends[i]
            link = links[end.link]
            if fault.kind != OFFSET:
                link.fault, link.alteration = OVERRIDDEN, end.held
            elif link.fault == UNALTERED:
                link.fault, link.alteration = SHIFTED, end.held
            else:
                link.alteration += end.held
    return 0


@kernel
def _lose(unit, units, links, pasts, signals):
    """A unit takes no more steps and no inputs, and its outputs stay as they are, those that others go by, too."""
    unit.lost = 1
    if unit.input_mode == NOTED:
        shown = units[unit.slow + 1]
        for k in range(shown.links):
            link = links[shown.first_link + k]
            signals[shown.first_signal + k] = signals[link.source]
            link.present = signals[link.source]
        for k in range(shown.first_past, shown.first_past + shown.pasts):
            pasts[k].samples = 1


@kernel
def _changed(k, m, link):
    """Whether a fault that has begun or ended alters a link, the k-th one, or has lost its source."""
    units = m.units
    for j in range(m.faults.size):
        fault = m.faults[j]
        if fault.change == 0:
            continue
        for i in range(fault.first, fault.last):
            if m.fault_ends[i].link == k:
                return True
        if fault.kind == LOST:
            unit = units[fault.unit]
            if unit.first_signal <= link.source < unit.first_signal + unit.signals:
                return True
            if unit.input_mode == NOTED:
                shown = units[unit.slow + 1]
                if shown.first_signal <= link.source < shown.first_signal + shown.links:
                    return True
    return False


@kernel
def end_change(t, h, m):
    """Of units whose inputs have jumped, the past of these tells nothing any more: the present values are the only sample."""
    units, links, pasts, signals = m.units, m.links, m.pasts, m.signals
    for k in range(_nodes(units)):
        unit, jumped = units[k], False
        for i in range(unit.first_link, unit.first_link + unit.links):
            jumped = jumped or _given(links[i], signals) != links[i].seen or _changed(i, m, links[i])
        if not jumped:
            continue
        for i in range(unit.first_link, unit.first_link + unit.links):
            links[i].now = links[i].present = _given(links[i], signals)
        for i in range(unit.first_past, unit.first_past + unit.pasts):
            pasts[i].samples, pasts[i].elapsed = 1, 0.0
        if unit.input_mode == NOTED:
            own = units[unit.slow]
            for i in range(own.first_past, own.first_past + own.pasts):
                pasts[i].samples = 0
        unit.ends = UNKNOWN
    for k in range(m.faults.size):
        m.faults[k].change = 0
    return 0
