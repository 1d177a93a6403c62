"""Thickness of the elastohydrodynamic film in a point contact (Hamrock and Dowson), and the speed that draws it in.

    h = 2.69 Rx U^0.67 G^0.53 W^-0.067 (1 - 0.61 exp(-0.73 k))     in the middle of the contact
    h = 3.63 Rx U^0.68 G^0.49 W^-0.073 (1 - exp(-0.68 k))           where it is thinnest
    U = eta0 u / (E' Rx),  G = xi E',  W = Q / (E' Rx²)

with E' = 2 E* (see hertz.py) and k the ratio of the contact's axes. Isothermal, fully flooded, smooth surfaces.
Source: Hamrock & Dowson, J. Lubr. Technol. 99 (1977) 264-276, in the notation of Hamrock's textbook.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..core.errors import BadInput
from ..core.kernels import kernel, kernel_tuple
from .geometry import BallGeometry
from .hertz import PointContact

CENTRAL_EXPONENT, MINIMUM_EXPONENT = 0.67, 0.68  # of the speed


@kernel_tuple
class Lubricant(NamedTuple):
    """Oil at the contact's inlet."""

    viscosity: float  # Pa.s, at ambient pressure
    pressure_viscosity: float  # 1/Pa


@kernel
def mean_surface_speed(ball_diameter, pitch_diameter, rotation):
    """Mean speed of the surfaces of ball and race under pure rolling, m/s; rotation in rad/s, of the ring that turns."""
    return (pitch_diameter**2 - ball_diameter**2) / (4.0 * pitch_diameter) * abs(rotation)


@kernel
def film_height(contact, radius_x, load, speed, oil, thinnest):
    """Film in the middle of a contact, or where it is thinnest, m, for a load above 0; as `film_thickness`.

    oil: a `Lubricant`, or anything with its numbers.
    """
    k, modulus = contact.ellipse.k, contact.modulus
    u, g = oil.viscosity * speed / (modulus * radius_x), oil.pressure_viscosity * modulus
    w = load / (modulus * radius_x**2)
    if thinnest:
        return 3.63 * radius_x * u**MINIMUM_EXPONENT * g**0.49 * w**-0.073 * (1.0 - math.exp(-0.68 * k))
    return 2.69 * radius_x * u**CENTRAL_EXPONENT * g**0.53 * w**-0.067 * (1.0 - 0.61 * math.exp(-0.73 * k))


def entrainment_speed(geometry: BallGeometry, rotation: float) -> float:
    """Mean speed of the surfaces of ball and race under pure rolling, m/s; rotation in rad/s, of the ring that turns."""
    return mean_surface_speed(geometry.ball_diameter, geometry.pitch_diameter, rotation)


def film_thickness(
    contact: PointContact, radius_x: float, load: float, speed: float, oil: Lubricant, *, thinnest: bool = False
) -> float:
    """Film in the middle of a contact, or where it is thinnest, m; 0 at speed 0.

    radius_x: Rx of the contact in m.  load: N, above 0 (the film would be infinite, slowly, without one).  speed: m/s.
    """
    if not (load > 0.0 and speed >= 0.0):
        raise BadInput("film thickness", f"load {load:g} N, speed {speed:g} m/s", "a load above 0 and a speed of at least 0")
    return film_height(contact, radius_x, load, speed, oil, thinnest)
