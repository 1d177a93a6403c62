"""Reading .ssd files: what connections, units of measure and parameters come to, in numbers that follow from the standard.

The FMU: x' = u, y = gain u + count + 100 flag + 1000 mode + 10000 letters of the text.
"""

import shutil
import zipfile

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.engine.coupling import resolve_coupling
from cosimo.orchestrator.run.run import run
from cosimo.tests.scene.ssp import systems
from cosimo.tests.scene.ssp.systems import (
    PAIR,
    STEP,
    bindings,
    component,
    connection,
    document,
    parameter_set,
    read,
    system,
    units,
    values,
)
from cosimo.tests.units.native import native_fmu


def test_units_connections_and_experiment(load):
    elements = component("b", inside=bindings("u=Real:3")) + component("a", "u<[m]")
    scene = read(load, system("s", elements, connection("b.y", "a.u")), units("m"))
    assert list(scene.units) == ["b", "a"]
    assert scene.arrows == ("b.y -> a.u",)
    assert (scene.stop_time, scene.master.step, scene.master.algorithm, scene.master.extrapolation) == (1.0, 0.5, "jacobi", 0)
    assert (scene.title, scene.name, scene.remarks) == ("test", "test", ())
    assert values(scene) == {"b.x": 3.0, "b.y": 3.0, "a.x": 3.0, "a.y": 3.0}


def test_connections_go_by_the_kinds_of_their_ends_whichever_stands_first(load):
    for link in (connection("a.y", "b.u"), connection("b.u", "a.y")):
        assert read(load, system("s", PAIR, link)).arrows == ("a.y -> b.u",)


@pytest.mark.parametrize(
    ("given", "taken", "inside", "more", "link"),
    [
        ("metres.fmu", "metres.fmu", "", "", (1.0, 0.0)),
        ("metres.fmu", "mixed.fmu", "", "", (1000.0, 0.0)),  # the FMUs' own units
        ("metres.fmu", "mixed.fmu", "", 'suppressUnitConversion="true"', (1.0, 0.0)),
        ("metres.fmu", "adder.fmu", "", "", (1.0, 0.0)),  # unknown at one end: nothing to convert
        ("metres.fmu", "metres.fmu", '<ssc:LinearTransformation factor="2" offset="-3"/>', "", (2.0, -3.0)),
        (
            "metres.fmu",
            "mixed.fmu",
            '<ssc:LinearTransformation factor="2" offset="-3"/>',
            "",
            (2000.0, -3.0),
        ),  # after the conversion
        ("metres.fmu", "mixed.fmu", '<ssc:LinearTransformation factor="2"/>', 'suppressUnitConversion="true"', (2.0, 0.0)),
    ],
)
def test_conversion_comes_before_the_linear_transformation(load, given, taken, inside, more, link):
    elements = component("a", source=given) + component("b", source=taken)
    scene = read(load, system("s", elements, connection("a.y", "b.u", inside, more)))
    found = resolve_coupling(scene).links[0]
    assert (found.factor, found.offset) == pytest.approx(link, rel=1e-15)  # one division, rounded


def test_units_of_connectors_stand_in_where_the_fmus_have_none_and_may_have_any_name(load):
    """68 degF is 293.15 K; the names mean what the file says."""
    elements = component("a", "u< y>[degF]", bindings("u=Real:68")) + component("b", "u<[K]")
    assert values(read(load, system("s", elements, connection("a.y", "b.u")), units("degF", "K")))["b.x"] == pytest.approx(293.15)


def test_a_way_through_nested_systems_is_one_connection(load):
    """1 m becomes 1000 mm at the inner system, doubled on the way in, and 0.001 m each again at the input."""
    inner = system(
        "in", component("b", source="metres.fmu"), connection("v", "b.u", '<ssc:LinearTransformation offset="0.5"/>'), "v<[mm]"
    )
    middle = system("mid", inner, connection("w", "in.v"), "w<")
    source = component("a", inside=bindings("u=Real:1"), source="metres.fmu")
    outer = connection("mid.w", "a.y", '<ssc:LinearTransformation factor="2"/>')
    scene = read(load, system("s", source + middle, outer), units("mm"))
    assert list(scene.units) == ["a", "mid.in.b"]
    assert [c.source + c.target for c in scene.connections] == ["a.ymid.in.b.u"]
    assert values(scene)["mid.in.b.x"] == pytest.approx(2.5, rel=1e-15)  # 1 m, times 2, as 2000 mm, as 2 m, plus 0.5


def test_outputs_leave_systems_and_one_feeds_several(load):
    inner = system("in", component("b", inside=bindings("u=Real:7")), connection("b.y", "out"), "out>")
    scene = read(
        load, system("s", inner + component("c") + component("d"), connection("in.out", "c.u") + connection("in.out", "d.u"))
    )
    assert scene.arrows == ("in.b.y -> c.u", "in.b.y -> d.u")
    assert {k: v for k, v in values(scene).items() if k.endswith("y")} == {"in.b.y": 7.0, "c.y": 7.0, "d.y": 7.0}


def test_parameters_of_every_type_arrive(load):
    given = bindings("u=Real:2 gain=Real:3 count=Integer:4 flag=Boolean:1 mode=Enumeration:high text=String:abc")
    scene = read(load, system("s", component("a", inside=given)))
    assert values(scene)["a.y"] == 6.0 + 4.0 + 100.0 + 4000.0 + 30000.0
    assert scene.units["a"].parameters["mode"] == "high"


@pytest.mark.parametrize(
    ("outer", "inner", "own", "count"),
    [
        ((), (), ("count=Integer:1",), 1),
        ((), (), ("count=Integer:1", "count=Integer:2"), 2),  # the later one
        ((), ("a.count=Integer:3",), ("count=Integer:1",), 3),  # the higher one
        (("in.a.count=Integer:4",), ("a.count=Integer:3",), ("count=Integer:1",), 4),
        (("in.a.count=Integer:4", "in.a.count=Integer:5"), (), (), 5),
    ],
)
def test_higher_and_later_bindings_win(load, outer, inner, own, count):
    def bound(texts):
        return bindings(*texts) if texts else ""

    nested = system("in", component("a", inside=bound(own)), bindings=bound(inner))
    assert values(read(load, system("s", nested, bindings=bound(outer))))["in.a.y"] == count


def test_a_value_at_a_systems_connector_reaches_all_that_it_feeds(load):
    links = connection("p", "a.u") + connection("p", "b.u", '<ssc:LinearTransformation factor="10"/>')
    inner = system("in", PAIR, links, "p<", bindings("p=Real:2 a.u=Real:99"))
    found = values(read(load, system("s", inner, connection("q", "in.p"), "q<")))
    assert (found["in.a.y"], found["in.b.y"]) == (2.0, 20.0)
    found = values(read(load, system("s", inner, connection("q", "in.p"), "q<", bindings("q=Real:3"))))
    assert (found["in.a.y"], found["in.b.y"]) == (3.0, 30.0)


def test_a_parameter_of_a_system_reaches_the_parameters_it_is_connected_with(load):
    inner = system("in", component("a", "gain!"), connection("p", "a.gain"), "p![m]", bindings("p=Real:2"))
    found = read(load, system("s", inner, bindings=bindings("in.p=Real:3 in.a.gain=Real:5")), units("m"))
    assert found.units["in.a"].parameters == {"gain": 3000.0}  # the connector is in m, the gain in mm; what feeds it wins


def test_values_are_converted_from_the_unit_of_their_set(load):
    """gain is in mm: 2 inch are 50.8 of them."""
    given = bindings("gain=Real:2[inch] u=Real:1", units=systems.definitions("ssc:"))
    scene = read(load, system("s", component("a", inside=given)))
    assert values(scene)["a.y"] == pytest.approx(50.8, rel=1e-15)


def test_a_mapping_renames_transforms_and_leaves_out_the_rest(load):
    mapping = (
        '<ssm:MappingEntry source="x.n" target="b.count"/><ssm:MappingEntry source="x.n" target="a.count"/>'
        '<ssm:MappingEntry source="x.g" target="a.gain"><ssc:LinearTransformation factor="2" offset="1"/>'
        "</ssm:MappingEntry>"
        '<ssm:MappingEntry source="x.g" target="b.gain" suppressUnitConversion="true"/>'
        '<ssm:MappingEntry source="x.f" target="b.flag"><ssc:BooleanMappingTransformation>'
        '<ssc:MapEntry source="false" target="true"/></ssc:BooleanMappingTransformation></ssm:MappingEntry>'
        '<ssm:MappingEntry source="x.m" target="b.mode"><ssc:EnumerationMappingTransformation>'
        '<ssc:MapEntry source="slow" target="low"/></ssc:EnumerationMappingTransformation></ssm:MappingEntry>'
    )
    given = bindings(
        "n=Integer:5 g=Real:0.5[m] f=Boolean:false m=Enumeration:slow u=Real:8",
        mapping=mapping,
        prefix="x.",
        units=systems.definitions("ssc:", "m"),
    )
    scene = read(load, system("s", PAIR, bindings=given))
    assert scene.units["a"].parameters == {"gain": 1001.0, "count": 5}  # 500 mm, times 2, plus 1; u is not mapped
    assert scene.units["b"].parameters == {"gain": 0.5, "count": 5, "mode": "low", "flag": True}


def test_entries_of_a_mapping_with_an_empty_source_map_nothing(load):
    mapping = '<ssm:MappingEntry source="g" target="a.gain"/><ssm:MappingEntry source="" target="b.gain"/>' * 2
    scene = read(load, system("s", PAIR, bindings=bindings("g=Real:0.5", mapping=mapping)))
    assert (scene.units["a"].parameters, scene.units["b"].parameters) == ({"gain": 0.5}, {})
    assert sum("2 entries with an empty source are left out" in r for r in scene.remarks) == 1


def test_sets_and_mappings_in_files_and_in_the_fmu(load, folder, library):
    (folder / "sets").mkdir()
    spaces = systems.SPACES
    text = parameter_set("n=Integer:6", spaces=spaces)
    systems.validated(text, "SystemStructureParameterValues.xsd")
    (folder / "sets" / "a set.ssv").write_text(text)
    text = f'<ssm:ParameterMapping version="1.0" {spaces}><ssm:MappingEntry source="n" target="count"/></ssm:ParameterMapping>'
    systems.validated(text, "SystemStructureParameterMapping.xsd")
    (folder / "names.ssm").write_text(text)
    with zipfile.ZipFile(folder / "adder.fmu", "a") as file:
        file.writestr("resources/own.ssv", parameter_set("gain=Real:4", spaces=spaces))
    given = (
        '<ssd:ParameterBindings><ssd:ParameterBinding source="sets/a%20set.ssv"><ssd:ParameterMapping source="names.ssm"/>'
        '</ssd:ParameterBinding><ssd:ParameterBinding source="resources/own.ssv" sourceBase="component"/>'
        "</ssd:ParameterBindings>"
    )
    scene = read(load, system("s", component("a", inside=given)))
    assert scene.units["a"].parameters == {"gain": 4.0, "count": 6}


def test_what_fits_nothing_or_is_driven_is_left_out_with_a_remark(load):
    many = " ".join(f"v{k}=Real:1" for k in range(9))
    elements = component("a") + component("b", inside=bindings(f"u=Real:5 coutn=Integer:1 {many}"))
    scene = read(load, system("s", elements, connection("a.y", "b.u")))
    assert scene.units["b"].parameters == {}
    vain, driven = scene.remarks
    assert vain.endswith("values left out at 'b' because they fit no variable: 'coutn', 'v0', 'v1', 'v2', 'v3', ...")
    assert driven.endswith("values left out at 'b' because they are of inputs that a connection drives: 'u'")
    assert run(scene).info.warnings[:2] == scene.remarks
    assert scene.with_changes({"stop_time": 2.0}).remarks == scene.remarks


def test_components_may_be_systems_of_other_files_and_of_the_same_one(load, folder):
    part = system(
        "part",
        component("a", inside=bindings("count=Integer:1 gain=Real:2")),
        connection("u", "a.u"),
        "u<",
        bindings("a.count=Integer:2"),
    )
    (folder / "part.ssd").write_text(document(part))
    with zipfile.ZipFile(folder / "part.ssp", "w") as file:
        file.writestr("SystemStructure.ssd", document(part))
        other = part.replace('name="a.count"><ssv:Integer value="2"', 'name="a.gain"><ssv:Real value="8"')
        file.writestr("Other.ssd", document(other))
        file.write(folder / "adder.fmu", "adder.fmu")
    definition, package = "application/x-ssp-definition", "application/x-ssp-package"
    four = system("four", component("a"), bindings=bindings("a.count=Integer:4")).replace("<ssd:System ", '<ssd:System id="f" ')
    elements = (
        component("one", "u<", bindings("a.gain=Real:3"), "part.ssd", f'type="{definition}"')
        + component("two", "u<", "", "part.ssp", f'type="{package}"')
        + component("three", "u<", bindings("a.u=Real:0.5"), "part.ssp#Other.ssd", f'type="{package}"')
        + four
        + component("five", "", "", "#f", f'type="{definition}"')
    )
    scene = read(load, system("s", elements, bindings=bindings("one.u=Real:10")))
    found = {name: v for name, v in values(scene).items() if name.endswith("y")}
    assert found == {"one.a.y": 32.0, "two.a.y": 2.0, "three.a.y": 5.0, "four.a.y": 4.0, "five.a.y": 4.0}


def test_names_become_names_of_units(load):
    elements = "".join(component(n, "") for n in ("2 masses", "2_masses", "left.wheel", "größe"))
    assert list(read(load, system("s", elements)).units) == ["u2_masses", "u2_masses_2", "left.wheel", "gr__e"]


def test_an_experiment_that_is_not_told_is_taken_from_the_fmus_and_said(load):
    scene = load(document(system("s", PAIR), experiment=""))
    assert (scene.stop_time, scene.master.step) == (4.0, 0.5)
    assert ["no stop time" in scene.remarks[0], "no macro step" in scene.remarks[1]] == [True, True]


def test_steps_of_omsimulator_and_hints_of_open_simulation_platform(load):
    hint = (
        '<ssd:Annotations><ssc:Annotation type="com.opensimulationplatform"><osp:StepSizeHint value="1.0"/></ssc:Annotation>'
        "</ssd:Annotations>"
    )
    master = (
        '<ssd:Annotations><ssc:Annotation type="org.openmodelica"><oms:Annotations><oms:SimulationInformation>'
        '<oms:FixedStepMaster description="oms-ma" stepSize="0.25"/></oms:SimulationInformation></oms:Annotations>'
        "</ssc:Annotation></ssd:Annotations>"
    )
    root = system("s", component("a") + component("b", inside=hint)).replace("</ssd:Elements>", f"</ssd:Elements>{master}")
    scene = load(document(root))
    assert (scene.master.step, scene.units["a"].every, scene.units["b"].every) == (0.25, 1, 4)


def arrays(name: str, ports: dict[str, tuple[str, str]], values: str) -> str:
    """A component of FMI 3 with connectors that are arrays of two or three elements, name -> (kind, size)."""
    rows = "".join(
        f'<ssd:Connector name="{n}" kind="{kind}"><ssc:Float64/><ssd:Dimension size="{size}"/></ssd:Connector>'
        for n, (kind, size) in ports.items()
    )
    return (
        f'<ssd:Component name="{name}" source="state_space.fmu"><ssd:Connectors>{rows}</ssd:Connectors>'
        f"<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>{values}</ssd:ParameterValues>"
        "</ssd:ParameterBinding></ssd:ParameterBindings></ssd:Component>"
    )


def values2(**given: tuple[str, str, tuple[int, ...]]) -> str:
    """A ParameterSet of version 2.0: name -> (type, value, sizes)."""
    rows = "".join(
        f'<ssv:Parameter name="{n}"><ssv:{type_} value="{value}"/>'
        + "".join(f'<ssv:Dimension size="{k}"/>' for k in sizes)
        + "</ssv:Parameter>"
        for n, (type_, value, sizes) in given.items()
    )
    return f'<ssv:ParameterSet version="2.0" name="set"><ssv:Parameters>{rows}</ssv:Parameters></ssv:ParameterSet>'


PORT = (
    '<ssd:Connectors><ssd:Connector name="u" kind="input"><ssc:Float64/><ssd:Dimension size="3"/></ssd:Connector>'
    "</ssd:Connectors>"
)


def test_arrays_and_types_of_version_2_go_from_unit_to_unit(load, folder):
    """x' = A x + B u, y = C x + D u: `a` passes its input on doubled, `b` integrates it; through a system's connector as well."""
    shutil.copy(native_fmu("state_space", 3), folder / "state_space.fmu")
    zero, one = "0 0 0 0 0 0 0 0 0", "1 0 0 0 1 0 0 0 1"
    square = (3, 3)
    a = arrays(
        "a",
        {"y": ("output", "3")},
        values2(
            A=("Float64", zero, square),
            B=("Float64", zero, square),
            C=("Float64", zero, square),
            D=("Float64", "2 0 0 0 2 0 0 0 2", square),
            u=("Float64", "1 -2 3", (3,)),
        ),
    )
    b = arrays(
        "b",
        {"u": ("input", "3"), "y": ("output", "3")},
        values2(A=("Float64", zero, square), B=("Float64", one, square), C=("Float64", one, square), D=("Float64", zero, square)),
    )
    inner = system("inner", b, connection("u", "b.u")).replace("<ssd:Elements>", PORT + "<ssd:Elements>", 1)
    text = document(system("s", a + inner, connection("a.y", "inner.u")), annotations=STEP)
    scene = load(text.replace('version="1.0" name="test"', 'version="2.0" name="test"'), valid=False)
    assert scene.remarks == ()
    assert scene.arrows == tuple(f"a.y[{k}] -> inner.b.u[{k}]" for k in (1, 2, 3))
    last = values(scene)
    assert [last[f"inner.b.y[{k}]"] for k in (1, 2, 3)] == pytest.approx([2.0, -4.0, 6.0], rel=1e-12)  # over one second


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ('value="1 -2 3"', 'value="1 -2"', ["2 values of 'u'", "3"]),
        ('<ssv:Float64 value="1 -2 3"/>', '<ssv:UInt8 value="1 -2.5 3"/>', ["'-2.5'", "whole number"]),
        (
            '<ssd:Dimension size="3"/></ssd:Connector></ssd:Connectors><ssd:Elements>',
            '<ssd:Dimension size="2"/></ssd:Connector></ssd:Connectors><ssd:Elements>',
            ["shape (3) and (2)"],
        ),
        (
            '<ssd:Dimension size="3"/></ssd:Connector></ssd:Connectors><ssd:Elements>',
            '<ssd:Dimension sizeConnector="n"/></ssd:Connector></ssd:Connectors><ssd:Elements>',
            ["connector 'u' of sizes [0]"],
        ),
    ],
)
def test_arrays_that_do_not_fit_are_refused(load, folder, old, new, named):
    shutil.copy(native_fmu("state_space", 3), folder / "state_space.fmu")
    a = arrays("a", {"y": ("output", "3")}, values2(u=("Float64", "1 -2 3", (3,))))
    b = arrays("b", {"u": ("input", "3")}, values2())
    inner = system("inner", b, connection("u", "b.u")).replace("<ssd:Elements>", PORT + "<ssd:Elements>", 1)
    text = document(system("s", a + inner, connection("a.y", "inner.u")), annotations=STEP)
    assert old in text
    with pytest.raises(BadInput) as caught:
        load(text.replace(old, new), valid=False)
    assert [part for part in named if part not in str(caught.value)] == [], caught.value


def dictionary(entries, name="d"):
    rows = "".join(
        f'<ssb:DictionaryEntry name="{n}"><ssc:Real unit="{unit}"/></ssb:DictionaryEntry>' for n, unit in entries.items()
    )
    return (
        f'<ssd:SignalDictionaries><ssd:SignalDictionary name="{name}"><ssb:SignalDictionary version="1.0" name="{name}" '
        f'xmlns:ssb="http://ssp-standard.org/SSP1/SystemStructureSignalDictionary">{rows}<ssb:Units>{systems.definitions("ssc:")}</ssb:Units>'
        "</ssb:SignalDictionary></ssd:SignalDictionary></ssd:SignalDictionaries>"
    )


def reference(name, *signals, of="d"):
    ports = "".join(f'<ssd:Connector name="{s}" kind="inout"><ssc:Real/></ssd:Connector>' for s in signals)
    inside = f"<ssd:Connectors>{ports}</ssd:Connectors>"
    return f'<ssd:SignalDictionaryReference name="{name}" dictionary="{of}">{inside}</ssd:SignalDictionaryReference>'


def with_dictionary(root, entries):
    return root.removesuffix("</ssd:System>") + dictionary(entries) + "</ssd:System>"


def test_a_signal_dictionary_joins_what_reaches_it_anywhere_in_the_system(load):
    """3 m at the top is 3000 mm in the dictionary, and 3 m again at b, in a system of its own, and at c."""
    inner = system("in", reference("here", "v") + component("b", source="metres.fmu"), connection("here.v", "b.u"))
    a = component("a", inside=bindings("u=Real:3"), source="metres.fmu")
    outer = connection("a.y", "bus.v") + connection("bus.v", "c.u")
    root = system("s", a + component("c", source="metres.fmu") + reference("bus", "v") + inner, outer)
    scene = read(load, with_dictionary(root, {"v": "mm"}), valid=False)
    assert set(scene.arrows) == {"a.y -> in.b.u", "a.y -> c.u"}
    assert {k: pytest.approx(v, rel=1e-15) for k, v in values(scene).items() if k.endswith("x")} == {
        "a.x": 3.0,
        "in.b.x": 3.0,
        "c.x": 3.0,
    }


@pytest.mark.parametrize(
    ("links", "of", "part"),
    [
        (connection("a.y", "bus.v") + connection("b.y", "bus.v"), "d", "driven a second time"),
        (connection("a.y", "bus.w"), "d", "connector 'w'"),
        (connection("bus.v", "bus.v"), "d", "one that gives and one that takes"),
        (connection("a.y", "bus.v"), "e", "reference to the signal dictionary e"),
    ],
)
def test_a_signal_of_a_dictionary_has_one_source(load, links, of, part):
    root = with_dictionary(system("s", PAIR + reference("bus", "v", of=of), links), {"v": "m"})
    with pytest.raises(BadInput) as raised:
        read(load, root, valid=False)
    assert part in str(raised.value)
