"""Film thickness against the textbook example and the limits of the formula."""

import pytest
from cosimo.components.bearings.film import Lubricant, entrainment_speed, film_thickness
from cosimo.components.bearings.geometry import BallGeometry
from cosimo.components.bearings.hertz import effective_modulus
from cosimo.components.core.errors import BadInput

OIL = Lubricant(0.04, 2.3e-8)
STEEL = effective_modulus(2e11, 0.3, 2e11, 0.3)
TEXTBOOK = BallGeometry(9, 0.0127, 0.5 * (0.052291 + 0.077706), 0.52, 0.52)


def film(race, load=4944.0, speed=6.2517, **more):
    """Film of the textbook's bearing, m."""
    return film_thickness(TEXTBOOK.contact(race, STEEL), TEXTBOOK.radii(race)[0], load, speed, OIL, **more)


def test_textbook_bearing():
    """Hamrock and Dowson's example at 400 rad/s under 4944 N a ball; four digits of an independent computation."""
    assert entrainment_speed(TEXTBOOK, 400.0) == pytest.approx(6.2517, rel=1e-4)
    assert entrainment_speed(TEXTBOOK, -400.0) == entrainment_speed(TEXTBOOK, 400.0)
    assert (1e6 * film("inner"), 1e6 * film("outer")) == pytest.approx((0.6904, 0.8277), rel=2e-4)
    thinnest = [1e6 * film(race, thinnest=True) for race in ("inner", "outer")]
    assert thinnest == pytest.approx([0.5527, 0.6612], rel=2e-4)


@pytest.mark.parametrize(("thinnest", "by_speed", "by_load"), [(False, 0.67, -0.067), (True, 0.68, -0.073)])
def test_exponents_of_speed_and_load(thinnest, by_speed, by_load):
    once = film("inner", thinnest=thinnest)
    assert film("inner", speed=2.0 * 6.2517, thinnest=thinnest) / once == pytest.approx(2.0**by_speed, rel=1e-12)
    assert film("inner", load=2.0 * 4944.0, thinnest=thinnest) / once == pytest.approx(2.0**by_load, rel=1e-12)


def test_no_speed_no_film():
    assert film("inner", speed=0.0) == film("outer", speed=0.0, thinnest=True) == 0.0


@pytest.mark.parametrize(("load", "speed"), [(0.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (float("nan"), 1.0)])
def test_what_the_formula_does_not_cover_is_refused(load, speed):
    with pytest.raises(BadInput):
        film("inner", load, speed)
