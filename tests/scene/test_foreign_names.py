"""Names of foreign variables are any string, wherever a scene names them."""

import json
from xml.sax.saxutils import quoteattr

import pytest
from cosimo import BadInput, load_scene, read_result, read_scene, write_scene
from cosimo.components.core.columns import read_table
from cosimo.orchestrator.cli.common import changes_of
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.ssp.write import write as write_ssp
from cosimo.orchestrator.settings.names import connection, readings, split_name
from cosimo.tests.units.native import native_fmu

FIXED, GIVES, TAKES = "Float64_fixed_parameter", "Float64_continuous_output", "Float64_continuous_input"
NAMES = [
    *("mass flow", "a.b.c", "x[1]", "a[1].b", "der(x)", 'say "hi"', "it's", "a -> b", "a <-> b", "Länge µ", " lead", "trail "),
    *("x = 1", "a, mean", "x*", "#", "[units]", "u/v", "a\\b", "x;y", "1e3", "true", "b.Float64", "{x}", "%s", "<b>", "-"),
]
AMBIGUOUS = {"x*"}  # also all outputs and inputs that begin with x


def renamed(fmi, **names):
    changes = ((f'name="{old}"', f"name={quoteattr(new)}") for old, new in names.items())
    return native_fmu("feedthrough", fmi, "", *changes)


def pair(fmi, name, connections, **more):
    units = {
        "a": {"fmu": renamed(fmi, **{GIVES: name, FIXED: f"{name}!"}), "parameters": {f"{name}!": 2.5}},
        "b.c": {"fmu": renamed(fmi, **{TAKES: name})},
    }
    return read_scene({"stop_time": 1.0, "units": units, "connections": connections, "master": {"step": 0.5}, **more}, "odd")


@pytest.mark.parametrize("fmi", [2, 3])
def test_any_name_is_connected_recorded_and_set(fmi, tmp_path):
    for k, name in enumerate(NAMES[:: fmi - 1]):
        table, text = {"source": f"a.{name}", "target": f"b.c.{name}"}, f"a.{name} -> b.c.{name}"
        scenes = [pair(fmi, name, [table], record={"signals": [f"a.{name}", f"b.c.{GIVES}"]})]
        if name not in AMBIGUOUS:
            scenes.append(pair(fmi, name, [text]))
        scenes.append(load_scene(write_scene(scenes[0], tmp_path / "odd.toml")))
        outer = {"units": {"o": {"scene": str(tmp_path / "odd.toml")}}, "stop_time": 1.0, "master": {"step": 0.5}}
        scenes += [load_scene(write_ssp(scenes[0], tmp_path / "odd.ssp"))] if k % 2 else []
        for scene in scenes:
            assert [(link.source, link.target) for link in scene.coupling.links] == [(("a", name), ("b.c", name))], name
            assert scene.ends == ((f"a.{name}", f"b.c.{name}"),)
            assert scene.units["a"].parameters == {f"{name}!": 2.5}
        assert [link.target for link in read_scene(outer).coupling.links] == [("o.b.c", name)]
        for scene in scenes[:2]:
            assert (("a", name) in scene.coupling.signals) == (name != "x[1]" or scene is scenes[0]), (
                name
            )  # an element of an array
        for changed in (
            scenes[0].with_changes({f"a.{name}!": 4.0}),
            scenes[0].with_changes(changes_of(scenes[0], [f"a.{name}!=4.0"], None)),
        ):
            assert changed.units["a"].parameters == {f"{name}!": 4.0}, name


def test_a_run_with_odd_names_is_written_and_read_again(tmp_path):
    names = ['a -> b, "c" [1]', " x;\tä ", "mean, maximum"]
    units = {"a": {"fmu": renamed(2, **{GIVES: names[0], FIXED: names[1]}), "parameters": {names[1]: 2.5}}}
    units["b"] = {"fmu": renamed(2, **{TAKES: names[2], GIVES: names[1]})}
    data = {"stop_time": 1.0, "units": units, "master": {"step": 0.1}}
    data["connections"] = [{"source": f"a.{names[0]}", "target": f"b.{names[2]}"}]
    scene = read_scene({**data, "record": {"signals": [f"a.{names[0]}", f"b.{names[1]}"]}})
    result = run(scene, output=tmp_path / "out")
    again = read_result(tmp_path / "out")
    for each in (result, again):
        assert list(each.columns) == [f"a.{names[0]}", f"b.{names[1]}"]
        assert each[f"b.{names[1]}"][-1] == 2.5
    column = read_table(tmp_path / "out" / "result.csv").numbers(f"b.{names[1]}")
    assert column.tolist() == result[f"b.{names[1]}"].tolist()
    assert again.scene.ends == scene.ends
    told = json.loads((tmp_path / "out" / "run.json").read_text())["scene"]["connections"]
    assert told[0]["source"] == f"a.{names[0]}"
    report = result.report(tmp_path / "out").read_text(encoding="utf-8")
    assert any(spelt in report for spelt in ("a -&gt; b, &#34;c&#34; [1]", "a -&gt; b, &quot;c&quot; [1]")), report[:200]


def test_a_text_with_two_meanings_is_refused_with_the_form_that_has_one():
    units = {
        "a": {"fmu": renamed(2, **{GIVES: "x", "Float64_discrete_output": "x -> b.y"})},
        "b": {"fmu": renamed(2, **{TAKES: "y -> b.z", "Float64_discrete_input": "z"})},
    }
    data = {"stop_time": 1.0, "units": units, "master": {"step": 0.5}}
    with pytest.raises(BadInput, match=r"'a.x' to 'b.y -> b.z' or 'a.x -> b.y' to 'b.z'.*source = "):
        read_scene({**data, "connections": ["a.x -> b.y -> b.z"]})
    for source, target in (("x", "y -> b.z"), ("x -> b.y", "z")):
        told = {"source": f"a.{source}", "target": f"b.{target}"}
        links = read_scene({**data, "connections": [told]}).coupling.links
        assert [(link.source[1], link.target[1]) for link in links] == [(source, target)]


def test_a_name_that_two_units_share_is_refused():
    units = {"a": {"fmu": renamed(2, **{GIVES: "b.y"})}, "a.b": {"fmu": renamed(2, **{GIVES: "y"})}}
    with pytest.raises(BadInput, match=r"'a.b.y', a variable of 'a' and one of 'a.b'"):
        read_scene({"stop_time": 1.0, "units": units, "master": {"step": 0.5}})


def test_names_of_units_decide_where_a_text_is_parted():
    assert split_name("a.b.c", ["a", "a.b"]) == ("a.b", "c")
    assert split_name("a.b", ["a.b"]) == ("a", "b")
    assert [r[1:] for r in readings("a.x -> y -> b.z", ["a", "b"])] == [("a.x -> y", "b.z")]
    assert connection("a.x", "b.y", ["a", "b"]) == "a.x -> b.y"
    assert connection("a.x ", "b.y", ["a", "b"]) == {"source": "a.x ", "target": "b.y"}


@pytest.mark.parametrize("fmi", [2, 3])
def test_two_variables_of_one_name_are_refused_with_both(fmi):
    path = native_fmu("feedthrough", fmi, "", ('name="Float64_discrete_output"', f'name="{GIVES}"'))
    with pytest.raises(BadInput, match=rf"two variables '{GIVES}' \(output 8 and output 10; lines .*names that are unique"):
        read_scene({"stop_time": 1.0, "units": {"a": {"fmu": path}}, "master": {"step": 0.5}})
