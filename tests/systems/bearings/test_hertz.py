"""Hertz contact and ball bearing geometry against textbook numbers, limits, and the commonest mistakes of the field."""

import math

import pytest
from cosimo.components.bearings.geometry import BallGeometry
from cosimo.components.bearings.hertz import brewe_hamrock, effective_modulus, exact_ellipse, in_series, point_contact
from cosimo.components.core.errors import BadInput

PRINTED = 1e-4  # the reference numbers have five digits
STEEL = effective_modulus(2.06e11, 0.3, 2.06e11, 0.3)


@pytest.mark.parametrize(
    ("ratio", "k", "second", "first"),
    [
        (1.0001, 1.00007, 1.57074, 1.57085),
        (2.0, 1.58580, 1.29715, 1.95211),
        (5.0, 2.89018, 1.12052, 2.49374),
        (10.0, 4.49945, 1.05988, 2.91420),
        (32.35, 9.29127, 1.01811, 3.62299),
        (100.0, 18.1871, 1.00573, 4.28950),
    ],
)
def test_exact_ellipse_against_an_independent_solution(ratio, k, second, first):
    shape = exact_ellipse(ratio)
    assert (shape.k, shape.second, shape.first) == pytest.approx((k, second, first), rel=1e-5)


@pytest.mark.parametrize(
    ("ratio", "k", "integral"),
    [(1.0 + 1e-9, 6.66666721715803e-10, 5.2359881870e-10), (1.0 + 5e-7, 3.33333305602154e-7, 2.61799293e-7)],
)
def test_nearly_round_ellipse_against_sixty_digits(ratio, k, integral):
    """The same equation solved with 60 digits of the ratio's double: k - 1, and how far F and E are from pi/2 to either side."""
    shape = exact_ellipse(ratio)
    # one unit of the last place of k and of pi/2
    assert shape.k - 1.0 == pytest.approx(k, abs=3e-16)
    assert shape.first - 0.5 * math.pi == pytest.approx(integral, abs=4e-16 + 1e-6 * integral)
    assert 0.5 * math.pi - shape.second == pytest.approx(integral, abs=4e-16 + 1e-6 * integral)


@pytest.mark.parametrize("ratio", [1.0 + 2e-6, 1.3, 30.0, 1e6])
def test_exact_ellipse_solves_its_equation(ratio):
    """Ry/Rx = (k² E - F) / (F - E), the condition that both principal curvatures fit."""
    shape = exact_ellipse(ratio)
    found = (shape.k**2 * shape.second - shape.first) / (shape.first - shape.second)
    # near a circle both differences lose digits: rounding over (k - 1)
    assert found == pytest.approx(ratio, rel=1e-12 + 1e-15 / (ratio - 1.0))


@pytest.mark.parametrize(
    ("ratio", "error"), [(1.0001, 8.69), (2.0, 1.92), (5.0, -0.67), (10.0, -0.63), (32.35, 1.64), (100.0, 5.93)]
)
def test_the_fit_errs_as_its_docstring_says(ratio, error):
    fit, exact = (point_contact(1.0, ratio, STEEL, ellipse).stiffness for ellipse in (brewe_hamrock, exact_ellipse))
    assert 100.0 * (fit / exact - 1.0) == pytest.approx(error, abs=0.01)


def test_sphere_on_sphere_is_the_circular_limit():
    """K = 4/3 E* sqrt(r) with E* = E'/2 and 1/r = 1/r1 + 1/r2; the approach (9 Q² / (16 E*² r))^(1/3)."""
    radius = 1.0 / (1.0 / 0.01 + 1.0 / 0.03)
    contact, e_star = point_contact(radius, radius, STEEL), 0.5 * STEEL
    assert contact.stiffness == pytest.approx(4.0 / 3.0 * e_star * math.sqrt(radius), rel=1e-12)
    assert contact.deflection(50.0) == pytest.approx((9.0 * 50.0**2 / (16.0 * e_star**2 * radius)) ** (1.0 / 3.0), rel=1e-12)
    across, along = contact.axes(50.0)
    assert across == along == pytest.approx(2.0 * (3.0 * 50.0 * radius / (4.0 * e_star)) ** (1.0 / 3.0), rel=1e-12)
    assert contact.peak_pressure(50.0) == pytest.approx(1.5 * 50.0 / (math.pi * 0.25 * across * along), rel=1e-12)


@pytest.mark.parametrize("load", [0.0, -5.0])
def test_no_load_no_contact_and_no_nan(load):
    contact = point_contact(0.005, 0.1, STEEL)
    assert (contact.deflection(load), contact.axes(load), contact.peak_pressure(load)) == (0.0, (0.0, 0.0), 0.0)


def test_lubrication_textbook_bearing():
    """Hamrock and Dowson's example: d = 12.7 mm, races of 52.291 and 77.706 mm, grooves of 6.604 mm, E = 200 GPa."""
    modulus = effective_modulus(2e11, 0.3, 2e11, 0.3)
    bearing = BallGeometry(9, 0.0127, 0.5 * (0.052291 + 0.077706), 0.52, 0.52)
    inner, outer = (bearing.contact(race, modulus) for race in ("inner", "outer"))
    assert (inner.ellipse.k, inner.ellipse.second, inner.ellipse.first) == pytest.approx((9.285, 1.0181, 3.6223), rel=PRINTED)
    assert (inner.stiffness, outer.stiffness) == pytest.approx((3.1138e10, 3.2921e10), rel=PRINTED)
    assert bearing.stiffness(modulus) == pytest.approx(1.13168e10, rel=PRINTED)
    across, along = inner.axes(4944.0)
    assert (1e3 * along, 1e3 * across) == pytest.approx((5.308, 0.572), rel=1e-3)
    assert inner.peak_pressure(4944.0) == pytest.approx(3.11e9, rel=2e-3)
    assert inner.deflection(4944.0) == pytest.approx(29.32e-6, rel=3e-4)


@pytest.mark.parametrize(
    ("bearing", "sums"),
    [
        (BallGeometry(9, 0.0127, 0.065, 0.52, 0.52), ((0.2018, 0.9400), (0.1378, 0.9121))),
        (BallGeometry(16, 0.022225, 0.12526, 0.5232, 0.5232, math.radians(40.0)), ((0.1081, 0.9262), (0.0832, 0.9041))),
    ],
    ids=["Harris 209", "Harris 218"],
)
def test_curvature_sums_of_textbook_bearings(bearing, sums):
    for race, (total, difference) in zip(("inner", "outer"), sums, strict=True):
        found = bearing.curvature(race)
        assert (1e-3 * found[0], found[1]) == pytest.approx((total, difference), abs=6e-5)  # four printed decimals


def test_mistake_one_e_prime_is_twice_e_star():
    """A contact computed with E* in place of E' is half as stiff."""
    contact = point_contact(0.005, 0.1, STEEL).stiffness
    e_star = 1.0 / (2.0 * (1.0 - 0.3**2) / 2.06e11)
    assert pytest.approx(2.264e11, rel=2e-4) == STEEL  # four printed digits
    assert pytest.approx(0.5 * STEEL, rel=1e-12) == e_star
    assert point_contact(0.005, 0.1, e_star).stiffness == pytest.approx(0.5 * contact, rel=1e-12)


def test_mistake_two_newton_per_millimetre_to_the_three_halves():
    """Harris 209 with E = 206.85 GPa: 1.1704e10 N/m^1.5 are 3.701e5 N/mm^1.5, a factor of 10^4.5 and not of 10^3."""
    stiffness = BallGeometry(9, 0.0127, 0.065).stiffness(effective_modulus(2.0685e11, 0.3, 2.0685e11, 0.3))
    assert stiffness == pytest.approx(1.1704e10, rel=PRINTED)
    assert stiffness / 10.0**4.5 == pytest.approx(3.701e5, rel=PRINTED)


def test_contacts_in_series_share_the_load_and_add_their_deflections():
    inner, outer = 3.1e10, 3.3e10
    load = 800.0
    both = in_series(inner, outer)
    assert (load / both) ** (2 / 3) == pytest.approx((load / inner) ** (2 / 3) + (load / outer) ** (2 / 3), rel=1e-12)


def test_defect_frequencies():
    """Deep groove bearing 6205 with 9 balls of 7.94 mm on 39.04 mm: public multiples of the shaft speed, and identities."""
    bearing = BallGeometry(9, 7.94e-3, 39.04e-3)
    found = bearing.defect_frequencies(1.0)
    lines = (found["inner"], found["outer"], found["cage"], 2.0 * found["ball"])
    assert lines == pytest.approx((5.4152, 3.5848, 0.39828, 4.7135), rel=PRINTED)
    assert found["inner"] + found["outer"] == pytest.approx(9.0, rel=1e-14)
    assert found["outer"] == pytest.approx(9.0 * found["cage"], rel=1e-14)


@pytest.mark.parametrize(
    "build",
    [
        lambda: BallGeometry(0, 0.01, 0.05),
        lambda: BallGeometry(9, 0.06, 0.05),
        lambda: BallGeometry(9, 0.01, 0.05, inner_conformity=0.5),
        lambda: exact_ellipse(0.5),
        lambda: exact_ellipse(float("nan")),
        lambda: point_contact(-0.01, 0.1, STEEL),
    ],
)
def test_impossible_bearings_are_refused(build):
    with pytest.raises(BadInput):
        build()
