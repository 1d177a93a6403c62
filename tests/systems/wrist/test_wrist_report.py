"""Figures and tables of wrists and linkages carry what made-up signals hold: postures, rule, differences, ligaments, extremes."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from cosimo.orchestrator.run.run_record import RunRecord
from cosimo.orchestrator.systems import SYSTEMS, read_scene
from cosimo.orchestrator.systems.wrist.records import bundles, direction, follows_rule, linkages, muscles, postures, wrists
from cosimo.tests.harness.figures import assert_valid_with_units, figures, tables

pytestmark = pytest.mark.full

UNIT = re.compile(r", (degrees|1|N|N·m|mm|s)$")
HELD = (1.0, 2.0, 3.0, 4.0)  # s: flexion, radial deviation, extension, ulnar deviation
ANGLES = {"flexion": (30, 0, -30, 0), "deviation": (0, 12, 0, -20), "roll": (-2, 1, -2, 4),
          "proximal_flexion": (25, 10, -25, -18), "distal_flexion": (5, -10, -5, 18)}  # fmt: skip


def wrist_run(factors=None, analysis=None, prefix=""):
    """Wrists that go from posture to posture in straight lines, angles times a factor each; muscles, ligaments, a linkage."""
    t = np.linspace(0.0, 5.0, 501)
    units, columns = {}, {}
    for unit, factor in (factors or {"wrist": 1.0}).items():
        name = f"{unit}{prefix}"
        units[name] = {"component": "Wrist"}
        for n, v in ANGLES.items():
            columns[f"{name}.{n}"] = factor * np.radians(np.interp(t, (0.0, *HELD, 5.0), (0.0, *v, 0.0)))
    units |= {"tendons": {"component": "ForearmTendons"}, "ligaments": {"component": "LigamentBundle"},
              "bar": {"component": "FourBar"}}  # fmt: skip
    for i in range(1, 6):
        columns |= {f"tendons.activation[{i}]": 0.1 * i + 0.0 * t, f"tendons.force[{i}]": 10.0 * i + 0.0 * t,
                    f"ligaments.tension[{i}]": (i != 2) * t, f"ligaments.strain[{i}]": 0.01 * t}  # fmt: skip
    columns["tendons.flexion_torque"] = 0.5 * t
    crank = np.linspace(0.0, 2.0 * np.pi, t.size)
    columns |= {"bar.input_angle": crank, "bar.output_angle": 1.0 + 0.3 * np.sin(crank), "bar.ratio": 0.3 * np.cos(crank),
                "bar.transmission_angle": np.radians(78.0 - 34.0 * np.cos(crank)),
                "bar.coupler_point.x": 0.02 * np.cos(crank), "bar.coupler_point.y": 0.02 * np.sin(crank)}  # fmt: skip
    scene = read_scene({
        "title": "Made-up wrist", "stop_time": 5.0, "master": {"step": 0.01}, "units": units,
        "analysis": {"system": "wrist", **(analysis or {})},
    })  # fmt: skip
    return SimpleNamespace(scene=scene, time=t, columns=columns, measures=dict.fromkeys(columns, "1"), snapshots={},
                           outcome="done", message="", info=RunRecord(outcome="done"))  # fmt: skip


@pytest.fixture(scope="module")
def shown():
    return SYSTEMS["wrist"].figures(wrist_run({"intact": 1.0, "cut": 1.2}, {"postures": list(HELD)}))


def test_every_figure_is_valid_and_every_axis_has_its_unit(shown):
    found = figures(shown)
    assert list(found) == ["Motion of the hand and its rows", "Paths", "Muscles", "Ligaments", "Four-bar linkage bar"]
    for figure in [*found.values(), *figures(SYSTEMS["wrist"].figures(wrist_run())).values()]:
        assert_valid_with_units(figure, UNIT)


def test_postures_stand_in_the_table_with_their_rule(shown):
    rows = tables(shown)["Postures"].rows
    assert [r[0] for r in rows] == ["intact"] * 4 + ["cut"] * 4
    assert [r[2] for r in rows[:4]] == ["flexion", "radial deviation", "extension", "ulnar deviation"]
    assert rows[1][3:8] == ("0.00", "12.00", "1.00", "10.00", "−10.00")
    assert {r[8] for r in rows} == {"yes"}


def test_what_differs_from_the_first_stands_in_a_table_of_its_own(shown):
    rows = tables(shown)["Against intact"].rows
    assert [r[:3] for r in rows] == [("cut", "1", "flexion"), ("cut", "2", "radial deviation"), ("cut", "3", "extension"),
                                     ("cut", "4", "ulnar deviation")]  # fmt: skip
    assert rows[3][4] == "−4.00"  # a fifth more of 20 degrees
    assert "Against wrist" not in tables(SYSTEMS["wrist"].figures(wrist_run(analysis={"postures": list(HELD)})))


def test_without_instants_the_ends_of_the_motion_are_the_postures():
    (record,) = wrists(wrist_run())
    found = postures(record)
    assert [(p.name, p.time) for p in found] == [
        ("flexion", pytest.approx(1.0)),
        ("radial deviation", pytest.approx(2.0)),
        ("extension", pytest.approx(3.0)),
        ("ulnar deviation", pytest.approx(4.0)),
    ]
    assert len(postures(record, (), 350)) == 2  # after the transient only what comes then: on the way back, and ulnar


@pytest.mark.parametrize(
    ("angles", "name"),
    [
        ((30, 2), "flexion"),
        ((-30, 30), "radial extension"),
        ((20, -18), "ulnar flexion"),
        ((1, 0), "rest"),
        ((-1, 14), "radial deviation"),
        ((-5, -20), "ulnar deviation"),
    ],
)
def test_directions_have_names(angles, name):
    assert direction(*np.radians(angles)) == name


def test_the_rule_is_broken_by_a_row_that_goes_the_other_way():
    assert follows_rule("radial deviation", 0.2, 0.2) is False
    assert follows_rule("flexion", 0.2, -0.1) is False
    assert follows_rule("flexion", 0.2, 0.001) is None  # hardly moves
    assert follows_rule("ulnar flexion", 0.2, 0.2) is None  # of which it says nothing
    run = wrist_run(analysis={"postures": [2.0]})
    run.columns["wrist.distal_flexion"] = -run.columns["wrist.distal_flexion"]
    assert tables(SYSTEMS["wrist"].figures(run))["Postures"].rows[0][8] == "no"


def test_wrists_of_subsystems_have_the_subsystems_names():
    assert [w.unit for w in wrists(wrist_run({"intact": 1.0, "cut": 1.2}, prefix="_x"))] == ["intact_x", "cut_x"]
    run = wrist_run({"intact": 1.0, "cut": 1.2}, prefix="_x")
    run.columns = {n.replace("_x.", ".wrist."): v for n, v in run.columns.items()}
    units = {u.replace("_x", ".wrist"): v for u, v in run.scene.units.items()}
    run.scene = SimpleNamespace(units=units, coupling=run.scene.coupling)
    assert [w.unit for w in wrists(run)] == ["intact", "cut"]


def test_muscles_ligaments_and_linkages_are_found_by_their_names():
    run = wrist_run()
    (found,) = muscles(run)
    assert list(found.activation) == ["FCR", "FCU", "ECRL", "ECRB", "ECU"]
    assert list(found.torques) == ["flexion"]
    (bound,) = bundles(run)
    assert bound.tension["scapho-lunate"][-1] == 5.0
    (bar,) = linkages(run)
    assert np.degrees(bar.signals["transmission_angle"].max()) == pytest.approx(112.0)
    blocks = {b.title: b for b in SYSTEMS["wrist"].figures(run) if b.kind == "figure"}
    assert "from 44.00 to 112.00 degrees" in blocks["Four-bar linkage bar"].caption
    assert "Without tension throughout: trapezium-scaphoid" in blocks["Ligaments"].caption


def test_the_abstract_and_what_is_ours_are_told_apart(shown):
    text = " ".join(b.caption for b in shown)
    assert "Sandow (2020" in text
    assert text.count("choice of this project") >= 3


def test_without_recorded_angles_there_is_nothing_to_show():
    run = wrist_run()
    run.columns = {"wrist.flexion": run.columns["wrist.flexion"]}
    assert SYSTEMS["wrist"].figures(run) == []
