"""The JSON schema of scene files: every shipped scene fits, and what only an editor could see in time does not."""

import json
import tomllib

import jsonschema
import pytest
from cosimo import BadInput, read_scene
from cosimo.orchestrator.scene.scene import scene_files
from cosimo.orchestrator.systems.scene_schema import scene_schema
from cosimo.tests.commands import exit_code

SCENE = {"stop_time": 1.0, "master": {"step": 1e-3}}


@pytest.fixture(scope="module")
def validator():
    schema = scene_schema()
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def test_every_shipped_scene_fits_and_names_the_schema(validator):
    for name, path in scene_files().items():
        text = path.read_text()
        assert [e.message for e in validator.iter_errors(tomllib.loads(text))] == [], name
        assert text.startswith("#:schema ../../../../scene.schema.json\n"), name


@pytest.mark.parametrize(
    "unit",
    [
        {"component": "Pantograph", "parameters": {"speed": 70, "bump_stops": {"travel": 0.04}, "bump_stops.stiffness": 1e5}},
        {"component": "Catenary", "parameters": {"dropper_position": [5.0, 10.5], "dropper_position[1]": 6.0}},
        {"component": "Pantograph", "preset": "DSA380", "effects": ["lower_frame"]},
        {"component": "mine:Own", "parameters": {"anything": [[1, 2], [3, 4]]}, "effects": ["any"]},
        {"fmu": "box.fmu", "parameters": {"k": True}},
        {"scene": "other.toml", "parameters": {"p.speed": 1.0}},
    ],
)
def test_what_may_be_said(validator, unit):
    assert [e.message for e in validator.iter_errors({**SCENE, "units": {"u": unit}})] == []


@pytest.mark.parametrize(
    ("unit", "place"),
    [
        ({"component": "Pantagraph"}, "component"),
        ({"component": "Pantograph", "parameters": {"sped": 70}}, "parameters"),
        ({"component": "Pantograph", "parameters": {"speed": -1}}, "speed"),
        ({"component": "Pantograph", "parameters": {"speed": "fast"}}, "speed"),
        ({"component": "Pantograph", "parameters": {"bump_stops": {"trawel": 1}}}, "bump_stops"),
        ({"component": "Pantograph", "effects": ["bump_stop"]}, "effects"),
        ({"component": "Pantograph", "preset": "DSA381"}, "preset"),
        ({"component": "Pantograph", "efects": []}, "u"),
        ({"scene": "other.toml", "effects": []}, "u"),
    ],
)
def test_what_is_marked_at_its_place(validator, unit, place):
    errors = list(validator.iter_errors({**SCENE, "units": {"u": unit}}))
    assert errors
    assert any(place in map(str, e.absolute_path) for e in errors), [e.json_path for e in errors]


def test_keys_of_analysis_depend_on_the_system(validator):
    def errors(analysis):
        return list(validator.iter_errors({**SCENE, "units": {"u": {"fmu": "a.fmu"}}, "analysis": analysis}))

    assert errors({"system": "railway", "window": [240.0, 360.0]}) == []
    assert errors({"system": "railway", "windw": [240.0, 360.0]})
    assert errors({"system": "railways"})


@pytest.mark.parametrize(("wrong", "right"), [("mastr", "master"), ("stop_tim", "stop_time"), ("unit", "units")])
def test_a_misspelt_table_is_named_with_the_nearest_key(wrong, right):
    data = {**SCENE, "units": {"p": {"component": "Pantograph"}}}
    data[wrong] = data.pop(right)
    with pytest.raises(BadInput, match=f"unknown key '{wrong}'.*Did you mean '{right}'"):
        read_scene(data)


def test_the_command_writes_it(tmp_path):
    assert exit_code("schema", "-o", str(tmp_path / "scene.schema.json")) == 0
    assert json.loads((tmp_path / "scene.schema.json").read_text())["properties"]["stop_time"]


def test_it_is_written_where_the_editor_of_a_scene_looks_for_it(tmp_path, capsys):
    """With the path that shipped scenes have, in place of an old one; without a path beside the scene, which then names it."""
    folder = tmp_path / "a" / "b" / "c" / "d"
    folder.mkdir(parents=True)
    shipped, own = folder / "shipped.toml", folder / "own.toml"
    shipped.write_bytes(scene_files()["mass-on-spring"].read_bytes())
    own.write_bytes(b"\xef\xbb\xbfstop_time = 1.0\r\n# \xc2\xb5\r\n")
    (tmp_path / "scene.schema.json").write_text("of an earlier version")
    assert exit_code("schema", shipped, own) == 0
    assert json.loads((tmp_path / "scene.schema.json").read_text()) == scene_schema()
    assert (folder / "scene.schema.json").read_text() == (tmp_path / "scene.schema.json").read_text()
    assert own.read_bytes() == b"#:schema scene.schema.json\nstop_time = 1.0\r\n# \xc2\xb5\r\n"
    assert exit_code("schema", own) == 0
    assert own.read_bytes().count(b"#:schema") == 1
    assert shipped.read_bytes() == scene_files()["mass-on-spring"].read_bytes()


@pytest.fixture
def beside(tmp_path):
    """A scene with a schema beside it, and a function that changes what the schema says."""
    scene = tmp_path / "own scene.toml"
    scene.write_bytes(scene_files()["mass-on-spring"].read_bytes().replace(b"../", b""))
    assert exit_code("schema", scene) == 0

    def change(edit):
        file = tmp_path / "scene.schema.json"
        content = json.loads(file.read_text())
        edit(content)
        file.write_text(json.dumps(content))

    return scene, change


def warnings_of(capsys, *arguments):
    capsys.readouterr()
    assert exit_code(*map(str, arguments)) == 0
    return [line for line in capsys.readouterr().err.splitlines() if "schema" in line]


@pytest.mark.parametrize(
    "edit",
    [
        lambda schema: schema.update({"$comment": "written by cosimo 0.0.1"}),
        lambda schema: schema.pop("$comment"),  # as before there was a mark
        lambda schema: schema["$defs"].pop("component.Catenary"),
        lambda schema: schema["$defs"]["component.PlanarLink"]["properties"]["parameters"]["properties"].pop("mass"),
    ],
    ids=["version", "no mark", "list of components", "a component of the scene"],
)
def test_a_person_is_told_of_a_stale_schema_and_how_to_mend_it(beside, edit, capsys):
    scene, change = beside
    assert warnings_of(capsys, "show", scene) == []
    change(edit)
    (line,) = warnings_of(capsys, "show", scene)
    assert f"Write it anew: cosimo schema '{scene}'" in line
    assert warnings_of(capsys, "run", scene, "--dry-run") == [line]
    assert exit_code("schema", scene) == 0
    assert warnings_of(capsys, "show", scene) == []


@pytest.mark.parametrize("content", [b"{", b"[]", b'{"title": "of another program"}', b"\xff"])
def test_a_file_that_is_no_schema_of_scenes_is_left_alone(beside, content, capsys, tmp_path):
    (tmp_path / "scene.schema.json").write_bytes(content)
    assert warnings_of(capsys, "show", beside[0]) == []


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("missing.toml", None, "a scene file"),
        ("scene.ssd", b"<a/>", "a scene file"),
        ("latin.toml", b"title = '\xb5'", "UTF-8"),
        ("far.toml", b"#:schema https://example.org/a.json\n", "the path of a file"),
        ("none.toml", b"#:schema \n", "the path of a file"),
    ],
)
def test_what_has_no_place_for_it_is_refused(name, content, message, tmp_path, capsys):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    assert exit_code("schema", tmp_path / name) == 2
    assert message in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ([name] if content is not None else [])
