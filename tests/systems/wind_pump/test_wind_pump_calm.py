"""Everything at rest, and nothing to overcome: drive and load are equal to the last bit, and the wind rises from there."""

import pytest
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.scene_runs import finished

pytestmark = pytest.mark.full

TRANSMISSIONS = ("FixedTransmission", "AveragedConverter", "PlanetaryTransmission", "InertialConverter")


def calm(transmission, load, seconds=2.0):
    """A turbine at rest in a wind that rises from 0, on a shaft that rests under a load, N.m, or a piston at its dead centre."""
    ramp = {"end_speed": 6.0, "rate": 3.0}
    units = {
        "wind": {"component": "Wind", "effects": ["ramp"], "parameters": {"mean_speed": 0.0, "ramp": ramp}},
        "turbine": {"component": "WindTurbine"},
        "gear": {"component": transmission},
    }
    connections = ["wind.speed -> turbine.wind", "turbine.speed -> gear.turbine_speed", "gear.turbine_torque -> turbine.torque"]
    if load is None:
        units["pump"] = {"component": "PistonPump"}
        connections += ["gear.speed -> pump.speed", "pump.torque -> gear.load_torque"]
    else:
        units["gear"]["parameters"] = {"load_torque": load}
    return read_scene({"stop_time": seconds, "units": units, "connections": connections, "master": {"step": 2e-3}})


@pytest.mark.parametrize("transmission", TRANSMISSIONS)
@pytest.mark.parametrize("load", [0.0, None])
def test_the_wind_rises_from_a_calm(transmission, load):
    result = finished(calm(transmission, load))
    assert result["gear.speed"].min() >= 0.0
    assert result["gear.speed"][0] == 0.0
    assert result["gear.speed"].max() > 0.0


@pytest.mark.parametrize("transmission", TRANSMISSIONS)
def test_a_calm_stays_calm(transmission):
    scene = calm(transmission, None, 1.0).with_changes({"units.wind.effects": [], "units.wind.parameters": {"mean_speed": 0.0}})
    result = finished(scene)
    assert not result["gear.speed"].any()
    assert not result["turbine.speed"].any()
