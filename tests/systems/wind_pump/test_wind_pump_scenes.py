"""What the scenes of wind pumps must show: who starts first, what a gust does, no water lost in a day."""

import numpy as np
import pytest
from cosimo.orchestrator.systems import load_scene, summary
from cosimo.orchestrator.systems.wind_pump.records import chains, runnings
from cosimo.tests.scene_runs import finished

pytestmark = pytest.mark.full

BOTH_CONVERTERS = {"gear_ratio", "crank_radius", "lever_mass", "slider_mass", "clutch_arm", "driven_inertia"}


def test_the_converter_starts_while_the_fixed_ratio_stands():
    """Up to 3.3 m/s: above the start wind of the converter, 2.66 m/s and its lag, and below that of the gear, 3.58 m/s."""
    result = finished(load_scene("wind-pump-start").with_changes({"stop_time": 110.0}))
    fixed, converter = chains(result)
    assert (fixed.name, converter.name) == ("fixed", "converter")
    assert runnings(fixed) == []
    (run_of_converter,) = runnings(converter)
    assert 2.66 < run_of_converter.begin_wind < 2.95
    assert fixed.signals["delivered"][-1] < 0.5 * 4.24e-4 < converter.signals["delivered"][-1]  # m³, less than half a stroke
    # until it starts the fixed pump creeps up its stroke, where the torques balance: standstill, nearly
    assert fixed.signals["turbine_speed"].max() < 0.2


def test_in_a_gust_the_ratio_changes_and_the_power_coefficient_stays():
    """One gust from 5 to 12 m/s; the mean of the clutches drives turbine and pump as the clutches do."""
    full = load_scene("wind-pump-gusts").with_changes({"stop_time": 18.0})
    result = finished(full)
    t, ratio, cp = result.time, result["converter.ratio"], result["turbine.power_coefficient"]
    strong = (t > 14.0) & (t < 16.0)
    before = (t > 6.0) & (t < 12.0)
    assert ratio[strong].mean() > 5.0 * ratio[before].mean()
    assert cp[before].mean() > 0.28
    assert cp[strong].mean() > 0.24
    for energy in result.info.energy.values():  # what the coupling makes of nothing, J
        assert abs(energy.created) < 1e-3 * energy.exchanged
    mean = finished(
        full.with_changes(
            {
                "units.converter.component": "AveragedConverter",
                "units.converter.effects": [],
                "units.converter.parameters": {
                    n: v for n, v in full.units["converter"].parameters.items() if n in BOTH_CONVERTERS
                },
                # crank and lever turn with the turbine: n² (J1 + m a² r² / 2)
                "units.turbine.parameters": {"inertia": 15.0 + 100.0 * (0.1 + 47.0 * 4.0 * 0.02**2 / 2.0)},
                "master": {"step": 0.01},
                "record.signals": ["turbine.speed", "converter.speed", "pipe.delivered"],
            }
        )
    )
    late = mean.time > 6.0
    for name in ("turbine.speed", "converter.speed"):
        assert mean[name][late].mean() == pytest.approx(result[name][t > 6.0].mean(), rel=0.03)


def test_two_hours_of_the_day_lose_no_water():
    """What was delivered was drawn, ran over or is in the tank; a macro step of half the length changes the water by 1e-3."""
    scene = load_scene("wind-pump-day").with_changes({"stop_time": 7200.0, "units.wind.parameters": {"mean_speed": 5.0}})
    result = finished(scene)
    delivered = result["pipe.delivered"]
    assert delivered[-1] > 1.0
    drawn = result["pipe.tank.supplied"] + result["pipe.tank.overflowed"] + 6.0 * (result["pipe.tank.level"] - 0.5)
    np.testing.assert_allclose(drawn, delivered, rtol=0.0, atol=1e-9)
    finer = finished(scene.with_changes({"master.step": 0.4}))
    assert finer["pipe.delivered"][-1] == pytest.approx(delivered[-1], rel=1e-3)


def test_a_recorded_wind_in_kilometres_per_hour_has_the_figures_of_one_in_metres_per_second():
    """Records have the unit of measure of the input that a signal drives."""
    scene = load_scene("wind-pump-record").with_changes({"stop_time": 20.0})
    result = finished(scene)
    (chain,) = chains(result)
    np.testing.assert_allclose(chain.wind, result["wind.speed"] / 3.6, rtol=1e-12)
    assert 0.2 < {row.name: row.value for row in summary(result)}["converter.mean_power_coefficient"] < 0.3
