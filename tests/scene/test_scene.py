"""Scenes: what is refused, with which message; changes; files."""

import copy
from functools import reduce

import jsonschema
import numpy as np
import pytest
from cosimo import BadInput, load_scene, read_scene
from cosimo.components import catalogue
from cosimo.components.catalogue import CATALOGUE
from cosimo.components.core.variables import input_
from cosimo.orchestrator.engine.coupling import resolve_coupling
from cosimo.orchestrator.scene.scene import Scene, read_toml, scene_files
from cosimo.tests.commands import exit_code
from cosimo.tests.support import Linear, two_masses
from pydantic import ValidationError

GOOD = two_masses("gauss-seidel", 1e-2, 1) | {"record": {}}
PANTOGRAPH = {"component": "Pantograph"}
PROBE = {"component": "cosimo.tests.support:Probe"}
SHELF = {"component": "cosimo.tests.scene.test_scene:Shelf"}
NAN, INF = float("nan"), float("inf")


class Shelf(Linear):
    """Takes an array."""

    profile = input_(0.0, "mm", "three lengths", size=3)

    def matrices(self):
        return np.zeros((0, 0)), np.zeros((0, 3)), np.zeros((0, 0)), np.zeros((0, 3)), np.zeros(0)


# (place, bad value, what the message must name)
BAD = [
    ("stop_tme", 1.0, ["stop_tme", "'stop_time'"]),
    ("stop_time", 0.0, ["stop_time", "0 s", "after start_time"]),
    ("stop_time", -1.0, ["stop_time", "-1 s", "after start_time"]),
    ("stop_time", NAN, ["stop_time", "nan"]),
    ("stop_time", INF, ["stop_time", "inf", "finite"]),
    ("stop_time", "long", ["stop_time", "'long'", "number"]),
    ("stop_time", True, ["stop_time", "True", "number"]),
    ("units", {}, ["units", "at least one"]),
    ("units", [], ["units", "table"]),
    ("units.a", 5, ["units.a", "5", "table"]),
    ("units.a-b", PROBE, ["units.a-b", "letters"]),
    ("units.a", {}, ["units.a", "neither component nor fmu"]),
    ("units.a", {**PROBE, "fmu": "x.fmu"}, ["units.a", "both component and fmu"]),
    ("units.a", {"fmu": "no/such.fmu"}, ["units.a.fmu", "no/such.fmu", "FMU file"]),
    ("units.a", {"fmu": __file__}, ["units.a.fmu", "test_scene.py", "an FMU"]),
    ("units.a", {"fmu": __file__, "preset": "p"}, ["units.a.preset", "'p'"]),
    ("units.a.componant", "x", ["units.a", "componant", "'component'"]),
    ("units.a.component", "Pantograf", ["units.a", "Pantograf", "'Pantograph'"]),
    ("units.a.component", "cosimo.tests.support:Mas", ["units.a", "Mas", "'Mass'"]),
    ("units.a.component", "cosimo.tests.suport:Mass", ["units.a", "tests.suport"]),
    ("units.a.parameters.k", "soft", ["a", "'soft'", "number"]),
    ("units.a.parameters.m", -1.0, ["a", "m = -1.0"]),
    ("units.a.parameters.m", NAN, ["a", "m = nan"]),
    ("units.a.parameters.m", None, ["units.a.parameters", "None"]),
    ("units.a.parameters.kk", 1.0, ["a", "'kk'", "'k'"]),
    ("units.a.parameters.force", 1.0, ["units.a.parameters", "'force'", "no effect"]),
    ("units.p", {**PANTOGRAPH, "effects": ["contact_los"]}, ["p", "contact_los", "'contact_loss'"]),
    ("units.p", {**PANTOGRAPH, "effects": "contact_loss"}, ["units.p.effects", "list"]),
    ("units.p", {**PANTOGRAPH, "preset": "EN 50318:2003"}, ["p", "EN 50318:2003", "'EN 50318:2002'"]),
    ("units.p", {**PANTOGRAPH, "parameters": {"bump_stops.travel": 0.1}}, ["p", "bump_stops.travel", "effect 'bump_stops'"]),
    ("connections", ["b.force = a.force"], ["'b.force = a.force'", "->"]),
    ("connections", ["b -> a.force"], ["'b -> a.force'"]),
    ("connections", ["c.force -> a.force"], ["unit 'c'", "a, b"]),
    ("connections", ["b.forse -> a.force"], ["b.forse", "output", "'force'"]),
    ("connections", ["b.force -> a.forse"], ["a.forse", "input", "'force'"]),
    ("connections", ["a.force -> b.position"], ["a.force", "output", "from an output to an input"]),
    ("connections", ["b.force -> a.x_out"], ["a.x_out", "input", "from an output to an input"]),
    ("connections", ["b.force -> a.force", "b.force -> a.force"], ["a.force", "second time"]),
    ("connections", ["a.x_out -> a.force"], ["twice, expected two units"]),
    ("connections", ["a.x_out -> b.velocity"], ["'m'", "'m/s'"]),
    ("connections", "a.x_out -> b.position", ["connections", "list"]),
    ("connections", ["b.* -> a.force"], ["b.* -> a.force", "unit.* -> unit.*"]),
    ("connections", ["b.x* -> a.*"], ["b.x* -> a.*", "outputs _out and inputs force", "at least one name on both sides"]),
    ("connections", ["b.* -> a.*", "b.force -> a.force"], ["a.force", "second time"]),
    ("master", None, ["master", "table"]),
    ("master.step", 0, ["master.step", "0"]),
    ("master.step", -1e-3, ["master.step", "-0.001"]),
    ("master.step", NAN, ["master.step", "nan"]),
    ("master.step", INF, ["master.step", "inf"]),
    ("master.step", 2.0, ["master.step", "2 s", "at most the length of the run"]),
    ("master.step", "1e-3", ["master.step", "'1e-3'", "number"]),
    ("master.algorithm", "gauss_seidel", ["master.algorithm", "'gauss_seidel'", "Did you mean 'gauss-seidel'"]),
    ("master.extrapolation", 3, ["master.extrapolation", "3", "0, 1 or 2"]),
    ("master.moving_places", "held", ["master.moving_places", "'held'", "'linear'"]),
    ("master.feedthrough", "old", ["master.feedthrough", "'old'"]),
    ("master.order", ["a"], ["master.order", "every unit once"]),
    ("master.order", ["a", "a"], ["master.order", "every unit once"]),
    ("master", {"algorithm": "jacobi", "step": 0.1, "order": ["a", "b"]}, ["master.order", "jacobi"]),
    ("record.signals", ["a.x_ot"], ["record.signals", "a.x_ot", "'x_out'"]),
    ("record.signals", ["x_out"], ["record.signals", "unit.variable"]),
    ("record.interval", 5.0, ["record.interval", "5 s"]),
    ("record.snapshot_interval", 0.1, ["record.snapshot_interval", "without snapshots"]),
    ("record.snapshots", ["a.x_out"], ["record.snapshots", "a.x_out"]),
    ("analysis", {"system": "bearing"}, ["analysis.system", "'bearings'"]),
    ("analysis", {"system": "bearings", "transeint": 0.5}, ["analysis", "transeint", "'transient'"]),
    ("analysis", {"system": "railway", "orders": [1.0]}, ["analysis", "'orders'", "system = 'rotor'"]),
    ("analysis", {"window": [0.0, 1.0]}, ["analysis", "'window'", "system = 'railway'"]),
    ("analysis", {"system": ["bearings"]}, ["analysis.system", "'bearings'"]),
    ("analysis", {"transient": "x"}, ["analysis.transient", "'x'", "number"]),
    ("analysis", {"transient": -1.0}, ["analysis.transient", "-1.0"]),
    ("analysis", {"section": {"angle": "a.x_out", "turns": 0}}, ["analysis.section.turns", "0"]),
    ("analysis", {"section": {"signal": 1, "angle": "a.x_out"}}, ["analysis.section.signal", "1", "text"]),
    ("analysis", {"section": {"angle": "a.x_out", "angel": "a.x_out"}}, ["analysis.section", "angel"]),
    ("analysis", {"system": "bearings", "bearing": 5}, ["analysis.bearing", "5"]),
    ("analysis", {"system": "bearings", "marks": ["outr"]}, ["analysis.marks", "outr", "'outer'"]),
    ("analysis", {"system": "bearings", "envelope_band": [1.0]}, ["analysis.envelope_band"]),
    ("analysis", {"system": "bearings", "recurrence": 5}, ["analysis.recurrence", "5", "table"]),
    ("analysis", {"system": "bearings", "recurrence": {"threshold": "x"}}, ["analysis.recurrence.threshold", "'x'"]),
    ("analysis", {"system": "bearings", "recurrence": {"treshold": 1.0}}, ["analysis.recurrence", "treshold", "'threshold'"]),
    ("analysis", {"system": "bearings", "highest_frequency": NAN}, ["analysis.highest_frequency", "nan"]),
    ("analysis", {"system": "rotor", "orders": []}, ["analysis.orders", "at least one"]),
    ("analysis", {"system": "rotor", "orders": 2}, ["analysis.orders", "2", "list"]),
    ("analysis", {"system": "rotor", "orbit_windows": [[2.0, 1.0]]}, ["analysis", "orbit_windows", "[2, 1]"]),
    ("analysis", {"system": "rotor", "critical_speeds": "abc"}, ["analysis.critical_speeds", "'abc'", "list"]),
    ("analysis", {"system": "rotor", "bearing": "x"}, ["analysis", "'bearing'", "system = 'bearings'"]),
    ("analysis", {"system": "friction_drive", "average": 1.0}, ["'average'", "system = 'wind_pump'"]),
    ("analysis", {"system": "friction_drive", "feed_band": 0.0}, ["analysis.feed_band", "0"]),
    ("analysis", {"system": "wind_pump", "averge": 2.0}, ["averge", "'average'"]),
    ("analysis", {"system": "wind_pump", "average": -1.0}, ["analysis.average", "-1"]),
    ("analysis", {"system": "wind_pump", "standstill": 0.0}, ["analysis.standstill", "0"]),
    ("analysis", {"system": "wrist", "posture": [1.0]}, ["posture", "'postures'"]),
    ("analysis", {"system": "wrist", "postures": [-1.0]}, ["analysis.postures", "-1"]),
    ("analysis", {"system": "wrist", "postures": 2.0}, ["analysis.postures", "2.0", "list"]),
    ("analysis", {"system": "pipe_robot", "detail": [2.0, 1.0]}, ["analysis.detail", "end after the start"]),
    ("analysis", {"system": "pipe_robot", "standstill": 1.0}, ["'standstill'"]),
    ("sweep", {"a.m": [True]}, ["sweep.a.m", "True", "number"]),
    ("sweep", {"a.m": ["a"]}, ["sweep.a.m", "'a'", "number"]),
    ("sweep", {"a.m": {"from": 0.0, "to": INF, "points": 3}}, ["sweep", "a.m", "from"]),
    ("units.p", {**PROBE, "parameters": {"length": "3 kg"}}, ["p", "length", "'3 kg'", "dimension of mm"]),
    ("units.p", {**PROBE, "parameters": {"length": True}}, ["p", "length", "True", "number in mm"]),
    ("units.p", {**PROBE, "parameters": {"time": 1.0}}, ["p", "'time'", "this is an output"]),
    ("units.p", {**SHELF, "parameters": {"profile": 1.0}}, ["p", "'profile'", "a list"]),
]


def changed(place: str, value: object) -> dict:
    data = copy.deepcopy(GOOD)
    *path, last = place.split(".", 3)
    reduce(lambda table, key: table.setdefault(key, {}), path, data)[last] = value
    return data


@pytest.mark.parametrize(("place", "value", "named"), BAD)
def test_bad_scenes_give_one_message_that_names_the_fault(place, value, named):
    with pytest.raises(BadInput) as caught:
        read_scene(changed(place, value), "bad")
    message = str(caught.value)
    assert message.startswith("bad: ")
    assert [part for part in named if part not in message] == [], message
    assert "\n" not in message
    assert "pydantic" not in message


ALONE = {**GOOD, "units": {"p": PROBE}, "connections": []}
DELAYED = {**GOOD["master"], "feedthrough": "delayed"}


@pytest.mark.parametrize(
    ("data", "words"),
    [
        *(
            ({k: v for k, v in GOOD.items() if k != missing}, f"{missing}: got nothing, expected a value. Add {missing} = ")
            for missing in ("stop_time", "units", "master")
        ),
        ({**ALONE, "master": {"step": 0.1, "extrapolation": 1}}, "master.extrapolation"),
        ({**ALONE, "master": {"step": 0.1, "feedthrough": "immediate"}}, "master.feedthrough"),
        ({**GOOD, "connections": ["b.force -> a.force"], "master": DELAYED}, r"master\.feedthrough"),  # nothing depends directly
    ],
)
def test_scenes_that_lack_something_are_refused(data, words):
    with pytest.raises(BadInput, match=words):
        read_scene(data)


def test_a_star_connects_all_of_the_same_name():
    scene = read_scene(GOOD)
    starred = read_scene({**GOOD, "connections": ["b.* -> a.*", *GOOD["connections"][1:]]})
    assert resolve_coupling(starred).links == resolve_coupling(scene).links
    units = {"a": {"component": "cosimo.tests.support:Probe"}, "b": {"component": "cosimo.tests.scene.test_scene:Shelf"}}
    links = resolve_coupling(read_scene({**GOOD, "units": units, "connections": ["a.prof* -> b.prof*"]})).links
    assert [(k.source[1], k.target[1]) for k in links] == [(f"profile[{i}]", f"profile[{i}]") for i in (1, 2, 3)]


def test_changes_are_checked_and_leave_the_scene_alone():
    scene = read_scene(GOOD, "two")
    other = scene.with_changes({"a.k": 5.0, "stop_time": 6, "master.step": 5e-4, "record.interval": 0.1})
    assert (other.units["a"].parameters["k"], other.stop_time, other.master.step, other.name) == (5.0, 6.0, 5e-4, "two")
    assert (scene.units["a"].parameters["k"], scene.stop_time) == (10.0, 1.0)
    for change, named in [
        ({"c.k": 1.0}, "'c'"),
        ({"master.stp": 1.0}, "stp"),
        ({"stop_time.x": 1.0}, "stop_time.x"),
        ({"a.k": "x"}, "'x'"),
    ]:
        with pytest.raises(BadInput, match=named):
            scene.with_changes(change)
    with pytest.raises(ValidationError, match="frozen"):
        scene.stop_time = 2.0


def test_names_with_dots_nested_tables_and_lists_are_one_form():
    nested = {**PANTOGRAPH, "effects": ["bump_stops"], "parameters": {"bump_stops": {"travel": 0.02}}}
    scene = read_scene({**GOOD, "connections": [], "units": {"p": nested}, "master": {"step": 0.1}})
    assert scene.units["p"].parameters == {"bump_stops.travel": 0.02}
    assert scene.with_changes({"p.bump_stops.travel": 0.03}).units["p"].parameters == {"bump_stops.travel": 0.03}


def test_undriven_inputs_are_reported_unless_given_a_value():
    scene = {**GOOD, "connections": GOOD["connections"][:2]}
    assert resolve_coupling(read_scene(scene)).undriven == ("b.velocity",)
    scene["units"] = {**GOOD["units"], "b": {**GOOD["units"]["b"], "parameters": {"velocity": 0.1}}}
    assert resolve_coupling(read_scene(scene)).undriven == ()


def test_files(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('stop_time = 1\n[units.p]\ncomponent = "Pantograph"\n[master]\nstep = 0.1\n')
    assert load_scene(path) == load_scene(str(path))
    assert load_scene(path).name == "mine"
    path.write_text("stop_time = 1\nunits = [\nmaster = 3\n")
    with pytest.raises(BadInput, match=r"mine\.toml:\d+: got a syntax error"):
        load_scene(path)
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(BadInput, match="UTF-8"):
        load_scene(path)
    with pytest.raises(BadInput, match="No such file"):
        load_scene(tmp_path / "none.toml")
    with pytest.raises(BadInput, match="'en50318-2002'"):
        load_scene("en50318-2003")


@pytest.mark.parametrize("name", scene_files())
def test_shipped_scenes_are_good(name):
    scene = load_scene(name)
    assert scene.title
    assert read_scene(scene.settings(), name) == scene


@pytest.mark.parametrize(
    ("component", "why"),
    [
        (":X", "ValueError: Empty module name"),
        ("..a:X", "TypeError: "),
        ("no_such_module:X", "ModuleNotFoundError: .* PYTHONPATH"),
        ("faulty_module:X", "ZeroDivisionError: division by zero"),
    ],
)
def test_modules_that_cannot_be_imported_are_bad_input(component, why, tmp_path, monkeypatch):
    (tmp_path / "faulty_module.py").write_text("1 / 0\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(BadInput, match=rf"units\.a: got component .*, expected module:Class that can be imported\. {why}"):
        read_scene({"stop_time": 1.0, "units": {"a": {"component": component}}, "master": {"step": 0.1}})


def test_a_fault_in_a_declaration_of_the_catalogue_has_its_file(tmp_path, monkeypatch):
    (tmp_path / "misdeclared.py").write_text(
        "from cosimo import OdeComponent, parameter\n\n\nclass Slip(OdeComponent):\n    rate = parameter(1.0, '1/s^2', 'a rate')\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(CATALOGUE, "Slip", "misdeclared")
    monkeypatch.setattr(catalogue.importlib, "import_module", lambda name: __import__(name.rpartition(".")[2]))
    with pytest.raises(BadInput, match=r"misdeclared\.py:5: Slip\.rate: got unit '1/s\^2'"):
        read_scene({"stop_time": 1.0, "units": {"a": {"component": "Slip"}}, "master": {"step": 0.1}})


def test_schema_names_every_setting():
    schema = Scene.model_json_schema()
    assert set(schema["properties"]) == set(Scene.model_fields)
    assert schema["$defs"]["MasterSettings"]["properties"]["extrapolation"]["enum"] == [0, 1, 2]


def test_schema_fits_what_scenes_may_say():
    """Editors check with it: it accepts every shipped file, nested tables of parameters and sweeps too, and tells mistakes."""
    schema = Scene.model_json_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    assert {name: [e.message for e in validator.iter_errors(read_toml(path))] for name, path in scene_files().items()} == {
        name: [] for name in scene_files()
    }
    plain = {"stop_time": 1.0, "units": {"a": {"component": "X"}, "b": {"scene": "b.toml"}}, "master": {"step": 0.1}}
    assert validator.is_valid(plain)
    for wrong in (
        {"foo": 1},
        {"master": {"step": -1.0}},
        {"stop_time": "1"},
        {"units": {"1a": {"component": "X"}}},
        {"sweep": {"a.p": []}},
        {"units": {"a": {"component": "X", "parameter": {}}}},
    ):
        assert not validator.is_valid(plain | wrong), wrong


def test_command_line_maps_bad_scenes_to_exit_code_2(tmp_path, capsys):
    path = tmp_path / "bad.toml"
    path.write_text('stop_time = 1\n[units.p]\ncomponent = "Pantograf"\n[master]\nstep = 0.1\n')
    assert exit_code("run", str(path)) == 2
    message = capsys.readouterr().err
    assert message.startswith("cosimo: bad: ")
    assert message.count("\n") == 1
