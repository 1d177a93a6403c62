"""Ports that are joined stand for connections of their members; what cannot be joined is refused with what there is."""

import pytest
from cosimo import BadInput, load_scene, read_result, read_scene, run, summary
from cosimo.orchestrator.systems.railway.records import passages

CATENARY = {
    "component": "Catenary",
    "effects": ["second_pantograph", "further_pantographs"],
    "parameters": {"further_pantographs.count": 2},
}
PANTOGRAPH = {"component": "Pantograph"}


def scene(*connections, **units):
    """Of units between which the connections are."""
    return read_scene({"stop_time": 0.01, "units": units, "connections": list(connections), "master": {"step": 1e-3}})


def arrows(*connections, **units):
    """The connections that they stand for."""
    return set(scene(*connections, **units).arrows)


CONTACT = {
    "catenary.wire_height -> head.wire_height",
    "catenary.contact_compliance -> head.wire_compliance",
    "head.contact_force -> catenary.contact_force",
    "head.contact_position -> catenary.contact_position",
}


@pytest.mark.parametrize("text", ["head.contact <-> catenary.contact", "catenary.contact<->head.contact"])
def test_two_ports_are_joined_in_both_directions(text):
    assert arrows(text, head=PANTOGRAPH, catenary=CATENARY) == CONTACT


def test_ports_of_effects_and_elements_of_arrays():
    """The third pantograph is the first of `further_pantographs`."""
    found = arrows("head.contact <-> catenary.further_pantographs[2]", head=PANTOGRAPH, catenary=CATENARY)
    assert found == {
        "catenary.further_pantographs.wire_height[2] -> head.wire_height",
        "catenary.further_pantographs.contact_compliance[2] -> head.wire_compliance",
        "head.contact_force -> catenary.further_pantographs.contact_force[2]",
        "head.contact_position -> catenary.further_pantographs.contact_position[2]",
    }
    second = arrows("catenary.second_pantograph <-> head.contact", head=PANTOGRAPH, catenary=CATENARY)
    assert second == {arrow.replace("catenary.", "catenary.second_pantograph.") for arrow in CONTACT}


def test_a_partner_without_a_member_is_joined_by_the_others():
    """A lumped catenary leaves nothing out of its compliance."""
    lumped = {"component": "LumpedCatenary"}
    assert arrows("head.contact <-> catenary.contact", head=PANTOGRAPH, catenary=lumped) == {
        c for c in CONTACT if "compliance" not in c
    }


def test_ports_of_a_subsystem_are_joined_inside_it(tmp_path):
    (tmp_path / "inner.toml").write_text(
        'connections = ["head.contact <-> catenary.contact"]\n[units]\nhead = { component = "Pantograph" }\n'
        'catenary = { component = "LumpedCatenary" }\n'
    )
    outer = read_scene(
        {"stop_time": 0.01, "units": {"part": {"scene": "inner.toml"}}, "master": {"step": 1e-3}}, "outer", tmp_path
    )
    assert "part.catenary.wire_height -> part.head.wire_height" in outer.arrows


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("head.contact <-> catenary.contakt", ["catenary.contakt", "'contact'"]),
        ("head.contact <-> catenary.second_wire", ["Switch on the effect 'second_wire'"]),
        ("head.contact <-> catenary.further_pantographs[9]", ["no elements [9]"]),
        ("head.contact <-> other.contact", ["head.contact with", "contact_force", "with one name"]),
        ("head.contact <-> head.contact", ["twice, expected two units"]),
        ("head.contact <-> catenary.*", ["unit.port <-> unit.port"]),
        ("head <-> catenary.contact", ["unit.port <-> unit.port"]),
        ("head.contact <-> catenary.contact <-> other.contact", ["unit.port <-> unit.port"]),
        ("head.contact <-> nothing.contact", ["unit 'nothing'"]),
    ],
)
def test_what_cannot_be_joined_is_refused(text, named):
    with pytest.raises(BadInput) as refused:
        scene(text, head=PANTOGRAPH, catenary=CATENARY, other=PANTOGRAPH)
    assert all(part in str(refused.value) for part in named), refused.value


def test_an_input_that_a_port_drives_is_not_driven_again():
    with pytest.raises(BadInput, match=r"head\.wire_height driven a second time"):
        scene("head.contact <-> catenary.contact", "catenary.wire_height -> head.wire_height", head=PANTOGRAPH, catenary=CATENARY)


def test_a_result_that_is_read_back_knows_what_was_joined(tmp_path):
    result = run(load_scene("lumped-catenary"), in_process=True, verify="no", output=tmp_path)
    assert len(passages(read_result(tmp_path))) == 1
    assert dict.fromkeys(r.name for r in summary(read_result(tmp_path))) == dict.fromkeys(r.name for r in summary(result))
