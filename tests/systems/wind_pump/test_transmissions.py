"""Transmissions without events: torques and speeds against their relations, power at every interface, vibration, order."""

import itertools
import math

import numpy as np
import pytest
from cosimo.components.wind_pump import averaged, fixed, planetary
from cosimo.components.wind_pump.averaged import AveragedConverter
from cosimo.components.wind_pump.driven_shaft import STANDING, TURNING, shaft_guard, shaft_mode
from cosimo.components.wind_pump.fixed import FixedTransmission
from cosimo.components.wind_pump.planetary import SHAFTS, PlanetaryTransmission
from cosimo.tests.slopes import slope
from cosimo.tests.support import initialized
from cosimo.tests.systems.energy import energy_rate

pytestmark = pytest.mark.interpreted

DERIVATIVES = {
    FixedTransmission: fixed.fixed_derivatives,
    AveragedConverter: averaged.averaged_derivatives,
    PlanetaryTransmission: planetary.gear_derivatives,
}
MODE = {FixedTransmission: 2, AveragedConverter: 1, PlanetaryTransmission: 3}
ARRANGEMENTS = list(itertools.permutations(SHAFTS, 2))


def started(cls, effects=(), parameters=None, turbine_speed=0.0, load_torque=0.0):
    """An initialized transmission with its inputs."""
    return initialized(cls(effects, parameters), {"turbine_speed": turbine_speed, "load_torque": load_torque})


CASES = [
    (FixedTransmission, (), {"gear_ratio": 2.5, "driven_damping": 0.3}),
    (FixedTransmission, ("mesh_friction",), {}),
    (AveragedConverter, (), {}),
    (AveragedConverter, ("mesh_friction",), {"driven_damping": 0.3}),
    (PlanetaryTransmission, (), {"driven_damping": 0.3}),
    (PlanetaryTransmission, ("mesh_friction", "dry_brake", "centrifugal_brake"), {"turbine_on": "sun", "substep": 2e-4}),
    (PlanetaryTransmission, ("centrifugal_brake",), {"turbine_on": "sun", "pump_on": "ring", "substep": 2e-4}),
]


@pytest.mark.known_answers(
    FixedTransmission="mesh_friction", PlanetaryTransmission="mesh_friction", AveragedConverter="mesh_friction"
)
@pytest.mark.parametrize(("cls", "effects", "parameters"), CASES)
@pytest.mark.parametrize("mode", [STANDING, TURNING])
def test_power_in_is_power_out_and_lost_and_stored(cls, effects, parameters, mode):
    """At random states: dE/dt = T1 w_t - T_load w - dissipation, the derivative of the energy along the derivatives."""
    transmission = started(cls, effects, parameters)
    rng = np.random.default_rng(5)
    for _ in range(50):
        transmission.set("turbine_speed", rng.normal(scale=4.0))
        transmission.set("load_torque", rng.uniform(0.0, 40.0))
        x = rng.normal(scale=2.0, size=transmission.x.size)
        x[MODE[cls]] = mode
        speed = MODE[cls] - 1 if cls is not PlanetaryTransmission else 1
        x[speed] = abs(x[speed]) if mode == TURNING else 0.0
        if "dry_brake" in effects:
            x[4] = math.copysign(1.0, x[2])
        transmission.x[:] = x
        rate, _ = energy_rate(transmission, DERIVATIVES[cls], 1e-3)  # the energy is quadratic: central differences are exact
        transmission.refresh()
        y = {n: transmission[n] for n in transmission.outputs}
        powers = (y["turbine_torque"] * transmission["turbine_speed"], transmission["load_torque"] * y["speed"], y["dissipation"])
        assert y["dissipation"] >= 0.0
        scale = max(map(abs, (*powers, transmission.energy()))) + 1.0
        assert rate == pytest.approx(powers[0] - powers[1] - powers[2], abs=1e-9 * scale)


def test_modes_of_the_driven_shaft():
    assert shaft_mode(1.0, -5.0, 3.0) == TURNING
    assert shaft_mode(0.0, 2.9, 3.0) == STANDING
    assert shaft_mode(0.0, 3.1, 3.0) == TURNING
    assert shaft_mode(0.0, -50.0, 3.0) == STANDING  # nothing turns it back
    assert shaft_mode(0.0, 0.0, 0.0) == STANDING
    assert shaft_guard(STANDING, 0.0, 2.0, 3.0) == 1.0
    assert shaft_guard(TURNING, 0.5, 2.0, 3.0) == 0.5


# -- fixed ratio -----------------------------------------------------------------------------------------------------------
@pytest.mark.full
def test_the_driven_shaft_swings_as_a_torsional_vibration():
    """Turbine at constant speed: the driven shaft about i w_t, w = i w_t + (w0 - i w_t) e^(-d t) (cos - d/wd sin)."""
    shaft = {"gear_ratio": 2.0, "shaft_damping": 3.0, "start_speed": 5.0, "substep": 1e-3}
    transmission = started(FixedTransmission, (), shaft, turbine_speed=3.0, load_torque=7.0)
    k, c, inertia, ahead = 2000.0, 3.0, 0.5, 5.0 - 2.0 * 3.0
    decay = c / (2.0 * inertia)
    damped = math.sqrt(k / inertia - decay**2)
    theta = 7.0 / k  # twist in the steady state; the shaft starts relaxed
    transmission.step(0.0, 0.137)
    angle, t = damped * 0.137, 0.137
    # z = theta - theta_steady: z'' + c/J z' + k/J z = 0 with z(0) = -theta_steady, z'(0) = -ahead
    b = (-ahead - decay * theta) / damped
    z = math.exp(-decay * t) * (-theta * math.cos(angle) + b * math.sin(angle))
    z_rate = math.exp(-decay * t) * (
        decay * theta * math.cos(angle) - decay * b * math.sin(angle) + damped * (theta * math.sin(angle) + b * math.cos(angle))
    )
    assert transmission["speed"] == pytest.approx(6.0 - z_rate, abs=1e-6)
    assert transmission["turbine_torque"] == pytest.approx(2.0 * (k * (theta + z) + c * z_rate), abs=1e-4)


@pytest.mark.parametrize(("cls", "parameters"), [(FixedTransmission, {}), (PlanetaryTransmission, {"third_damping": 0.5})])
def test_order_of_the_integrator_is_four(cls, parameters):
    """The driven shaft keeps turning, so that there is no event."""

    def state(substep):
        transmission = started(cls, (), parameters | {"start_speed": 4.0, "substep": substep}, turbine_speed=4.5)
        transmission.step(0.0, 0.08)
        assert transmission.work["events"] == 0
        return transmission.x.copy()

    h = np.array([2e-3, 1e-3, 5e-4])
    exact = state(5e-5)
    errors = [np.abs(state(d) - exact).max() for d in h]
    assert abs(slope(h, errors) - 4.0) < 0.2


# -- mean of the converter -------------------------------------------------------------------------------------------------
def test_coefficients_of_the_mean_torque_are_the_printed_ones():
    assert AveragedConverter().coefficients() == pytest.approx((0.0636620, 0.0322289), abs=5e-8)


def test_stall_and_no_load_of_another_converter():
    """m = 4, m_y = 0.05, a = 2, b = 1, r = 0.03, rho = 0.05: stall at 20 rad/s 3.0558 N.m, no load 23.7037 rad/s."""
    other = {"gear_ratio": 1.0, "lever_mass": 4.0, "slider_mass": 0.05, "crank_radius": 0.03}
    assert started(AveragedConverter, (), other, 20.0)["driving_torque"] == pytest.approx(3.0558, abs=5e-5)
    assert started(AveragedConverter, (), other, 10.0)["driving_torque"] == pytest.approx(0.7639, abs=5e-5)
    free = started(AveragedConverter, (), other | {"start_speed": 25.0, "driven_damping": 1e-9}, 20.0)
    free.set("load_torque", 1e-6)  # what faces no torque coasts; a little load brings it to the edge of engaging
    free.x[0] = 23.70371
    free.refresh()
    assert free["driving_torque"] == 0.0
    free.x[0] = 23.7036
    free.refresh()
    assert free["driving_torque"] > 0.0
    assert free["turbine_torque"] > 0.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_mean_torque_keeps_the_power(sign):
    """T2 = k1 w1² - k2 w1 w written down again; T1 w_t = T2 w, also where the turbine turns the other way."""
    rng = np.random.default_rng(2)
    k1, k2 = AveragedConverter().coefficients()
    for _ in range(30):
        turbine, share = rng.uniform(0.01, 20.0), rng.uniform(0.0, 1.2)
        w1 = 6.0 * turbine
        w = share * w1 * k1 / k2
        converter = started(AveragedConverter, (), {"start_speed": w}, sign * turbine)
        expected = k1 * w1**2 - k2 * w1 * w if share < 1.0 else 0.0
        assert converter["driving_torque"] == pytest.approx(expected, rel=1e-9, abs=1e-12)
        assert converter["turbine_torque"] * sign * turbine == pytest.approx(expected * w, rel=1e-9, abs=1e-12)


def test_a_converter_at_constant_speed_approaches_its_end_exponentially():
    """Linear in w: J w' = k1 w1² - T - k2 w1 w."""
    k1, k2 = AveragedConverter().coefficients()
    w1 = 6.0 * 3.0
    converter = started(AveragedConverter, (), None, turbine_speed=3.0, load_torque=10.0)
    end, rate = (k1 * w1**2 - 10.0) / (k2 * w1), k2 * w1
    converter.step(0.0, 2.0)
    assert converter["speed"] == pytest.approx(end * (1.0 - math.exp(-2.0 * rate)), rel=1e-9)
    assert converter["ratio"] == pytest.approx(converter["speed"] / 3.0, rel=1e-14)


# -- planetary -------------------------------------------------------------------------------------------------------------
COEFFICIENTS = {"sun": 1.0, "ring": 3.0, "carrier": -4.0}


@pytest.mark.first
@pytest.mark.parametrize(("turbine_on", "pump_on"), ARRANGEMENTS)
def test_willis_relations_hold_in_the_steady_state(turbine_on, pump_on):
    """Speeds: w_s + k w_r = (1 + k) w_c; torques as 1 : k : -(1 + k). With sun and ring the pump's speed is counted against."""
    third_on = next(s for s in SHAFTS if s not in (turbine_on, pump_on))
    on = {"turbine_on": turbine_on, "pump_on": pump_on, "substep": 1e-3}
    gear = started(PlanetaryTransmission, (), on, turbine_speed=6.0, load_torque=2.0)
    gear.step(0.0, 60.0)
    direction = -1.0 if {turbine_on, pump_on} == {"sun", "ring"} else 1.0
    speeds = {turbine_on: 6.0, pump_on: direction * gear["speed"], third_on: gear["third_speed"]}
    assert speeds["sun"] + 3.0 * speeds["ring"] == pytest.approx(4.0 * speeds["carrier"], abs=1e-9)
    on_gear = {turbine_on: gear["turbine_torque"], pump_on: -direction * gear["driving_torque"], third_on: -gear["third_torque"]}
    unit = on_gear["sun"]
    assert [on_gear[s] for s in SHAFTS] == pytest.approx([COEFFICIENTS[s] * unit for s in SHAFTS], abs=1e-9)
    assert gear["driving_torque"] == pytest.approx(2.0, abs=1e-9)  # the load
    assert gear["third_torque"] == pytest.approx(5.0 * gear["third_speed"], abs=1e-9)  # the viscous brake
    assert gear["speed"] > 0.0
    assert gear["dissipation"] == pytest.approx(6.0 * gear["turbine_torque"] - 2.0 * gear["speed"], abs=1e-8)


@pytest.mark.full
@pytest.mark.parametrize(("turbine_on", "pump_on"), ARRANGEMENTS)
def test_a_brake_that_holds_makes_a_fixed_ratio(turbine_on, pump_on):
    on = {"turbine_on": turbine_on, "pump_on": pump_on, "dry_brake.static": 1e4, "dry_brake.kinetic": 1e4}
    gear = PlanetaryTransmission(["dry_brake"], on)
    gear.initialize(0.0)
    gear.set("turbine_speed", 4.0)
    gear.step(0.0, 120.0)  # carrier to sun: c / (16 J) = 0.6 per s, so that half of it is e^-37
    assert gear["third_speed"] == 0.0
    assert gear["ratio"] == pytest.approx(abs(COEFFICIENTS[turbine_on] / COEFFICIENTS[pump_on]), rel=1e-9)


@pytest.mark.known_answers(PlanetaryTransmission="dry_brake")
@pytest.mark.parametrize("share", [0.999, 1.001])
def test_a_dry_brake_slips_at_its_torque_and_not_before(share):
    """The pump stands under a large load; a turbine that winds up the shaft slowly loads the sun with a third of its torque."""
    gear = PlanetaryTransmission(["dry_brake"], {"dry_brake.static": 10.0, "dry_brake.kinetic": 8.0, "shaft_damping": 0.0})
    gear.set("load_torque", 1e6)
    gear.initialize(0.0)
    gear.set("turbine_speed", 1e-3)
    gear.step(0.0, share * 3.0 * 10.0 / 2000.0 / 1e-3)
    assert gear["speed"] == 0.0
    assert (gear["third_speed"] != 0.0) == (share > 1.0)
    if share < 1.0:
        assert gear["third_torque"] == pytest.approx(-share * 10.0, rel=1e-9)


def test_a_stalled_pump_leaves_the_turbine_the_torque_of_the_brake():
    """Ring turns, carrier stands: w_s = -k w_r, brake b k w_r on the sun, k times that on the ring."""
    gear = started(PlanetaryTransmission, (), None, turbine_speed=2.0, load_torque=1e3)
    gear.step(0.0, 20.0)
    assert gear["speed"] == 0.0
    assert gear["third_speed"] == pytest.approx(-6.0, rel=1e-9)
    assert gear["turbine_torque"] == pytest.approx(3.0 * 5.0 * 6.0, rel=1e-9)
