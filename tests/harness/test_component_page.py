"""What a component's page says, against the declarations and the physics."""

import json

import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.component_page import component_page, component_pages, passages


def test_every_declared_variable_effect_and_preset_is_on_a_page():
    for page in component_pages(count_states=False):
        cls = component_class(page.name)
        scalars = {f"{v.name}[{k}]" for v in page.variables for k in range(1, v.size + 1)} | {
            v.name for v in page.variables if not v.size
        }
        assert scalars == set(cls.variables)
        assert [e.name for e in page.effects] == list(cls.effects)
        assert [p.name for p in page.presets] == list(cls.presets)
        assert {n for port in page.ports for n in (*port.inputs, *port.outputs)} == {
            v.name for v in page.variables if v.causality != "parameter"
        }
        assert page.states is None
        assert json.loads(json.dumps(page.to_json()))["name"] == page.name
    assert len(CATALOGUE) > 40


def test_states_that_effects_add():
    """A third mass has a position and a velocity; an inductance has a current; a law without dynamics has nothing."""
    pantograph = component_page("Pantograph")
    adds = {e.name: e.states for e in pantograph.effects}
    assert (pantograph.states, adds["lower_frame"], adds["bump_stops"]) == (4, 2, 0)


def test_what_a_page_knows_from_elsewhere():
    page = component_page("Pantograph", count_states=False)
    rows = {v.name: v for v in page.variables}
    assert rows["speed"].limits == ">= 0, <= 200"
    assert rows["head_mass"].sources == ("EN 50318:2002 (verbatim)",)
    assert rows["contact_force"].default is None
    assert {"en50318-2002", "two-pantographs"} <= page.scenes.keys()
    assert page.hard_cases
    assert [p.kind for p in page.text] == ["text", "equations", "text", "source"]


def test_passages_of_a_docstring():
    parts = list(passages("Title.\n\n    a = b\n      + c\n\nText\ngoes on.\nSource: a paper,\np. 3."))
    assert [(p.kind, p.text) for p in parts] == [
        ("text", "Title."),
        ("equations", "a = b\n  + c"),
        ("text", "Text goes on."),
        ("source", "a paper, p. 3."),
    ]


def test_an_unknown_component_is_one_message():
    with pytest.raises(BadInput, match="Did you mean 'Pantograph'"):
        component_page("Pantagraph")
