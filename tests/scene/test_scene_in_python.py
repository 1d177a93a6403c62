"""Scenes written, changed and drawn in Python."""

import xml.etree.ElementTree as xml

import cosimo
import pytest
from cosimo import BadInput, load_scene, read_scene
from cosimo.orchestrator.scene.drawing import Arrow, Box, _columns, draw
from cosimo.orchestrator.scene.scene import scene_files
from cosimo.tests.support import Mass, Oscillator, two_masses

SVG = "{http://www.w3.org/2000/svg}"


def test_a_scene_of_classes_is_that_of_their_names():
    scene = cosimo.build_scene(
        {"a": cosimo.unit(Mass, k=10.0, c=0.01, v0=100.0), "b": Oscillator},
        {"b.force": "a.force", "a.x_out": "b.position", "a.v_out": "b.velocity"},
        stop_time=1,
        step=1e-2,
        master={"algorithm": "jacobi", "extrapolation": 0, "feedthrough": "immediate"},
    )
    assert scene.settings() == read_scene(two_masses()).settings()


def test_effects_presets_and_arrays_of_a_unit():
    unit = cosimo.unit("Pantograph", effects=["bump_stops"], preset="DSA380", bump_stops={"travel": 0.04}, settings={"every": 2})
    scene = cosimo.build_scene({"p": unit}, stop_time=1.0, step=1e-3)
    assert scene.units["p"].parameters == {"bump_stops.travel": 0.04}
    assert (scene.units["p"].preset, scene.units["p"].every) == ("DSA380", 2)
    assert cosimo.unit("box.fmu") == {"fmu": "box.fmu"}
    assert cosimo.unit("other.toml", a={"k": 1.0}) == {"scene": "other.toml", "parameters": {"a": {"k": 1.0}}}
    assert cosimo.unit(cosimo.component_class("Pantograph")) == {"component": "Pantograph"}


def test_a_class_that_nobody_could_look_up_is_refused():
    class Local(Mass):
        pass

    with pytest.raises(BadInput, match="a class of a module"):
        cosimo.unit(Local)


@pytest.mark.parametrize("name", ["en50318-2002", "en50318-2002-interface-model", "rov-manoeuvre", "two-pantographs"])
def test_a_drawing_has_every_unit_and_every_connection(name):
    scene = load_scene(name)
    root = xml.fromstring(scene.show())
    texts = [t.text for t in root.iter(f"{SVG}text")]
    hints = "\n".join(t.text or "" for t in root.iter(f"{SVG}title"))
    assert set(scene.units) <= set(texts)
    for link in scene.coupling.links:
        assert link.source[1] in hints
        assert link.target[1] in hints
    assert not [e for e in root.iter() if e.tag in (f"{SVG}script", f"{SVG}image")]


def test_boxes_do_not_overlap():
    assert len(scene_files()) > 40
    for name in ("rov-waves-eight-thrusters", "wrist-what-if"):
        boxes = [
            tuple(float(r.get(k)) for k in ("x", "y", "width", "height"))
            for r in xml.fromstring(load_scene(name).show()).iter(f"{SVG}rect")
        ]
        for i, (x, y, w, h) in enumerate(boxes):
            assert not [b for b in boxes[:i] if x < b[0] + b[2] and b[0] < x + w and y < b[1] + b[3] and b[1] < y + h]


def test_columns_follow_the_arrows_and_circles_end():
    arrows = [Arrow(a, b, ("s",)) for a, b in ("ab", "bc", "ac", "ca", "dd")]
    assert _columns("abcd", arrows) == {"a": 0, "b": 1, "c": 2, "d": 0}
    drawing = draw([Box(n, hint="<&>") for n in "abcd"], arrows, "<title>")
    xml.fromstring(drawing)


def test_a_drawing_is_kept_as_a_file(tmp_path):
    path = load_scene("mass-on-spring").show().save(tmp_path / "scene.svg")
    assert xml.parse(path).getroot().tag == f"{SVG}svg"
