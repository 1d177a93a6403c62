"""The pipe along its way: the table at its places, no overshoot, the taper as the derivative, constant ends."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.components.pipe_robot.route import PipeRoute
from cosimo.tests.support import initialized
from scipy.interpolate import PchipInterpolator

pytestmark = pytest.mark.interpreted

PLACES = (0.0, 0.5, 1.5, 2.0, 4.0, 4.5, 6.0, 7.0)
DIAMETERS = (0.2, 0.2, 0.19, 0.18, 0.18, 0.21, 0.2, 0.2)
SLOPES = (0.0, 0.1, 0.2, 0.3, 0.2, 0.0, -0.1, 0.0)


def table(name: str, values) -> dict[str, float]:
    return {f"{name}[{i + 1}]": v for i, v in enumerate(values)}


def route(**more) -> PipeRoute:
    return initialized(
        PipeRoute(parameters=table("place", PLACES) | table("diameter_table", DIAMETERS) | table("slope_table", SLOPES) | more)
    )


def at(unit: PipeRoute, position: float, name: str) -> float:
    unit.set("position", position)
    unit.refresh()
    return unit[name]


def test_the_table_is_met_at_its_places():
    unit = route(**table("factor_table", (1.0, 0.5, 0.5, 1.0, 2.0, 1.0, 1.0, 1.0)))
    for place, diameter, slope in zip(PLACES, DIAMETERS, SLOPES, strict=True):
        assert at(unit, place, "diameter") == pytest.approx(diameter, rel=1e-15)
        assert at(unit, place, "slope") == pytest.approx(slope, abs=1e-16)
    assert at(unit, 4.0, "friction_factor") == pytest.approx(2.0, rel=1e-15)
    assert at(unit, 0.9, "friction_factor") == pytest.approx(0.5, rel=1e-15)


def test_it_does_not_overshoot_and_stays_constant_outside():
    unit = route()
    inside = np.linspace(-1.0, 8.0, 901)
    diameters = np.array([at(unit, x, "diameter") for x in inside])
    assert diameters.min() >= 0.18 - 1e-16
    assert diameters.max() <= 0.21 + 1e-16
    assert at(unit, -50.0, "diameter") == at(unit, 0.0, "diameter")
    assert at(unit, 50.0, "slope") == at(unit, 7.0, "slope")
    assert at(unit, -50.0, "taper") == at(unit, 50.0, "taper") == 0.0


def test_the_taper_is_the_derivative_of_the_diameter_and_continuous():
    unit, d = route(), 1e-5
    for x in [*np.linspace(-0.2, 7.2, 75), *PLACES]:
        difference = (at(unit, x + d, "diameter") - at(unit, x - d, "diameter")) / (2.0 * d)
        # across a place the second derivative jumps by up to 6 * 0.03 / 0.25: half of it times d
        assert at(unit, x, "taper") == pytest.approx(difference, abs=0.5 * d)


def test_between_the_places_it_is_the_cubic_of_fritsch_and_butland():
    """As scipy has it but for the ends, where this one is level; slopes of the table that change their sign, too."""
    unit = route()
    diameter, slope = PchipInterpolator(PLACES, DIAMETERS), PchipInterpolator(PLACES, SLOPES)
    for x in np.linspace(0.5, 6.0, 111):
        assert at(unit, x, "diameter") == pytest.approx(diameter(x), rel=1e-13)
        assert at(unit, x, "taper") == pytest.approx(diameter(x, 1), abs=1e-14)
        assert at(unit, x, "slope") == pytest.approx(slope(x), abs=1e-14)


def test_a_cone_is_one():
    """Between places of one straight line, ends apart, the cubic is that line."""
    unit = route(**table("diameter_table", 0.2 - 0.01 * np.array(PLACES)))
    for x in np.linspace(0.5, 6.0, 23):
        assert at(unit, x, "diameter") == pytest.approx(0.2 - 0.01 * x, rel=1e-14)
        assert at(unit, x, "taper") == pytest.approx(-0.01, rel=1e-12)


@pytest.mark.known_answers(PipeRoute="route_table")
def test_a_survey_of_any_length_is_the_cubic_of_scipy_between_its_level_ends():
    x = np.round(np.concatenate([[0.0, 0.001], np.linspace(0.5, 20.0, 38), [20.5, 20.501]]), 6)
    d = np.round(0.2 + 0.01 * np.sin(x), 9)
    d[1], d[-1] = d[0], d[-2]  # level ends, where SciPy's slopes are others
    rows = "".join(f"{a:.6f};{1e3 * b:.6f};{5.0 * np.cos(a):.9f}\n" for a, b in zip(x, d, strict=True))
    unit = PipeRoute(["route_table"], {"route_table.table": f"position [m];diameter [mm];slope [deg]\n{rows}"})
    unit.initialize(0.0)
    cubic = PchipInterpolator(x, d)
    for place in np.linspace(0.5, 20.0, 301):
        assert at(unit, place, "diameter") == pytest.approx(float(cubic(place)), abs=1e-15)
        assert at(unit, place, "friction_factor") == 1.0
    assert at(unit, x[7], "slope") == pytest.approx(np.radians(5.0 * np.cos(x[7])), abs=1e-10)


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ("position [m],slope [deg]\n0,1\n1,2\n", "no column 'diameter'"),
        ("position [m],diameter [mm]\n0,200\n0,210\n", "position 0 behind 0"),
        ("position [m],diameter [mm]\n0,200\n1,-210\n", "a diameter of -0.21 m"),
        ("position [m],diameter [mm],friction_factor\n0,200,1\n1,210,-1\n", "a friction factor of -1"),
        ("position [m],diameter [mm],slope [rad]\n0,200,0\n1,210,8\n", "a slope of 8 rad"),
        ("position [m],diameter [mm],bend\n0,200,1\n1,210,1\n", "column 'bend'"),
    ],
)
def test_a_survey_that_cannot_be_used_is_one_message(table, expected):
    with pytest.raises(BadInput, match=expected):
        PipeRoute(["route_table"], {"route_table.table": table}).initialize(0.0)
