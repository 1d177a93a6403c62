"""Figures of underwater vehicles carry what the made-up signals hold: track, gaps, limits, errors, drift."""

import re

import numpy as np
import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import SYSTEMS, load_scene, read_scene
from cosimo.orchestrator.systems.rov.records import vehicles
from cosimo.tests.harness.figures import assert_valid_with_units, figures, numbers
from cosimo.tests.systems.rov.vehicles import ASIDE, DEPTH, LIMIT, RADIUS, THRUST, vehicle_run

pytestmark = pytest.mark.full

UNIT = re.compile(r", (m|N|degrees|degrees/s|m/s|m/s²|s|1)$")


def named(figure, name, axis=""):
    return next(t for t in figure["data"] if t.get("name") == name and t.get("xaxis", "x") == "x" + axis)


@pytest.fixture(scope="module")
def blocks():
    return SYSTEMS["rov"].figures(vehicle_run({"headings": 2.0}))


def test_every_figure_is_valid_and_every_axis_has_its_unit(blocks):
    for figure in figures([*blocks, *SYSTEMS["rov"].figures(run(short("rov-tumbling"), in_process=True))]).values():
        assert_valid_with_units(figure, UNIT)


def short(name):
    return load_scene(name).with_changes({"stop_time": 1.0})


def test_the_report_has_its_figures_and_tables(blocks):
    expected = ["Track", "Depth and attitude", "Motion in body axes", "Thrusts", "Errors against the set point"]
    assert list(figures(blocks)) == expected
    assert [b.title for b in blocks if b.kind == "cells"] == ["Thrusters", "Errors"]


def test_track_from_above_and_from_the_south_with_set_point_and_headings(blocks):
    figure = figures(blocks)["Track"]
    plan, side = named(figure, "track"), named(figure, "track", "2")
    assert (plan["x"][-1], plan["y"][-1]) == (pytest.approx(2.0 * RADIUS, rel=1e-3), pytest.approx(0.0, abs=1e-3))
    assert set(np.round(numbers(side["y"]), 6)) == {-DEPTH}
    assert numbers(named(figure, "set point")["x"])[0] == pytest.approx(-ASIDE)
    strokes = np.array([numbers(named(figure, "heading")[a]) for a in "xy"])
    begins, ends = strokes[:, 0::3], strokes[:, 1::3]
    assert begins.shape[1] == 11  # every 2 s of 20
    length = np.linalg.norm(ends - begins, axis=0)
    np.testing.assert_allclose(length, 0.06 * 2.0 * RADIUS, rtol=1e-2)
    ahead = np.arctan2(*(ends - begins))  # from north to east
    np.testing.assert_allclose(ahead, np.linspace(0.0, np.pi, 11), atol=1e-2)  # the bow points along the circle


def test_the_depth_has_its_set_point_and_the_current_is_shown():
    made = figures(SYSTEMS["rov"].figures(run(short("rov-station-keeping"), in_process=True)))
    assert numbers(named(made["Depth and attitude"], "set point")["y"]) == pytest.approx(5.5)
    assert [t["name"] for t in made["Current"]["data"]] == ["north", "east"]


def test_angles_have_gaps_where_they_wrap_and_where_they_cannot_be_told():
    figure = figures(SYSTEMS["rov"].figures(vehicle_run()))["Depth and attitude"]
    yaw = numbers(named(figure, "yaw", "4")["y"])
    assert np.isnan(yaw).sum() == 1
    assert np.nanmax(np.abs(np.diff(yaw))) < 3.0
    vertical = SYSTEMS["rov"].figures(vehicle_run(vertical=True))
    figure = figures(vertical)["Depth and attitude"]
    for n, name in (("2", "roll"), ("4", "yaw")):
        trace = named(figure, name, n)
        t, angle = numbers(trace["x"]), numbers(trace["y"])
        assert np.isnan(angle[t >= 10.0]).all()
        assert np.isfinite(angle[t < 10.0]).all()
    assert numbers(named(figure, "pitch", "3")["y"])[-1] == pytest.approx(90.0)
    assert "are ambiguous" in next(b.caption for b in vertical if b.title == "Depth and attitude")


def test_depth_grows_downwards(blocks):
    ends = figures(blocks)["Depth and attitude"]["layout"]["yaxis"]["range"]
    assert ends[0] > DEPTH > ends[1]


def test_thrusts_show_their_limits(blocks):
    figure = figures(blocks)["Thrusts"]
    assert [numbers(named(figure, f"thruster {k}")["y"]).mean() for k in (1, 6)] == [THRUST, 6.0 * THRUST]
    limited = named(figure, "at its limit")
    assert (min(limited["x"]), max(limited["x"])) == LIMIT
    assert set(limited["y"]) == {6.0 * THRUST}
    table = next(b for b in blocks if b.title == "Thrusters")
    assert table.rows[0] == ("thruster 1", "4", "4", "4", "0 %")
    assert table.rows[5][1:4] == ("24", "24", "24")
    assert float(table.rows[5][4].split()[0]) == pytest.approx(25.5, abs=0.1)  # 5 s and half a step at both ends, of 20


def test_errors_are_told_in_numbers_after_the_transient():
    table = next(b for b in SYSTEMS["rov"].figures(vehicle_run({"transient": 5.0})) if b.title == "Errors")
    rows = {row[0]: row[1:] for row in table.rows}
    assert rows["east"] == ("mm", "200", "200")
    assert rows["yaw"] == ("degrees", "4.06", "5.73")  # 0.1 rad, over whole turns and one sample
    assert table.caption == "From 5 s on."


def test_several_vehicles_share_their_figures():
    result = run(short("rov-added-mass"), in_process=True)
    made = figures(SYSTEMS["rov"].figures(result))
    assert list(made) == ["Track", "Depth and attitude", "Motion in body axes"]
    assert {"hull track", "whole track"} <= {t["name"] for t in made["Track"]["data"]}
    assert "yaxis2" not in made["Track"]["layout"]  # they go straight down: nothing to see from above
    both = [numbers(named(made["Motion in body axes"], f"{u} acceleration z", "2")["y"]) for u in ("hull", "whole")]
    np.testing.assert_allclose(*both, rtol=1e-4)


def test_what_a_body_in_a_perfect_fluid_keeps_is_shown_as_its_drift():
    result = run(short("rov-tumbling"), in_process=True)
    (vehicle,) = vehicles(result)
    assert list(vehicle.constants) == ["energy", "impulse", "moment of impulse"]
    for values in vehicle.constants.values():
        np.testing.assert_allclose(values, values[:, :1] + 0.0 * values, atol=1e-8 * np.abs(values).max())
    # 17 kg at 0.7 m/s ...: the impulse at the start in north, east, down, the body level and bow to the north
    np.testing.assert_allclose(vehicle.constants["impulse"][:, 0], [17.0 * 0.7, -24.2 * 0.4, 26.07 * 0.5])
    blocks = SYSTEMS["rov"].figures(result)
    assert "Drift of energy and impulse" in figures(blocks)


@pytest.mark.parametrize(
    "changes",
    [
        {"units.hull.effects": ["added_mass", "coriolis", "linear_drag"]},
        {"units.hull.effects": ["added_mass"]},
        {"hull.thrust": [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]},
    ],
)
def test_what_is_not_kept_is_not_shown_as_kept(changes):
    (vehicle,) = vehicles(run(short("rov-tumbling").with_changes({"stop_time": 0.04, **changes}), in_process=True))
    assert not vehicle.constants


def test_a_run_without_position_has_no_figures():
    result = run(short("rov-tumbling").with_changes({"record.signals": ["hull.surge"]}), in_process=True)
    assert SYSTEMS["rov"].figures(result) == []


@pytest.mark.parametrize(
    ("fault", "inside"),
    [
        ({"signal": "t3.thrust", "kind": "override", "value": 0.5}, 0.5),
        ({"signal": "hull.thrust[3]", "kind": "drop"}, 0.0),
        ({"signal": "t3.thrust", "kind": "offset", "value": -2.0}, 3.0 * THRUST - 2.0),
        ({"signal": "t3.thrust", "kind": "freeze"}, 3.0 * THRUST),
    ],
)
def test_thrusts_are_those_that_arrive(fault, inside):
    result = vehicle_run()
    result.scene = read_scene({**result.scene.model_dump(), "faults": [{**fault, "begin": 5.0, "end": 10.0}]})
    thrusts = vehicles(result)[0].thrusts
    during = (result.time >= 5.0) & (result.time < 10.0)
    assert set(thrusts[3][during]) == {inside}
    assert set(thrusts[3][~during]) == {3.0 * THRUST}
    assert set(thrusts[2]) == {2.0 * THRUST}


def test_without_a_limit_in_reach_no_share_is_drawn():
    result = vehicle_run()
    result.columns["control.scale"] = np.ones_like(result.time)
    block = next(b for b in SYSTEMS["rov"].figures(result) if b.title == "Thrusts")
    assert "No thruster saturated" in block.caption
    assert not any(t["name"] == "given of what is wanted" for t in block.figure["data"])
