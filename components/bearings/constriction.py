"""Heat through small contacts: closed forms of thermal constriction, in SI units.

An isothermal ellipse of semi-axes a >= b on a half space of conductivity k, on one side:

    R = K(m) / (2 pi k a),  m = 1 - (b/a)²         (circle: 1 / (4 k a))

In a ball of radius r that is heated at one such spot and cooled at the opposite one, each spot's resistance grows by

    (ln(2 r / (a + b)) + 1/2) / (4 pi k r),

from the smooth part of the sphere's Neumann function, (1/s - 2 - ln(s + s²)) / (4 pi k r) with s = sin(half the angle),
averaged over the spot with the density of an isothermal ellipse (mean of ln(distance): ln((a + b)/2) + 2 ln 2 - 3/2). The
remainder is of order (a/r)² of the resistance: 0.1 % at a/r = 0.1.

A gap of two curved surfaces, x²/2Rx + y²/2Ry wide, lets through 2 pi k sqrt(Rx Ry) ln(widest/narrowest): equal steps of the
logarithm of its width carry equal heat.

Source: the constriction is classical (Carslaw & Jaeger; Yovanovich); ball and gap are derived here and held against finite
volumes in the tests.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from scipy.special import ellipkm1

from ..core.errors import BadInput
from ..core.kernels import kernel, kernel_tuple
from .hertz import PointContact


def constriction(major: float, minor: float, conductivity: float) -> float:
    """Resistance on one side of an isothermal ellipse with semi-axes in m on a half space (W/(m.K)), K/W."""
    if not (major >= minor > 0.0 and conductivity > 0.0):
        raise BadInput("thermal constriction", f"semi-axes {major:g} and {minor:g} m, conductivity {conductivity:g} W/(m.K)",
                       "major >= minor > 0 and a positive conductivity")
    return float(ellipkm1((minor / major) ** 2)) / (2.0 * math.pi * conductivity * major)


def ball_spreading(major: float, minor: float, radius: float, conductivity: float) -> float:
    """What a ball of `radius` m adds to the constriction at each of two opposite spots, K/W."""
    return (math.log(2.0 * radius / (major + minor)) + 0.5) / (4.0 * math.pi * conductivity * radius)


def flux_tube(ratio: float) -> float:
    """Constriction of an isothermal circle of `ratio` times the radius of an insulated cylinder, over that on a half space.

    (1 - ratio)^1.5 after Cooper, Mikic & Yovanovich (1969), recalled; within 1 % of the exact series for ratios up to 0.3.
    """
    return (1.0 - ratio) ** 1.5


@kernel_tuple
class ThermalContact(NamedTuple):
    """Constants of the heat flow through one race's contact with a ball."""

    conductance: float  # of both sides in series at a load of 1 N, W/(K.N^(1/3))
    mean_axis: float  # (a + b)/2 of the contact at a load of 1 N, m/N^(1/3)
    area: float  # of the contact at a load of 1 N, m2/N^(2/3)
    gap: float  # 2 pi sqrt(Rx Ry), m; times conductivity and ln(widest/narrowest): a gap's conductance


def thermal_contact(
    contact: PointContact, radii: tuple[float, float], ball_conductivity: float, ring_conductivity: float
) -> ThermalContact:
    """Constants of a Hertzian contact with relative radii (Rx, Ry) in m between conductivities in W/(m.K)."""
    short, long = (0.5 * axis for axis in contact.axes(1.0))
    resistance = constriction(long, short, ball_conductivity) + constriction(long, short, ring_conductivity)
    gap = 2.0 * math.pi * math.sqrt(math.prod(radii))
    return ThermalContact(1.0 / resistance, 0.5 * (short + long), math.pi * short * long, gap)


@kernel
def contact_conductance(load, contact):
    """Conductance of a contact under a load in N, W/K; 0 without load. Both semi-axes grow with the cube root of the load."""
    return contact.conductance * load ** (1.0 / 3.0) if load > 0.0 else 0.0


@kernel
def conductances_in_series(one, other):
    """Conductance of two conductances one after the other, W/K; 0 where one of them is 0."""
    return one * other / (one + other) if one > 0.0 and other > 0.0 else 0.0
