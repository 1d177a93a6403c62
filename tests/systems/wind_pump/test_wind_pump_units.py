"""Wind pumps where models fail: standstill, speeds through zero, gusts, no wind, no load, seized pumps, odd inertias."""

import math

import numpy as np
import pytest
from cosimo import read_scene
from cosimo.components.wind_pump.averaged import AveragedConverter
from cosimo.components.wind_pump.fixed import FixedTransmission
from cosimo.components.wind_pump.piston_pump import PistonPump
from cosimo.components.wind_pump.planetary import PlanetaryTransmission
from cosimo.components.wind_pump.turbine import WindTurbine
from cosimo.components.wind_pump.wind import Wind
from cosimo.tests.scene_runs import finished

STANDSTILL_TORQUE = 0.5 * 1.225 * math.pi * 1.5**3 * 0.5  # N.m per (m/s)² of wind, default windmill
PEAK = 1000.0 * 9.81 * 20.0 * 0.25 * math.pi * 0.06**2 * 0.075  # N.m, default pump
TRANSMISSIONS = (FixedTransmission, AveragedConverter, PlanetaryTransmission)


class Chain:
    """Wind, turbine, transmission and pump, one after the other, each with the newest outputs of the others, held."""

    def __init__(self, transmission, wind, pump=None, turbine=None, h=0.01):
        self.wind, self.transmission, self.h, self.t = wind, transmission, h, 0.0
        self.turbine, self.pump = turbine or WindTurbine(), pump or PistonPump()
        for unit in (self.wind, self.turbine, self.transmission, self.pump):
            unit.initialize(0.0)

    def run(self, duration: float, watch=lambda chain: None) -> list:
        """Steps for a time, s, and what `watch` gives after each of them."""
        seen = []
        for _ in range(round(duration / self.h)):
            t, h = self.t, self.h
            self.wind.step(t, h)
            self.turbine.set("wind", self.wind["speed"])
            self.turbine.set("torque", self.transmission["turbine_torque"])
            self.turbine.step(t, h)
            self.transmission.set("turbine_speed", self.turbine["speed"])
            self.transmission.set("load_torque", self.pump["torque"])
            self.transmission.step(t, h)
            self.pump.set("speed", self.transmission["speed"])
            self.pump.step(t, h)
            self.transmission.refresh()
            self.t += h
            seen.append(watch(self))
        return seen


def steady(speed):
    """A wind that does not change."""
    return Wind(parameters={"mean_speed": speed})


def everything(chain):
    """All outputs of all units."""
    return np.concatenate([u.y for u in (chain.wind, chain.turbine, chain.transmission, chain.pump)])


@pytest.mark.parametrize("transmission", TRANSMISSIONS)
def test_nothing_moves_without_wind(transmission):
    chain = Chain(transmission(), steady(0.0))
    chain.run(2.0)
    assert np.isfinite(everything(chain)).all()
    assert chain.turbine["speed"] == chain.transmission["speed"] == chain.pump["flow"] == 0.0
    assert chain.transmission["ratio"] == chain.turbine["tip_speed_ratio"] == chain.turbine["power_coefficient"] == 0.0


@pytest.mark.parametrize("curve", ["farm", "heier", "simple", "variant"])
@pytest.mark.parametrize("wind", [0.0, 1e-300, 1e-12, 1e-3, 8.0])
def test_standstill_and_calm_are_no_division_by_zero(curve, wind):
    for speed in (0.0, 1e-300, -1e-9, 3.0, -3.0):
        turbine = WindTurbine(parameters={"curve": curve, "start_speed": speed})
        turbine.set("wind", wind)
        turbine.initialize(0.0)
        turbine.step(0.0, 1.0)
        assert np.isfinite(turbine.y).all()
        assert abs(turbine["power_coefficient"]) < 1e9


def test_a_turbine_without_starting_torque_stays_where_it_is():
    """The exponential fits without a linear term give nothing at standstill; the one with it starts, but slowly."""
    for curve, starts in (("simple", False), ("variant", False), ("heier", True)):
        turbine = WindTurbine(parameters={"curve": curve})
        turbine.set("wind", 10.0)
        turbine.initialize(0.0)
        turbine.step(0.0, 1.0)
        assert (turbine["speed"] > 1e-3) == starts


@pytest.mark.parametrize("gear_ratio", [1.0, 0.5])
def test_the_start_wind_of_a_fixed_ratio_is_that_of_the_pumps_peak(gear_ratio):
    """A slowly rising wind starts the pump at sqrt(i peak / (torque at standstill per v²)); 3.58 m/s at i = 1."""
    start = math.sqrt(gear_ratio * PEAK / STANDSTILL_TORQUE)
    if gear_ratio == 1.0:
        assert start == pytest.approx(3.58, abs=5e-3)
    ramp = {"mean_speed": 0.5 * start, "ramp.rate": 0.02, "ramp.end_speed": 1.2 * start}
    pump = PistonPump(parameters={"start_angle": 0.5 * math.pi})
    chain = Chain(FixedTransmission(parameters={"gear_ratio": gear_ratio}), Wind(["ramp"], ramp), pump)
    seen = chain.run(0.55 * start / 0.02, lambda c: (c.wind["speed"], c.pump["angle"]))
    began = next(wind for wind, angle in seen if angle > 0.5 * math.pi)
    assert began == pytest.approx(start, rel=2e-3)  # the rotor still swings a little on the compliant shaft
    assert seen[-1][1] != pytest.approx(0.5 * math.pi, abs=0.2)


def test_what_runs_keeps_running_in_a_wind_that_does_not_start_it():
    """3 m/s, below the start wind of 3.58 and above the stop wind, with a flywheel: both states last. That is the hysteresis."""
    shaft = {"driven_inertia": 60.0, "stiffness": 2e4, "shaft_damping": 50.0}
    middle = {"start_angle": 0.5 * math.pi}
    running = Chain(
        FixedTransmission(parameters=shaft | {"start_speed": 2.0}),
        steady(3.0),
        PistonPump(),
        WindTurbine(parameters={"start_speed": 2.0}),
    )
    standing = Chain(FixedTransmission(parameters=shaft), steady(1.0), PistonPump(parameters=middle))
    standing.wind = Wind(["ramp"], {"mean_speed": 1.0, "ramp.rate": 0.1, "ramp.end_speed": 3.0})
    standing.wind.initialize(0.0)
    speeds = running.run(60.0, lambda c: c.transmission["speed"])
    assert min(speeds) > 0.5
    assert np.mean(speeds[-2000:]) == pytest.approx(np.mean(speeds[-4000:-2000]), rel=0.05)
    standing.run(60.0)
    assert standing.transmission["speed"] == 0.0
    assert standing.pump["angle"] == pytest.approx(0.5 * math.pi, abs=1e-12)


@pytest.mark.parametrize("transmission", TRANSMISSIONS)
def test_a_gust_from_5_to_12_m_s_is_survived(transmission):
    """A step of the wind in the middle of pumping; afterwards the pump is where it was before."""
    gust = {"mean_speed": 5.0, "gusts.start_time": 30.0, "gusts.rise": 0.0, "gusts.stay": 5.0, "gusts.amplitude": 7.0}
    chain = Chain(transmission(), Wind(["gusts"], gust))
    before = np.mean(chain.run(30.0, lambda c: c.transmission["speed"])[-1000:])
    seen = chain.run(5.0, everything)
    assert np.isfinite(seen).all()
    after = np.mean(chain.run(35.0, lambda c: c.transmission["speed"])[-1000:])
    assert after == pytest.approx(before, rel=0.1)


@pytest.mark.parametrize("transmission", TRANSMISSIONS)
def test_a_pump_stops_as_the_wind_dies_and_starts_again(transmission):
    """Stop and restart; the driven shaft never turns back, and stands exactly in between."""
    gusts = {"mean_speed": 0.0, "gusts.amplitude": 6.0, "gusts.start_time": 0.0, "gusts.stay": 25.0, "gusts.period": 60.0}
    chain = Chain(transmission(), Wind(["gusts"], gusts))
    speeds = np.array(chain.run(85.0, lambda c: c.transmission["speed"]))
    assert speeds.min() == 0.0
    assert speeds[1000:2500].mean() > 1.0
    assert not speeds[5000:6000].any()
    assert speeds[-500:].mean() > 1.0
    assert np.isfinite(everything(chain)).all()


@pytest.mark.parametrize("transmission", TRANSMISSIONS)
def test_a_pump_without_head_is_no_load(transmission):
    """A dry well: the turbine runs up to where it has no torque; the driven shaft follows and no power is asked for."""
    pump = PistonPump()
    pump.set("head", 0.0)
    chain = Chain(transmission(), steady(5.0), pump)
    chain.run(60.0)
    assert chain.turbine["speed"] == pytest.approx(2.4 * 5.0 / 1.5, rel=0.02)
    assert chain.pump["torque"] == chain.pump["hydraulic_power"] == 0.0


def test_a_seized_pump_stalls_a_fixed_ratio_and_lets_the_converters_turbine_run():
    stalled, idling = (
        Chain(cls(), steady(5.0), PistonPump(parameters={"start_angle": 0.5 * math.pi}))
        for cls in (FixedTransmission, AveragedConverter)
    )
    for chain in (stalled, idling):
        chain.pump.set("head", 1e6)
        chain.run(60.0)
        assert chain.transmission["speed"] == 0.0
    assert stalled.turbine["speed"] == pytest.approx(0.0, abs=1e-6)
    assert stalled.transmission["driving_torque"] == pytest.approx(STANDSTILL_TORQUE * 25.0, rel=1e-6)
    assert idling.turbine["speed"] == pytest.approx(8.0, rel=1e-3)
    assert idling.transmission["turbine_torque"] == 0.0


@pytest.mark.parametrize("transmission", TRANSMISSIONS)
@pytest.mark.parametrize("speed", [1e-300, -1e-300, 1e-9, -1e-9, -2.0])
def test_a_turbine_through_standstill_leaves_a_shaft_that_does_not_turn_back(transmission, speed):
    unit = transmission()
    unit.set("turbine_speed", speed)
    unit.set("load_torque", 3.0)
    unit.initialize(0.0)
    unit.step(0.0, 1.0)
    assert np.isfinite(unit.y).all()
    assert unit["speed"] >= 0.0
    assert abs(unit["ratio"]) < 1e6


@pytest.mark.parametrize("transmission", TRANSMISSIONS)
def test_a_turbine_that_swings_about_standstill_never_turns_the_pump_back(transmission):
    """A slow oscillation of the turbine: stops and starts, each located, and speeds that stay positive."""
    unit = transmission(parameters={"driven_inertia": 0.1})
    unit.set("load_torque", 2.0)
    unit.initialize(0.0)
    lowest = math.inf
    for k in range(4000):
        unit.set("turbine_speed", 3.0 * math.sin(0.5 * k * 0.01))
        unit.step(0.01 * k, 0.01)
        lowest = min(lowest, unit["speed"])
    assert lowest == 0.0
    assert unit.work["events"] >= 2  # a compliant shaft that is wound up backwards has to unwind first, others go at once
    assert np.isfinite(unit.y).all()


def test_a_light_shaft_runs_at_its_stable_step_and_a_heavy_one_at_any():
    light = FixedTransmission(parameters={"driven_inertia": 1e-6})
    light.set("substep", 0.9 * light.stable_step())
    chain = Chain(light, steady(5.0), h=1e-3)
    chain.run(0.02)
    assert np.isfinite(everything(chain)).all()
    heavy = Chain(FixedTransmission(parameters={"driven_inertia": 1e7}), steady(5.0))
    heavy.run(20.0)
    assert 0.0 < heavy.transmission["speed"] < 1e-3


@pytest.mark.parametrize("transmission", TRANSMISSIONS)
@pytest.mark.parametrize("curvature", [0.0, 1.0])
def test_a_rest_in_which_drive_and_load_are_equal_is_left_as_the_drive_grows(transmission, curvature):
    """Both are 0 to the last bit; the turbine's speed then grows as t or as t², and the load does not."""
    unit = transmission()
    unit.initialize(0.0)
    unit.u[1, 0], unit.u[2, 0] = 1.0 - curvature, curvature
    unit.step(0.0, 0.5)
    assert unit["speed"] > 0.0
    assert unit.work["events"] < 10


@pytest.mark.full
def test_a_centrifugal_pump_opens_its_valve_into_a_pipe_with_friction():
    """Head and flow in a loop: solved to H0 n² - n d Q - c Q² = H_static + K Q² at every instant after the valve opens."""
    scene = read_scene(
        {
            "title": "centrifugal pump",
            "stop_time": 6.0,
            "connections": [
                "turbine.speed -> gear.turbine_speed",
                "gear.turbine_torque -> turbine.torque",
                "gear.speed -> pump.speed",
                "pump.torque -> gear.load_torque",
                "pump.flow -> pipe.flow",
                "pipe.head -> pump.head",
            ],
            "units": {
                "turbine": {"component": "WindTurbine", "parameters": {"wind": 6.0}},
                "gear": {
                    "component": "FixedTransmission",
                    "parameters": {"gear_ratio": 30.0, "driven_inertia": 0.02, "stiffness": 200.0, "shaft_damping": 0.1},
                },
                "pump": {"component": "CentrifugalPump"},
                "pipe": {
                    "component": "WaterPipe",
                    "effects": ["friction"],
                    "parameters": {"static_head": 10.0, "friction": {"coefficient": 1e6}},
                },
            },
            "master": {"step": 5e-3},
            "record": {"signals": ["gear.speed", "pump.flow", "pipe.head"]},
        }
    )
    result = finished(scene)
    n, flow = result["gear.speed"] / 150.0, result["pump.flow"]
    a, b, c = 6.3e6, 2e3 * n, np.minimum(10.0 - 30.0 * n**2, 0.0)
    np.testing.assert_allclose(flow, (-b + np.sqrt(b * b - 4.0 * a * c)) / (2.0 * a), atol=1e-9)
    assert flow[0] == 0.0 < flow[-1]
