"""A layout as arrays for kernels, and the numbers that parameters put into it.

Structure alone decides which part hangs where: `Plan`. Tensions, masses, stiffnesses and heights are `Filled` from what the plan
says and, where it says nothing, from `Given`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...core import kernels
from ...core.contract import Refusal
from ...core.kernels import DONE, kernel, kernel_tuple
from .layout import GRAVITY, Layout

# columns of tables; of the wires, the droppers and the springs of a plan first
LANE, FROM, TO, CLAMPED_TO, CONTACT, WORN = range(6)  # places of the ends; contact wire 0 or 1, or -1; whether its mass differs
PLACE, LOWER, UPPER = range(3)
SPRING_PLACE, SPRING_LANE, PULLED_BY = range(3)
WIRE, FIRST, LAST = range(3)  # of a stretch; places
ADDED, FACTOR = range(2)  # to the tension, N; of the mass
TENSION, MASS, BENDING, HEIGHT_FROM, HEIGHT_TO = range(5)
DROPPER_NUMBERS = (
    "stiffness",
    "axial_stiffness",
    "mass",
    "mass_per_length",
    "contact_clamp",
    "messenger_clamp",
    "height",
    "sag",
    "within",
    "first",
    "last",
    "cut_length",
    "length",
    "preload",
)
EA, OWN, PER_LENGTH, CLAMP_BELOW, CLAMP_ABOVE, WANTED, SAG, WITHIN, SAG_FROM, SAG_TO = range(1, 11)
GIVEN_CUT, GIVEN_LENGTH, GIVEN_PRELOAD = range(11, 14)
HOLD_NUMBERS = ("stiffness", "damping", "mass", "lift", "height", "arm_length", "arm_angle", "arm_mass", "kink")
STIFFNESS, DAMPING, HOLD_MASS, LIFT, HOLD_HEIGHT, ARM_LENGTH, ARM_ANGLE, ARM_MASS, KINK = range(len(HOLD_NUMBERS))
REACTION = 5  # of `Filled.hold`, whose rows before are those of a plan
MASS_BELOW, MASS_ABOVE, OWN_MASS, HEIGHT, LENGTH, CUT_LENGTH, PRELOAD, CUT_AT_REST = range(1, 9)  # of `Filled.dropper`
STEEPEST = 80.0  # degrees below the horizontal that an arm may hang by its own weight

# statuses of `initialize`
NO_TENSION, STEEP_ARM, SHORT_DROPPER, OTHER_LENGTH, OTHER_CUT, OTHER_PRELOAD, UNSETTLED = range(kernels.OWN + 1, kernels.OWN + 8)
FOLLOWS = "{refused[2]}, which follows from the rest of the line"
LEAVE_OUT = "Leave it out; or leave out the height, so that the cut length rules."
REFUSALS = {
    NO_TENSION: Refusal(
        "a tension of {refused[0]} N in a wire from {refused[1]} to {refused[2]} m",
        "a positive one",
        "Reduce what the stitch wires take off the messenger.",
    ),
    STEEP_ARM: Refusal(
        "arm: a lateral force of {refused[0]} N under an arm of {refused[1]} kg",
        "a force that can carry the arm",
        "Give its angle, or a greater stagger.",
    ),
    SHORT_DROPPER: Refusal(
        "the dropper at {refused[0]} m with a length of {refused[1]} m",
        "an upper wire above the lower one",
        "Raise the system height, or the tension of the upper wire; or place an auxiliary wire between the others, with main droppers "
        "close enough.",
    ),
    OTHER_LENGTH: Refusal("a length of {refused[1]} of the dropper at {refused[0]} m", FOLLOWS, LEAVE_OUT),
    OTHER_CUT: Refusal("a cut length of {refused[1]} of the dropper at {refused[0]} m", FOLLOWS, LEAVE_OUT),
    OTHER_PRELOAD: Refusal("a preload of {refused[1]} of the dropper at {refused[0]} m", FOLLOWS, LEAVE_OUT),
    UNSETTLED: Refusal(
        "temperature.change: {refused[0]} K", "a change at which tensions converge", "Check axial_stiffness, and the sag."
    ),
}


@kernel_tuple
class Given(NamedTuple):
    """What takes the place of the numbers that a layout does not say: parameters of `Catenary` and of its effects."""

    contact_wire_tension: float  # N
    contact_wire_mass: float  # kg/m
    messenger_tension: float  # N
    messenger_mass: float  # kg/m
    dropper_stiffness: float  # N/m
    dropper_mass: float  # kg
    contact_clamp_mass: float  # kg
    messenger_clamp_mass: float  # kg
    support_stiffness: float  # N/m
    support_damping: float  # N.s/m
    contact_wire_bending: float  # N m²
    messenger_bending: float  # N m²
    arm_stiffness: float  # N/m
    arm_mass: float  # kg
    sag: float  # m


@kernel_tuple
class Plan(NamedTuple):
    """A layout; f places, w wires, k stretches of wires, d droppers, h springs to the ground, t wires anchored at both ends."""

    lanes: np.ndarray  # (W,) int, 1 for contact wires, -1 for an auxiliary wire
    place: np.ndarray  # (f,) m
    wires: np.ndarray  # (w, 6) int
    wire_numbers: np.ndarray  # (w, 5)
    stretches: np.ndarray  # (k, 3) int
    stretch_numbers: np.ndarray  # (k, 2)
    droppers: np.ndarray  # (d, 3) int
    dropper_numbers: np.ndarray  # (14, d)
    holds: np.ndarray  # (h, 3) int
    hold_numbers: np.ndarray  # (9, h)
    fixed: np.ndarray  # (t,) int, wires that are anchored at both ends
    fixed_numbers: np.ndarray  # (t, 3) axial stiffness EA, N, thermal expansion, 1/K, and room for what stays constant, m/m


@kernel_tuple
class Filled(NamedTuple):
    """Numbers of a layout."""

    tension: np.ndarray  # (w,) N
    mass: np.ndarray  # (w,) kg/m
    bending: np.ndarray  # (w,) N m²
    hold: np.ndarray  # (6, h) stiffness N/m, damping N.s/m, mass kg, lift N, height m, reaction N
    dropper: np.ndarray  # (9, d) stiffness N/m, masses kg, height, length and cut length m, preload N, cut length at rest m
    refused: np.ndarray  # (4,) numbers of a refusal


def empty_numbers(wires: int, droppers: int, holds: int) -> Filled:
    """Room for the numbers of a layout."""
    zeros: Any = (*np.zeros((3, wires)), np.zeros((6, holds)), np.zeros((9, droppers)), np.zeros(4))
    return Filled(*zeros)


def plan_of(layout: Layout, fixed: Sequence[tuple[int, float, float]] = ()) -> Plan:
    """fixed: of the wires that are anchored at both ends their number, axial stiffness and thermal expansion."""
    x = layout.places

    def at(positions: object) -> np.ndarray:
        return np.searchsorted(x, np.asarray(positions) - 1e-6)

    wires, numbers, stretches = [], [], []
    for row, w in enumerate(layout.wires):
        contact = w.lane // 2 if w.lane in layout.contact_lanes else -1
        wires.append((w.lane, *at([w.start, w.end]), -1 if w.clamped_to is None else w.clamped_to, contact, bool(w.masses)))
        numbers.append((w.tension, w.mass, w.bending, *w.heights))
        stretches += [(row, part.start, part.end, part.value, 1.0) for part in w.tension_changes]
        stretches += [(row, part.start, part.end, 0.0, part.value) for part in w.masses]
    d, h, parts = layout.droppers, layout.holds, np.array(stretches).reshape(-1, 5)
    lanes = np.isin(np.arange(layout.lanes), layout.contact_lanes).astype(np.int64)
    lanes[list(layout.auxiliary_lanes)] = -1
    thermal = np.array(fixed, dtype=float).reshape(-1, 3)
    return Plan(
        lanes,
        x,
        _whole(wires),
        np.array(numbers, dtype=float),
        _whole(np.column_stack((parts[:, 0], at(parts[:, 1]), at(parts[:, 2])))),
        parts[:, 3:].copy(),
        _whole(np.column_stack((at(d.position), d.lower, d.upper))),
        np.array([getattr(d, n) for n in DROPPER_NUMBERS]),
        _whole(np.column_stack((at(h.position), h.lane, h.wire))),
        np.array([getattr(h, n) for n in HOLD_NUMBERS]),
        _whole(thermal[:, 0]),
        np.column_stack((thermal[:, 1:], np.zeros(len(thermal)))),
    )


def _whole(rows: object) -> np.ndarray:
    return np.ascontiguousarray(rows, dtype=np.int64)


def filled_layout(layout: Layout, given: Given, filled: Filled) -> Layout:
    """A layout with the numbers that parameters give."""
    wires = tuple(
        replace(w, tension=float(T), mass=float(m), bending=float(B))
        for w, T, m, B in zip(layout.wires, filled.tension, filled.mass, filled.bending, strict=True)
    )
    d, h, own, none = layout.droppers, layout.holds, filled.dropper, np.zeros(filled.dropper.shape[1])
    clamps = {
        name: np.where(np.isnan(mass := getattr(d, name)), getattr(given, f"{name}_mass"), mass)
        for name in ("contact_clamp", "messenger_clamp")
    }
    d = replace(
        d,
        stiffness=own[STIFFNESS].copy(),
        axial_stiffness=none,
        mass=own[OWN_MASS].copy(),
        mass_per_length=none,
        height=own[HEIGHT].copy(),
        sag=none,
        **clamps,
    )
    h = replace(
        h, **{n: filled.hold[i].copy() for i, n in enumerate(HOLD_NUMBERS[:REACTION])}, arm_length=np.zeros(h.position.size)
    )
    return replace(layout, wires=wires, droppers=d, holds=h)


# -- kernels -----------------------------------------------------------------------------------------------------------
@kernel
def given_at(number, otherwise):
    """A number of a plan, or what takes its place."""
    return otherwise if math.isnan(number) else number


@kernel
def parabola(x, first, last, depth):
    """Height of a parabola, 0 at first and last and `-depth` between them, at x; m."""
    return -4.0 * depth * (x - first) * (last - x) / (last - first) ** 2


@kernel
def fill_droppers(numbers, given, dropper):
    """Stiffnesses and masses of droppers, for their present lengths; returns how many are others than before.

    numbers, dropper: of `Plan` and `Filled`.
    """
    changed = 0
    for k in range(dropper.shape[1]):
        own = dropper[:, k]
        stiffness, axial = given_at(numbers[STIFFNESS, k], given.dropper_stiffness), numbers[EA, k]
        if axial > 0.0:
            stiffness = axial / own[LENGTH]
        mass = given_at(numbers[OWN, k], given.dropper_mass) + numbers[PER_LENGTH, k] * own[LENGTH]
        below = given_at(numbers[CLAMP_BELOW, k], given.contact_clamp_mass) + 0.5 * mass
        above = given_at(numbers[CLAMP_ABOVE, k], given.messenger_clamp_mass) + 0.5 * mass
        if stiffness != own[STIFFNESS] or below != own[MASS_BELOW] or above != own[MASS_ABOVE]:
            changed += 1
        own[STIFFNESS], own[MASS_BELOW], own[MASS_ABOVE], own[OWN_MASS] = stiffness, below, above, mass
    return changed


@kernel
def arm_of(force, length, angle, mass):
    """(angle below the horizontal rad, vertical stiffness N/m, mass at the wire kg, lift on the wire N) of a steady arm.

    It pulls sideways with `force`, N. Arm of length l at angle phi, a rod with a hinge: V0 = F tan phi, k = F / (l cos³ phi),
    exact for constant F. Without an angle, NaN, V0 is half of the arm's weight, which it then just carries.
    """
    hanging, lift = 0.5 * GRAVITY * mass, 0.0
    phi = angle
    if math.isnan(angle):
        phi = math.atan2(hanging, force) if force > 0.0 else 0.0
    if not math.isnan(angle) or force > 0.0:
        lift = force * math.tan(phi) - hanging
    return phi, force / (length * math.cos(phi) ** 3), mass / 3.0, lift


@kernel
def fill_holds(plan, given, tension, hold, refused):
    """Springs to the ground, for the present tensions of wires; hold, refused: of `Filled`. A status."""
    for k in range(plan.holds.shape[0]):
        numbers, own = plan.hold_numbers[:, k], hold[:, k]
        on_contact_wire = plan.lanes[plan.holds[k, SPRING_LANE]] > 0
        own[STIFFNESS] = given_at(numbers[STIFFNESS], given.arm_stiffness if on_contact_wire else given.support_stiffness)
        own[DAMPING] = given_at(numbers[DAMPING], given.support_damping)
        own[HOLD_MASS] = given_at(numbers[HOLD_MASS], given.arm_mass)
        own[LIFT], own[HOLD_HEIGHT] = numbers[LIFT], numbers[HOLD_HEIGHT]
        if numbers[ARM_LENGTH] > 0.0:
            force = abs(tension[plan.holds[k, PULLED_BY]] * numbers[KINK])
            phi, vertical, at_wire, lifts = arm_of(force, numbers[ARM_LENGTH], numbers[ARM_ANGLE], numbers[ARM_MASS])
            if math.isnan(numbers[ARM_ANGLE]) and math.degrees(phi) > STEEPEST:
                refused[0], refused[1] = force, numbers[ARM_MASS]
                return STEEP_ARM
            own[STIFFNESS] += vertical
            own[HOLD_MASS] += at_wire
            own[LIFT] += lifts
    return DONE


@kernel
def fill_layout(plan, given, filled):
    """All numbers, for the present lengths of droppers; heights that follow from cut lengths are NaN. A status."""
    for k in range(plan.wires.shape[0]):
        contact, numbers = plan.wires[k, CONTACT] >= 0, plan.wire_numbers[k]
        filled.tension[k] = given_at(numbers[TENSION], given.contact_wire_tension if contact else given.messenger_tension)
        filled.mass[k] = given_at(numbers[MASS], given.contact_wire_mass if contact else given.messenger_mass)
        filled.bending[k] = given_at(numbers[BENDING], given.contact_wire_bending if contact else given.messenger_bending)
    fill_droppers(plan.dropper_numbers, given, filled.dropper)
    for k in range(filled.dropper.shape[1]):
        numbers = plan.dropper_numbers[:, k]
        depth, height = given_at(numbers[SAG], given.sag), numbers[WANTED]
        if depth != 0.0:
            height += parabola(numbers[WITHIN], numbers[SAG_FROM], numbers[SAG_TO], depth)
        filled.dropper[HEIGHT, k] = height
    return fill_holds(plan, given, filled.tension, filled.hold, filled.refused)
