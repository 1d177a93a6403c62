"""Races and balls that are not perfect: waviness by order, and localized defects with a smooth profile.

Everything here ends in the gap of each ball, the length by which the surfaces of ball and races are farther apart than on a
perfect bearing; a bearing model subtracts it from its contact deformation. Ball j stands at angle + 2 pi j / Z, j = 0 ... Z - 1.

How a bearing model uses it: its parts declare `Waviness`, `Defect` and `BallDefect` as effects, its `shapes` take over
`wave_shapes`, its start calls `start_waves`, and a kernel calls `add_faults` with `gap` and `rate`, (Z,), filled beforehand.
What belongs to the inner ring turns with it, the outer ring is at rest, and a pit on a ball meets the inner race and half a
turn of the ball later the outer one.

`rate` gets the time derivative of the gap, for contact damping; hand over None where nobody asks for it. The angle `spin` is
that of the ball against the cage and needs a state of its own: spin_speed = spin_ratio * speed with `BallGeometry.spin_ratio`,
no whole multiple of any other angle, so that it cannot be had from a wrapped one.
"""

from __future__ import annotations

import math
from collections.abc import Container
from typing import Any, NamedTuple

from ..core.component import Effect
from ..core.kernels import kernel, kernel_tuple
from ..core.variables import NUMBERED, integer, parameter

ORDERS = 8
TWO_PI = 2.0 * math.pi


class Waviness(Effect):
    """Waves of a race: the surface lies deeper by the sum of amplitude * cos(order * angle + phase), angle along the race."""

    order = integer(
        (2, 3, 4, 5, 6, 7, 8, 9),
        "number of waves along the race; amplitude 0 leaves an order out",
        size=ORDERS,
        low=1,
        high=10000,
        structural="a property of the race",
    )
    amplitude = parameter((1e-6, *[0.0] * (ORDERS - 1)), "m", "amplitude of the order", size=ORDERS, nominal=1e-6)
    phase = parameter(0.0, "rad", "phase of the order at the race's own angle 0", size=ORDERS)


class Defect(Effect):
    """A pit in a race with the profile of a raised cosine: depth and slope are continuous, so nothing jumps as a ball passes."""

    explicit_only = True

    depth = parameter(5e-6, "m", "depth in the middle; negative for a bump", nominal=1e-6)
    width = parameter(math.radians(3.0), "rad", "extent along the race", low=1e-6, high=TWO_PI)
    position = parameter(0.0, "rad", "middle of the pit on its race")


class BallDefect(Effect):
    """A pit on one ball that meets the inner race and, half a turn of the ball later, the outer race."""

    explicit_only = True

    depth = parameter(5e-6, "m", "depth in the middle; negative for a bump", nominal=1e-6)
    width = parameter(math.radians(10.0), "rad", "extent along the ball's circumference", low=1e-6, high=TWO_PI)
    position = parameter(0.0, "rad", "turn of the ball from its start at which the pit meets the inner race")
    ball = integer(1, "number of the ball, counted from 1", low=1, structural=NUMBERED)


class CageFault(Effect):
    """A broken cage that no longer holds one ball at its distance: the ball runs ahead of its place, or behind, by a fixed angle.

    Loads then repeat once a turn of the cage only, so that lines at the cage's frequency come up, and sidebands at its distance
    about those of pits: the signs of a broken cage. That it moves balls from their places is how Wang et al. (Mechanical
    Systems and Signal Processing 182 (2023) 109545, abstract read) model it; a constant angle is a choice of ours. A cage that
    moves against its balls, strikes them or rubs is not in it.
    """

    explicit_only = True

    offset = parameter(math.radians(5.0), "rad", "angle of the ball ahead of its place; below half the distance of two balls")
    ball = integer(2, "number of the ball, counted from 1", low=1, structural=NUMBERED)


@kernel_tuple
class Pit(NamedTuple):
    """A raised-cosine pit; ball: index of the ball that carries it, for one on a ball."""

    depth: float  # m
    half_width: float  # rad
    position: float  # rad
    ball: int


def wave_shapes(on: Container[str], balls: int) -> dict[str, Any]:
    """Tables of `develop` for `shapes` of a bearing with so many balls, (2, ORDERS, Z); None where there are no waves."""
    return {f"{ring}_waves": (2, ORDERS, balls) if f"{ring}_waviness" in on else None for ring in ("inner", "outer")}


@kernel
def develop(waves, table):
    """Waves of a race for balls at equal distances, as they stand at angle 0; waves: as of `Waviness`, table: (2, n, Z), m.

    table[0, l, j] = A_l cos(l 2 pi j / Z + phase_l), table[1, l, j] with the sine.
    """
    balls = table.shape[2]
    for i in range(waves.order.size):
        for j in range(balls):
            angle = waves.order[i] * (TWO_PI * j / balls) + waves.phase[i]
            table[0, i, j], table[1, i, j] = waves.amplitude[i] * math.cos(angle), waves.amplitude[i] * math.sin(angle)


@kernel
def start_waves(s, e):
    """Waves of both races for the present parameters."""
    if e.inner_waviness is not None:
        develop(e.inner_waviness, s.inner_waves)
    if e.outer_waviness is not None:
        develop(e.outer_waviness, s.outer_waves)


@kernel
def highest_order(waves):
    """The largest order that has an amplitude; 0 where none has."""
    highest = 0
    for i in range(waves.order.size):
        if waves.amplitude[i] != 0.0:
            highest = max(highest, waves.order[i])
    return highest


@kernel
def smooth_pit(depth, width, position, ball=1):
    """A pit from its depth (m), full width and position (rad); `ball`, counted from 1, for one on a ball."""
    return Pit(depth, 0.5 * width, position, ball - 1)


@kernel
def race_pit(v):
    """A pit from the parameters of `Defect`."""
    return smooth_pit(v.depth, v.width, v.position)


@kernel
def ball_pit(v):
    """A pit from the parameters of `BallDefect`."""
    return smooth_pit(v.depth, v.width, v.position, v.ball)


@kernel
def wrapped(angle):
    """The angle in [0, 2 pi), rad."""
    angle -= TWO_PI * math.floor(angle / TWO_PI)
    # a tiny negative angle rounds to 2 pi itself
    return angle if angle < TWO_PI else 0.0


@kernel
def add_waves(gap, rate, angle, speed, waves, table):
    """gap[j] += sum over l of A_l cos(l (angle + 2 pi j / Z) + phase_l), m; rate[j] += its derivative, angle' = speed.

    An order of amplitude 0 is left out. waves, table: as of `develop`.
    """
    for i in range(waves.order.size):
        if waves.amplitude[i] != 0.0:
            order = waves.order[i]
            c, s = math.cos(order * angle), math.sin(order * angle)
            for j in range(gap.size):
                gap[j] += table[0, i, j] * c - table[1, i, j] * s
            if rate is not None:
                c, s = order * speed * c, order * speed * s
                for j in range(gap.size):
                    rate[j] -= table[0, i, j] * s + table[1, i, j] * c


@kernel
def pit_profile(angle, pit):
    """(depth in m, slope in m/rad) of a pit at an angle of its race: depth/2 (1 + cos(pi s / half_width)), s from its middle."""
    s = angle - pit.position
    s -= TWO_PI * math.floor(s / TWO_PI + 0.5)
    if abs(s) >= pit.half_width:
        return 0.0, 0.0
    scale = math.pi / pit.half_width
    return 0.5 * pit.depth * (1.0 + math.cos(scale * s)), -0.5 * pit.depth * scale * math.sin(scale * s)


@kernel
def add_pit(gap, rate, angle, speed, pit):
    """Gap of every ball that stands in the pit of a race; angle: of ball 0 along the race, angle' = speed."""
    spacing = TWO_PI / gap.size
    for j in range(gap.size):
        depth, slope = pit_profile(angle + spacing * j, pit)
        gap[j] += depth
        if rate is not None:
            rate[j] += slope * speed


@kernel
def add_ball_pit(gap, rate, spin, speed, pit):
    """Gap of the ball that carries a pit; spin: turn of the ball against the cage, spin' = speed."""
    inner_depth, inner_slope = pit_profile(spin, pit)
    outer_depth, outer_slope = pit_profile(spin + math.pi, pit)
    gap[pit.ball] += inner_depth + outer_depth
    if rate is not None:
        rate[pit.ball] += (inner_slope + outer_slope) * speed


@kernel
def add_faults(gap, rate, angles, speed, ratios, inner_waves, outer_waves, e):
    """Waves and pits of a bearing added to gap (Z,) and, unless None, to rate (Z,).

    angles: of the inner ring, of the cage and, with a pit on a ball, its spin.  ratios: has cage_ratio and spin_ratio.
    inner_waves, outer_waves: of `develop`.
    """
    inner, cage, cage_speed = angles[0], angles[1], ratios.cage_ratio * speed
    if e.inner_waviness is not None:
        add_waves(gap, rate, cage - inner, cage_speed - speed, e.inner_waviness, inner_waves)
    if e.outer_waviness is not None:
        add_waves(gap, rate, cage, cage_speed, e.outer_waviness, outer_waves)
    if e.inner_defect is not None:
        add_pit(gap, rate, cage - inner, cage_speed - speed, race_pit(e.inner_defect))
    if e.outer_defect is not None:
        add_pit(gap, rate, cage, cage_speed, race_pit(e.outer_defect))
    if e.ball_defect is not None:
        add_ball_pit(gap, rate, angles[2], ratios.spin_ratio * speed, ball_pit(e.ball_defect))
