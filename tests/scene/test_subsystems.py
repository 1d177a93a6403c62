"""Scenes inside scenes: names, parameters, paths, files of other kinds, and what is refused."""

from pathlib import Path

import pytest
from cosimo import BadInput, Scene, load_scene, read_scene
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.ssp.write import write

MASSES = """
connections = ["b.force -> a.force", "a.x_out -> b.position", { source = "a.v_out", target = "b.velocity", factor = 0.5 }]
[units.a]
component = "cosimo.tests.support:Mass"
parameters = { k = 10.0, c = 0.01, v0 = 100.0 }
[units.b]
component = "cosimo.tests.support:Oscillator"
"""
MASTER = {"stop_time": 0.2, "master": {"step": 1e-2, "algorithm": "jacobi"}}
PROBE = {"component": "cosimo.tests.support:Probe"}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "masses.toml").write_text(MASSES)
    return tmp_path


def including(folder, *, connections=(), **units):
    return read_scene({**MASTER, "connections": list(connections), "units": units}, "whole", folder)


def test_a_scene_as_a_subsystem_gives_the_same_bits_as_alone(folder):
    text = (folder / "parts" / "masses.toml").read_text()
    (folder / "alone.toml").write_text("stop_time = 0.2\n" + text + '[master]\nstep = 1e-2\nalgorithm = "jacobi"\n')
    alone = run(load_scene(folder / "alone.toml"))
    for file in ("parts/masses.toml", "alone.toml"):  # with and without stop time and master of its own
        result = run(including(folder, sub={"scene": file}))
        assert list(result.columns) == [f"sub.{name}" for name in alone.columns]
        assert all((result.columns[f"sub.{name}"] == column).all() for name, column in alone.columns.items())


def test_connections_reach_into_subsystems_and_parameters_change_them(folder):
    (folder / "outer.toml").write_text('[units]\ninner = { scene = "parts/masses.toml", parameters = { a.v0 = 7.0 } }\n')
    scene = including(
        folder,
        connections=["left.inner.a.x_out -> p.length"],
        p=PROBE,
        left={"scene": "outer.toml"},
        right={"scene": "parts/masses.toml", "parameters": {"a": {"v0": 3.0}, "b.k": 5.0}},
    )
    assert list(scene.units) == ["p", "left.inner.a", "left.inner.b", "right.a", "right.b"]
    assert [scene.units[n].parameters.get("v0") for n in ("left.inner.a", "right.a")] == [7.0, 3.0]
    assert scene.units["right.b"].parameters == {"k": 5.0}
    assert "left.inner.b.force -> left.inner.a.force" in scene.arrows
    result = run(scene)
    assert result["left.inner.a.v_out"][0] == 7.0
    changed = scene.with_changes({"right.a.v0": 11.0})
    assert changed.units["right.a"].parameters["v0"] == 11.0
    assert read_scene(scene.settings(), "whole") == scene


def test_paths_are_relative_to_the_file_that_names_them(folder):
    packed = write(
        read_scene({"stop_time": 1.0, "units": {"p": {"component": "Pantograph"}}, "master": {"step": 0.1}}, "rigid"),
        folder / "parts" / "rigid.ssp",
    )
    fmu = load_scene(packed).units["p"].fmu
    (folder / "parts" / "own.fmu").write_bytes(Path(fmu).read_bytes())
    (folder / "parts" / "own.toml").write_text('[units]\np = { fmu = "own.fmu" }\nq = { scene = "rigid.ssp" }\n')
    scene = including(folder, s={"scene": "parts/own.toml"}, t={"scene": "parts/rigid.ssp", "parameters": {"p.speed": 50.0}})
    assert {n: u.fmu for n, u in scene.units.items()} == {"s.p": str(folder / "parts" / "own.fmu"), "s.q.p": fmu, "t.p": fmu}
    assert scene.units["t.p"].parameters == {"speed": 50.0}


def test_shipped_scenes_can_be_included(folder):
    scene = including(folder, track={"scene": "lumped-catenary"})
    assert scene.master.step == 1e-2  # of this scene; that of the included one belongs to its own runs
    assert "track.catenary.wire_height -> track.pantograph.wire_height" in scene.arrows


def test_contacts_belong_to_a_subsystem(folder):
    (folder / "touching.toml").write_text("""
[units]
one = { component = "cosimo.tests.support:Mass" }
two = { component = "cosimo.tests.support:Mass" }
[[contacts]]
name = "touch"
law = "spring"
stiffness = 10.0
first = { force = "one.force", position = "one.x_out", velocity = "one.v_out", inertia = 1.0 }
second = { force = "two.force", position = "two.x_out", velocity = "two.v_out", inertia = 1.0 }
""")
    (contact,) = including(folder, left={"scene": "touching.toml"}).contacts
    assert (contact.name, contact.first.force, contact.second.velocity) == ("left.touch", "left.one.force", "left.two.v_out")
    assert (contact.law, contact.second.inertia) == ("spring", 1.0)


BAD = [
    ({"sub": {"scene": "none.toml"}}, ["none.toml", "No such file"]),
    ({"sub": {"scene": "lumped-catenery"}}, ["whole: units.sub.scene", "'lumped-catenary'"]),
    ({"sub": {"scene": 5}}, ["whole: units.sub.scene", "5", "text"]),
    ({"sub": {"scene": "parts/masses.toml", "effects": []}}, ["whole: units.sub", "'effects'"]),
    ({"sub": {"scene": "parts/masses.toml", "parameters": {"c.k": 1.0}}}, ["units.sub.parameters", "'c'", "There is a, b"]),
    ({"sub": {"scene": "parts/masses.toml", "parameters": {"a.kk": 1.0}}}, ["sub.a", "'kk'", "'k'"]),
    ({"sub": {"scene": "parts/masses.toml", "parameters": {"a.k": None}}}, ["whole: units.sub.parameters", "None"]),
    ({"sub": {"scene": "parts/masses.toml"}, "sub.a": PROBE}, ["two units 'sub.a'"]),
    ({"sub-x": {"scene": "parts/masses.toml"}}, ["units.sub-x.a"]),
    ({"sub": {"scene": "circle.toml"}}, ["circle.toml", "do not contain themselves"]),
    ({"sub": {"scene": "typo.toml"}}, ["typo: got unknown key 'conections'", "'connections'"]),
    ({"sub": {"scene": "wrong.toml"}}, ["whole: ", "sub.a.forse", "'force'"]),
    ({"sub": {"scene": "form.toml"}}, ["whole: ", "sub.b.force = a.force"]),
]


@pytest.mark.parametrize(("units", "named"), BAD)
def test_bad_subsystems_give_one_message(folder, units, named):
    (folder / "circle.toml").write_text('[units]\na = { scene = "other.toml" }\n')
    (folder / "other.toml").write_text('[units]\nb = { scene = "circle.toml" }\n')
    (folder / "typo.toml").write_text(MASSES.replace("connections", "conections"))
    (folder / "wrong.toml").write_text(MASSES.replace("a.force", "a.forse"))
    (folder / "form.toml").write_text(MASSES.replace("b.force -> a.force", "b.force = a.force"))
    with pytest.raises(BadInput) as caught:
        including(folder, **units)
    message = str(caught.value)
    assert [part for part in named if part not in message] == [], message


def test_the_schema_has_subsystems_beside_units():
    (forms,) = Scene.model_json_schema()["properties"]["units"]["patternProperties"].values()
    unit, subsystem = forms["else"], forms["then"]
    assert (unit["$ref"], sorted(subsystem["properties"])) == ("#/$defs/UnitSettings", ["parameters", "scene"])
