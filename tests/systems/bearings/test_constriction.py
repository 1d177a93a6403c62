"""Closed forms of constriction against SciPy, series and finite volumes."""

import math

import numpy as np
import pytest
from cosimo.components.bearings.constriction import (
    arithmetic_geometric_mean,
    ball_spreading,
    bridged_resistance,
    conductances_in_series,
    constriction,
    finite_ring,
    thermal_contact,
    through_gap,
)
from cosimo.components.bearings.hertz import effective_modulus, point_contact
from cosimo.components.core.errors import BadInput
from scipy.special import ellipkm1, eval_legendre

STEEL = effective_modulus(2.07e11, 0.3, 2.07e11, 0.3)


def test_a_circle_is_one_over_four_k_a():
    assert constriction(2e-4, 2e-4, 46.0) == 1.0 / (4.0 * 46.0 * 2e-4)  # the mean of equal numbers is that number: no rounding


@pytest.mark.parametrize("ratio", [1.001, 2.0, 8.0, 1e3, 1e6])
def test_an_ellipse_is_the_elliptic_integral(ratio):
    """The classical form with SciPy's integral; both are good to a few roundings."""
    major, minor = 3e-4, 3e-4 / ratio
    expected = ellipkm1((minor / major) ** 2) / (2.0 * math.pi * 46.0 * major)
    assert constriction(major, minor, 46.0) == pytest.approx(expected, rel=1e-13)
    assert constriction(minor, major, 46.0) == constriction(major, minor, 46.0)


def test_a_slender_ellipse_tends_to_the_logarithm():
    """K = ln(4 a/b) + O((b/a)² ln): a/b = 1e4 leaves 1e-7."""
    assert constriction(1.0, 1e-4, 1.0) == pytest.approx(math.log(4e4) / (2.0 * math.pi), rel=1e-7)


def test_constriction_refuses_what_is_no_spot():
    for wrong in ((0.0, 1e-4, 46.0), (1e-4, -1e-4, 46.0), (1e-4, 1e-4, 0.0)):
        with pytest.raises(BadInput, match="semi-axes"):
            constriction(*wrong)


def test_the_mean_lies_between_its_numbers_and_is_homogeneous():
    for one, other in ((1.0, 2.0), (3.0, 1e-9), (1e-12, 1e12)):
        mean = arithmetic_geometric_mean(one, other)
        assert math.sqrt(one * other) <= mean <= 0.5 * (one + other)
        assert arithmetic_geometric_mean(7.0 * one, 7.0 * other) == pytest.approx(7.0 * mean, rel=1e-14)


def ball_by_series(ratio: float, terms: int = 40000) -> float:
    """Resistance times k r between two opposite caps of a ball, of angle asin(ratio), each with uniform flux; mean over the cap.

    T = sum over odd n of 2 g_n P_n / n, g_n the coefficients of the flux; the caps' flux is 1/(cap's area).
    """
    top = math.sqrt(1.0 - ratio**2)
    n = np.arange(1, terms, 2)
    # mean of P_n over the cap, (P_{n-1} - P_{n+1}) / ((2n + 1)(1 - cos)); flux and temperature are projected alike
    mean = (eval_legendre(n - 1, top) - eval_legendre(n + 1, top)) / ((2 * n + 1) * (1.0 - top))
    return float(np.sum(2.0 * (2 * n + 1) / n * mean**2) / (2.0 * math.pi))


@pytest.mark.first
@pytest.mark.parametrize("ratio", [0.02, 0.05, 0.1])
def test_a_ball_against_legendre_series(ratio):
    """The series has uniform flux instead of uniform temperature: 8/(3 pi²) instead of 1/4 for a disc, and ln(distance) has the
    mean ln a - 1/4 (uniform disc) instead of ln a + 2 ln 2 - 3/2. What is behind the spot itself must agree."""
    behind = 2.0 * ball_spreading(ratio, ratio, 1.0, 1.0)
    shift = 2.0 * ((2.0 * math.log(2.0) - 1.5) + 0.25) / (4.0 * math.pi)
    expected = ball_by_series(ratio) - 2.0 * 8.0 / (3.0 * math.pi**2 * ratio)
    # the truncated series (terms * ratio >> 1) and terms of order ratio: a few per mille of 1
    assert behind + shift == pytest.approx(expected, abs=0.15 * ratio)


def test_the_mean_logarithm_over_an_isothermal_disc():
    """2 ln 2 - 3/2 from points drawn with the density 1/(2 pi a sqrt(a² - r²)), projections of a sphere."""
    rng = np.random.default_rng(3)
    points = rng.normal(size=(2, 400000, 3))
    points /= np.linalg.norm(points, axis=2, keepdims=True)
    stretch = np.array([3.0, 1.0])  # an ellipse: the mean of ln(distance) is that of a circle of radius (a + b)/2
    logs = np.log(np.linalg.norm((points[0, :, :2] - points[1, :, :2]) * stretch, axis=1))
    # standard deviation 0.75 over sqrt(4e5) = 1.2e-3; four of them
    assert logs.mean() == pytest.approx(math.log(2.0) + 2.0 * math.log(2.0) - 1.5, abs=5e-3)


def contact(ratio=8.0):
    radii = 3.4e-3, 3.4e-3 * ratio
    return thermal_contact(point_contact(*radii, STEEL), *radii, 46.0, 23.0)


def test_a_contact_has_both_sides_in_series_and_grows_with_the_cube_root():
    hertz = point_contact(3.4e-3, 27.2e-3, STEEL)
    for load in (1e-3, 1.0, 500.0):
        b, a = (0.5 * axis for axis in hertz.axes(load))
        expected = constriction(a, b, 46.0) + constriction(a, b, 23.0)
        assert bridged_resistance(0.0, load ** (1 / 3), contact(), None) == pytest.approx(expected, rel=1e-13)  # roundings


def test_nothing_touches_without_load_and_width():
    assert bridged_resistance(0.0, 0.0, contact(), None) == math.inf
    assert bridged_resistance(1e-6, 0.0, contact(), None) < math.inf


def test_a_gap_that_conducts_nothing_leaves_the_constriction():
    bare = bridged_resistance(0.0, 5.0, contact(), None)
    inside, left = through_gap(0.0, 0.0, 1e-5, 1e-6, 1e-300, 5.0, contact(), None)
    assert inside + left == pytest.approx(bare, rel=1e-13)  # the ladder's differences add up to the whole: roundings


def test_a_gap_under_good_conductors_is_the_integral():
    """Where the solids cost nothing the unloaded gap conducts 2 pi k sqrt(Rx Ry) ln(1 + w/c)."""
    c = contact()._replace(conductivity=1e9)
    inside, left = through_gap(math.inf, 0.0, 2e-5, 1e-6, 0.026, 0.0, c, None)
    expected = 2.0 * math.pi * 0.026 * math.sqrt(c.radius_along * c.radius_across) * math.log(21.0)
    assert 1.0 / (inside + left) == pytest.approx(expected, rel=1e-5)  # 1e-9 of the solids against 0.026 of the gas, times 100


def test_a_gap_lies_between_nothing_and_all_in_parallel():
    c = contact()
    bare = bridged_resistance(0.0, 5.0, c, None)
    gap = 2.0 * math.pi * 0.026 * math.sqrt(c.radius_along * c.radius_across) * math.log(21.0)
    resistance = sum(through_gap(0.0, 0.0, 2e-5, 1e-6, 0.026, 5.0, c, None))
    assert 1.0 / (1.0 / bare + gap) < resistance < bare


@pytest.mark.parametrize("ball", [None, np.rec.array([(4e-3, 46.0)], names="radius, conductivity")[0]])
def test_two_ladders_are_one(ball):
    """From 0 to 5 and on to 20 um; the ladder's own step error is 0.1 %."""
    c = contact()
    once = sum(through_gap(0.0, 0.0, 2e-5, 1e-6, 0.1, 5.0, c, ball))
    inside, _ = through_gap(0.0, 0.0, 5e-6, 1e-6, 0.1, 5.0, c, ball)
    assert sum(through_gap(inside, 5e-6, 2e-5, 1e-6, 0.1, 5.0, c, ball)) == pytest.approx(once, rel=2e-3)


def test_conductances_in_series_are_safe_at_zero():
    assert conductances_in_series(0.0, 3.0) == 0.0
    assert conductances_in_series(0.0, 0.0) == 0.0
    assert conductances_in_series(2.0, 2.0) == 1.0


def test_a_finite_ring_takes_off_what_the_tube_says():
    """(1 - ratio)^1.5, the approximation of Cooper, Mikic and Yovanovich, has 1.5 where the exact series has 1.41."""
    a, b, k = 1e-4, 5e-3, 46.0
    exact = constriction(a, a, k) - finite_ring(b, k)
    assert exact == pytest.approx(constriction(a, a, k) * (1.0 - a / b) ** 1.5, rel=0.1 * a / b + (a / b) ** 2)
