"""Terminals of FMUs are ports: they are joined by their matching rules (FMI 3.0.2, 2.4.9); what cannot be is refused by name."""

import json
import zipfile

import pytest
from cosimo import BadInput, build, read_scene, run
from cosimo.orchestrator.engine.coupling.ports import port_names
from cosimo.tests.commands import exit_code

MODEL = """<fmiModelDescription fmiVersion="3.0" modelName="{name}" instantiationToken="t" generationTool="other">
<CoSimulation modelIdentifier="{name}"/>
<ModelVariables>
<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
{variables}
</ModelVariables><ModelStructure>{outputs}</ModelStructure></fmiModelDescription>"""


def variables(give, take):
    """Of a description: outputs and inputs, "name[2]" an array of two."""
    named = [(n, "output") for n in give] + [(n, "input") for n in take]
    for k, (name, causality) in enumerate(named, 1):
        whole, _, size = name.partition("[")
        start = ' start="0.0"' if causality == "input" else ""
        dimension = f'<Dimension start="{size[:-1]}"/>' if size else ""
        yield f'<Float64 name="{whole}" valueReference="{k}" causality="{causality}"{start}>{dimension}</Float64>'


def fmu(folder, name, give, take, terminals):
    """An FMU of another maker, of which only the descriptions are read."""
    path = folder / f"{name}.fmu"
    structure = "".join(f'<Output valueReference="{k}"/>' for k in range(1, len(give) + 1))
    with zipfile.ZipFile(path, "w") as file:
        text = MODEL.format(name=name, variables="\n".join(variables(give, take)), outputs=structure)
        file.writestr("modelDescription.xml", text)
        if terminals is not None:
            file.writestr("terminalsAndIcons/terminalsAndIcons.xml", terminals)
    return {"fmu": str(path)}


def terminals(*texts):
    return f'<fmiTerminalsAndIcons fmiVersion="3.0"><Terminals>{"".join(texts)}</Terminals></fmiTerminalsAndIcons>'


def terminal(name, rule, *members, inside="", kind=""):
    """members: (member, variable) or with the kind of variable."""
    written = "".join(
        f'<TerminalMemberVariable variableName="{v}" variableKind="{k[0] if k else "signal"}"{f" memberName={m!r}" if m else ""}/>'
        for m, v, *k in members
    )
    of_kind = f' terminalKind="{kind}"' if kind else ""
    return f'<Terminal name="{name}" matchingRule="{rule}"{of_kind}>{written}{inside}</Terminal>'


def joined(text, **units):
    data = {"stop_time": 0.01, "units": units, "connections": [text], "master": {"step": 1e-3}}
    return set(read_scene(data).arrows)


def pair(tmp_path, first, second):
    """Two FMUs, f -> v and back, with a terminal each."""
    one = fmu(tmp_path, "One", ["force", "heat"], ["speed"], terminals(first))
    return {"one": one, "two": fmu(tmp_path, "Two", ["v"], ["f", "q"], terminals(second))}


FIRST = [("f", "force"), ("v", "speed")]
SECOND = [("v", "v"), ("f", "f")]
BOTH = {"one.force -> two.f", "two.v -> one.speed"}


@pytest.mark.parametrize(
    ("rule", "first", "second", "arrows"),
    [
        ("plug", FIRST, SECOND, BOTH),
        ("bus", [*FIRST, ("heat", "heat")], SECOND, BOTH),  # what one of them has alone is left
        ("sequence", [("", "speed"), ("x", "force")], [("y", "v"), ("", "f")], BOTH),  # names do not count
        ("plug", [("f", "force", "outflow"), ("v", "speed")], [("f", "f", "inflow"), ("v", "v")], BOTH),
    ],
)
def test_members_belong_together_by_the_matching_rule(rule, first, second, arrows, tmp_path):
    units = pair(tmp_path, terminal("shaft", rule, *first), terminal("flange", rule, *second))
    assert joined("one.shaft <-> two.flange", **units) == arrows


@pytest.mark.parametrize(
    ("first", "second", "named"),
    [
        (terminal("t", "plug", *FIRST, ("heat", "heat")), terminal("t", "plug", *SECOND), "'heat' of terminal one.t"),
        (terminal("t", "plug", *FIRST), terminal("t", "plug", *SECOND, ("q", "q")), "'q' of terminal two.t"),
        (terminal("t", "plug", *FIRST, ("k", "gone")), terminal("t", "plug", *SECOND), "'k' of terminal one.t"),
        (terminal("t", "sequence", *FIRST), terminal("t", "sequence", *SECOND), "an output of one side"),
        (terminal("t", "sequence", *FIRST[:1]), terminal("t", "sequence", ("f", "f"), ("v", "v")), "'#2' of terminal two.t"),
        (terminal("t", "bus", *FIRST), terminal("t", "plug", *SECOND), "terminals of rule 'bus' and 'plug'"),
        (terminal("t", "bus", *FIRST, kind="a"), terminal("t", "bus", *SECOND, kind="b"), "terminals of kind 'a' and 'b'"),
        (terminal("t", "org.own", *FIRST), terminal("t", "org.own", *SECOND), "the matching rule 'org.own'"),
        (
            terminal("t", "bus", ("f", "force", "inflow")),
            terminal("t", "bus", ("f", "f", "inflow")),
            "'f' of kind 'inflow' and 'f' of kind 'inflow'",
        ),
        (
            terminal("t", "bus", *FIRST, inside='<TerminalStreamMemberVariable inStreamMemberName="h"/>'),
            terminal("t", "bus", *SECOND),
            "terminal one.t with streams: h",
        ),
        (terminal("s", "bus", *FIRST), terminal("t", "bus", *SECOND), "a port of one. There is s"),
        ("<Terminal>", terminal("t", "bus", *SECOND), "terminalsAndIcons.xml cannot be read"),
        (terminal("t", "bus", *FIRST, FIRST[0]), terminal("t", "bus", *SECOND), "terminal t has two members 'f'"),
    ],
)
def test_terminals_that_do_not_fit_are_refused_by_name(first, second, named, tmp_path):
    with pytest.raises(BadInput) as refused:
        joined("one.t <-> two.t", **pair(tmp_path, first, second))
    assert named in str(refused.value)


def test_terminals_in_terminals_and_elements_of_arrays(tmp_path):
    """`wheels` is an array of FMI 3; "wheels[2]" picks the second element by the name of its array."""
    inner = terminal("drive", "bus", *FIRST)
    one = fmu(tmp_path, "One", ["force"], ["speed"], terminals(terminal("all", "bus", inside=inner)))
    other = terminal("all", "bus", inside=terminal("drive", "bus", ("f", "f"), ("v", "v")))
    two = fmu(tmp_path, "Two", ["v[2]"], ["f[2]"], terminals(other))
    assert joined("one.all.drive <-> two.all.drive[2]", one=one, two=two) == {"one.force -> two.f[2]", "two.v[2] -> one.speed"}
    three = fmu(tmp_path, "Three", ["v"], ["f"], terminals(other))
    assert joined("one.all <-> three.all", one=one, three=three) == {"one.force -> three.f", "three.v -> one.speed"}


def test_an_fmu_without_terminals_or_with_a_faulty_file_runs_as_before(tmp_path):
    for content in (None, "<Terminal>", '<!DOCTYPE x [<!ENTITY a "b">]><x/>'):
        unit = fmu(tmp_path, "Plain", ["shaft.f"], ["shaft.v"], content)
        scene = read_scene({"stop_time": 0.01, "units": {"a": unit}, "master": {"step": 1e-3}})
        assert port_names(scene.coupling.interfaces["a"]) == ["shaft"]


CONTACT = {
    "catenary.wire_height -> head.wire_height",
    "catenary.contact_compliance -> head.wire_compliance",
    "head.contact_force -> catenary.contact_force",
    "head.contact_position -> catenary.contact_position",
}


def test_own_fmus_have_the_ports_of_their_components(tmp_path, capsys):
    """With a partner of either packaging; the ports of the elements of an array, too."""
    head, catenary = ({"fmu": str(build(name, tmp_path))} for name in ("Pantograph", "Catenary"))
    assert joined("head.contact <-> catenary.contact", head=head, catenary=catenary) == CONTACT
    assert joined("head.contact <-> catenary.contact", head={"component": "Pantograph"}, catenary=catenary) == CONTACT
    rows = catenary | {"effects": ["further_pantographs"]}
    found = joined("head.contact <-> catenary.further_pantographs[1]", head=head, catenary=rows)
    assert found == {
        c.replace("catenary.", "catenary.further_pantographs.").replace(" -> head", "[1] -> head")
        if c.startswith("cat")
        else c.replace("catenary.", "catenary.further_pantographs.") + "[1]"
        for c in CONTACT
    }
    with pytest.raises(BadInput, match="Switch on the effect 'second_pantograph'"):
        joined("head.contact <-> catenary.second_pantograph", head=head, catenary=catenary)
    exit_code("show", head["fmu"], "--json")
    assert json.loads(capsys.readouterr().out)["ports"] == [
        {
            "name": "contact",
            "inputs": ["wire_height", "contact_compliance"],
            "outputs": ["contact_force", "contact_position"],
            "matching": "bus",
        }
    ]


def test_a_new_scene_joins_terminals(tmp_path):
    heads = [str(build(name, tmp_path)) for name in ("Pantograph", "Catenary")]
    exit_code("new", "scene", tmp_path / "s.toml", *heads)
    text = (tmp_path / "s.toml").read_text(encoding="utf-8")
    assert '"pantograph.contact <-> catenary.contact"' in text
    assert 'fmu = "Pantograph.fmu"' in text  # beside the scene, with which it can be moved


@pytest.mark.full
def test_native_fmus_are_joined_and_give_the_bits_of_components(tmp_path):
    def of(head, catenary):
        data = {"stop_time": 0.02, "connections": ["head.contact <-> catenary.contact"], "master": {"step": 1e-3}}
        return run(read_scene(data | {"units": {"head": head, "catenary": catenary}}), verify="no", in_process=True)

    for name in ("Pantograph", "Catenary"):
        assert exit_code("build", name, "--native", "-o", str(tmp_path)) == 0
    native = [{"fmu": str(tmp_path / f"{name}.fmu")} for name in ("Pantograph", "Catenary")]
    plain = of({"component": "Pantograph"}, {"component": "Catenary"})
    assert of(*native)["head.contact_force"].tolist() == plain["head.contact_force"].tolist()
