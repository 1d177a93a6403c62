"""Elastic contact of two curved bodies at a point (Hertz), in SI units.

The ball is body 1. x is the rolling direction, y across it; the radii below are those of the relative curvature,
1/Rx = 1/r1x + 1/r2x, with a concave groove negative. E' = 2 / ((1 - nu1²)/E1 + (1 - nu2²)/E2) throughout, twice the E*
of contact mechanics: formulas of the two traditions differ by that factor and must not be mixed.

The kernels take what they are given; the functions for Python beside them refuse radii for which there is no such contact.
Source: Hertz's solution in the notation of Hamrock & Dowson; Brewe & Hamrock, J. Lubr. Technol. 99 (1977) 485-487.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..core.errors import BadInput
from ..core.kernels import kernel, kernel_tuple

LARGEST_RATIO = 1e8  # of the radii: beyond it the contact is a line
NEARLY_ROUND = 1e-6  # above a ratio of 1, below which the equation of the ellipse is 0/0
ITERATIONS = 30  # of Newton's method for the ellipse; nine have been enough for every ratio


@kernel_tuple
class Ellipse(NamedTuple):
    """Shape of the contact: k, the ratio of its axes (y over x), with the complete elliptic integrals of 1 - 1/k²."""

    k: float
    first: float  # F, of the first kind
    second: float  # E, of the second kind


@kernel
def effective_modulus(modulus_1, poisson_1, modulus_2, poisson_2):
    """E' of two materials, Pa."""
    return 2.0 / ((1.0 - poisson_1**2) / modulus_1 + (1.0 - poisson_2**2) / modulus_2)


@kernel
def complete_elliptic(m1):
    """Complete elliptic integrals (K, E) of the parameter m = 1 - m1, for 0 < m1 <= 1; m1 is given, for m close to 1 loses it.

    By the arithmetic-geometric mean. Source: Abramowitz & Stegun, Handbook of Mathematical Functions, 17.6.
    """
    a, b, total, weight = 1.0, math.sqrt(m1), 0.5 * (1.0 - m1), 0.5
    for _ in range(40):
        c = 0.5 * (a - b)
        a, b = 0.5 * (a + b), math.sqrt(a * b)
        weight *= 2.0
        total += weight * c * c
        if not abs(c) > 1e-17 * a:
            break
    first = 0.5 * math.pi / a
    return first, first * (1.0 - total)


@kernel
def ellipse_of(k):
    """The contact ellipse whose axes have the ratio k >= 1."""
    first, second = complete_elliptic(1.0 / k**2)
    return Ellipse(k, first, second)


@kernel
def solved_ellipse(ratio):
    """The contact ellipse for Ry/Rx = ratio >= 1, to rounding.

    (k² E - F) / (F - E) is the ratio of the radii; both differences are positive for k > 1. Over ln k their derivatives are
    2 k² E - F and E, and the logarithm of the quotient is nearly a straight line: Newton's method, from ratio^(2/3), which is
    right near a circle.
    """
    k = ratio ** (2.0 / 3.0)
    if ratio < 1.0 + NEARLY_ROUND:
        return ellipse_of(k)
    low, high, wanted = 0.4 * math.log(ratio), math.log(ratio), math.log(ratio)  # k lies between ratio^(1/2) and ratio
    log_k, last = math.log(k), math.inf
    for _ in range(ITERATIONS):
        shape = ellipse_of(math.exp(log_k))
        squared = shape.k**2 * shape.second
        top, bottom = squared - shape.first, shape.first - shape.second
        step = (wanted - math.log(top / bottom)) / ((squared + top) / top - shape.second / bottom)
        if not abs(step) < last:  # the rest is rounding
            break
        log_k, last = min(max(log_k + step, low), high), abs(step)
    return ellipse_of(math.exp(log_k))


@kernel
def fitted_ellipse(ratio):
    """The closed-form fit of Brewe and Hamrock for Ry/Rx = ratio >= 1; see `brewe_hamrock`."""
    return Ellipse(1.0339 * ratio**0.6360, 1.5277 + 0.6023 * math.log(ratio), 1.0003 + 0.5968 / ratio)


@kernel
def hertz_stiffness(radius, modulus, ellipse):
    """K of Q = K delta^1.5 in N/m^1.5. radius: R with 1/R = 1/Rx + 1/Ry, m; modulus: E', Pa. 1 N/mm^1.5 is 10^4.5 N/m^1.5."""
    k, first, second = ellipse.k, ellipse.first, ellipse.second
    return math.pi * k * modulus * math.sqrt(radius * second / (4.5 * first**3))


@kernel
def hertz_axes(load, radius, modulus, ellipse):
    """Full axes of the contact ellipse in x and in y under a load in N, m."""
    k = ellipse.k
    long = 2.0 * (6.0 * k**2 * ellipse.second * max(load, 0.0) * radius / (math.pi * modulus)) ** (1.0 / 3.0)
    return long / k, long


@kernel
def two_in_series(one, other):
    """Stiffness of two contacts that carry the same load one after the other, N/m^1.5."""
    return (one ** (-2.0 / 3.0) + other ** (-2.0 / 3.0)) ** -1.5


def exact_ellipse(ratio: float) -> Ellipse:
    """The contact ellipse for Ry/Rx = ratio >= 1, solved to rounding."""
    return solved_ellipse(_checked_ratio(ratio))


def brewe_hamrock(ratio: float) -> Ellipse:
    """Closed-form fit of 1977 for Ry/Rx = ratio >= 1.

    Contact stiffness against the exact solution: +8.7 % at 1, +1.9 % at 2, -0.7 % at 5 and 10, +1.6 % at 32, +5.9 % at 100.
    """
    return fitted_ellipse(_checked_ratio(ratio))


def _checked_ratio(ratio: float) -> float:
    if not 1.0 <= ratio <= LARGEST_RATIO:
        raise BadInput(
            "Hertz contact",
            f"Ry/Rx = {ratio:.6g}",
            f"a ratio in [1, {LARGEST_RATIO:g}]",
            "Exchange x and y if the ratio is below 1.",
        )
    return float(ratio)


@kernel_tuple
class PointContact(NamedTuple):
    """A Hertzian point contact: Q = K delta^1.5."""

    radius: float  # m, R with 1/R = 1/Rx + 1/Ry
    modulus: float  # Pa, E'
    ellipse: Ellipse

    @property
    def stiffness(self) -> float:
        """K, N/m^1.5. 1 N/mm^1.5 is 10^4.5 N/m^1.5."""
        return hertz_stiffness(*self)

    def deflection(self, load: float) -> float:
        """Approach of the two bodies under a load in N, m; 0 without load."""
        return (max(load, 0.0) / self.stiffness) ** (2.0 / 3.0)

    def axes(self, load: float) -> tuple[float, float]:
        """Full axes of the contact ellipse in x and in y under a load in N, m."""
        return hertz_axes(load, *self)

    def peak_pressure(self, load: float) -> float:
        """Pressure in the middle of the contact, Pa; 0 without load."""
        if load <= 0.0:
            return 0.0
        across, along = self.axes(load)
        return 6.0 * load / (math.pi * across * along)


def point_contact(radius_x: float, radius_y: float, modulus: float, ellipse=exact_ellipse) -> PointContact:
    """The contact of relative radii Rx <= Ry (m) and E' (Pa); `ellipse`: `exact_ellipse` or `brewe_hamrock`."""
    if not (radius_x > 0.0 and radius_y > 0.0 and modulus > 0.0):
        raise BadInput(
            "Hertz contact",
            f"Rx = {radius_x:g} m, Ry = {radius_y:g} m, E' = {modulus:g} Pa",
            "positive values",
            "A groove must be wider than the ball.",
        )
    return PointContact(1.0 / (1.0 / radius_x + 1.0 / radius_y), modulus, ellipse(radius_y / radius_x))


def in_series(*stiffness: float) -> float:
    """Stiffness of contacts that carry the same load one after the other, N/m^1.5."""
    return sum(k ** (-2.0 / 3.0) for k in stiffness) ** -1.5
