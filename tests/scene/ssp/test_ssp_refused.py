"""Systems in .ssd files that are refused, in one message with the place, and what is left out with a remark."""

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.tests.scene.ssp import systems
from cosimo.tests.scene.ssp.systems import PAIR, STEP, bindings, component, connection, document, read, system, units, values

A = component("a")
BINDING = "<ssd:ParameterBindings><ssd:ParameterBinding {}/></ssd:ParameterBindings>"
OURS = '<ssc:Annotation type="cosimo"><x>{}</x></ssc:Annotation>'
ENTRY = '<ssm:MappingEntry source="{}" target="{}"/>'
VALUE = '<ssc:MapEntry source="3" target="{}"/>'
TWICE = (
    '<ssm:MappingEntry source="U" target="a.count"><ssc:IntegerMappingTransformation>'
    f"{VALUE.format(4)}{VALUE.format(5)}</ssc:IntegerMappingTransformation></ssm:MappingEntry>"
)
BAD = [  # (root, more, what the message must name)
    (system("s", PAIR, connection("a.y", "c.u")), "", ["element 'c'", "'s'"]),
    (system("s", PAIR, connection("a.z", "b.u")), "", ["connector 'z'", "'a'"]),
    (system("s", PAIR, connection("a.u", "b.u")), "", ["a.u and b.u", "both take"]),
    (system("s", PAIR, connection("a.y", "b.y")), "", ["both give"]),
    (system("s", PAIR, connection("a.y", "b.u") + connection("b.y", "b.u")), "", ["b.u driven a second time", "a.y"]),
    (
        system(
            "s",
            PAIR,
            connection(
                "a.y",
                "b.u",
                '<ssc:BooleanMappingTransformation><ssc:MapEntry source="true" target="false"/>'
                "</ssc:BooleanMappingTransformation>",
            ),
        ),
        "",
        ["connection 'a.y -> b.u'", "a map from a real output", "truth values"],
    ),
    (system("s", A + A), "", ["second element 'a'"]),
    (system("s", component("a", "v<") + component("b"), connection("b.y", "a.v")), "", ["connector 'v'", "connector of 'a'"]),
    (system("s", component("a", "y<")), "", ["connector a.y of kind 'input'", "'output'"]),
    (system("s", component("a").replace("<ssc:Real/>", "<ssc:Integer/>", 1)), "", ["connector a.u of type Integer", "Real"]),
    (system("s", component("a", "u<[inch]", source="metres.fmu")), units("inch"), ["connector a.u in 'inch'", "'m'"]),
    (system("s", component("a", "y>[s]") + component("b", "u<[K]"), connection("a.y", "b.u")), units("s", "K"), ["'s'", "'K'"]),
    (system("s", component("a", "y>[foo]") + component("b", "u<[K]"), connection("a.y", "b.u")), "", ["'foo'", "no definition"]),
    (system("s", component("a", source="none.fmu")), "", ["none.fmu", "FMU file"]),
    (system("s", component("a", more='type="application/x-else"')), "", ["application/x-else"]),
    (system("s", component("a", source="#none")), "", ["'#none'"]),
    (system("s", component("a", source="test.ssd", more='type="application/x-ssp-definition"')), "", ["nested more than"]),
    (system("s", component("a", source="adder.fmu", more='type="application/x-ssp-package"')), "", ["SystemStructure.ssd"]),
    (system("s", component("a", inside=bindings("count=Real:2.5"))), "", ["count = 2.5", "Integer"]),
    (system("s", component("a", inside=bindings("mode=Enumeration:hihg"))), "", ["hihg", "'high'"]),
    (system("s", component("a", inside=bindings("gain=Real:1[s]", units=systems.definitions("ssc:", "s")))), "", ["'s'", "'mm'"]),
    (system("s", component("a", inside=bindings("gain=Real:INF"))), "", ["gain", "inf", "finite"]),
    (system("s", component("a", inside=BINDING.format('source="no.ssv"'))), "", ["no.ssv", "No such file"]),
    (system("s", component("a", inside=BINDING.format('source="adder.fmu"'))), "", ["adder.fmu", "syntax error"]),
    (system("s", component("a", inside=BINDING.format(""))), "", ["ParameterBinding without values"]),
    (system("s", A + '<ssd:SignalDictionaryReference name="d" dictionary="e"/>'), "", ["signal dictionary"]),
    (
        system("s", A, bindings=bindings("U=Real:3 V=Real:4", mapping=ENTRY.format("U", "a.u") + ENTRY.format("V", "a.u"))),
        "",
        ["target 'a.u' of two entries"],
    ),
    (system("s", A, bindings=bindings("U=Integer:3", mapping=TWICE)), "", ["a second MapEntry of '3'"]),
]


@pytest.mark.parametrize(("root", "more", "named"), BAD)
def test_bad_systems_give_one_message_with_the_place(load, root, more, named):
    with pytest.raises(BadInput) as caught:
        read(load, root, more)
    message = str(caught.value)
    assert [part for part in named if part not in message] == [], message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("<a", ["test.ssd:1", "syntax error"]),
        ("<a/>", ["SystemStructureDescription of SSP 1.0"]),
        (document(system("s", A)).replace('version="1.0" name="test"', 'version="3.0" name="test"'), ["version '3.0'"]),
        (document(system("s", A)).replace('source="adder.fmu"', ""), ["Component without source"]),
        (document(system("s", A)).replace('kind="input"', 'kind="inpt"'), ["'inpt'", "input"]),
        (document(system("s", A) + system("t", A)), ["2 systems, 's', 't'", "expected one"]),
        (document(system("s", A, bindings=bindings("a.count=Integer:1_1"))), ["'1_1'", "a whole number"]),
        (document(system("s", A, bindings=bindings("a.u=Real:1_1"))), ["'1_1'", "a number"]),
        (document(system("s", A), experiment='startTime="1" stopTime="1"'), ["stop_time", "after start_time, 1 s"]),
        (document(system("s", A), experiment='stopTime="x"'), ['stopTime="x"', "a finite number"]),
        (document(system("s", A), experiment='stopTime="-1"'), ["stop_time", "-1"]),
        (document(system("s", A), annotations=OURS.format("{")), ["no JSON"]),
        (document(system("s", A), annotations=OURS.format('{"units": {"a": 1}}')), ["another form"]),
        (document(system("s", A), annotations=OURS.format('{"scene": {"mster": {}}}')), ["mster", "'master'"]),
    ],
)
def test_files_that_the_schema_would_refuse_give_one_message_too(load, text, named):
    with pytest.raises(BadInput) as caught:
        load(text, valid=False)
    message = str(caught.value)
    assert [part for part in named if part not in message] == [], message


VALUED = system("s", PAIR, connection("a.y", "b.u"), bindings="{}")
LENIENT = [  # what other tools write, and what the one remark on it names
    (
        document(VALUED.format(bindings("U=Real:3", mapping=ENTRY.format("V", "a.u"))), annotations=STEP),
        "parameters that are mapped and in no set; left out: 'V'",
    ),
    (
        document(VALUED.format(bindings("a.gain=Real:3 a.gain=Real:4")), annotations=STEP),
        "parameters that stand there twice; the last value is taken: 'a.gain'",
    ),
    (
        document(system("s", component("a", "u<") + component("b"), connection("a.y", "b.u")), annotations=STEP),
        "connector a.y is not listed; the FMU's variable is taken",
    ),
    (
        document(
            system("s", component("a", source="proxyfmu://localhost?file=adder.fmu") + component("b"), connection("a.y", "b.u")),
            annotations=STEP,
        ),
        "is read as the file itself",
    ),
    (
        document(
            system("s", component("a", more='implementation="ScheduledExecution"') + component("b"), connection("a.y", "b.u")),
            annotations=STEP,
        ),
        "'a' is to be run by scheduled execution",
    ),
    (
        document(system("s", component("a", "y> v<") + component("b", "u<"), connection("a.y", "b.u")), annotations=STEP),
        "connector a.v left out: the FMU has no such variable",
    ),
    (
        document(
            system(
                "s",
                component("a", "y> u<").replace("<ssc:Real/>", "<ssc:Clock/>").replace("<ssc:Clock/>", "<ssc:Real/>", 1)
                + component("b", "u<"),
                connection("a.y", "b.u"),
            ),
            annotations=STEP,
        ),
        "connector a.u left out: its type is Clock",
    ),
    (
        document(
            system("s", component("a", more='tool:colour="red"') + component("b"), connection("a.y", "b.u")), annotations=STEP
        ),
        "the prefix 'tool' is not declared; its meaning is not known",
    ),
    (
        document(system("s", PAIR, connection("a.y", "b.u")), annotations=STEP).replace(" xmlns:ssc=", " xmlns:other="),
        "the prefix 'ssc' is not declared; taken as http://ssp-standard.org/SSP1/SystemStructureCommon",
    ),
    (
        document(
            system("s", component("a", inside=bindings("blob=Binary:00ff")) + component("b"), connection("a.y", "b.u")),
            annotations=STEP,
        ),
        "'blob'",
    ),
]


@pytest.mark.parametrize(("text", "remark"), LENIENT)
def test_what_is_not_needed_is_left_out_with_one_remark(load, text, remark):
    scene = load(text, valid=False)
    assert scene.arrows == ("a.y -> b.u",)
    assert [remark in r for r in scene.remarks] == [True], scene.remarks
    assert values(scene)["b.y"] == 0.0


def test_an_empty_source_stands_for_what_is_inline(load):
    text = document(system("s", component("a", inside=bindings("u=Real:3"))), annotations=STEP)
    text = text.replace("<ssd:ParameterBinding ", '<ssd:ParameterBinding source="" ', 1)
    assert 'source=""' in text
    assert values(load(text, valid=False))["a.y"] == 3.0


def test_entities_are_refused(load, folder):
    (folder / "secret").write_text("7")
    text = document(system("s", component("a", inside=bindings("count=Integer:1"))))
    text = text.replace("?>\n", '?>\n<!DOCTYPE d [<!ENTITY e SYSTEM "secret"><!ENTITY f "2">]>\n')
    for bad in (text.replace("</ssd:System>", "&e;</ssd:System>"), text.replace('value="1"', 'value="&f;"')):
        with pytest.raises(BadInput, match="entities"):
            load(bad, valid=False)
