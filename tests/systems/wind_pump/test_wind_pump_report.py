"""Figures and tables of wind pumps carry what the made-up signals hold: start and stop winds, ratio, energies."""

import re

import numpy as np
import pytest
from cosimo.orchestrator.harness.analysis.signals import accumulated
from cosimo.orchestrator.systems import SYSTEMS, read_scene
from cosimo.orchestrator.systems.wind_pump.records import branches, chains, efficiencies, moving_mean, runnings
from cosimo.tests.harness.figures import assert_valid_with_units, figures, numbers, tables
from cosimo.tests.systems.wind_pump.wind_pumps import (
    CP,
    PUMPED,
    STARTS,
    STOPS,
    TRANSMITTED,
    gusty_run,
    hysteresis_run,
    run_of,
    triangle,
)

pytestmark = pytest.mark.full

UNIT = re.compile(r", (m/s|rpm|1|W|l/s|m³|m|s|h)$")


@pytest.fixture(scope="module")
def shown():
    return SYSTEMS["wind_pump"].figures(hysteresis_run())


def test_every_figure_is_valid_and_every_axis_has_its_unit(shown):
    by_title = {**figures(shown), **figures(SYSTEMS["wind_pump"].figures(gusty_run()))}
    for figure in by_title.values():
        assert_valid_with_units(figure, UNIT)


def test_a_wind_that_rises_and_falls_has_its_branches(shown):
    assert list(figures(shown)) == ["Time histories", "Against the wind", "Water"]
    assert list(tables(shown)) == ["Starts and stops", "Energy along the chain"]
    figure = figures(shown)["Against the wind"]
    pump = next(k for k, a in figure["layout"].items() if k.startswith("yaxis") and a["title"]["text"] == "pump speed, rpm")
    traces = {t["name"]: t for t in figure["data"] if t["yaxis"] == pump.replace("axis", "")}
    assert {"wind rising", "wind falling", "pump starts", "pump stops"} <= traces.keys()
    x, y = (numbers(traces["wind rising"][k]) for k in "xy")
    assert np.nanmax(np.where(x < STARTS - 0.01, y, 0.0)) == 0.0
    x, y = (numbers(traces["wind falling"][k]) for k in "xy")
    assert np.nanmin(np.where((x > STOPS + 0.1) & (x < 5.0), y, 90.0)) > 0.5 * STOPS * 30.0 / np.pi
    assert np.nanmean(numbers(traces["pump starts"]["x"])) == pytest.approx(STARTS, abs=0.003)  # a sample: 0.0025 m/s
    assert np.nanmean(numbers(traces["pump stops"]["x"])) == pytest.approx(STOPS, abs=0.003)


def test_start_and_stop_stand_in_the_table(shown):
    (row,) = tables(shown)["Starts and stops"].rows
    assert row[0] == "gear"
    at = [200.0 * STARTS / 5.0, STARTS, 400.0 - 200.0 * STOPS / 5.0, STOPS]
    assert [float(v) for v in row[1:5]] == pytest.approx(at, rel=2e-3)


def test_energy_along_the_chain_has_the_shares(shown):
    rows = tables(shown)["Energy along the chain"].rows
    assert [r[1] for r in rows] == ["wind through the rotor's area", "on the rotor", "turbine to transmission",
                                    "transmission to pump", "pump to water"]  # fmt: skip
    # the pump stands for a part of the time, so that the rotor takes less than its Cp of the wind in all
    assert float(rows[1][3]) < 100.0 * CP
    assert [float(r[3]) for r in rows[2:]] == pytest.approx([100.0, 100.0 * TRANSMITTED, 100.0 * PUMPED], rel=1e-3)


def test_a_piston_that_creeps_does_not_run():
    t, wind = triangle()
    result = hysteresis_run()
    creeping = (t > 20.0) & (t < 30.0)
    result.columns["gear.speed"] = np.where(creeping, 0.3, result.columns["gear.speed"])  # 3 rad in 10 s
    (chain,) = chains(result)
    (run,) = runnings(chain)
    assert run.begin_wind == pytest.approx(STARTS, abs=0.003)
    assert run.turns == pytest.approx(accumulated(t, result.columns["gear.speed"] * ~creeping)[-1] / (2.0 * np.pi), rel=0.01)
    assert wind.max() == 5.0


def test_a_run_that_begins_and_ends_outside_the_record_has_no_marks():
    (chain,) = chains(gusty_run())
    (run,) = runnings(chain)
    assert (run.begin, run.end, run.begin_wind, run.end_wind) == (None, None, None, None)


def test_a_gusty_wind_is_shown_in_bins_and_in_hours():
    by_title = figures(SYSTEMS["wind_pump"].figures(gusty_run()))
    course, against = by_title["Time histories"], by_title["Against the wind"]
    assert any(a["title"]["text"] == "time, h" for k, a in course["layout"].items() if k.startswith("xaxis"))
    lines = [t for t in against["data"] if t["name"] == "bins of 0.5 m/s"]
    x, y = (numbers(lines[0][k]) for k in "xy")  # turbine speed: 1 rad/s at 1 m/s
    assert x == pytest.approx(y * np.pi / 30.0, abs=0.25)
    assert x.min() < 3.5 < 6.5 < x.max()


def test_moving_mean_takes_a_pulsation_away_and_keeps_the_rest():
    t = np.sort(np.concatenate((np.linspace(0.0, 20.0, 2001), np.linspace(5.0, 6.0, 57)[1:-1])))
    t = np.unique(t)
    values = 3.0 + 0.5 * t + np.sin(2.0 * np.pi * t)
    inner = (t > 1.0) & (t < 19.0)
    # two whole periods; chords of 10 ms instead of the sine: (2 pi 0.01)² / 12 of it
    assert moving_mean(t, values, 2.0)[inner] == pytest.approx((3.0 + 0.5 * t)[inner], abs=1e-3)
    assert moving_mean(t, values, 0.0) is not None
    assert (moving_mean(t, values, 0.0) == values).all()


def test_branches_follow_a_slow_wind_and_give_up_on_a_gusty_one():
    t, wind = triangle()
    assert [(way, part.start, part.stop) for way, part in branches(wind)] == [("rising", 0, 2001), ("falling", 2000, 4001)]
    noisy = wind + 0.05 * np.sin(40.0 * t)  # 2 % of the range: no turning points
    assert [way for way, _ in branches(noisy)] == ["rising", "falling"]
    assert branches(np.full(t.size, 6.0)) == []
    assert branches(5.0 + np.sin(t)) == []


def test_the_ripple_of_a_piston_is_drawn_as_its_mean():
    t, wind = triangle()
    result = run_of(t, wind, np.full(t.size, True), ripple=1.0, analysis={"average": 2.0})
    (chain,) = chains(result)
    figure = figures(SYSTEMS["wind_pump"].figures(result))["Time histories"]
    drawn = next(x for x in figure["data"] if x["name"] == "pump" and max(numbers(x["y"])) > 50.0)
    assert max(numbers(drawn["y"])) < 0.6 * chain.powers["hydraulic"].max()
    shares = {stage: share for stage, _, share in efficiencies(chain)}
    assert shares["hydraulic"] == pytest.approx(PUMPED, rel=1e-3)


def test_the_mean_power_coefficient_is_that_of_the_mean_powers():
    """A calm in which the rotor overruns the wind has any coefficient, and hardly any power."""
    t, wind = triangle()
    result = run_of(t, wind, np.full(t.size, True), analysis={"average": 40.0})
    result.columns["turbine.power_coefficient"] = np.where(wind < 0.2, -1e4 * (0.2 - wind), CP)
    figure = figures(SYSTEMS["wind_pump"].figures(result))["Time histories"]
    panel = next(k for k, a in figure["layout"].items() if k.startswith("yaxis") and "Cp" in a["title"]["text"])
    drawn = numbers(next(x for x in figure["data"] if x["yaxis"] == panel.replace("axis", ""))["y"])
    middle = slice(drawn.size // 4, 3 * drawn.size // 4)
    assert drawn[middle] == pytest.approx(CP, rel=1e-4)


def test_two_chains_are_told_apart():
    result = hysteresis_run()
    scene = result.scene.model_dump(exclude_unset=True)
    again = [c.replace("gear.", "second.") for c in scene["connections"] if "gear." in c and "turbine.torque" not in c]
    scene["connections"] = [*scene["connections"], *(c for c in again if "pump.speed" not in c)]
    scene["units"]["second"] = {"component": "FixedTransmission"}
    result.scene = read_scene(scene)
    result.columns["second.speed"] = 0.5 * result.columns["gear.speed"]
    blocks = SYSTEMS["wind_pump"].figures(result)
    names = {t["name"] for t in figures(blocks)["Time histories"]["data"]}
    assert {"gear: pump", "second: pump", "gear: turbine"} <= names
    assert {row[0] for row in tables(blocks)["Starts and stops"].rows} == {"gear", "second"}


def test_without_a_pump_speed_there_is_nothing_to_show():
    result = hysteresis_run()
    del result.columns["gear.speed"]
    assert SYSTEMS["wind_pump"].figures(result) == []
