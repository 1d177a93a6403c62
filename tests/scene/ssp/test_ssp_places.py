"""URIs of a system begin at the document in which they stand (RFC 3986, 5.2), in archives and in folders; differences in parameter sets."""

import zipfile

import pytest
from cosimo import BadInput, load_scene
from cosimo.tests.scene.ssp import systems
from cosimo.tests.scene.ssp.systems import SPACES, bindings, component, connection, document, parameter_set, system

NESTED = 'type="application/x-ssp-definition"'
SET = '<ssd:ParameterBindings><ssd:ParameterBinding source="{}">{}</ssd:ParameterBinding></ssd:ParameterBindings>'
MAPPING = '<ssd:ParameterMapping source="{}"/>'


def saved(folder, kind, members):
    """A system whose files are these, as an archive or as a folder; its .ssd or .ssp file."""
    if kind == "ssp":
        path = folder / "test.ssp"
        with zipfile.ZipFile(path, "w") as file:
            for place, content in members.items():
                file.writestr(place, content)
        return path
    for place, content in members.items():
        path = folder / "laid" / place
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content.encode() if isinstance(content, str) else content)
    return folder / "laid" / "SystemStructure.ssd"


@pytest.mark.parametrize("kind", ["ssd", "ssp"])
def test_uris_begin_at_their_document(folder, kind, library):
    adder, metres = (folder / "adder.fmu").read_bytes(), (folder / "metres.fmu").read_bytes()
    rows = '<ssm:MappingEntry source="p" target="gain"/>'
    mapping = f'<ssm:ParameterMapping version="1.0" {SPACES}>{rows}</ssm:ParameterMapping>'
    inner = system("inner", component("a", source="u.fmu", inside=SET.format("set%201.ssv", MAPPING.format("./maps/m.ssm"))))
    deeper = system("deeper", component("a", source="../u.fmu") + component("b", source="./x/../../../u.fmu"))
    # one file with two systems, of which the one with the id is meant
    two = system(
        "first",
        component("a", source="no.fmu")
        + system("wanted", component("c", source="u.fmu")).replace("<ssd:System ", '<ssd:System id="w" '),
    )
    outer = system(
        "outer",
        component("top", source="u.fmu")
        + component("one", "", source="sub/inner.ssd", more=NESTED)
        + component("two", "", source="sub/deep/deeper.ssd", more=NESTED)
        + component("three", "", source="sub/two.ssd#w", more=NESTED),
    )
    members = {
        "SystemStructure.ssd": document(outer),
        "u.fmu": adder,
        "sub/u.fmu": metres,
        "sub/inner.ssd": document(inner),
        "sub/set 1.ssv": parameter_set("p=Real:3", spaces=SPACES),
        "set 1.ssv": parameter_set("p=Real:7", spaces=SPACES),
        "sub/maps/m.ssm": mapping,
        "sub/deep/deeper.ssd": document(deeper),
        "sub/two.ssd": document(two),
    }
    scene = load_scene(saved(folder, kind, members))
    units = {name: scene.coupling.interfaces[name].outputs["y"].unit for name in scene.units}
    assert units == {"top": "", "one.a": "m", "two.a": "m", "two.b": "", "three.c": "m"}
    assert scene.units["one.a"].parameters == {"gain": 3.0}
    assert not [r for r in scene.remarks if "outside" in r]


@pytest.mark.parametrize("kind", ["ssd", "ssp"])
@pytest.mark.parametrize(
    "source",
    [
        "../../../u.fmu",
        "/u.fmu",
        "file:///u.fmu",
        "u.fmu?x=1",
        "u.fmu#part",
        "%2e%2e/%2e%2e/%2E./u.fmu",
        "..%2fu.fmu",
        "u.fmu/",
        "//h/u.fmu",
        "[u.fmu",
    ],
)
def test_uris_that_leave_or_mean_something_else_are_refused(folder, kind, source):
    inner = system("inner", component("a", source=source))
    members = {
        "SystemStructure.ssd": document(system("outer", component("one", "", source="a/b/inner.ssd", more=NESTED))),
        "a/b/inner.ssd": document(inner),
        "u.fmu": (folder / "adder.fmu").read_bytes(),
    }
    with pytest.raises(BadInput, match=r"inner.ssd:\d+: got (source .* relative path|source .* FMU file beside|file )"):
        load_scene(saved(folder, kind, members))


def test_differences_in_parameter_sets_have_no_offset(folder, library):
    systems.fmu(folder / "differences.fmu", library, 'K" relativeQuantity="true')
    systems.fmu(folder / "values.fmu", library, "K")
    inside = bindings("u=Real:18[degF]", units=systems.definitions("ssc:", "degF"))
    elements = component("d", source="differences.fmu", inside=inside) + component("v", source="values.fmu", inside=inside)
    scene = load_scene(
        saved(
            folder,
            "ssp",
            {
                "SystemStructure.ssd": document(system("s", elements)),
                **{name: (folder / name).read_bytes() for name in ("differences.fmu", "values.fmu")},
            },
        )
    )
    assert scene.units["d"].parameters["u"] == pytest.approx(10.0, rel=1e-12)
    assert scene.units["v"].parameters["u"] == pytest.approx(10.0 + 255.3722222222222, rel=1e-12)


def test_a_difference_and_a_value_need_a_transformation(folder, library):
    systems.fmu(folder / "difference.fmu", library, "K", 'degF" relativeQuantity="true')
    fmu = (folder / "difference.fmu").read_bytes()

    def links(inside):
        elements = component("a", source="difference.fmu") + component("b", source="difference.fmu")
        text = document(system("s", elements, connection("a.y", "b.u", inside)))
        scene = load_scene(saved(folder, "ssp", {"SystemStructure.ssd": text, "difference.fmu": fmu}))
        return [(link.factor, link.offset) for link in scene.coupling.links]

    with pytest.raises(BadInput, match=r"a difference for a value.*LinearTransformation"):
        links("")
    ((factor, offset),) = links('<ssc:LinearTransformation factor="1" offset="290"/>')
    assert (factor, offset) == (pytest.approx(5.0 / 9.0, rel=1e-12), 290.0)
