"""Planar four-bar linkage in closed form: position, rates, transmission angle, its limits, and where it may fold over.

Crank a, coupler b, rocker c, ground d from the crank's pin to the rocker's. Crank angle phi and rocker angle psi are counted from
the ground's direction. With the diagonal f from the rocker's pin to the crank's tip, f² = a² + d² - 2 a d cos phi,

    psi = delta - gamma (open) or delta + gamma (crossed)
    tan gamma = S / (f² + c² - b²),    S² = (f² - (b - c)²) ((b + c)² - f²)

delta: direction of the diagonal. S is four times the area of the triangle of diagonal, coupler and rocker, and sin of the
transmission angle is S / (2 b c). Where a link can lie along all others, |a - d| = |b - c| or a + d = b + c, a factor of S² is
the square of a sine or cosine of phi / 2: its root passes zero without a kink, and with it the linkage goes straight on.
Textbook kinematics (Freudenstein's equation), derived anew.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..core.kernels import kernel, kernel_tuple

SAME = 1e-9  # of the sum of the lengths: lengths that differ by less count as equal, as tolerances of manufacture are far larger


@kernel_tuple
class Linkage(NamedTuple):
    """Lengths in m, and how it goes on. sign: 1 open, -1 crossed; near, far: at the crank angles 0 and pi, 0 where there is no
    change point, 1 through it without a kink, -1 folded back into the same assembly."""

    crank: float
    coupler: float
    rocker: float
    ground: float
    sign: float
    near: float
    far: float


@kernel
def change_points(crank, coupler, rocker, ground):
    """Whether all links can lie along one line with the crank at 0 and with the crank at pi."""
    small = SAME * (crank + coupler + rocker + ground)
    near = abs(abs(crank - ground) - abs(coupler - rocker)) < small
    return near, abs(crank + ground - coupler - rocker) < small


@kernel
def longest_link(crank, coupler, rocker, ground):
    """Which of the four is longest, from 0, the first of equal ones."""
    longest, length = 0, crank
    if coupler > length:
        longest, length = 1, coupler
    if rocker > length:
        longest, length = 2, rocker
    if ground > length:
        longest, length = 3, ground
    return longest


@kernel
def turns_freely(crank, coupler, rocker, ground):
    """Whether coupler and rocker would turn about one pin by themselves, with the crank along the ground."""
    small = SAME * (crank + coupler + rocker + ground)
    return abs(crank - ground) < small and abs(coupler - rocker) < small


def kind(crank: float, coupler: float, rocker: float, ground: float) -> str:
    """By Grashof: "crank-rocker", "double crank", "rocker-crank", "double rocker", "change point", or "triple rocker"."""
    lengths = (crank, coupler, rocker, ground)
    rest = 0.5 * sum(lengths) - min(lengths) - max(lengths)
    if any(change_points(*lengths)):
        return "change point"
    if rest < 0.0:
        return "triple rocker"
    return ("crank-rocker", "double rocker", "rocker-crank", "double crank")[lengths.index(min(lengths))]


@kernel
def argument(q, r, angle):
    """Argument of q - r exp(-i angle), rad, without a jump over any number of turns; q, r > 0."""
    if r <= q:
        return math.atan2(r * math.sin(angle), q - r * math.cos(angle))
    return math.pi - angle - math.atan2(q * math.sin(angle), r - q * math.cos(angle))


@kernel
def root(value, slope, half, half_slope, way):
    """(root, its slope): of value with the slope of value; or at a change point half as it is (way 1) or its magnitude (-1)."""
    if way == 0.0:
        if value <= 0.0:
            return 0.0, 0.0
        length = math.sqrt(value)
        return length, 0.5 * slope / length
    if way < 0.0 and half < 0.0:
        return -half, -half_slope
    return half, half_slope


@kernel
def position(angle, p):
    """(rocker angle, its slope over the crank angle, sine of the transmission angle, its cosine) at a crank angle, rad.

    p: `Linkage`. Where it does not close, the sine is 0, as it is in the toggle; past a change point it may be negative.
    """
    a, b, c, d = p.crank, p.coupler, p.rocker, p.ground
    sine, cosine = math.sin(angle), math.cos(angle)
    square, change = a * a + d * d - 2.0 * a * d * cosine, 2.0 * a * d * sine  # of the diagonal, and its slope
    half_turn = math.sqrt(a * d)
    s, c_half = math.sin(0.5 * angle), math.cos(0.5 * angle)
    near, near_slope = root(square - (b - c) ** 2, change, 2.0 * half_turn * s, half_turn * c_half, p.near)
    far, far_slope = root((b + c) ** 2 - square, -change, 2.0 * half_turn * c_half, -half_turn * s, p.far)
    area, area_slope = near * far, near_slope * far + near * far_slope
    along = square + c * c - b * b
    if p.near > 0.0 and p.far > 0.0:  # parallelogram or deltoid: gamma may go round
        gamma = argument(a, d, angle) if abs(a - c) <= abs(a - b) else argument(d, a, angle)
    elif p.near > 0.0 and b > c:
        gamma = math.pi - math.atan2(area, -along)
    else:
        gamma = math.atan2(area, along)
    gamma_slope = (along * area_slope - area * change) / (4.0 * square * c * c)
    delta, delta_slope = math.pi - argument(d, a, angle), a * (a - d * cosine) / square
    scale = 2.0 * b * c
    return delta - p.sign * gamma, delta_slope - p.sign * gamma_slope, area / scale, (b * b + c * c - square) / scale
