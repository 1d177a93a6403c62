"""Figures of bearings and rotors carry what the made-up signals hold: lines, orbits, resonance, criticals, units."""

import json
import re
from types import SimpleNamespace

import numpy as np
import plotly.graph_objects as go
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.analysis.records import RecordedUnit
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import SYSTEMS, load_scene
from cosimo.orchestrator.systems.bearings.records import bearings
from cosimo.orchestrator.systems.rotor.records import rotors
from cosimo.orchestrator.systems.rotor.whirl import whirl
from cosimo.tests.harness.figures import assert_valid_with_units, figures, numbers
from cosimo.tests.systems.bearings.machines import JIS_6306, RATE, SPEED, bearing_run, rotor_run

pytestmark = pytest.mark.full

UNIT = re.compile(r", (m|N|s|mm|µm|Hz|rpm|degrees|mm/s|m/s²|1|1/s|%|√µm)\b|number of at least")


def named(figure, name):
    return next(t for t in figure["data"] if t.get("name") == name)


@pytest.fixture(scope="module")
def bearing():
    return figures(SYSTEMS["bearings"].figures(bearing_run()))


@pytest.fixture(scope="module")
def rotor():
    return figures(SYSTEMS["rotor"].figures(rotor_run({"critical_speeds": [100.0]})))


def test_every_figure_is_valid_and_every_axis_has_its_unit(bearing, rotor):
    for figure in (*bearing.values(), *rotor.values()):
        assert_valid_with_units(figure, UNIT)


def test_bearing_report_has_its_figures_and_tables():
    blocks = SYSTEMS["bearings"].figures(bearing_run())
    assert list(figures(blocks)) == [
        "Time history", "Amplitude spectrum", "Envelope spectrum", "Orbit and phase planes", "Recurrence",
    ]  # fmt: skip
    recurrence, motion = (b for b in blocks if b.kind == "cells")
    assert [row[1] for row in recurrence.rows] == ["RR", "DET", "L", "Lmax", "DIV", "ENTR", "LAM", "TT"]
    assert motion.rows[0][:3] == ("displacement x", "µm", "5")


def test_lines_stand_at_the_frequencies_of_the_geometry(bearing):
    outer = numbers(named(bearing["Amplitude spectrum"], "outer race (BPFO)")["x"])
    expected = JIS_6306["outer"] * np.arange(1, 6)
    assert np.unique(outer[~np.isnan(outer)]) == pytest.approx(expected, rel=1e-5)  # six digits are drawn
    assert {n["text"] for n in bearing["Amplitude spectrum"]["layout"]["annotations"]} >= {"BPFO", "shaft"}


def test_inner_race_gets_sidebands_of_the_rotation_when_it_has_the_defect():
    figure = figures(SYSTEMS["bearings"].figures(bearing_run(effects=("inner_defect",))))["Amplitude spectrum"]
    at = numbers(named(figure, "inner race (BPFI)")["x"])
    assert np.unique(at[~np.isnan(at)])[:5] == pytest.approx(JIS_6306["inner"] + 30.0 * np.arange(-2, 3), rel=1e-5)


def test_envelope_finds_the_repetition_of_what_rings(bearing):
    trace = named(bearing["Envelope spectrum"], "envelope")
    f, a = numbers(trace["x"]), numbers(trace["y"])
    assert f[np.argmax(a)] == pytest.approx(JIS_6306["outer"], abs=1.0 / 1.75)  # a bin: 1.75 s after the transient


def test_displacement_spectrum_reads_the_amplitude_in_its_unit(bearing):
    trace = named(bearing["Amplitude spectrum"], "x")
    f, a = numbers(trace["x"]), numbers(trace["y"])
    assert f[np.argmax(a)] == pytest.approx(30.0, abs=0.6)  # a bin
    assert a.max() == pytest.approx(2.0, rel=0.152)  # µm; halfway between bins Hann reads 0.849


def test_orbit_has_one_scale_and_its_section(bearing):
    layout = bearing["Orbit and phase planes"]["layout"]
    assert layout["yaxis"]["scaleanchor"] == "x"
    assert np.ptp(layout["xaxis"]["range"]) == pytest.approx(np.ptp(layout["yaxis"]["range"]))
    # The section's cage angle passes multiples of 1/8 turn 92.54 times a second; the motion has 30 Hz: no common period.
    section = named(bearing["Orbit and phase planes"], "section")
    assert len(section["x"]) == pytest.approx(1.75 * JIS_6306["outer"], abs=1)
    x, y = numbers(section["x"]), numbers(section["y"])
    assert ((x - 5.0) / 2.0) ** 2 + y**2 == pytest.approx(1.0, abs=1e-4)  # on the ellipse; five digits are drawn


def test_section_of_the_scene_is_taken():
    wanted = {"section": {"signal": "bearing.displacement_x", "angle": "bearing.inner_angle", "turns": 1}}
    figure = figures(SYSTEMS["bearings"].figures(bearing_run(wanted)))["Orbit and phase planes"]
    x = numbers(named(figure, "section")["x"])
    assert x == pytest.approx(7.0, abs=1e-4)  # 5 + 2 µm at angle zero, each turn
    assert len(x) == 52  # 30 turns a second, from 0.25 s (7.5 turns) to 2 s (60 turns, the last sample is just before it)


def test_without_an_angle_the_section_is_where_the_velocity_rises_through_zero():
    result = bearing_run()
    for name in ("bearing.inner_angle", "bearing.cage_angle"):
        del result.columns[name]
    section = named(figures(SYSTEMS["bearings"].figures(result))["Orbit and phase planes"], "section")
    assert numbers(section["x"]) == pytest.approx(3.0, abs=1e-4)  # x = 5 + 2 cos: its least, in µm
    assert numbers(section["y"]) == pytest.approx(0.0, abs=1e-4)


def test_recurrence_of_a_periodic_motion_is_diagonal():
    tables = [b for b in SYSTEMS["bearings"].figures(bearing_run()) if b.kind == "cells"]
    measures = {r[1]: r[2] for r in tables[0].rows}
    # Every diagonal is whole but for the corners; the interval of recording is no multiple of the period.
    assert float(measures["DET"]) > 99.5
    picture = next(t for t in figures(SYSTEMS["bearings"].figures(bearing_run()))["Recurrence"]["data"] if t["type"] == "heatmap")
    z = np.array(picture["z"])
    assert (z == z.T).all()
    assert (np.diag(z) == 1).all()


def test_settings_of_the_analysis_that_do_not_exist_are_named():
    for analysis, meant in (
        ({"marks": ["outter"]}, "outer"), ({"recurrence": {"treshold": 1}}, "threshold"), ({"bearing": "beering"}, "bearing"),
        ({"section": {"signal": "bearing.displacement_x", "angle": "bearing.cag_angle"}}, "cage_angle"),
    ):  # fmt: skip
        with pytest.raises(BadInput, match=meant):
            SYSTEMS["bearings"].figures(bearing_run(analysis))


def test_dimensionless_bearing_has_no_units_of_measure():
    result = bearing_run()
    result.measures = dict.fromkeys(result.columns, "1")
    axes = [a["title"]["text"] for f in figures(SYSTEMS["bearings"].figures(result)).values()
            for k, a in f["layout"].items() if re.fullmatch(r"[xy]axis\d*", k)]  # fmt: skip
    assert not [text for text in axes if re.search(r", (s|Hz|m|µm|mm/s|N)\b", text)]


def test_bearing_record_knows_rotation_and_frequencies():
    (record,) = bearings(bearing_run())
    assert record.rotation == pytest.approx(SPEED / (2 * np.pi), rel=1e-9)  # rounding of the angle
    assert record.rate == pytest.approx(RATE)
    assert record.frequencies["outer"] == pytest.approx(JIS_6306["outer"], rel=1e-5)
    assert record.defects == ("outer",)


def test_a_speed_that_changes_or_turns_back_has_no_frequencies():
    result = bearing_run()
    for shape in (1.0 + 0.2 * result.time, 1.0 - 1.0 * result.time, np.zeros_like(result.time)):
        angle = np.cumsum(SPEED * shape) / RATE
        result.columns |= {"bearing.inner_angle": angle % (2 * np.pi), "bearing.cage_angle": 0.4 * angle % (2 * np.pi)}
        (record,) = bearings(result)
        assert not record.frequencies
        titles = set(figures(SYSTEMS["bearings"].figures(result)))
        assert titles == {"Time history", "Amplitude spectrum", "Orbit and phase planes", "Recurrence"}


def test_rotor_that_turns_back_is_shown_without_orders():
    result = rotor_run(rate=-4.0)
    assert set(figures(SYSTEMS["rotor"].figures(result))) == {
        "Time history", "Amplitude spectrum at 191 rpm", "Orbits", "Forces of the bearings",
    }  # fmt: skip


def test_sources_are_found_through_wildcards():
    result = rotor_run()
    front, rotor = RecordedUnit(result, "front"), RecordedUnit(result, "rotor")
    assert front.source("displacement_x") == "rotor.bearing_a.displacement_x"
    assert rotor.source("bearing_a.force_x") == "front.linearisation.force_x"
    assert front.source("clearance_change") == ""  # nothing of that name
    assert front.column("displacement_x") == "rotor.bearing_a.displacement_x"
    assert front.column("clearance_change") == ""


def test_rotor_report_has_its_figures(rotor):
    run_up = ("Run-up: synchronous motion", "Run-up: polar plot")
    assert list(rotor) == ["Time history", *run_up, "Waterfall", "Orbits", "Forces of the bearings"]


def test_run_up_shows_the_resonance_with_amplitude_and_phase(rotor):
    figure = rotor["Run-up: synchronous motion"]
    x = [t for t in figure["data"] if t.get("name") == "x"]
    speed, amplitude, lag = numbers(x[0]["x"]), numbers(x[0]["y"]), numbers(x[1]["y"])
    top = int(np.argmax(amplitude))
    # Peak of r^2 / |1 - r^2 + 2 i zeta r| at r = (1 - 2 zeta^2)^-1/2, 1 / (2 zeta sqrt(1 - zeta^2)) high; a window of 4 turns
    # is 0.25 s there, 5 rad/s: a quarter of the resonance's width.
    assert speed[top] == pytest.approx(100.0 / np.sqrt(0.98) * 30 / np.pi, rel=0.02)
    assert amplitude[top] == pytest.approx(10.0 * 5.025, rel=0.02)
    assert np.interp(100.0 * 30 / np.pi, speed, lag) == pytest.approx(90.0, abs=3.0)
    marked = numbers(named(figure, "critical speed (undamped)")["x"])
    assert marked[0] == pytest.approx(954.93, abs=0.01)


def test_waterfall_follows_the_rotation(rotor):
    picture = next(t for t in rotor["Waterfall"]["data"] if t["type"] == "heatmap")
    speed, f, z = numbers(picture["x"]), numbers(picture["y"]), np.array(picture["z"], dtype=float)
    # The highest amplitude at a speed is at its frequency: within the spread over a window plus a bin.
    assert f[np.argmax(z, axis=0)] == pytest.approx(speed / 60.0, abs=1.5 * (f[1] - f[0]) + 0.5 * 20.0 * 0.32 / (2 * np.pi))


def test_orbits_are_shown_for_every_window_and_place():
    shown = [b for b in SYSTEMS["rotor"].figures(rotor_run({"orbit_windows": [[1.0, 1.2], [19.0, 19.2]]})) if b.title == "Orbits"]
    assert len(shown) == 2
    first = shown[0].figure
    orbits = [t for t in first["data"] if t["name"] == "orbit"]
    assert len(orbits) == 2  # watched place and bearing
    assert max(numbers(orbits[1]["x"])) == pytest.approx(0.1 * max(numbers(orbits[0]["x"])), rel=1e-4)
    assert [first["layout"][k]["scaleanchor"] for k in ("yaxis", "yaxis2")] == ["x", "x2"]


def test_campbell_diagram_adds_the_recorded_tangent_of_the_bearing():
    result = rotor_run()
    (record,) = rotors(result)
    assert whirl(result, record) is None  # a bearing of unknown stiffness
    free, held = np.zeros((3, 25)), np.zeros((3, 25))
    held[:, [0, 6]] = 1e9  # N/m along x and y: far above the supports' 1e6
    for tangent in (free, held):
        result.snapshots = {"front.linearisation.stiffness": SimpleNamespace(time=np.array([0.0, 1.0, 2.0]), values=tangent)}
        found = whirl(result, record)
        assert found.frequency.shape == found.direction.shape == (61, 8)
        # The bearing stands at the end of the shaft where a support of 1e6 N/m is: with it, the lowest mode is higher.
        if tangent is free:
            # 86.66 rad/s: Friswell et al., example 5.9.1, at rest
            assert found.frequency[0, 0] == pytest.approx(86.66, rel=1e-3)
            lowest = found.frequency[0, 0]
        else:
            assert found.frequency[0, 0] > 1.05 * lowest
    figure = figures(SYSTEMS["rotor"].figures(result))["Campbell diagram"]
    synchronous = named(figure, "1 × speed")
    assert synchronous["y"][1] == pytest.approx(synchronous["x"][1] / 60.0, rel=1e-4)  # five digits are drawn


def test_campbell_diagram_with_modes_that_are_overdamped_at_some_speeds():
    """A bare shaft of one element on dampers of 1e4 N.s/m: 4 modes oscillate at rest, 8 at speed."""
    result = rotor_run()
    rotor = result.scene.units["rotor"]
    damping = {f"linear_supports.damping_{axis}[{k}]": 1e4 for axis in "xy" for k in (1, 2)}
    result.scene.units["rotor"] = rotor.model_copy(update={
        "effects": ["gyroscopic", "linear_supports"], "parameters": {"element": 1.5, "watched_position": 0.0, **damping},
    })  # fmt: skip
    (record,) = rotors(result)
    found = whirl(result, record)
    assert np.isfinite(found.frequency).sum(axis=1)[[0, -1]].tolist() == [4, 8]
    figure = figures(SYSTEMS["rotor"].figures(result))["Campbell diagram"]
    go.Figure(figure)
    json.dumps(figure, allow_nan=False)
    drawn = np.concatenate([numbers(t["y"]) for t in figure["data"] if "whirl" in t.get("name", "")])
    assert np.isfinite(drawn).any()


def test_steady_rotor_has_a_spectrum_with_its_speed_marked():
    figure = figures(SYSTEMS["rotor"].figures(rotor_run(rate=0.0, duration=5.0)))["Amplitude spectrum at 382 rpm"]
    trace = named(figure, "x")
    assert numbers(trace["x"])[np.argmax(numbers(trace["y"]))] == pytest.approx(40.0 / (2 * np.pi), abs=0.2)  # a bin


@pytest.mark.parametrize(
    ("name", "stop", "expected"),
    [
        ("outer-ring-defect", 0.3, {"Amplitude spectrum", "Envelope spectrum", "Orbit and phase planes", "Recurrence"}),
        ("gyroscopic-rotor", 6.0, {"Time history", "Run-up: synchronous motion", "Waterfall", "Campbell diagram", "Orbits"}),
    ],
)
def test_shipped_scenes_have_their_figures(name, stop, expected):
    scene = load_scene(name).with_changes({"stop_time": stop, "analysis.transient": 0.1})
    result = run(scene, in_process=True)
    made = figures(SYSTEMS[scene.analysis.system].figures(result))
    assert expected <= set(made)
    if "Campbell diagram" in made:
        # Friswell et al., example 5.9.1: synchronous critical speeds on isotropic supports 86.4, 86.9 and 260.5 rad/s (825, 830,
        # 2488 rpm); with supports a fifth stiffer upwards they lie at and above these.
        marked = numbers(named(made["Campbell diagram"], "critical speed (undamped)")["x"])
        first = np.unique(marked[~np.isnan(marked)])[0]
        assert 825.0 <= first <= 830.0
