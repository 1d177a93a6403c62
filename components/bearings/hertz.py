"""Elastic contact of two curved bodies at a point (Hertz), in SI units.

The ball is body 1. x is the rolling direction, y across it; the radii below are those of the relative curvature,
1/Rx = 1/r1x + 1/r2x, with a concave groove negative. E' = 2 / ((1 - nu1²)/E1 + (1 - nu2²)/E2) throughout, twice the E*
of contact mechanics: formulas of the two traditions differ by that factor and must not be mixed.
Source: Hertz's solution in the notation of Hamrock & Dowson; Brewe & Hamrock, J. Lubr. Technol. 99 (1977) 485-487.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..core.errors import BadInput

LARGEST_RATIO = 1e8  # of the radii: beyond it the contact is a line


def effective_modulus(modulus_1: float, poisson_1: float, modulus_2: float, poisson_2: float) -> float:
    """E' of two materials, Pa."""
    return 2.0 / ((1.0 - poisson_1**2) / modulus_1 + (1.0 - poisson_2**2) / modulus_2)


@dataclass(frozen=True)
class Ellipse:
    """Shape of the contact: k, the ratio of its axes (y over x), with the complete elliptic integrals of 1 - 1/k²."""

    k: float
    first: float  # F, of the first kind
    second: float  # E, of the second kind


def exact_ellipse(ratio: float) -> Ellipse:
    """The contact ellipse for Ry/Rx = ratio >= 1, solved to rounding."""
    from scipy.optimize import brentq  # here and below: a bearing that is given its stiffness does without SciPy

    _check_ratio(ratio)
    if ratio == 1.0:
        return Ellipse(1.0, 0.5 * math.pi, 0.5 * math.pi)

    def mismatch(log_k: float) -> float:
        shape = _ellipse(math.exp(log_k))
        # (k² E - F) / (F - E) is the ratio of the radii; both differences are positive for k > 1
        return math.log((shape.k**2 * shape.second - shape.first) / (shape.first - shape.second)) - math.log(ratio)

    # k lies between ratio^(1/2) and ratio; just above a circle the quotient is 0/0, where k = ratio^(2/3) to first order
    if ratio < 1.0 + 1e-6:
        return _ellipse(ratio ** (2.0 / 3.0))
    return _ellipse(math.exp(brentq(mismatch, 0.4 * math.log(ratio), math.log(ratio), xtol=1e-14, rtol=1e-14)))


def brewe_hamrock(ratio: float) -> Ellipse:
    """Closed-form fit of 1977 for Ry/Rx = ratio >= 1.

    Contact stiffness against the exact solution: +8.7 % at 1, +1.9 % at 2, -0.7 % at 5 and 10, +1.6 % at 32, +5.9 % at 100.
    """
    _check_ratio(ratio)
    return Ellipse(1.0339 * ratio**0.6360, 1.5277 + 0.6023 * math.log(ratio), 1.0003 + 0.5968 / ratio)


def _ellipse(k: float) -> Ellipse:
    from scipy.special import ellipe, ellipkm1

    return Ellipse(k, float(ellipkm1(1.0 / k**2)), float(ellipe(1.0 - 1.0 / k**2)))


def _check_ratio(ratio: float) -> None:
    if not 1.0 <= ratio <= LARGEST_RATIO:
        raise BadInput("Hertz contact", f"Ry/Rx = {ratio:.6g}", f"a ratio in [1, {LARGEST_RATIO:g}]",
                       "Exchange x and y if the ratio is below 1.")


@dataclass(frozen=True)
class PointContact:
    """A Hertzian point contact: Q = K delta^1.5."""

    radius: float  # m, R with 1/R = 1/Rx + 1/Ry
    modulus: float  # Pa, E'
    ellipse: Ellipse

    @property
    def stiffness(self) -> float:
        """K, N/m^1.5. 1 N/mm^1.5 is 10^4.5 N/m^1.5."""
        k, first, second = self.ellipse.k, self.ellipse.first, self.ellipse.second
        return math.pi * k * self.modulus * math.sqrt(self.radius * second / (4.5 * first**3))

    def deflection(self, load: float) -> float:
        """Approach of the two bodies under a load in N, m; 0 without load."""
        return (max(load, 0.0) / self.stiffness) ** (2.0 / 3.0)

    def axes(self, load: float) -> tuple[float, float]:
        """Full axes of the contact ellipse in x and in y under a load in N, m."""
        k = self.ellipse.k
        long = 2.0 * (6.0 * k**2 * self.ellipse.second * max(load, 0.0) * self.radius / (math.pi * self.modulus)) ** (1.0 / 3.0)
        return long / k, long

    def peak_pressure(self, load: float) -> float:
        """Pressure in the middle of the contact, Pa; 0 without load."""
        if load <= 0.0:
            return 0.0
        across, along = self.axes(load)
        return 6.0 * load / (math.pi * across * along)


def point_contact(radius_x: float, radius_y: float, modulus: float, ellipse=exact_ellipse) -> PointContact:
    """The contact of relative radii Rx <= Ry (m) and E' (Pa); `ellipse`: `exact_ellipse` or `brewe_hamrock`."""
    if not (radius_x > 0.0 and radius_y > 0.0 and modulus > 0.0):
        raise BadInput("Hertz contact", f"Rx = {radius_x:g} m, Ry = {radius_y:g} m, E' = {modulus:g} Pa", "positive values",
                       "A groove must be wider than the ball.")
    return PointContact(1.0 / (1.0 / radius_x + 1.0 / radius_y), modulus, ellipse(radius_y / radius_x))


def in_series(*stiffness: float) -> float:
    """Stiffness of contacts that carry the same load one after the other, N/m^1.5."""
    return sum(k ** (-2.0 / 3.0) for k in stiffness) ** -1.5
