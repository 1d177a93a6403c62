"""Files with one thing wrong in them: read, or refused with one message; never a traceback."""

import contextlib

from cosimo import BadInput, load_scene
from cosimo.tests.scene.ssp.systems import bindings, component, connection, definitions, document, system, units
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from lxml import etree

LINEAR = '<ssc:LinearTransformation factor="2" offset="1"/>'
MAPPING = f'<ssm:MappingEntry source="g" target="in.b.gain">{LINEAR}</ssm:MappingEntry>'
TEXT = document(
    system(
        "s",
        component("a", "u<[m] y>[m]", bindings("count=Integer:1 flag=Boolean:true"), "metres.fmu", 'implementation="any"')
        + system("in", component("b"), connection("p", "b.u", LINEAR), "p<[mm]"),
        connection("a.y", "in.p", "", 'suppressUnitConversion="false"'),
        "",
        bindings("g=Real:2[m] m=Enumeration:low", mapping=MAPPING, units=definitions("ssc:", "m")),
    ),
    units("m", "mm"),
    'startTime="0" stopTime="1"',
    '<ssc:Annotation type="com.opensimulationplatform"><osp:Algorithm><osp:FixedStepAlgorithm baseStepSize="0.5"/>'
    '</osp:Algorithm></ssc:Annotation><ssc:Annotation type="cosimo"><x>{"scene": {"master": {"step": 0.25}}}</x>'
    "</ssc:Annotation>",
)
ODD = st.sampled_from(
    [
        "",
        "0",
        "-1",
        "nan",
        "INF",
        "1e999",
        "9" * 5000,
        "true",
        "..",
        "/",
        "#",
        "%00",
        "a.u",
        "in.b",
        "s",
        "\u200b",
        "x y",
        "u -> y",
        "*",
        "a\tb",
        "metres.fmu",
        "test.ssd",
        "application/x-ssp-package",
        "application/x-ssp-definition",
        "output",
        "parameter",
        "inout",
        "component",
        "[]",
        '{"units": []}',
        '{"elements": {"a": "in.b"}}',
    ]
)


@settings(max_examples=300, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture])
@given(st.data())
def test_one_thing_wrong_never_gives_a_traceback(folder, data):
    root = etree.fromstring(TEXT.encode())
    nodes = list(root.iter())
    node = nodes[data.draw(st.integers(0, len(nodes) - 1))]
    change = data.draw(st.sampled_from(["attribute", "drop", "double", "text", "remove attribute", "other place"]))
    if change in ("attribute", "remove attribute") and node.attrib:
        name = data.draw(st.sampled_from(sorted(node.attrib)))
        if change == "attribute":
            node.set(name, data.draw(ODD))
        else:
            del node.attrib[name]
    elif change == "text":
        node.text = data.draw(ODD)
    elif node is not root and change == "drop":
        node.getparent().remove(node)
    elif node is not root and change == "double":
        node.addnext(etree.fromstring(etree.tostring(node)))
    elif node is not root:
        other = nodes[data.draw(st.integers(0, len(nodes) - 1))]
        if node not in other.iterancestors() and other is not node:
            other.append(node)
    path = folder / "test.ssd"
    path.write_bytes(etree.tostring(root, encoding="UTF-8", xml_declaration=True))
    with contextlib.suppress(BadInput):
        load_scene(path)
