"""Heat through small contacts: thermal constriction, in SI units.

An isothermal ellipse of semi-axes a >= b on a half space of conductivity k, on one side:

    R = K(1 - (b/a)²) / (2 pi k a) = 1 / (4 k agm(a, b))        (circle: 1 / (4 k a))

with the complete elliptic integral K, or the arithmetic-geometric mean of the semi-axes.

In a ball of radius r that is heated at one such spot and cooled at the opposite one, each spot's resistance grows by

    (ln(2 r / (a + b)) + 1/2) / (4 pi k r),

from the smooth part of the sphere's Neumann function, (1/s - 2 - ln(s + s²)) / (4 pi k r) with s = sin(half the angle),
averaged over the spot with the density of an isothermal ellipse (mean of ln(distance): ln((a + b)/2) + 2 ln 2 - 3/2).

Beside a contact the gap of two curved surfaces lets heat through as well. Where it has opened to a width g, an ellipse with
the squared semi-axes a² + 2 Ry g, b² + 2 Rx g is bridged; the gap from g to g + dg conducts 2 pi k sqrt(Rx Ry) dg / (g + c).
The constriction from one such ellipse to the next is taken in series, the gap between them in parallel: a ladder.

Source: the constriction is classical (Carslaw & Jaeger; Yovanovich); ball and ladder are derived here and compared with finite
volumes by the validation case thermal-scaling: the ladder's resistance is less than 10 % too high with air in the gap, and
less than 15 % with oil. Contact and gap simply in parallel would be too low.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..core.errors import BadInput
from ..core.kernels import kernel, kernel_tuple
from .hertz import hertz_axes

RUNGS = 10  # of the ladder; with 200 the resistance is another by 0.1 % at most


@kernel
def arithmetic_geometric_mean(one, other):
    """agm of two positive numbers, to rounding."""
    while abs(one - other) > 1e-15 * one:
        one, other = 0.5 * (one + other), math.sqrt(one * other)
    return one


def constriction(major: float, minor: float, conductivity: float) -> float:
    """Resistance on one side of an isothermal ellipse with semi-axes in m on a half space (W/(m.K)), K/W."""
    if not (major > 0.0 and minor > 0.0 and conductivity > 0.0):
        raise BadInput(
            "thermal constriction",
            f"semi-axes {major:g} and {minor:g} m, conductivity {conductivity:g} W/(m.K)",
            "positive values",
        )
    return 1.0 / (4.0 * conductivity * arithmetic_geometric_mean(major, minor))


@kernel
def ball_spreading(major, minor, radius, conductivity):
    """Resistance that a ball of `radius` m adds at each of two opposite spots with semi-axes in m, K/W."""
    return (math.log(2.0 * radius / (major + minor)) + 0.5) / (4.0 * math.pi * conductivity * radius)


@kernel
def finite_ring(radius, conductivity):
    """Resistance that a small spot lacks in an insulated cylinder of `radius` m against a half space, K/W.

    The leading term of R = (1 - 1.4098 a/b + ...) / (4 k a) of an isothermal circle in a tube (Yovanovich, from memory).
    """
    return 1.4098 / (4.0 * conductivity * radius)


@kernel
def ring_part(diameter, width, balls):
    """Radius of a circle as large as the part of a ring that belongs to one ball, m."""
    return math.sqrt(diameter * width / balls)


@kernel_tuple
class ThermalContact(NamedTuple):
    """Constants of the heat flow through one race's contact with a ball."""

    along: float  # semi-axis in rolling direction at a load of 1 N, m/N^(1/3)
    across: float  # the other one
    radius_along: float  # relative radii Rx, Ry, m
    radius_across: float
    conductivity: float  # of both sides in series, 1/(1/k1 + 1/k2), W/(m.K)


@kernel
def thermal_contact(contact, radius_along, radius_across, ball_conductivity, ring_conductivity):
    """Constants of a Hertzian contact with relative radii Rx, Ry in m between conductivities in W/(m.K)."""
    along, across = hertz_axes(1.0, contact.radius, contact.modulus, contact.ellipse)
    return ThermalContact(
        0.5 * along, 0.5 * across, radius_along, radius_across, 1.0 / (1.0 / ball_conductivity + 1.0 / ring_conductivity)
    )


@kernel
def note_contact(contact, numbers):
    """A `ThermalContact` into an array, (5,)."""
    numbers[0], numbers[1], numbers[2] = contact.along, contact.across, contact.radius_along
    numbers[3], numbers[4] = contact.radius_across, contact.conductivity


@kernel
def noted_contact(numbers):
    """The `ThermalContact` of an array."""
    return ThermalContact(numbers[0], numbers[1], numbers[2], numbers[3], numbers[4])


@kernel
def bridged_resistance(width, cube_root, contact, ball):
    """Constriction on both sides of the contact and the gap beside it as far as it is up to `width` m wide, K/W.

    cube_root: of the load, N^(1/3).  ball: its `radius` in m and `conductivity`, for its spreading, or None. Without load and
    width the constriction is infinite.
    """
    along = math.sqrt((contact.along * cube_root) ** 2 + 2.0 * contact.radius_along * width)
    across = math.sqrt((contact.across * cube_root) ** 2 + 2.0 * contact.radius_across * width)
    if along == 0.0:
        return math.inf
    resistance = 1.0 / (4.0 * contact.conductivity * arithmetic_geometric_mean(along, across))
    if ball is not None:
        resistance += ball_spreading(along, across, ball.radius, ball.conductivity)
    return resistance


@kernel
def through_gap(resistance, low, high, closest, conductivity, cube_root, contact, ball):
    """(resistance of all within, constriction from there on) after the ladder from gap `low` to `high`, K/W.

    resistance: of what lies within the gap `low`, without the constriction that begins there; infinite where nothing touches.
    """
    span = math.log((high + closest) / (low + closest)) / RUNGS
    bridge = 2.0 * math.pi * math.sqrt(contact.radius_along * contact.radius_across) * conductivity * span
    left = bridged_resistance(low, cube_root, contact, ball)
    for n in range(RUNGS):
        width = (low + closest) * math.exp((n + 0.5) * span) - closest
        outer = bridged_resistance(width, cube_root, contact, ball)
        if resistance < math.inf:
            resistance = 1.0 / (bridge + 1.0 / (resistance + left - outer))
        elif bridge > 0.0:
            resistance = 1.0 / bridge
        left = outer
    outer = bridged_resistance(high, cube_root, contact, ball)
    return resistance + left - outer, outer


@kernel
def conductances_in_series(one, other):
    """Conductance of two conductances one after the other, W/K; 0 where one of them is 0."""
    return one * other / (one + other) if one > 0.0 and other > 0.0 else 0.0
