"""The parts of a line along the track, as plain data: the uniform catenary and a line from a table both become a `Layout`.

Lanes are the rows of a mesh: 0 the contact wire, 1 its messenger, 2 a second contact wire, then a further messenger, stitch wires
and auxiliary wires of compound catenaries. A wire takes its lane from one anchor to the other.

A number that the line does not say is NaN: a parameter of `Catenary` takes its place, see `plan`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from ...core.errors import BadInput

SECOND = 2  # lane of the second contact wire
GRAVITY = 9.81  # m/s²
SAID_BY_A_PARAMETER = math.nan


@dataclass(frozen=True)
class Stretch:
    """A part of a wire with a tension or a mass of its own. start, end: m."""

    start: float
    end: float
    value: float


@dataclass(frozen=True)
class Wire:
    """One wire. Lengths in m, tension in N, mass in kg/m, bending stiffness EI in N m².

    heights: of its two ends.  tension_changes: what is added to the tension in parts, N; masses: factors of the mass in parts.
    clamped_to: lane of the wire that holds its ends, or None for anchors.
    """

    lane: int
    start: float
    end: float
    tension: float = SAID_BY_A_PARAMETER
    mass: float = SAID_BY_A_PARAMETER
    bending: float = SAID_BY_A_PARAMETER
    heights: tuple[float, float] = (0.0, 0.0)
    tension_changes: tuple[Stretch, ...] = ()
    masses: tuple[Stretch, ...] = ()
    clamped_to: int | None = None

    @property
    def least_worn(self) -> float:
        """Largest factor of the mass along the wire."""
        worn = sum(part.end - part.start for part in self.masses)
        factors = [part.value for part in self.masses]
        return max(factors if worn > self.end - self.start - 1e-6 else [*factors, 1.0])


@dataclass(frozen=True)
class Holds:
    """Springs to the ground: supports and steady arms. All (k,).

    height: of the wire there at rest, m; NaN where it follows.  lift: force of the arm on the wire at rest, N, upwards.
    A steady arm of a table has a length (0 without one), an angle below the horizontal (rad, NaN where it carries its own weight)
    and a mass of its own, and pulls with the tension of wire number `wire` times the `kink` of the lateral positions: stiffness,
    mass and lift follow, and the given numbers are added.
    """

    position: np.ndarray
    lane: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    mass: np.ndarray
    lift: np.ndarray
    height: np.ndarray
    arm_length: np.ndarray
    arm_angle: np.ndarray
    arm_mass: np.ndarray
    kink: np.ndarray
    wire: np.ndarray


@dataclass(frozen=True)
class Droppers:
    """Droppers, by position. All (d,). lower, upper: lanes; stiffness in N/m, masses in kg.

    axial_stiffness: N, over the length in the place of the stiffness, where it is positive.  mass_per_length: kg/m, times the
    length in the place of the mass, where it is positive.
    height: of the lower clamp at rest, m, without its sag; NaN where it follows from the cut length.
    sag: depth in m of a parabola between `first` and `last`, m in the span, at the place `within` it.
    cut_length, length, preload: what a table says of them, m, m, N; NaN where it says nothing.
    """

    position: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    stiffness: np.ndarray
    axial_stiffness: np.ndarray
    mass: np.ndarray
    mass_per_length: np.ndarray
    contact_clamp: np.ndarray
    messenger_clamp: np.ndarray
    height: np.ndarray
    sag: np.ndarray
    within: np.ndarray
    first: np.ndarray
    last: np.ndarray
    cut_length: np.ndarray
    length: np.ndarray
    preload: np.ndarray

    @property
    def mass_below(self) -> np.ndarray:
        """Of each dropper the clamp below and half of its own mass, (d,) kg."""
        return self.contact_clamp + 0.5 * self.mass

    @property
    def mass_above(self) -> np.ndarray:
        """Of each dropper the clamp above and half of its own mass, (d,) kg."""
        return self.messenger_clamp + 0.5 * self.mass


@dataclass(frozen=True)
class Layout:
    """All wires, droppers and springs; supports: their positions, (s,) m, both ends of the line included."""

    lanes: int
    supports: np.ndarray
    wires: tuple[Wire, ...]
    droppers: Droppers
    holds: Holds
    contact_lanes: tuple[int, ...] = (0,)
    auxiliary_lanes: tuple[int, ...] = ()
    # (k, 5): contact wire, position, stagger, kink, and the number of the wire whose tension times the kink is the force there
    lateral: np.ndarray = field(default_factory=lambda: np.zeros((0, 5)))
    reference: float = 0.0  # m, level in the line's table that heights count from

    @property
    def lateral_force(self) -> np.ndarray:
        """Of each row of `lateral` the force by which a steady arm pulls the contact wire, (k,) N; statics of a string."""
        return np.array([w.tension for w in self.wires])[self.lateral[:, 4].astype(int)] * self.lateral[:, 3]

    @property
    def places(self) -> np.ndarray:
        """Positions at which the mesh has nodes, m."""
        ends = [x for w in self.wires for x in (w.start, w.end, *(c for s in w.tension_changes for c in (s.start, s.end)))]
        return np.unique(np.concatenate((self.supports, self.droppers.position, ends)).round(9))


def columns(kind: type, size: int, **given: Any) -> dict[str, np.ndarray]:
    """Fields of `Holds` or `Droppers`, (size,) each: the given ones, numbers or arrays, and zeros."""
    return {f.name: np.broadcast_to(given.get(f.name, 0.0), size).copy() for f in fields(kind)}


def uniform(
    spans: int, span_length: float, within: np.ndarray, pre_sag: bool = False, arms: bool = False, level: bool = False
) -> Layout:
    """The uniform catenary. within: droppers in a span, (k,) m.  pre_sag, arms, level: whether these effects are on."""
    if not (np.all(np.diff(within) > 0.0) and within[0] > 0.0 and within[-1] < span_length):
        raise BadInput(
            "Catenary", f"dropper positions {within.tolist()}", f"increasing values inside the span of {span_length:g} m"
        )
    if pre_sag and within.size < 2:
        raise BadInput(
            "Catenary",
            "pre_sag with one dropper in a span",
            "at least two: it is 0 at the first and at the last",
            "Set droppers to 2 or more, or leave pre_sag off.",
        )
    supports = span_length * np.arange(spans + 1)
    positions = (span_length * np.arange(spans)[:, None] + within).ravel()
    d, end = positions.size, float(supports[-1])
    inner = supports[1:-1]
    s = inner.size

    def both(contact_wire: float, messenger: float) -> np.ndarray:
        return np.repeat([contact_wire, messenger], s)

    arm = SAID_BY_A_PARAMETER if arms else 0.0
    holds = Holds(
        **columns(
            Holds,
            2 * s,
            position=np.tile(inner, 2),
            lane=np.repeat([0, 1], s),
            stiffness=both(arm, SAID_BY_A_PARAMETER),
            damping=both(0.0, SAID_BY_A_PARAMETER),
            mass=both(arm, 0.0),
            height=both(0.0 if level else math.nan, 0.0),
            wire=np.zeros(2 * s, int),
        )
    )
    droppers = Droppers(
        **columns(
            Droppers,
            d,
            position=positions,
            lower=np.zeros(d, int),
            upper=np.ones(d, int),
            within=np.tile(within, spans),
            first=within[0],
            last=within[-1],
            sag=SAID_BY_A_PARAMETER if pre_sag else 0.0,
            **dict.fromkeys(("stiffness", "mass", "contact_clamp", "messenger_clamp"), SAID_BY_A_PARAMETER),
            **dict.fromkeys(("cut_length", "length", "preload"), math.nan),
        )
    )
    return Layout(2, supports, (Wire(0, 0.0, end), Wire(1, 0.0, end)), droppers, holds)
