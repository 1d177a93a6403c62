"""A farm windmill on the averaged converter under a constant load: its equilibrium over the wind, and that it gets there."""

import pytest
from cosimo.components.wind_pump.averaged import AveragedConverter
from cosimo.components.wind_pump.turbine import WindTurbine
from scipy.optimize import fsolve

LOAD = 13.2435  # N.m
TABLE = [(2.0, 2.428, 0.2196, 4.228), (2.5, 2.466, 0.2837, 1.701), (3.0, 2.518, 0.2993, 0.953), (6.0, 3.349, 0.2726, 0.174)]


def pair(wind, turbine_speed, speed):
    """Turbine and converter at their speeds, with each other's outputs."""
    turbine = WindTurbine(parameters={"start_speed": turbine_speed})
    converter = AveragedConverter(parameters={"start_speed": speed})
    turbine.set("wind", wind)
    converter.set("turbine_speed", turbine_speed)
    converter.set("load_torque", LOAD)
    for unit in (turbine, converter):
        unit.initialize(0.0)
    turbine.set("torque", converter["turbine_torque"])
    return turbine, converter


@pytest.mark.parametrize(("wind", "turbine_speed", "coefficient", "inverse_ratio"), TABLE)
def test_torques_balance_at_the_printed_speeds(wind, turbine_speed, coefficient, inverse_ratio):
    """Numbers solved elsewhere, to their four digits; the ratio changes forty times, the power coefficient stays high."""

    def surplus(speeds):
        turbine, converter = pair(wind, *speeds)
        return turbine["aerodynamic_torque"] - converter["turbine_torque"], converter["driving_torque"] - LOAD

    speeds = fsolve(surplus, (turbine_speed, turbine_speed / inverse_ratio), xtol=1e-12)
    turbine, converter = pair(wind, *speeds)
    assert speeds[0] == pytest.approx(turbine_speed, abs=5e-4)
    assert turbine["power_coefficient"] == pytest.approx(coefficient, abs=5e-5)
    assert 1.0 / converter["ratio"] == pytest.approx(inverse_ratio, abs=5e-4)
    assert turbine["power"] == pytest.approx(LOAD * converter["speed"], rel=1e-9)


def test_a_windmill_that_starts_from_rest_arrives_there():
    turbine, converter = pair(3.0, 0.0, 0.0)
    h = 0.05
    for k in range(2400):
        turbine.set("torque", converter["turbine_torque"])
        turbine.step(k * h, h)
        converter.set("turbine_speed", turbine["speed"])
        converter.step(k * h, h)
    assert turbine["speed"] == pytest.approx(2.51789, abs=2e-5)
    assert 1.0 / converter["ratio"] == pytest.approx(0.953159, abs=2e-5)
