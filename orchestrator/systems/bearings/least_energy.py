"""Reference for a bearing under both loads: the inner ring where its energy is least, by SciPy, with SciPy's elliptic integrals.

Used by the validation case paper-thermal-resistance, by no component. Grooves of radius f d whose centres are A apart without
load; a ring that does not tilt moves by (radial, axial), and a ball at psi is squeezed by how much its centres come further apart:

    s(psi) = |(A cos alpha + radial cos psi, A sin alpha + axial)| - A,   energy = sum 2/5 K max(s, 0)^2.5 - Fr radial - Fa axial.

The contact angle is free, and each ball has its own. Hertz's ellipse of each contact and its constriction follow from the ball's load.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, root
from scipy.special import ellipe, ellipkm1


class Bearing(NamedTuple):
    """Dimensions in m, angle in rad, conductivity of balls and rings in W/(m.K), E' in Pa (of two bodies: E / (1 - nu²))."""

    balls: int
    ball: float
    pitch: float
    inner: float  # groove radius over ball diameter
    outer: float
    angle: float
    modulus: float
    conductivity: float


class Contact(NamedTuple):
    """Stiffness in N/m^1.5, constriction on both sides of it at 1 N in K/W; the latter falls with the cube root of the load."""

    stiffness: float
    constriction: float


@cache
def contact(bearing: Bearing, race: str) -> Contact:
    """Hertz's solution of a ball in a groove, from the radii of curvature."""
    gamma = bearing.ball * math.cos(bearing.angle) / bearing.pitch
    conformity, sign = (bearing.inner, 1.0) if race == "inner" else (bearing.outer, -1.0)
    rolling = 1.0 / (2.0 / bearing.ball + sign * 2.0 * gamma / (bearing.ball * (1.0 - sign * gamma)))
    across = 1.0 / (2.0 / bearing.ball - 1.0 / (conformity * bearing.ball))

    def curvature(ratio: float) -> float:
        """Ry/Rx that an ellipse with minor over major axis of `ratio` belongs to, less the given one."""
        k, e = ellipkm1(ratio**2), ellipe(1.0 - ratio**2)
        return (e / ratio**2 - k) / (k - e) - across / rolling

    ratio = brentq(curvature, 1e-3, 1.0 - 1e-9, xtol=1e-14)
    k, e = ellipkm1(ratio**2), ellipe(1.0 - ratio**2)
    radius = 1.0 / (1.0 / rolling + 1.0 / across)
    # half-axes at 1 N: major³ = 3 E(m) R / (pi ratio² E'), with 2 / E' = 2 (1 - nu²) / E for two like bodies
    major = (3.0 * e * radius / (math.pi * ratio**2 * 0.5 * bearing.modulus)) ** (1.0 / 3.0)
    approach = 3.0 * k / (2.0 * math.pi * major * 0.5 * bearing.modulus)
    return Contact(approach**-1.5, 2.0 * k / (2.0 * math.pi * bearing.conductivity * major))


def loads(bearing: Bearing, axial: float, radial: float) -> np.ndarray:
    """Loads of the balls in N where the energy is least, (Z,), the first ball on the load line; forces in N."""
    distance = (bearing.inner + bearing.outer - 1.0) * bearing.ball
    stiffness = sum(contact(bearing, race).stiffness ** (-2.0 / 3.0) for race in ("inner", "outer")) ** -1.5
    cosine = np.cos(2.0 * math.pi * np.arange(bearing.balls) / bearing.balls)
    total = axial + radial
    scale = (total / stiffness) ** (2.0 / 3.0)

    def squeezed(moved: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        across = distance * math.cos(bearing.angle) + scale * moved[0] * cosine
        along = distance * math.sin(bearing.angle) + scale * moved[1]
        stretched = np.hypot(across, along)
        return stiffness * np.maximum(stretched - distance, 0.0) ** 1.5, across / stretched, along / stretched

    def slope(moved: np.ndarray) -> np.ndarray:
        """Gradient of the energy over the forces."""
        load, across, along = squeezed(moved)
        return np.array([load @ (across * cosine) - radial, (load * along).sum() - axial]) / total

    # along a growing radial force: the start of each is the end of the last
    place, wanted = np.array([0.0, 1.0]), radial
    for share in np.linspace(0.0, 1.0, 9 if radial else 1):
        radial = share * wanted
        answer = root(slope, place, tol=1e-13)
        place = answer.x
    radial = wanted
    if not np.abs(slope(place)).max() <= 1e-9:  # nor not a number
        raise ArithmeticError(f"no equilibrium under {axial:g} N axial and {radial:g} N radial")
    return squeezed(place)[0]


def resistance(bearing: Bearing, axial: float, radial: float) -> float:
    """Resistance of the contacts from ring to ring in K/W: two in each ball, balls in parallel."""
    both = sum(contact(bearing, race).constriction for race in ("inner", "outer"))
    return both / float(np.cbrt(loads(bearing, axial, radial)).sum())


def exponent(bearing: Bearing, axial: float, ratio: float, step: float = 0.02) -> float:
    """-d ln R / d ln F at a fixed ratio of radial to axial load, by a central difference."""
    ends = [resistance(bearing, f * axial, f * ratio * axial) for f in (math.exp(-step), math.exp(step))]
    return math.log(ends[0] / ends[1]) / (2.0 * step)
