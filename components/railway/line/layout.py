"""What hangs where along the track, as plain data: the uniform catenary and a line from a table both become a `Layout`.

Lanes are the rows of a mesh: 0 the contact wire, 1 its messenger, 2 a second contact wire, then further messengers and stitch
wires. A wire takes its lane from one anchor to the other.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...core.errors import BadInput

SECOND = 2  # lane of the second contact wire
GRAVITY = 9.81  # m/s²


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
    tension: float
    mass: float
    bending: float = 0.0
    heights: tuple[float, float] = (0.0, 0.0)
    tension_changes: tuple[Stretch, ...] = ()
    masses: tuple[Stretch, ...] = ()
    clamped_to: int | None = None

@dataclass(frozen=True)
class Holds:
    """Springs to the ground: supports and steady arms. All (k,).

    lift: force of the arm on the wire at rest, N, upwards.  height: of the wire there at rest, m; NaN where it follows.
    """

    position: np.ndarray
    lane: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray
    mass: np.ndarray
    lift: np.ndarray
    height: np.ndarray


@dataclass(frozen=True)
class Droppers:
    """Droppers, by position. All (d,). lower, upper: lanes; masses in kg, each with its clamp and half of the dropper.

    height: of the contact wire's clamp at rest, m; NaN where it follows from the cut length.  mass: without clamps.
    cut_length, length, preload: what a table says of them, m, m, N; NaN where it says nothing.
    """

    position: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    stiffness: np.ndarray
    mass_below: np.ndarray
    mass_above: np.ndarray
    height: np.ndarray
    mass: np.ndarray
    cut_length: np.ndarray
    length: np.ndarray
    preload: np.ndarray


@dataclass(frozen=True)
class Layout:
    """All wires, droppers and springs; supports: their positions, (s,) m, both ends of the line included."""

    lanes: int
    supports: np.ndarray
    wires: tuple[Wire, ...]
    droppers: Droppers
    holds: Holds
    contact_lanes: tuple[int, ...] = (0,)
    lateral: np.ndarray = field(default_factory=lambda: np.zeros((0, 4)))  # (k, 4): contact wire, position, stagger, force
    reference: float = 0.0  # m, level in the line's table that heights count from

    @property
    def places(self) -> np.ndarray:
        """Positions at which the mesh has nodes, m."""
        ends = [x for w in self.wires for x in (w.start, w.end, *(c for s in w.tension_changes for c in (s.start, s.end)))]
        return np.unique(np.concatenate((self.supports, self.droppers.position, ends)).round(9))


def uniform(p: Any, bending: Any, pre_sag: Any, arm: Any, level: Any) -> Layout:
    """The uniform catenary: parameters of `Catenary` and its effects, NamedTuples or None."""
    count = int(p.droppers)
    within = p.dropper_position[:count]
    if not (np.all(np.diff(within) > 0.0) and within[0] > 0.0 and within[-1] < p.span_length):
        expected = f"increasing values inside the span of {p.span_length:g} m"
        raise BadInput("Catenary", f"dropper positions {within.tolist()}", expected)
    if pre_sag is not None and count < 2:
        raise BadInput("Catenary", "pre_sag with one dropper in a span", "at least two: it is 0 at the first and at the last",
                       "Set droppers to 2 or more, or leave pre_sag off.")
    supports = p.span_length * np.arange(p.spans + 1)
    positions = (p.span_length * np.arange(p.spans)[:, None] + within).ravel()
    d = positions.size
    height = np.zeros(d)
    if pre_sag is not None:  # parabola through the first and the last dropper of a span
        height = np.tile(parabola(within, within[0], within[-1], pre_sag.depth), p.spans)
    half = 0.5 * p.dropper_mass
    EI = (bending.contact_wire, bending.messenger) if bending is not None else (0.0, 0.0)
    end = float(supports[-1])
    wires = (Wire(0, 0.0, end, p.contact_wire_tension, p.contact_wire_mass, EI[0]),
             Wire(1, 0.0, end, p.messenger_tension, p.messenger_mass, EI[1]))
    inner = supports[1:-1]
    s = inner.size
    arms = (arm.stiffness, arm.mass) if arm is not None else (0.0, 0.0)

    def both(contact_wire: float, messenger: float) -> np.ndarray:
        return np.repeat([contact_wire, messenger], s)

    holds = Holds(np.tile(inner, 2), np.repeat([0, 1], s), both(arms[0], p.support_stiffness), both(0.0, p.support_damping),
                  both(arms[1], 0.0), np.zeros(2 * s), both(0.0 if level is not None else np.nan, 0.0))
    droppers = Droppers(positions, np.zeros(d, int), np.ones(d, int), np.full(d, p.dropper_stiffness),
                        np.full(d, p.contact_clamp_mass + half), np.full(d, p.messenger_clamp_mass + half), height,
                        np.full(d, p.dropper_mass), *np.full((3, d), np.nan))
    return Layout(2, supports, wires, droppers, holds)


def parabola(x: np.ndarray, first: float, last: float, depth: float) -> np.ndarray:
    """Heights of a parabola, 0 at first and last and `-depth` between them, at x (n,); m."""
    return -4.0 * depth * (x - first) * (last - x) / (last - first) ** 2
