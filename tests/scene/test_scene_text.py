"""A scene as TOML text: every shipped scene comes back the same, names and texts with all signs."""

import tomllib

import pytest
from cosimo.orchestrator.scene.scene import scene_files, scene_text, write_scene
from cosimo.orchestrator.systems import load_scene, read_scene


@pytest.mark.parametrize("name", scene_files())
def test_a_shipped_scene_comes_back(name, tmp_path):
    scene = load_scene(name)
    again = load_scene(write_scene(scene, tmp_path / "again.toml", ["a remark"]))
    assert again.model_dump() == scene.model_dump()


def test_a_scene_with_changes_comes_back(tmp_path):
    scene = load_scene("gimbal-scan").with_changes(
        {
            "units.body.effects": ["gravity"],
            "units.body.parameters": {"gravity.mass": 1e-17, "start_inner_angle": -0.1},
            "record.interval": None,
            "master.step": 1e-3,
        }
    )
    assert load_scene(write_scene(scene, tmp_path / "deep" / "again.toml")).model_dump() == scene.model_dump()


@pytest.mark.parametrize("title", ['a "quoted" \\ title', "two\nlines\tand a tab", "Größe µ = 3 °", "\x7f # no comment", ""])
def test_texts_keep_every_sign(title):
    data = {"title": title, "stop_time": 1.0, "units": {"a.b": {"component": "PlanarLink"}}, "master": {"step": 0.5}}
    text = scene_text(data)
    assert tomllib.loads(text) == data
    assert read_scene(tomllib.loads(text)).title == title


def test_subsystems_are_written_as_their_units(tmp_path):
    (tmp_path / "inner.toml").write_text('stop_time = 1.0\n[units]\nlink = { component = "PlanarLink" }\n[master]\nstep = 0.1\n')
    (tmp_path / "outer.toml").write_text(
        'stop_time = 1.0\n[units]\npart = { scene = "inner.toml", parameters = { link.mass = 2.0 } }\n[master]\nstep = 0.1\n'
    )
    scene = load_scene(tmp_path / "outer.toml")
    again = load_scene(write_scene(scene, tmp_path / "elsewhere" / "again.toml"))
    assert again.units == scene.units
    assert again.units["part.link"].parameters == {"mass": 2.0}
