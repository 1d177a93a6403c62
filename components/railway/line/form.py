"""Form finding: heights of all wires at rest, dropper lengths and preloads, reactions of the supports.

Strings between nodes carry their weight in parabolas, whose nodes a network of straight strings with half of the weight at either
end gives exactly: so the network has nodes at supports, droppers and clamps alone, and no mesh error. Wires are taken as strings:
bending stiffness changes heights within centimetres of a clamp only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...core.contract import filled as in_words
from ...core.errors import BadInput
from ...core.kernels import DONE, kernel, kernel_tuple
from ...core.linear import factor_band, factor_general, solve_band, solve_general
from .from_table import lay_out
from .layout import GRAVITY, Layout
from .plan import (
    ADDED,
    CLAMPED_TO,
    CUT_AT_REST,
    CUT_LENGTH,
    FACTOR,
    FIRST,
    FROM,
    GIVEN_CUT,
    GIVEN_LENGTH,
    GIVEN_PRELOAD,
    HEIGHT,
    HEIGHT_FROM,
    HEIGHT_TO,
    HOLD_HEIGHT,
    LANE,
    LAST,
    LENGTH,
    LIFT,
    LOWER,
    MASS_ABOVE,
    MASS_BELOW,
    OTHER_CUT,
    OTHER_LENGTH,
    OTHER_PRELOAD,
    PLACE,
    PRELOAD,
    REACTION,
    REFUSALS,
    SHORT_DROPPER,
    SPRING_LANE,
    SPRING_PLACE,
    STIFFNESS,
    TO,
    UPPER,
    WANTED,
    WIRE,
    Given,
    Plan,
    empty_numbers,
    fill_droppers,
    fill_layout,
    filled_layout,
    plan_of,
)
from .table import Line

RIGID_CLAMP = 1e10  # N/m
AGREED_LENGTH, AGREED_FORCE = 1e-4, 0.1  # m, N: what a table says of a dropper besides, in the digits of a drawing
PASSES = 4  # masses depend on the lengths, which depend on them: an error of 1 mm leaves 1e-8 m after two


@kernel_tuple
class Network(NamedTuple):
    """Workspace of form finding, F = W f nodes, W at each of f places: node W i + lane."""

    stiffness: np.ndarray  # (F, W + 1) N/m, upper band
    factors: np.ndarray  # (F, W + 1)
    general: np.ndarray  # (F, 4 W - 1) where droppers have cut lengths
    nodal: np.ndarray  # (8, F)


# rows of `nodal`; of the element to the right of the node its tension, N, and its weight, N; weight on the node, N; other forces,
# N; height, m; 1 where an anchor or a spring of given height holds the node and where a clamp does so besides; unknowns
PULL, OWN_WEIGHT, WEIGHT, LOADS, Z, FIXED, PLACED, UNKNOWN = range(8)


def empty_network(plan: Plan, cut_lengths: bool) -> Network:
    """Room for the network of a plan."""
    W = plan.lanes.size
    F = W * plan.place.size
    return Network(np.zeros((F, W + 1)), np.zeros((F, W + 1)), np.zeros((F if cut_lengths else 0, 4 * W - 1)), np.zeros((8, F)))


@kernel
def load_network(plan, filled, net):
    """Weights and tensions of the network, and which of its nodes are held."""
    W, x, nodal = plan.lanes.size, plan.place, net.nodal
    nodal[:] = 0.0
    nodal[Z] = math.nan
    nodal[FIXED] = 1.0
    for k in range(plan.wires.shape[0]):
        lane, a, b = plan.wires[k, LANE], plan.wires[k, FROM], plan.wires[k, TO]
        for i in range(a, b):
            nodal[PULL, W * i + lane] = filled.tension[k]
            nodal[OWN_WEIGHT, W * i + lane] = GRAVITY * filled.mass[k] * (x[i + 1] - x[i])
            if i > a:
                nodal[FIXED, W * i + lane] = 0.0
        if plan.wires[k, CLAMPED_TO] < 0:
            nodal[Z, W * a + lane], nodal[Z, W * b + lane] = plan.wire_numbers[k, HEIGHT_FROM], plan.wire_numbers[k, HEIGHT_TO]
        else:
            nodal[FIXED, W * a + lane], nodal[FIXED, W * b + lane] = 0.0, 0.0
    for k in range(plan.stretches.shape[0]):
        lane = plan.wires[plan.stretches[k, WIRE], LANE]
        for i in range(plan.stretches[k, FIRST], plan.stretches[k, LAST]):
            nodal[PULL, W * i + lane] += plan.stretch_numbers[k, ADDED]
            nodal[OWN_WEIGHT, W * i + lane] *= plan.stretch_numbers[k, FACTOR]
    for j in range(nodal.shape[1]):
        nodal[WEIGHT, j] += 0.5 * nodal[OWN_WEIGHT, j]
        if j >= W:
            nodal[WEIGHT, j] += 0.5 * nodal[OWN_WEIGHT, j - W]
    for end, mass in ((LOWER, MASS_BELOW), (UPPER, MASS_ABOVE)):
        for k in range(plan.droppers.shape[0]):
            nodal[WEIGHT, W * plan.droppers[k, PLACE] + plan.droppers[k, end]] += GRAVITY * filled.dropper[mass, k]
    for j in range(nodal.shape[1]):
        nodal[PLACED, j] = nodal[FIXED, j]
    for k in range(plan.droppers.shape[0]):
        nodal[PLACED, W * plan.droppers[k, PLACE] + plan.droppers[k, LOWER]] = 1.0
    for k in range(plan.holds.shape[0]):
        j = W * plan.holds[k, SPRING_PLACE] + plan.holds[k, SPRING_LANE]
        nodal[WEIGHT, j] -= filled.hold[LIFT, k]
        if not math.isnan(filled.hold[HOLD_HEIGHT, k]):
            nodal[PLACED, j], nodal[Z, j] = 1.0, filled.hold[HOLD_HEIGHT, k]
    net.stiffness[:] = 0.0
    for j in range(nodal.shape[1] - W):
        k_right = nodal[PULL, j] * (1.0 / (x[j // W + 1] - x[j // W]))
        net.stiffness[j, 0] += k_right
        net.stiffness[j + W, 0] += k_right
        net.stiffness[j, W] -= k_right
    for j in range(nodal.shape[1]):
        nodal[LOADS, j] = -nodal[WEIGHT, j]


@kernel
def held_by(j, net):
    """Force of the wires on node j for the present heights, N, downwards; where there is no height it is 0."""
    W, z, value = net.stiffness.shape[1] - 1, net.nodal[Z], 0.0
    if not math.isnan(z[j]):
        value = net.stiffness[j, 0] * z[j]
    if j + W < z.size and not math.isnan(z[j + W]):
        value += net.stiffness[j, W] * z[j + W]
    if j >= W and not math.isnan(z[j - W]):
        value += net.stiffness[j - W, W] * z[j - W]
    return value


@kernel
def tie(plan, band):
    """Add to an upper band what clamps the ends of wires to other wires."""
    W = plan.lanes.size
    for k in range(plan.wires.shape[0]):
        lane, other = plan.wires[k, LANE], plan.wires[k, CLAMPED_TO]
        for end in (FROM, TO):
            if other >= 0:
                i = W * plan.wires[k, end]
                band[i + lane, 0] += RIGID_CLAMP
                band[i + other, 0] += RIGID_CLAMP
                band[i + min(lane, other), abs(lane - other)] -= RIGID_CLAMP


@kernel
def hang_wires(contact, plan, net):
    """Heights of the contact wires, contact = 1, an auxiliary wire, -1, or the others, 0, between the nodes where they are placed."""
    W, nodal, band = plan.lanes.size, net.nodal, net.factors
    F, z, b, bound = nodal.shape[1], nodal[Z], nodal[UNKNOWN], nodal[OWN_WEIGHT]  # whose weights are those of nodes by now
    for j in range(F):
        mine = plan.lanes[j % W] == contact and nodal[PLACED, j] == 0.0
        bound[j] = 0.0 if mine else 1.0
        if mine:
            z[j] = math.nan
    for j in range(F):
        b[j] = nodal[LOADS, j] - held_by(j, net) if bound[j] == 0.0 else 0.0
        for k in range(W + 1):
            band[j, k] = net.stiffness[j, k]
    if contact == 0:
        tie(plan, band)
    for j in range(F):
        for k in range(W + 1):
            if bound[j] > 0.0 or (k > 0 and j + k < F and bound[j + k] > 0.0):
                band[j, k] = 1.0 if k == 0 else 0.0
    factor_band(band, 0, 0, F)
    solve_band(band, b, 0, F)
    for j in range(F):
        if bound[j] == 0.0:
            z[j] = b[j]


@kernel
def place_by_cut_lengths(plan, filled, net):
    """Heights of the contact wires' clamps where droppers have a cut length and no height.

    Such a dropper pulls with N = k (L - L0), so that all wires are solved together, node by node. One with a height is cut so
    that its clamp is there: what the contact wire lacks at that place is a load of the wire above.
    """
    W, nodal, band, free = plan.lanes.size, net.nodal, net.general, net.nodal[OWN_WEIGHT]
    F, m, b = nodal.shape[1], 2 * W - 1, nodal[UNKNOWN]  # m: column of the diagonal
    band[:] = 0.0
    for j in range(F):
        b[j] = nodal[LOADS, j]
        free[j] = 1.0 - nodal[PLACED, j]
        band[j, m] = net.stiffness[j, 0]
        if j + W < F:
            band[j, m + W] = net.stiffness[j, W]
        if j >= W:
            band[j, m - W] = net.stiffness[j - W, W]
    for k in range(plan.droppers.shape[0]):
        own = filled.dropper[:, k]
        i = W * plan.droppers[k, PLACE]
        low, up = i + plan.droppers[k, LOWER], i + plan.droppers[k, UPPER]
        if math.isnan(own[HEIGHT]):
            for one, other in ((low, up), (up, low)):
                band[one, m] += own[STIFFNESS]
                band[one, m + other - one] -= own[STIFFNESS]
            b[low] -= own[STIFFNESS] * own[CUT_LENGTH]
            b[up] += own[STIFFNESS] * own[CUT_LENGTH]
            free[low] = 1.0
        else:
            for c in range(max(i - W, 0), min(i + 2 * W, F)):
                band[up, m + c - up] += band[low, m + c - low] if abs(c - low) <= m else 0.0
            b[up] += b[low]  # with what an auxiliary wire carries there: its droppers come behind those
            nodal[Z, low] = own[HEIGHT]
    for k in range(plan.wires.shape[0]):
        lane, clamp = plan.wires[k, LANE], plan.wires[k, CLAMPED_TO]
        for end in (FROM, TO):
            i = W * plan.wires[k, end]
            if clamp >= 0:
                for one, other in ((i + lane, i + clamp), (i + clamp, i + lane)):
                    band[one, m] += RIGID_CLAMP
                    band[one, m + other - one] -= RIGID_CLAMP
    for j in range(F):
        if free[j] == 0.0:
            band[j] = 0.0
            band[j, m] = 1.0
            b[j] = 0.0 if math.isnan(nodal[Z, j]) else nodal[Z, j]
    factor_general(band)
    solve_general(band, b)
    for k in range(plan.droppers.shape[0]):
        if math.isnan(filled.dropper[HEIGHT, k]):
            filled.dropper[HEIGHT, k] = b[W * plan.droppers[k, PLACE] + plan.droppers[k, LOWER]]


@kernel
def hang_on_droppers(contact, plan, filled, net):
    """`hang_wires` of contact wires or an auxiliary wire, and what their droppers then carry and load the wires above with."""
    W, nodal = plan.lanes.size, net.nodal
    hang_wires(contact, plan, net)
    for k in range(plan.droppers.shape[0]):
        low = W * plan.droppers[k, PLACE] + plan.droppers[k, LOWER]
        if plan.lanes[low % W] == contact:
            filled.dropper[PRELOAD, k] = held_by(low, net) - nodal[LOADS, low]
    for k in range(plan.droppers.shape[0]):
        if plan.lanes[plan.droppers[k, LOWER]] == contact:
            nodal[LOADS, W * plan.droppers[k, PLACE] + plan.droppers[k, UPPER]] -= filled.dropper[PRELOAD, k]


@kernel
def hang(plan, filled, net):
    """Form of a filled layout: the contact wires hang as their clamps are placed, the others as these load them.

    Droppers whose height is NaN are cut to the present lengths. Heights, lengths, preloads and reactions become what follows.
    """
    W, nodal, by_length = plan.lanes.size, net.nodal, False
    load_network(plan, filled, net)
    for k in range(plan.droppers.shape[0]):
        by_length = by_length or math.isnan(filled.dropper[HEIGHT, k])
    if by_length:
        place_by_cut_lengths(plan, filled, net)
    for k in range(plan.droppers.shape[0]):
        nodal[Z, W * plan.droppers[k, PLACE] + plan.droppers[k, LOWER]] = filled.dropper[HEIGHT, k]
    hang_on_droppers(1, plan, filled, net)
    compound = False
    for lane in range(W):
        compound = compound or plan.lanes[lane] < 0
    if compound:
        hang_on_droppers(-1, plan, filled, net)
    hang_wires(0, plan, net)
    upward = nodal[UNKNOWN]
    for j in range(upward.size):
        upward[j] = held_by(j, net) - nodal[LOADS, j]
    for k in range(plan.wires.shape[0]):  # what a stitch pulls on its clamps is the messenger's load
        lane, clamp = plan.wires[k, LANE], plan.wires[k, CLAMPED_TO]
        for end in (FROM, TO):
            if clamp >= 0:
                upward[W * plan.wires[k, end] + clamp] += upward[W * plan.wires[k, end] + lane]
    for k in range(plan.holds.shape[0]):
        filled.hold[REACTION, k] = upward[W * plan.holds[k, SPRING_PLACE] + plan.holds[k, SPRING_LANE]]
    for k in range(plan.droppers.shape[0]):
        own, i = filled.dropper[:, k], W * plan.droppers[k, PLACE]
        own[LENGTH] = nodal[Z, i + plan.droppers[k, UPPER]] - nodal[Z, i + plan.droppers[k, LOWER]]
        own[CUT_LENGTH] = own[LENGTH] - own[PRELOAD] / own[STIFFNESS]


@kernel
def hang_as_planned(plan, filled, net):
    """`hang` with the cut lengths of the plan, and a status: whether all droppers have a length."""
    worst = -1
    for k in range(plan.droppers.shape[0]):
        filled.dropper[CUT_LENGTH, k] = plan.dropper_numbers[GIVEN_CUT, k]
    hang(plan, filled, net)
    for k in range(plan.droppers.shape[0]):
        length = filled.dropper[LENGTH, k]
        if length <= 0.0 and (worst < 0 or length < filled.dropper[LENGTH, worst]):
            worst = k
    if worst < 0:
        return DONE
    filled.refused[0], filled.refused[1] = plan.place[plan.droppers[worst, PLACE]], filled.dropper[LENGTH, worst]
    return SHORT_DROPPER


@kernel
def find_form_at_rest(plan, given, filled, net):
    """Form of a planned line with masses and stiffnesses that follow from the lengths of its droppers; a status."""
    filled.dropper[LENGTH] = 1.0
    status = fill_layout(plan, given, filled)
    if status == DONE:
        status = hang_as_planned(plan, filled, net)
    for _ in range(PASSES - 1):
        if status != DONE or fill_droppers(plan.dropper_numbers, given, filled.dropper) == 0:
            break
        for k in range(plan.droppers.shape[0]):
            if math.isnan(plan.dropper_numbers[WANTED, k]):
                filled.dropper[HEIGHT, k] = math.nan
        status = hang_as_planned(plan, filled, net)
    if status != DONE:
        return status
    for k in range(plan.droppers.shape[0]):
        filled.dropper[CUT_AT_REST, k] = filled.dropper[CUT_LENGTH, k]
    for given_row, formed, agreed, status in (
        (GIVEN_LENGTH, LENGTH, AGREED_LENGTH, OTHER_LENGTH),
        (GIVEN_CUT, CUT_LENGTH, AGREED_LENGTH, OTHER_CUT),
        (GIVEN_PRELOAD, PRELOAD, AGREED_FORCE, OTHER_PRELOAD),
    ):
        worst, most = -1, agreed
        for k in range(plan.droppers.shape[0]):
            off = abs(plan.dropper_numbers[given_row, k] - filled.dropper[formed, k])
            if off > most:  # not where nothing is given
                worst, most = k, off
        if worst >= 0:
            filled.refused[0] = plan.place[plan.droppers[worst, PLACE]]
            filled.refused[1], filled.refused[2] = plan.dropper_numbers[given_row, worst], filled.dropper[formed, worst]
            return status
    return DONE


# -- for Python --------------------------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Form:
    """A line at rest. droppers: (d,) each; supports: (k,) rows of messenger supports; heights: (n, lanes) at `position`, NaN."""

    layout: Layout
    position: np.ndarray  # (n,) m
    height: np.ndarray  # (n, lanes) m above the level of the model, NaN where there is no wire
    length: np.ndarray  # (d,) m, under load
    cut_length: np.ndarray  # (d,) m, without load
    preload: np.ndarray  # (d,) N, at the lower end
    support: np.ndarray  # (k,) m
    reaction: np.ndarray  # (k,) N, upwards on the messenger
    rest_height: np.ndarray  # (k,) m, of the unloaded support spring
    contact_force: np.ndarray  # (c,) N, upwards on a contact wire that is held at a support; its rows are those of `held`
    held: np.ndarray  # (c, 2) position m, lane


class Found:
    """A layout with room for its form; kernels fill it."""

    def __init__(self, layout: Layout, given: Given, fixed: Any = ()) -> None:
        self.layout, self.given, self.plan = layout, given, plan_of(layout, fixed)
        self.filled = empty_numbers(len(layout.wires), layout.droppers.position.size, layout.holds.position.size)
        self.net = empty_network(self.plan, cut_lengths=True)

    def check(self, status: int) -> None:
        """`BadInput` for a status that is a refusal."""
        if status != DONE:
            refused = self.filled.refused
            raise BadInput("line", *(in_words(text, lambda name: f"{refused[int(name[-2])]:.6g}") for text in REFUSALS[status]))

    def form(self) -> Form:
        """The form that is there."""
        layout, plan = filled_layout(self.layout, self.given, self.filled), self.plan
        own, h = self.filled.dropper, layout.holds
        messenger = ~np.isin(h.lane, layout.contact_lanes)
        reaction, held = self.filled.hold[REACTION], ~messenger & ~np.isnan(h.height)
        stiffness = h.stiffness[messenger]
        with np.errstate(divide="ignore"):
            spring = np.where(stiffness > 0.0, reaction[messenger] / stiffness, np.inf)
        return Form(
            layout,
            plan.place.copy(),
            self.net.nodal[Z].reshape(plan.place.size, -1).copy(),
            own[LENGTH].copy(),
            own[CUT_LENGTH].copy(),
            own[PRELOAD].copy(),
            h.position[messenger],
            reaction[messenger],
            h.height[messenger] + spring,
            reaction[held],
            np.column_stack((h.position[held], h.lane[held])),
        )


def given_of(p: Any, **more: float) -> Given:
    """What parameters of `Catenary` give; more: what parameters of its effects do."""
    return Given(*(getattr(p, name, more.get(name, 0.0)) for name in Given._fields))


def find_form(line: Line, p: Any) -> Form:
    """Form of a line; p: parameters of `Catenary`."""
    formed = Found(lay_out(line, False), given_of(p))
    formed.check(find_form_at_rest(formed.plan, formed.given, formed.filled, formed.net))
    return formed.form()


def form_of(layout: Layout, given: Given | None = None) -> Form:
    """Form of a layout, whose droppers hang as they are placed or, where a height is NaN, as they are cut.

    given: for the numbers that it does not say.
    """
    formed = Found(layout, given or Given(*[math.nan] * len(Given._fields)))
    formed.check(fill_layout(formed.plan, formed.given, formed.filled))
    formed.filled.dropper[CUT_LENGTH] = layout.droppers.cut_length
    hang(formed.plan, formed.filled, formed.net)
    return formed.form()
