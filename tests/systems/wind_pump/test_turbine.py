"""The wind turbine against closed forms: start-up, order, power, standstill, furling."""

import math

import numpy as np
import pytest
from cosimo.components.wind_pump.turbine import WindTurbine, turbine_derivatives
from cosimo.tests.slopes import slope
from cosimo.tests.support import initialized

pytestmark = pytest.mark.interpreted

AREA = math.pi * 1.5**2
FULL = 0.5 * 1.225 * AREA * 1.5 * 0.5  # N.m per (m/s)², torque of the default windmill at standstill


def running(effects=(), parameters=None, wind=5.0, torque=0.0):
    """An initialized turbine in a constant wind."""
    return initialized(WindTurbine(effects, parameters), {"wind": wind, "torque": torque})


@pytest.mark.parametrize("load", [0.0, 20.0])
@pytest.mark.parametrize("damping", [0.0, 2.0])
def test_a_farm_windmill_starts_exponentially(load, damping):
    """The straight line of C_Q makes it linear: time constant J / |dT/dw|, and the speed where wind and load balance."""
    turbine = running((), {"damping": damping}, wind=5.0, torque=load)
    slope = FULL * 5.0 * 1.5 / 2.4 + damping  # T = full v² - full v R w / 2.4
    final, constant = (FULL * 25.0 - load) / slope, 15.0 / slope
    for t in (0.0, 1.0, 2.5):
        turbine.step(t, 1.0 if t == 0.0 else 1.5)
        end = t + (1.0 if t == 0.0 else 1.5)
        assert turbine["speed"] == pytest.approx(final * (1.0 - math.exp(-end / constant)), rel=1e-11)
    angle = final * (end - constant * (1.0 - math.exp(-end / constant)))
    assert turbine["angle"] == pytest.approx(angle, rel=1e-11)


def test_order_of_the_integrator_is_four():
    """A rotor as light as a feather: at the default inertia the error is rounding at every step."""

    def speed(n):
        turbine = running((), {"curve": "heier", "inertia": 1.0, "start_speed": 20.0, "substep": 1.0 / n}, wind=6.0)
        turbine.step(0.0, 1.0)
        return turbine["speed"]

    n = np.array([20, 40, 80])
    exact = speed(2000)
    errors = [abs(speed(k) - exact) for k in n]
    assert abs(slope(1.0 / n, errors) - 4.0) < 0.2


@pytest.mark.parametrize(("curve", "effects"), [("farm", ()), ("heier", ("pitch",)), ("variant", ("bearing_friction",))])
def test_energy_at_random_states(curve, effects):
    """dE/dt = power of the wind - torque * speed - friction, as an identity of the derivatives."""
    turbine = running(effects, {"curve": curve, "damping": 0.7})
    rng = np.random.default_rng(1)
    for _ in range(50):
        speed, wind, torque = rng.uniform(0.1, 30.0), rng.uniform(0.5, 12.0), rng.normal(scale=50.0)
        turbine.set("wind", wind)
        turbine.set("torque", torque)
        if "pitch" in effects:
            turbine.set("pitch.angle", rng.uniform(0.0, 0.3))
        turbine.x[:1] = speed
        turbine.x[2:] = 1.0
        turbine.refresh()
        dx = np.zeros(turbine.x.size)
        turbine_derivatives(0.0, turbine.x, turbine.u[0], dx, *turbine.arguments)
        friction = 1.0 if effects == ("bearing_friction",) else 0.0
        expected = turbine["power"] - (torque + 0.7 * speed + friction) * speed
        assert 15.0 * speed * dx[0] == pytest.approx(expected, abs=1e-9 * (abs(turbine["power"]) + abs(torque * speed)))
        coefficient, ratio = turbine["power_coefficient"], turbine["tip_speed_ratio"]
        if speed * 1.5 > 20.0 * wind:  # the wind dies under a turning rotor
            assert coefficient == ratio == 0.0
            continue
        assert turbine["power"] == pytest.approx(0.5 * 1.225 * AREA * wind**3 * coefficient, rel=1e-12)
        assert ratio == pytest.approx(speed * 1.5 / wind, rel=1e-12)
        assert coefficient < 16.0 / 27.0


@pytest.mark.parametrize("shortfall", [0.999, 1.001])
def test_bearings_hold_the_rotor_up_to_the_wind_that_overcomes_them(shortfall):
    """At standstill the windmill's torque is full v²: it starts in sqrt(static / full), and not a creep before."""
    friction = {"bearing_friction.static": 8.0, "bearing_friction.kinetic": 5.0}
    turbine = running(("bearing_friction",), friction, wind=0.0)
    turbine.set("wind", shortfall * math.sqrt(8.0 / FULL))
    turbine.step(0.0, 20.0)
    assert (turbine["speed"] > 0.0) == (shortfall > 1.0)
    assert turbine.work["events"] == (1 if shortfall > 1.0 else 0)
    if shortfall < 1.0:
        assert turbine["angle"] == 0.0


@pytest.mark.known_answers(WindTurbine="bearing_friction")
def test_a_rotor_that_coasts_comes_to_rest_in_the_time_of_the_closed_form():
    """Without wind: w' = -(T_f + b w)/J, so that it stands after J/b ln(1 + b w0/T_f), and stays there."""
    turbine = running(("bearing_friction",), {"damping": 0.5, "start_speed": 3.0}, wind=0.0)
    rest = 15.0 / 0.5 * math.log(1.0 + 0.5 * 3.0 / 1.0)
    turned = 15.0 / 0.5 * (3.0 - 1.0 / 0.5 * math.log(1.0 + 0.5 * 3.0))
    turbine.step(0.0, rest - 1e-3)
    assert 0.0 < turbine["speed"] < 1e-4
    turbine.step(rest - 1e-3, 50.0)
    assert turbine["speed"] == 0.0
    assert turbine["angle"] == pytest.approx(turned, rel=1e-10)


@pytest.mark.known_answers(WindTurbine="furling")
@pytest.mark.full
def test_a_furled_rotor_feels_the_wind_at_which_it_turns_away():
    furled, calm = running(("furling",), wind=20.0), running(wind=8.0)
    for turbine in (furled, calm):
        turbine.step(0.0, 30.0)
    assert furled["speed"] == calm["speed"]
    assert furled["power_coefficient"] == pytest.approx(calm["power_coefficient"] * (8.0 / 20.0) ** 3, rel=1e-12)


def test_the_limit_of_betz_is_no_matter_where_the_curve_is_another():
    running((), {"curve": "heier", "standstill_coefficient": 1.0})
