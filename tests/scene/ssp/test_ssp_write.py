"""Writing .ssp files: the same results after the way there and back, the schema, and what other importers insist on."""

import json
import re
import zipfile
from pathlib import Path

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.fmus.build import built
from cosimo.orchestrator.harness.report import for_run
from cosimo.orchestrator.opened.native import initial_inputs
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.ssp.write import write
from cosimo.orchestrator.settings import SceneSettings
from cosimo.orchestrator.systems import SYSTEMS, load_scene, read_scene
from cosimo.orchestrator.systems.railway.records import passages
from cosimo.orchestrator.units.component import make
from cosimo.tests.commands import exit_code
from cosimo.tests.scene.ssp import systems
from cosimo.tests.short_run import full_but, shipped_scenes
from cosimo.tests.units.native import native_fmu
from fmpy.ssp.ssd import find_components, find_connectors, get_connections, read_ssd
from lxml import etree

NAMESPACES = {
    letters: f"http://ssp-standard.org/SSP1/SystemStructure{name}"
    for letters, name in (("ssd", "Description"), ("ssc", "Common"), ("ssv", "ParameterValues"))
}
RIGID = {"stop_time": 0.05, "units": {"p": {"component": "Pantograph"}}, "master": {"step": 1e-3}}
SHORT = {"en50318-2002": 0.1, "lumped-catenary": 0.2, "rotor-bearings-heat": 0.005, "ball-bearing-clearance": 0.01}


def description(path):
    with zipfile.ZipFile(path) as file:
        return file.read("SystemStructure.ssd")


def adders(folder, **more):
    """Three adders in different units of measure, with parameters of every type."""
    full = {"gain": 2.0, "count": 3, "flag": True, "mode": "high", "text": 'a <b> & "c"\n\té', "u": 0.1}
    return read_scene(
        {
            "stop_time": 2.0,
            "units": {
                "a.one": {"fmu": str(folder / "metres.fmu"), "parameters": full},
                "b": {"fmu": str(folder / "mixed.fmu"), "every": 2, "parameters": {"mode": 1}},
                "c": {"fmu": str(folder / "metres.fmu"), "interface": "co-simulation"},
            },
            "connections": ["a.one.y -> b.u", {"source": "b.y", "target": "c.u", "factor": 1 / 3, "offset": -1e-17}],
            "master": {"step": 0.25, "algorithm": "jacobi", "extrapolation": 1},
            **more,
        },
        "adders",
        folder,
    )


def same(one, other):
    """Whether two results have the same columns to the last bit."""
    assert one.outcome == other.outcome == "done", one.message + other.message
    assert list(one.columns) == list(other.columns)
    return all(one[name].tobytes() == other[name].tobytes() for name in one.columns)


@pytest.mark.parametrize("name", full_but(("lumped-catenary",), SHORT))
def test_shipped_scenes_give_the_same_bits_after_the_way_there_and_back(name, tmp_path):
    scene = load_scene(name).with_changes({"stop_time": SHORT[name]})
    back = load_scene(write(scene, tmp_path / "there.ssp"))
    one, other = run(scene), run(back)
    assert same(one, other)
    assert all(one.snapshots[n].values.tobytes() == other.snapshots[n].values.tobytes() for n in one.snapshots)


def test_foreign_fmus_units_of_measure_and_every_type_of_parameter_give_the_same_bits(folder):
    scene = adders(folder)
    back = load_scene(write(scene, folder / "there.ssp"))
    assert same(run(scene), run(back))
    assert list(back.units) == ["a.one", "b", "c"]
    assert back.units["a.one"].parameters == scene.units["a.one"].parameters
    assert (back.units["b"].parameters, back.units["b"].every, back.units["c"].interface) == ({"mode": "low"}, 2, "co-simulation")
    assert same(run(scene), run(load_scene(write(back, folder / "again.ssp"))))


@pytest.mark.parametrize("fmi", [2, 3])
def test_every_type_of_connection_gives_the_same_bits_in_both_versions_of_fmi(fmi, tmp_path):
    through, source = native_fmu("feedthrough", fmi), native_fmu("dahlquist", fmi)
    scene = read_scene(
        {
            "stop_time": 1.0,
            "master": {"step": 0.1, "algorithm": "jacobi"},
            "units": {
                "d": {"fmu": source},
                "g": {"fmu": through},
                "f": {
                    "fmu": through,
                    "parameters": {"Enumeration_in": "far", "String_in": "hi", "Int32_in": -7, "Boolean_in": True},
                },
            },
            "connections": [
                "d.x -> f.Float64_continuous_input",
                *(f"f.{t}_out -> g.{t}_in" for t in ("Int32", "Boolean", "String", "Enumeration")),
            ],
        },
        "native",
    )
    path = write(scene, tmp_path / "there.ssp")
    systems.validated(description(path))
    one, back = run(scene), run(load_scene(path))
    assert same(one, back)
    assert [one[f"g.{t}_out"][-1] for t in ("Int32", "Boolean", "Enumeration")] == [-7.0, 1.0, 7.0]


def test_everything_else_of_a_scene_survives(folder):
    extra = {
        "record": {"signals": ["c.x", "b.y"], "interval": 0.5},
        "title": "three",
        "faults": [{"signal": "b.u", "kind": "override", "value": 1.0, "begin": 0.5, "end": 1.0}],
        "sweep": {"b.count": [1.0, 2.0]},
        "analysis": {"system": "rotor", "orders": [1.0]},
    }
    scene = adders(folder, **extra)
    back = load_scene(write(scene, folder / "there.ssp"))
    kept = set(SceneSettings.model_fields) - {"units", "connections"}  # every table, also those to come
    assert {k: getattr(back, k) for k in kept} == {k: getattr(scene, k) for k in kept}


def test_files_are_valid_reproducible_and_hold_each_fmu_once(folder):
    one, two = (write(adders(folder), folder / f"{name}.ssp") for name in "ab")
    assert one.read_bytes() == two.read_bytes()
    systems.validated(description(one))
    with zipfile.ZipFile(one) as file:
        assert file.namelist() == ["SystemStructure.ssd", "resources/metres.fmu", "resources/mixed.fmu"]
        assert file.read("resources/mixed.fmu") == (folder / "mixed.fmu").read_bytes()


def test_what_libcosim_and_omsimulator_insist_on(folder):
    """libcosim's parser: prefixes letter by letter, declared at the root, a type and both ends for everything, every child of
    Elements a component, one parameter set, no unit conversion. OMSimulator's: identifiers, explicit type, its annotation
    first, no annotations at components, no top-level elements but System, Units and DefaultExperiment."""
    text = description(write(adders(folder), folder / "there.ssp")).decode()
    root = etree.fromstring(text.encode())
    assert set(re.findall(r"<(\w+):", text)) == {"ssd", "ssc", "ssv", "osp", "oms", "cosimo"}
    assert text.count("xmlns:") == text[: text.index(">", text.index("<ssd:"))].count("xmlns:") == 7
    elements = root.find("ssd:System/ssd:Elements", NAMESPACES)
    assert [e.get("name") for e in elements] == ["a_one", "b", "c"]
    assert {etree.QName(e).localname for e in elements} == {"Component"}
    assert {e.get("type") for e in elements} == {"application/x-fmu-sharedlibrary"}
    assert elements.findall("*/ssd:Annotations", NAMESPACES) == []
    assert all(len(c) == 1 for c in elements.findall("*/ssd:Connectors/ssd:Connector", NAMESPACES))
    assert max(len(b) for b in elements.findall("*/ssd:ParameterBindings", NAMESPACES)) == 1
    connections = root.findall("ssd:System/ssd:Connections/*", NAMESPACES)
    assert all(c.get(k) for c in connections for k in ("startElement", "startConnector", "endElement", "endConnector"))
    first = connections[0]  # from m to mm: told as a transformation, which all importers know
    assert first.get("suppressUnitConversion") == "true"
    assert first.find("ssc:LinearTransformation", NAMESPACES).get("factor") == "1000.0"
    assert [etree.QName(e).localname for e in root] == ["System", "Units", "DefaultExperiment"]
    annotations = root.findall("ssd:System/ssd:Annotations/ssc:Annotation", NAMESPACES)
    assert [a.get("type") for a in annotations] == ["org.openmodelica"]
    assert annotations[0].find(".//{*}FixedStepMaster").get("stepSize") == "0.25"
    experiment = root.find("ssd:DefaultExperiment", NAMESPACES)
    assert [a.get("type") for a in experiment.findall("*/*")] == ["com.opensimulationplatform", "cosimo"]
    assert experiment.find(".//{*}Algorithm/{*}FixedStepAlgorithm").get("baseStepSize") == "0.25"


def test_fmpy_reads_it_and_finds_every_input_connected(tmp_path):
    path = write(load_scene("lumped-catenary"), tmp_path / "there.ssp")
    found = read_ssd(str(path))
    assert [c.source for c in find_components(found.system)] == ["resources/LumpedCatenary.fmu", "resources/Pantograph.fmu"]
    inputs = [c for c in find_connectors(found.system) if c.kind == "input"]
    assert len(get_connections(found.system)) == len(inputs) == 3


def test_without_our_annotation_the_step_of_the_others_holds(folder):
    path = write(adders(folder), folder / "there.ssp")
    text = re.sub(r'<ssc:Annotation type="cosimo">.*?</ssc:Annotation>', "", description(path).decode(), flags=re.DOTALL)
    (folder / "resources").mkdir()
    for name in ("metres.fmu", "mixed.fmu"):
        (folder / "resources" / name).write_bytes((folder / name).read_bytes())
    (folder / "bare.ssd").write_text(text)
    bare = load_scene(folder / "bare.ssd")
    assert (bare.stop_time, bare.master.step, bare.master.algorithm) == (2.0, 0.25, "jacobi")
    assert list(bare.units) == ["a_one", "b", "c"]
    assert bare.units["a_one"].parameters == adders(folder).units["a.one"].parameters


def test_presets_and_effects_become_parameters(tmp_path):
    unit = {"component": "Pantograph", "preset": "EN 50318:2018", "effects": ["bump_stops"]}
    scene = read_scene({**RIGID, "units": {"p": unit}})
    root = etree.fromstring(description(write(scene, tmp_path / "there.ssp")))
    values = {p.get("name"): p[0].get("value") for p in root.iter("{*}Parameter")}
    assert values["effects.bump_stops"] == "true"
    back = load_scene(tmp_path / "there.ssp").units["p"]
    assert back.effects == ("lower_frame", "bump_stops")  # the preset has the first one
    assert same(run(scene), run(load_scene(tmp_path / "there.ssp")))


def test_fmus_of_one_name_and_different_content_do_not_meet(folder, library):
    other = systems.fmu(folder / "other" / "metres.fmu", library)
    scene = read_scene(
        {"stop_time": 1.0, "master": {"step": 0.5}, "units": {"a": {"fmu": str(folder / "metres.fmu")}, "b": {"fmu": str(other)}}}
    )
    back = load_scene(write(scene, folder / "there.ssp"))
    contents = {n: (folder.__class__(u.fmu)).read_bytes() for n, u in back.units.items()}
    assert contents == {"a": (folder / "metres.fmu").read_bytes(), "b": other.read_bytes()}


def test_what_cannot_be_packed_is_refused(tmp_path):
    sides = {
        side: {"force": f"{u}.force", "position": f"{u}.x_out", "velocity": f"{u}.v_out", "inertia": 1.0}
        for side, u in (("first", "a"), ("second", "b"))
    }
    mass = {"component": "cosimo.tests.support:Mass"}
    scene = read_scene(
        {**RIGID, "units": {"a": mass, "b": mass}, "contacts": [{"name": "touch", "law": "spring", "stiffness": 10.0, **sides}]}
    )
    with pytest.raises(BadInput, match="contact law that the master integrates"):
        write(scene, tmp_path / "bad.ssp")
    with pytest.raises(BadInput, match="control characters"):
        write(read_scene({**RIGID, "title": "a\x01b"}), tmp_path / "bad.ssp")
    with pytest.raises(BadInput, match=r"ends in \.ssp"):
        write(read_scene(RIGID), tmp_path / "bad.zip")
    (tmp_path / "file").write_text("")
    with pytest.raises(BadInput, match="can be written"):
        write(read_scene(RIGID), tmp_path / "file" / "x.ssp")


def test_the_command_writes_and_runs_systems(tmp_path, capsys):
    source, path = tmp_path / "rigid.toml", tmp_path / "rigid.ssp"
    source.write_text('stop_time = 0.01\n[units.p]\ncomponent = "Pantograph"\n[master]\nstep = 1e-3\n')
    end = exit_code("ssp", str(source), "--set", "p.speed=50", "-o", str(path))
    assert end == 0
    assert str(path) in capsys.readouterr().out
    assert exit_code("run", str(path), "-o", str(tmp_path)) == 0
    info = json.loads((tmp_path / "run.json").read_text())
    assert info["units"]["p"]["parameters"]["speed"] == 50.0
    assert info["scene"]["units"]["p"]["fmu"].endswith("Pantograph.fmu")


@pytest.mark.full
def test_a_packed_railway_has_the_figures_of_its_scene(tmp_path):
    """A package names no parameter that keeps its default; the supports' positions need one of them."""
    scene = load_scene("en50318-2002").with_changes({"stop_time": 0.5})
    packed = run(load_scene(write(scene, tmp_path / "there.ssp")))
    assert [p.supports for p in passages(packed)] == [p.supports for p in passages(run(scene))]
    titles = [text.count("<figure") for text in (for_run(r, tmp_path, SYSTEMS).read_text() for r in (packed, run(scene)))]
    assert titles[0] == titles[1] > 3


@pytest.mark.full
def test_every_shipped_scene_without_contacts_can_be_packed_with_valid_files(tmp_path):
    scenes = [scene for scene in shipped_scenes().values() if not scene.contacts]
    assert len(scenes) > 5
    for scene in scenes:
        path = write(scene, tmp_path / f"{scene.name}.ssp")
        systems.validated(description(path))
        tables = {Path(u.signals).stem.replace("-", "_"): u.component for u in scene.units.values() if u.signals}
        with zipfile.ZipFile(path) as file:
            for member in file.namelist()[1:]:
                name = member.removeprefix("resources/").removesuffix(".fmu")
                assert file.read(member) == built(tables.get(name, name)).read_bytes()


def test_units_begin_as_in_the_scene_wherever_the_package_runs(tmp_path):
    """Other masters look for no initial values that fit together: from the package's alone each unit has the scene's outputs."""
    scene = load_scene("lumped-catenary").with_changes({"stop_time": 0.01})
    path = write(scene, tmp_path / "there.ssp", initial_inputs(scene))
    first = {name: column[0] for name, column in run(scene, in_process=True).columns.items()}
    seen = 0
    for element in etree.fromstring(description(path)).iter("{*}Component"):
        name = element.get("name")
        component = make(name, scene.units[name])
        given = {p.get("name"): p[0].get("value") for p in element.iter("{*}Parameter") if p.get("name") in component.inputs}
        for port, value in given.items():
            component.set(port, float(value))
        component.initialize(0.0)
        outputs = dict(zip(component.outputs, component.y.tolist(), strict=True))
        recorded = {n: v for n, v in outputs.items() if f"{name}.{n}" in first}
        assert recorded == {n: first[f"{name}.{n}"] for n in recorded}
        seen += len(given) * bool(recorded)
    assert seen == 2  # height of the wire and force; the position begins where it does by default
    back = load_scene(path)
    assert back.remarks == ()
    assert {n: u.parameters for n, u in back.units.items()} == {
        n: u.parameters for n, u in load_scene(write(scene, tmp_path / "without.ssp")).units.items()
    }
