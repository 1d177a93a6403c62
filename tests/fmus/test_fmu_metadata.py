"""What other tools show of an FMU: units, types, sizes, terminals, picture, license, and which inputs they list."""

import struct
import zipfile
import zlib
from pathlib import Path
from xml.etree import ElementTree as ET

import fmpy
import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.measure import parse
from cosimo.fmus.build import build
from cosimo.fmus.description import FILE, ICON, model_description, shared_files, terminals
from cosimo.fmus.interface import interface
from cosimo.fmus.native.description import description
from cosimo.fmus.native.variables import NativeVariable
from cosimo.fmus.picture import SIZE, icon
from lxml import etree

SCHEMAS = Path(fmpy.__file__).parent / "schema"


def described(name, **more):
    return ET.fromstring(model_description(name, component_class(name), "", **more))


@pytest.mark.parametrize("name", CATALOGUE)
def test_units_types_and_sizes_of_every_real_variable(name):
    """Factors are compared with what the units' names mean: the value shown in the display unit is the same quantity."""
    root = described(name)
    units = {u.get("name"): {d.get("name"): d for d in u.findall("DisplayUnit")} for u in root.iter("Unit")}
    types = {t.get("name"): t.find("Real") for t in root.iter("SimpleType")}
    reals = [v.find("Real") for v in root.find("ModelVariables") if v.find("Real") is not None]
    assert reals
    for real in reals:
        assert float(real.get("nominal")) > 0.0
        assert real.get("displayUnit", next(iter(units[real.get("unit")]), None)) in (None, *units[real.get("unit")])
        if declared := real.get("declaredType"):
            assert types[declared].get("unit") == real.get("unit")
            assert types[declared].get("displayUnit") in (None, *units[real.get("unit")])
    for unit, shown in units.items():
        for display, element in shown.items():
            own, other = parse(unit), parse(display)
            assert own.exponents == other.exponents
            for value in (0.0, 1.0, 300.0):
                number = float(element.get("factor")) * value + float(element.get("offset", "0"))
                assert other.factor * number + other.offset == pytest.approx(own.factor * value + own.offset, abs=1e-10)


def test_what_is_shown_how():
    shown = {}
    for name in ("BeamRotor", "BearingTemperatures", "GimbalBody", "Pantograph"):
        root = described(name)
        shown |= {(name, v.get("name")): v[0].get("displayUnit") for v in root.find("ModelVariables")}
    assert shown["BeamRotor", "speed"] == shown["BeamRotor", "bearing_a.speed"] == "rpm"
    assert shown["GimbalBody", "outer_rate"] == "deg/s"
    assert shown["BearingTemperatures", "ambient"] == "degC"
    assert shown["Pantograph", "wire_height"] == "mm"
    assert shown["Pantograph", "contact_position"] is None  # hundreds of metres


def test_derivatives_of_inputs_are_listed_on_request(tmp_path):
    """Value references and everything else stay; the slave knows the inputs all the same."""
    without, all_ = described("Pantograph", derivatives=False), described("Pantograph")
    references = [{v.get("name"): v.get("valueReference") for v in root.find("ModelVariables")} for root in (without, all_)]
    inputs = [s.name for s in interface(component_class("Pantograph")) if s.causality == "input" and not s.order]
    assert set(references[1]) - set(references[0]) == {f"der({i}{more})" for i in inputs for more in ("", ",2")}
    assert references[0].items() <= references[1].items()
    outputs = [[u.get("index") for u in root.find("ModelStructure/Outputs")] for root in (without, all_)]
    names = [
        [list(root.find("ModelVariables"))[int(i) - 1].get("name") for i in indices]
        for root, indices in zip((without, all_), outputs, strict=True)
    ]
    assert names[0] == names[1]

    path = build("Pantograph", tmp_path)
    rows = fmpy.simulate_fmu(str(path), stop_time=0.01, step_size=0.001, output_interval=0.001)
    assert (len(rows), rows["time"][-1]) == (11, pytest.approx(0.01))
    with zipfile.ZipFile(path) as file:
        text = file.read("documentation/licenses/license.txt").decode()
        assert {FILE, ICON, "model.png"} <= set(file.namelist())
    assert text.count("Permission is hereby granted") == 2  # its own and PythonFMU's


@pytest.mark.parametrize("name", CATALOGUE)
def test_terminals_fit_the_schema_and_name_variables_of_the_fmu(name):
    component = component_class(name)
    files = shared_files(name, component, interface(component))
    schema = etree.XMLSchema(file=str(SCHEMAS / "fmi3" / "fmi3TerminalsAndIcons.xsd"))
    root = etree.fromstring(files[FILE])
    schema.assertValid(root)
    listed = {s.name for s in interface(component)}
    for terminal in root.iter("Terminal"):
        members = [m.get("memberName") for m in terminal]
        assert len(members) == len(set(members)) > 1
        assert {m.get("variableName") for m in terminal} <= listed


def test_a_rotor_and_a_bearing_match_member_by_member():
    """All that the rotor gives to and takes from a bearing is in one terminal of the bearing, as scenes connect them."""
    ends = {
        n: [s for s in interface(component_class(n)) if s.causality != "parameter" and not s.order]
        for n in ("BeamRotor", "DeepGrooveBearing")
    }
    rotor, bearing = (
        terminals((s.name for s in group), component_class(n).ports, component_class(n).port_members) for n, group in ends.items()
    )
    causality = {n: {s.name: s.causality for s in group} for n, group in ends.items()}
    port = rotor["bearing_a"]
    given = {m for m, v in port.items() if causality["BeamRotor"][v] == "output"}
    assert len(given) == 9
    shaft = {m: causality["DeepGrooveBearing"][v] for m, v in bearing["shaft"].items()}
    assert {m for m, c in shaft.items() if c == "input"} >= given
    assert {m for m, c in shaft.items() if c == "output"} >= set(port) - given
    assert "linearisation" not in bearing


def test_a_pantograph_and_a_catenary_match_member_by_member():
    pantograph, catenary = ({s.name: s.causality for s in interface(component_class(n))} for n in ("Pantograph", "Catenary"))
    ends = [
        terminals((n for n, c in i.items() if c != "parameter"), component_class(name).ports, component_class(name).port_members)[
            "contact"
        ]
        for name, i in (("Pantograph", pantograph), ("Catenary", catenary))
    ]
    assert set(ends[0]) == set(ends[1]) == {"contact_position", "contact_force", "wire_height", "contact_compliance"}
    assert all({pantograph[ends[0][m]], catenary[ends[1][m]]} == {"input", "output"} for m in ends[0])


def test_arrays_of_fmi_3_are_one_variable_with_a_type():
    component = component_class("BeamRotor")
    scalars = [s for s in interface(component) if s.name.startswith("bearing_a.stiffness[")]
    variables = tuple(NativeVariable(s, "INPUT", size=len(scalars) if not k else 0) for k, s in enumerate(scalars))
    root = ET.fromstring(description(3, "BeamRotor", component, variables, "", derivatives=False))
    assert [v.get("name") for v in root.find("ModelVariables")] == ["time", "bearing_a.stiffness"]
    assert all(t.get("unit") in {u.get("name") for u in root.iter("Unit")} for t in root.iter("Float64Type"))


def test_the_picture_is_a_sound_png_with_the_name_and_the_marks():
    files = [icon("Pantograph", 3, 5), icon("Pantograph", 3, 6), icon("Catenary", 3, 5)]
    assert len(set(files)) == 3
    content = files[0]
    assert content[:8] == b"\x89PNG\r\n\x1a\n"
    at, chunks = 8, {}
    while at < len(content):
        length, kind = struct.unpack(">I4s", content[at : at + 8])
        chunks[kind] = content[at + 8 : at + 8 + length]
        assert zlib.crc32(kind + chunks[kind]) == struct.unpack(">I", content[at + 8 + length : at + 12 + length])[0]
        at += 12 + length
    assert list(chunks) == [b"IHDR", b"PLTE", b"IDAT", b"IEND"]
    rows = zlib.decompress(chunks[b"IDAT"])
    assert len(rows) == SIZE * (1 + SIZE // 2)
    pixels = [n for k in range(SIZE) for b in rows[k * (1 + SIZE // 2) + 1 : (k + 1) * (1 + SIZE // 2)] for n in (b >> 4, b & 15)]
    assert set(pixels) == set(range(len(chunks[b"PLTE"]) // 3))
