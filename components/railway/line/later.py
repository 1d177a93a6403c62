"""A line other than its table says: as built, at another temperature, with a worn contact wire. Droppers keep their cut lengths.

As built, cut lengths, heights of supports and tensions have random deviations; a dropper may then be slack at rest.

A worn wire is lighter: all wires hang anew. The length of a wire that is anchored at both ends follows from tension, temperature
and shape,

    T / EA - S(T) / L = const - alpha dtheta,    S = integral of z'^2 / 2 dx,

which for a parabola is the usual equation of state, T - EA w^2 L^2 / (24 T^2) = const - EA alpha dtheta, and over unequal spans
that of the ideal span. The shape is that of all wires together on droppers of unchanged length: a contact wire that keeps its
tension carries the more of the weight the lower the messenger hangs. Wires with automatic tensioning keep their tension; where
all wires do, a temperature changes nothing. EA of a worn contact wire falls with its section.

Neglected: longitudinal motion along the track (tilted droppers, swung arms), expansion of droppers and stitch wires, friction of
tensioning devices, displacement of the messenger's supports.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...core.errors import BadInput
from ...core.kernels import DONE, kernel, kernel_tuple
from .form import Form, Found, Z, find_form_at_rest, given_of, hang
from .from_table import lay_out
from .layout import GRAVITY, Layout
from .plan import (
    ADDED,
    CLAMPED_TO,
    CONTACT,
    CUT_AT_REST,
    CUT_LENGTH,
    FACTOR,
    FIRST,
    FROM,
    HEIGHT,
    HOLD_HEIGHT,
    LANE,
    LAST,
    PLACE,
    SHORT_DROPPER,
    SPRING_LANE,
    TO,
    UNSETTLED,
    WIRE,
    Plan,
    fill_droppers,
    fill_holds,
)
from .table import Line, over

CONVERGED = 1e-10  # of the tension
PASSES = 200
EXPANSION = 1.7e-5  # 1/K, copper and its alloys, as read in a public source
ALWAYS = ("contact_wire", "messenger")  # wires of each section;
WIRES = (*ALWAYS, "second_contact_wire", "auxiliary")  # the others are there with their tension


@kernel_tuple
class Later(NamedTuple):
    """What has become of a line since it was as its table says."""

    change: float  # of the temperature, K
    worn: float  # share of the contact wires' present section that is gone
    dropper_length: float  # standard deviations as built: of cut lengths, m,
    support_height: float  # of the messenger at supports, m,
    tension: float  # and of tensions, as a share


def deviations(plan: Plan, seed: int) -> np.ndarray:
    """Standard normal numbers of a line as built: of its droppers, springs to the ground, wires; (d + h + w,)."""
    return np.random.default_rng(seed).standard_normal(plan.droppers.shape[0] + plan.holds.shape[0] + plan.wires.shape[0])


AS_PLANNED = np.zeros(0)  # in the place of `deviations`


def fixed_wires(line: Line, layout: Layout, asked: bool) -> Iterator[tuple[int, float, float]]:
    """Number of each wire that is anchored at both ends, its axial stiffness, N, and its thermal expansion, 1/K.

    asked: whether a line without such wires is refused.
    """
    formed = False
    for row, section, key in _wires_of_sections(line, layout):
        data = getattr(line.sections[section], key)
        if key == "second_contact_wire":
            data = over(data, line.sections[section].contact_wire)
        if data.fixed:
            formed = True
            if data.axial_stiffness is None:
                raise BadInput(
                    f"line.sections[{section + 1}].{key}",
                    "a wire that is anchored at both ends without axial_stiffness",
                    "its EA, N",
                )
            yield row, data.axial_stiffness, EXPANSION if data.expansion is None else data.expansion
    if asked and not formed:
        raise BadInput(
            "temperature.change",
            "a line whose wires all have automatic tensioning",
            "a wire that is anchored at both ends",
            "Say fixed = true and axial_stiffness = EA of it; the others keep their tension, and nothing changes.",
        )


def _wires_of_sections(line: Line, layout: Layout) -> Iterator[tuple[int, int, str]]:
    """Number of each wire that is a table of a section, the section and the table's key."""
    anchored = iter(
        [row for row, w in enumerate(layout.wires) if w.clamped_to is None]
    )  # section by section, in the order of `WIRES`
    for i, section in enumerate(line.sections):
        for key in WIRES:
            if key in ALWAYS or getattr(section, key).tension is not None:
                yield next(anchored), i, key


def line_at(line: Line, p: Any, change: float = 0.0, worn: float = 0.0) -> tuple[Line, Form]:
    """(line with the tensions, its form) at a temperature `change`, K, above that of the table, with a share `worn` of the contact
    wires' section gone since; p: parameters of `Catenary`."""
    layout = lay_out(line, False)
    formed = Found(layout, given_of(p), tuple(fixed_wires(line, layout, change != 0.0)))
    later = Later(change, worn, 0.0, 0.0, 0.0)
    formed.check(find_form_later(later, AS_PLANNED, formed.plan, formed.given, formed.filled, formed.net))
    sections = list(line.sections)
    for row, section, key in _wires_of_sections(line, layout):
        if row in formed.plan.fixed:
            own = replace(getattr(sections[section], key), tension=float(formed.filled.tension[row]))
            sections[section] = replace(sections[section], **{key: own})
    return replace(line, sections=tuple(sections)), formed.form()


# -- kernels -----------------------------------------------------------------------------------------------------------
@kernel
def excess(wire, plan, filled, net):
    """Length of a wire over that of its chord, S / L, m/m: slopes between nodes, and parabolas about them."""
    W, x, z, total = plan.lanes.size, plan.place, net.nodal[Z], 0.0
    lane, a, b = plan.wires[wire, LANE], plan.wires[wire, FROM], plan.wires[wire, TO]
    for i in range(a, b):
        tension, weight, length = filled.tension[wire], GRAVITY * filled.mass[wire], x[i + 1] - x[i]
        for k in range(plan.stretches.shape[0]):
            if plan.stretches[k, WIRE] == wire and plan.stretches[k, FIRST] <= i < plan.stretches[k, LAST]:
                tension += plan.stretch_numbers[k, ADDED]
                weight *= plan.stretch_numbers[k, FACTOR]
        rise = z[W * (i + 1) + lane] - z[W * i + lane]
        total += 0.5 * rise**2 / length + weight**2 * length**3 / (24.0 * tension**2)
    return total / (x[b] - x[a])


@kernel
def tension_of(EA, held, excess, tension):
    """Root of T / EA - S / L = held, N, with the S of the present shape and tension as that of a parabola, S ~ 1 / T²."""
    a = excess * tension**2
    low, high = 0.0, tension + 2.0 * EA * (abs(held) + excess)
    for _ in range(100):  # the left side grows with T
        middle = 0.5 * (low + high)
        if middle / EA - a / middle**2 > held:
            high = middle
        else:
            low = middle
    # halving gives the number, but not its derivative: a step of Newton's method at the root gives both
    return high - (high / EA - a / high**2 - held) / (1.0 / EA + 2.0 * a / high**3)


@kernel
def later_by(e):
    """`Later` by the effects of a catenary."""
    change, worn = 0.0, 0.0
    if e.temperature is not None:
        change = e.temperature.change
    if e.wear is not None:
        worn = e.wear.share
    if e.scatter is not None:
        return Later(change, worn, e.scatter.dropper_length, e.scatter.support_height, e.scatter.tension)
    return Later(change, worn, 0.0, 0.0, 0.0)


@kernel
def hold_wires(later, random, plan, given, filled):
    """`fill_holds` with the heights of supports as built; a status."""
    status = fill_holds(plan, given, filled.tension, filled.hold, filled.refused)
    if random.size > 0:
        for k in range(plan.holds.shape[0]):
            if plan.lanes[plan.holds[k, SPRING_LANE]] == 0:
                filled.hold[HOLD_HEIGHT, k] += later.support_height * random[plan.droppers.shape[0] + k]
    return status


@kernel
def hang_as_cut(plan, filled, net):
    """Form with the cut lengths of `CUT_AT_REST` and the present tensions, masses and heights of supports."""
    for k in range(plan.droppers.shape[0]):
        filled.dropper[HEIGHT, k] = math.nan
        filled.dropper[CUT_LENGTH, k] = filled.dropper[CUT_AT_REST, k]
    hang(plan, filled, net)


@kernel
def build(later, random, plan, given, filled, net):
    """The line as built, from the one at rest; a status."""
    d, h = plan.droppers.shape[0], plan.holds.shape[0]
    for k in range(plan.wires.shape[0]):
        if plan.wires[k, CLAMPED_TO] < 0:
            filled.tension[k] *= max(1.0 + later.tension * random[d + h + k], 0.0)
    for k in range(d):
        filled.dropper[CUT_AT_REST, k] += later.dropper_length * random[k]
        if filled.dropper[CUT_AT_REST, k] <= 0.0:
            filled.refused[0], filled.refused[1] = plan.place[plan.droppers[k, PLACE]], filled.dropper[CUT_AT_REST, k]
            return SHORT_DROPPER
    status = hold_wires(later, random, plan, given, filled)
    if status == DONE:
        hang_as_cut(plan, filled, net)
    return status


@kernel
def find_form_later(later, random, plan, given, filled, net):
    """Form of a planned line other than its table says, by `Later`: tensions, heights, preloads; a status.

    random: `deviations`, or `AS_PLANNED`.
    """
    status = find_form_at_rest(plan, given, filled, net)
    if status == DONE and random.size > 0:
        status = build(later, random, plan, given, filled, net)
    if status != DONE:
        return status
    held = plan.fixed_numbers[:, 2]
    for k in range(plan.fixed.size):
        EA, expansion, wire = plan.fixed_numbers[k, 0], plan.fixed_numbers[k, 1], plan.fixed[k]
        held[k] = filled.tension[wire] / EA - excess(wire, plan, filled, net) - expansion * later.change
    for k in range(plan.wires.shape[0]):
        if plan.wires[k, CONTACT] >= 0:
            filled.mass[k] *= 1.0 - later.worn
    fill_droppers(plan.dropper_numbers, given, filled.dropper)  # for the lengths at rest, which they keep
    for number in range(PASSES):
        moved = 0.0
        for k in range(plan.fixed.size):
            EA, wire = plan.fixed_numbers[k, 0], plan.fixed[k]
            if plan.wires[wire, CONTACT] >= 0:
                EA *= 1.0 - later.worn
            now = tension_of(EA, held[k], excess(wire, plan, filled, net), filled.tension[wire])
            moved = max(moved, abs(now / filled.tension[wire] - 1.0))
            filled.tension[wire] = now
        status = hold_wires(later, random, plan, given, filled)
        if status != DONE:
            return status
        hang_as_cut(plan, filled, net)
        if moved < CONVERGED and (number > 0 or plan.fixed.size == 0):  # the first tensions are those of the shape before
            return DONE
    filled.refused[0] = later.change
    return UNSETTLED
