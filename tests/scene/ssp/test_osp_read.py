"""Reading OspSystemStructure.xml: what connections, functions, groups and steps come to, in numbers that follow from libcosim's reader.

The FMU: x' = u, y = gain u + count + 100 flag + 1000 mode + 10000 letters of the text.
"""

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.scene.ssp.systems import values

SPACE = 'xmlns="http://opensimulationplatform.com/MSMI/OSPSystemStructure" version="0.1"'
GROUPS = """<OspModelDescription xmlns="http://opensimulationplatform.com/MSMI/OSPModelDescription" version="0.1"><VariableGroups>
<Port name="port"><Force name="effort"><Variable ref="y"/></Force><Variable ref="u"/></Port>
<Generic name="in"><Variable ref="u"/></Generic><Generic name="out"><Variable ref="y"/></Generic>
<Generic name="both"><Variable ref="x"/><Variable ref="y"/></Generic>
<Port name="mirror"><Force name="flow"><Variable ref="u"/></Force><Variable ref="x"/></Port></VariableGroups></OspModelDescription>"""


def simulator(name, values="", source="adder.fmu", step=""):
    """ "u=Real:2" as initial values."""
    rows = "".join(
        f'<InitialValue variable="{word.partition("=")[0]}"><{word.partition("=")[2].replace(":", " value=" + chr(34))}"/></InitialValue>'
        for word in values.split()
    )
    more = f' stepSize="{step}"' if step else ""
    return f'<Simulator name="{name}" source="{source}"{more}><InitialValues>{rows}</InitialValues></Simulator>'


def end(text, kind="Variable"):
    of, _, name = text.partition(".")
    return f'<{kind} {"function" if "Signal" in kind else "simulator"}="{of}" name="{name}"/>'


def variables(first, second, group=""):
    kind = f"Variable{group}"
    return f"<{kind}Connection>{end(first, kind)}{end(second, kind)}</{kind}Connection>"


def signal(function, variable, group=""):
    return (
        f"<Signal{group}Connection>{end(function, f'Signal{group}')}{end(variable, f'Variable{group}')}</Signal{group}Connection>"
    )


@pytest.fixture
def read(folder):
    def read(simulators, connections="", functions="", head="<EndTime>1</EndTime><BaseStepSize>0.5</BaseStepSize>", tail=""):
        (folder / "adder_OspModelDescription.xml").write_text(GROUPS)
        path = folder / "OspSystemStructure.xml"
        path.write_text(
            f"<OspSystemStructure {SPACE}>{head}<Simulators>{simulators}</Simulators><Functions>{functions}</Functions>"
            f"<Connections>{connections}</Connections>{tail}</OspSystemStructure>"
        )
        return load_scene(path)

    return read


def test_variables_initial_values_and_times(read):
    given = simulator("a", "u=Real:3 gain=Real:2 count=Integer:4 flag=Boolean:true text=String:ab") + simulator("b")
    for link in (variables("a.y", "b.u"), variables("b.u", "a.y")):
        scene = read(given, link)
        assert (scene.arrows, scene.stop_time, scene.master.step) == (("a.y -> b.u",), 1.0, 0.5)
        assert (scene.master.algorithm, scene.master.extrapolation, scene.remarks) == ("jacobi", 0, ())
        assert values(scene)["b.x"] == 20110.0  # 2 * 3 + 4 + 100 + 2 * 10000, held for 1 s


def test_a_linear_transformation_between_variables_feeds_several(read):
    links = signal("f.in", "a.y") + signal("f.out", "b.u") + signal("f.out", "c.u")
    given = simulator("a", "u=Real:3") + simulator("b") + simulator("c")
    found = values(read(given, links, '<LinearTransformation name="f" factor="-2" offset="1"/>'))
    assert (found["b.x"], found["c.y"]) == (-5.0, -5.0)


def test_a_sum_is_that_of_the_same_instant(read):
    """1 + 2 t at the steps' starts 0 and 0.5 s drives c."""
    links = signal("s.in[0]", "a.y") + signal("s.out", "c.u") + signal("s.in[1]", "b.x")
    found = values(
        read(simulator("a", "u=Real:1") + simulator("b", "u=Real:2") + simulator("c"), links, '<Sum name="s" inputCount="2"/>')
    )
    assert (found["c.x"], found["c.y"], found["s.out"]) == (1.5, 3.0, 3.0)


def test_a_sum_of_vectors_goes_by_groups(read):
    links = signal("v.in[0]", "a.out", "Group") + signal("v.in[1]", "b.out", "Group") + signal("v.out", "c.in", "Group")
    given = simulator("a", "u=Real:3") + simulator("b", "u=Real:4") + simulator("c")
    assert values(read(given, links, '<VectorSum name="v" inputCount="2" dimension="1"/>'))["c.x"] == 7.0


def test_groups_are_joined_by_the_order_of_their_members_with_groups_in_them(read):
    """port is ((y), u) and mirror ((u), x): a.y -> b.u and b.x -> a.u."""
    scene = read(simulator("a") + simulator("b"), variables("a.port", "b.mirror", "Group"))
    assert set(scene.arrows) == {"a.y -> b.u", "b.x -> a.u"}


@pytest.mark.parametrize(("step", "every", "told"), [("1", 2, 0), ("1.4", 2, 1), ("0.2", 1, 1), ("1e-9", 1, 1), ("", 1, 0)])
def test_steps_of_a_simulator_are_the_whole_base_steps_that_fit_in(read, step, every, told):
    """libcosim rounds down, and tells of it."""
    scene = read(simulator("a", step=step))
    assert scene.units["a"].every == every
    assert sum("no multiple" in remark for remark in scene.remarks) == told


def test_what_libcosim_does_otherwise_is_told(read):
    scene = read(
        simulator("a", "u=Real:1", "metres.fmu") + simulator("b", "", "mixed.fmu"),
        variables("a.y", "b.u"),
        head="<StartTime>1</StartTime><EndTime>2</EndTime><Algorithm>ecco</Algorithm>",
        tail="<EccoConfiguration/>",
    )
    assert (scene.start_time, scene.master.step) == (1.0, 0.1)
    for part in ("BaseStepSize", "ecco", "a.y is in m, b.u in mm"):
        assert sum(part in remark for remark in scene.remarks) >= 1, part
    assert values(scene)["b.x"] == pytest.approx(1.0, rel=1e-12)  # the number, not 1000


A = simulator("a") + simulator("b")
SUM = '<Sum name="s" inputCount="1"/>'
REFUSED = {
    "a second simulator": ((A + simulator("a"),), "a second 'a'"),
    "no such variable": ((simulator("a", "w=Real:1"),), "variable 'w'"),
    "no number": ((simulator("a", "u=Real:one"),), "'one'"),
    "two initial values": ((simulator("a", "u=Real:1 u=Real:2"),), "a second initial value of 'u'"),
    "a value without type": ((simulator("a", "u=Duck:1"),), "no value of 'u'"),
    "two inputs": ((A, variables("a.u", "b.u")), "both take a value"),
    "no such simulator": ((A, variables("a.y", "c.u")), "element 'c'"),
    "no such group": ((A, variables("a.prot", "b.port", "Group")), "group 'prot'"),
    "groups unlike": ((A, variables("a.both", "b.in", "Group")), "2 variables in 'both' and 1 variables in 'in'"),
    "no such signal": ((A, signal("s.in[1]", "a.y"), SUM), "signal 'in[1]' of function 's'"),
    "no such function": ((A, signal("t.in[0]", "a.y"), SUM), "function 't'"),
    "a signal left open": ((A, signal("s.in[0]", "a.y"), SUM), "'out' of 's' connected with no variables"),
    "a signal driven twice": (
        (A, signal("s.in[0]", "a.y") * 2 + signal("s.out", "b.u"), SUM),
        "'in[0]' of 's' connected with 1 and 1",
    ),
    "a function of another kind": ((A, "", '<Product name="s"/>'), "<Product>"),
    "too many terms": ((A, "", '<Sum name="s" inputCount="33"/>'), "inputCount '33'"),
    "a connection of another kind": ((A, "<Weld/>"), "<Weld>"),
    "one end": ((A, f"<VariableConnection>{end('a.y')}</VariableConnection>"), "VariableConnection with 1 ends"),
    "another algorithm": ((A, "", "", "<Algorithm>best</Algorithm>"), "'best'"),
    "no step": ((A, "", "", "<BaseStepSize>0</BaseStepSize>"), "BaseStepSize 0"),
    "an element of another kind": ((A, "", "", "", "<Sorcery/>"), "<Sorcery>"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_read_is_one_message(read, name):
    given, part = REFUSED[name]
    with pytest.raises(BadInput, match=r"OspSystemStructure\.xml") as raised:
        read(*given)
    assert part in str(raised.value)


def test_the_path_of_an_fmu_has_no_detour(read, folder):
    """The sandbox shows the folder of an FMU, not those on the way to it."""
    (folder / "aside").mkdir()
    scene = read(simulator("a", source="aside/../adder.fmu"))
    assert scene.units["a"].fmu == str(folder / "adder.fmu")


def test_another_xml_file_is_refused(folder):
    path = folder / "notes.xml"
    path.write_text("<notes/>")
    with pytest.raises(BadInput, match=r"expected an OspSystemStructure of version 0\.1"):
        load_scene(path)
