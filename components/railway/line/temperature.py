"""A line at another temperature than that of its table: wires that are anchored at both ends change their tension.

The length of such a wire follows from tension, temperature and shape,

    T / EA - S(T) / L = const - alpha dtheta,    S = integral of z'^2 / 2 dx,

which for a parabola is the usual equation of state, T - EA w^2 L^2 / (24 T^2) = const - EA alpha dtheta, and over unequal spans
that of the ideal span. The shape is that of all wires together on droppers of unchanged length: a contact wire that keeps its
tension carries the more of the weight the lower the messenger hangs. Wires with automatic tensioning keep their tension; where
all wires do, nothing changes.

Neglected: longitudinal motion along the track (tilted droppers, swung arms), expansion of droppers and stitch wires, friction of
tensioning devices, displacement of the messenger's supports.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...core.errors import BadInput
from .form import Form, find_form, form_of
from .from_table import lay_out
from .layout import GRAVITY, SECOND, Layout, Wire
from .table import Line, WireData, over

CONVERGED = 1e-10  # of the tension
PASSES = 200
EXPANSION = 1.7e-5  # 1/K, copper and its alloys, as read in a public source


@dataclass
class _Fixed:
    """A wire that is anchored at both ends. key: its table in the section; held: what stays constant, m/m."""

    section: int
    key: str
    lane: int
    start: float
    data: WireData
    tension: float
    held: float = 0.0


def line_at(line: Line, p: Any, change: float) -> tuple[Line, Form]:
    """(line with the tensions, its form) at a temperature `change`, K, above that of the table; p: parameters of `Catenary`."""
    rest = find_form(line, p)
    fixed = list(_fixed_wires(line, rest))
    if not fixed:
        raise BadInput("temperature.change", f"{change:g} K for a line whose wires all have automatic tensioning",
                       "a wire that is anchored at both ends", "Say fixed = true and axial_stiffness = EA of it; the others keep "
                       "their tension, and nothing changes.")
    for wire in fixed:
        expansion = EXPANSION if wire.data.expansion is None else wire.data.expansion
        wire.held = wire.tension / wire.data.axial_stiffness - _excess(rest, wire) - expansion * change
    form = rest
    for _ in range(PASSES):
        moved = 0.0
        for wire in fixed:
            tension = _tension(wire, _excess(form, wire))
            moved = max(moved, abs(tension / wire.tension - 1.0))
            wire.tension = tension
            section = line.sections[wire.section]
            own = replace(getattr(section, wire.key), tension=tension)
            sections = list(line.sections)
            sections[wire.section] = replace(section, **{wire.key: own})
            line = replace(line, sections=tuple(sections))
        layout = lay_out(line, p, None, rest.length)
        nowhere = np.full(rest.length.size, np.nan)
        form = form_of(replace(layout, droppers=replace(layout.droppers, height=nowhere, cut_length=rest.cut_length)))
        if moved < CONVERGED:
            return line, form
    raise BadInput("temperature.change", f"{change:g} K", "a change at which tensions converge",
                   "Check axial_stiffness, and the sag.")


def formed_layout(line: Line, p: Any, bending: Any, temperature: Any = None) -> Layout:
    """Layout of a line with what follows from the lengths of its droppers: masses, stiffnesses, heights of given cut lengths.

    p: parameters of `Catenary`; bending, temperature: its effects or None.
    """
    form = find_form(line, p)
    lengths = form.length
    if temperature is not None:
        line, form = line_at(line, p, temperature.change)
    layout = lay_out(line, p, bending, lengths)
    return replace(layout, droppers=replace(layout.droppers, height=form.layout.droppers.height))


def _fixed_wires(line: Line, form: Form) -> Iterator[_Fixed]:
    lanes = {"contact_wire": 0, "messenger": 1, "second_contact_wire": SECOND}
    for i, section in enumerate(line.sections):
        for key, lane in lanes.items():
            data = getattr(section, key)
            if key == "second_contact_wire" and data.tension is not None:
                data = over(data, section.contact_wire)
            if not data.fixed:
                continue
            if data.axial_stiffness is None:
                raise BadInput(f"line.sections[{i + 1}].{key}", "a wire that is anchored at both ends without axial_stiffness",
                               "its EA, N")
            at = [w for w in form.layout.wires if w.lane == lane + SECOND * (i % 2) and w.clamped_to is None]
            yield _Fixed(i, key, at[0].lane, at[i // 2].start, data, at[i // 2].tension)


def _wire_of(form: Form, wire: _Fixed) -> Wire:
    return next(w for w in form.layout.wires if w.lane == wire.lane and w.start == wire.start)


def _excess(form: Form, fixed: _Fixed) -> float:
    """Length of a wire over that of its chord, S / L, m/m: slopes between nodes, and parabolas about them."""
    wire = _wire_of(form, fixed)
    inside = (form.position > wire.start - 1e-6) & (form.position < wire.end + 1e-6)
    x, z = form.position[inside], form.height[inside, wire.lane]
    middle, length = 0.5 * (x[1:] + x[:-1]), np.diff(x)
    tension, weight = np.full(length.size, wire.tension), np.full(length.size, GRAVITY * wire.mass)
    for part in wire.tension_changes:
        tension[(middle > part.start) & (middle < part.end)] += part.value
    for part in wire.masses:
        weight[(middle > part.start) & (middle < part.end)] *= part.value
    excess = 0.5 * np.diff(z) ** 2 / length + weight**2 * length**3 / (24.0 * tension**2)
    return float(excess.sum() / (wire.end - wire.start))


def _tension(wire: _Fixed, excess: float) -> float:
    """Root of T / EA - S / L = held, N, with the S of the present shape as that of a parabola, S ~ 1 / T^2."""
    EA, a = wire.data.axial_stiffness, excess * wire.tension**2
    low, high = 0.0, wire.tension + 2.0 * EA * (abs(wire.held) + excess)
    for _ in range(100):  # the left side grows with T
        middle = 0.5 * (low + high)
        low, high = (low, middle) if middle / EA - a / middle**2 > wire.held else (middle, high)
    return high
