"""Numbers with their units: converted by the declaration, refused for another dimension; bare numbers stay what they are."""

import re

import pytest
from cosimo import BadInput, build, load_scene, read_scene
from cosimo.components.core.measure import is_quantity, number_in
from cosimo.orchestrator.systems.scene_schema import scene_schema
from cosimo.tests.commands import exit_code


@pytest.mark.parametrize(
    ("text", "unit", "number"),
    [
        ("250 km/h", "m/s", 250.0 / 3.6),
        ("250km/h", "m/s", 250.0 / 3.6),
        ("-3.5e2 mm/N", "m/N", -0.35),
        ("20 deg", "rad", 0.3490658503988659),
        ("20°", "rad", 0.3490658503988659),
        (".5 kN / m", "N/m", 500.0),
        ("4 kN·s/m", "N.s/m", 4000.0),
        ("4 kN s/m", "N.s/m", 4000.0),
        ("2 cm²", "m2", 2e-4),
        ("3 µm", "m", 3e-6),
        ("1500 rpm", "rad/s", 157.07963267948966),
        ("5 %", "1", 0.05),
        ("20 K", "K", 20.0),
        ("20 °C", "degC", 20.0),
    ],
)
def test_a_number_with_its_unit(text, unit, number):
    assert is_quantity(text)
    assert number_in(text, unit, "x") == pytest.approx(number, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "unit", "named"),
    [
        ("250 kg", "m/s", "a unit of the dimension of m/s"),
        ("50 Hz", "rad/s", "a unit of the dimension of rad/s"),
        ("3 m", "1", "a number without unit"),
        ("250 kmh", "m/s", "'kmh' is not known"),
        ("5 m//s", "m/s", "factors joined"),
        ("20 degC", "K", "A temperature and a difference"),
    ],
)
def test_another_dimension_is_refused(text, unit, named):
    with pytest.raises(BadInput, match=named) as refused:
        number_in(text, unit, "speed")
    assert repr(text) in str(refused.value)


@pytest.mark.parametrize("text", ["250", "km/h", "2,5 m/s", "1 000 m", "", "AC simple", "2 * 3", "nan m", "--3 m"])
def test_other_texts_are_no_numbers(text):
    """`1 000 m` and `2,5 m/s` may be read in two ways; the check of the parameter refuses them."""
    assert not is_quantity(text)
    with pytest.raises(BadInput, match="speed"):
        load_scene("lumped-catenary").with_changes({"pantograph.speed": text})


def test_a_scene_has_numbers_whatever_its_file_says():
    scene = load_scene("en50318-2002").with_changes(
        {
            "stop_time": "0.05 min",
            "pantograph.speed": "180 km/h",
            "units.catenary.parameters": {"damping": {"beta": "1 ms"}, "spans": 10},
        }
    )
    assert scene.stop_time == 3.0
    assert scene.units["pantograph"].parameters["speed"] == pytest.approx(50.0, rel=1e-15)
    assert scene.units["catenary"].parameters["damping.beta"] == 1e-3
    with pytest.raises(BadInput, match=re.escape("spans = '10 m'")):
        scene.with_changes({"catenary.spans": "10 m"})
    with pytest.raises(BadInput, match=re.escape("stop_time: got '3 m'")):
        scene.with_changes({"stop_time": "3 m"})


def test_elements_of_an_array_and_parameters_of_a_subsystem(tmp_path):
    (tmp_path / "inner.toml").write_text('[units]\nhead = { component = "Pantograph" }\n')
    inner = {"scene": "inner.toml", "parameters": {"head.speed": "36 km/h"}}
    lumped = {"component": "LumpedCatenary", "parameters": {"harmonic": ["20 %", 0.1]}}
    scene = read_scene({"stop_time": 1.0, "units": {"a": inner, "b": lumped}, "master": {"step": "1 ms"}}, "scene", tmp_path)
    assert scene.units["a.head"].parameters == {"speed": 10.0}
    assert scene.units["b"].parameters == {"harmonic[1]": 0.2, "harmonic[2]": 0.1}
    assert scene.master.step == 1e-3


def test_an_fmu_gets_its_own_unit(tmp_path):
    fmu = build("Pantograph", tmp_path)
    scene = load_scene(fmu).with_changes({"fmu.speed": "180 km/h"})
    assert scene.units["fmu"].parameters == {"speed": 50.0}
    with pytest.raises(BadInput, match="dimension of m/s"):
        load_scene(fmu).with_changes({"fmu.speed": "180 km"})


def test_the_command_line_takes_units(capsys):
    main_ = ["run", "lumped-catenary", "--dry-run", "--in-process"]
    assert exit_code(*main_, "--set", "pantograph.speed=180 kN") == 2
    assert "dimension of m/s" in capsys.readouterr().err


def test_editors_accept_units():
    speed = scene_schema()["$defs"]["component.Pantograph"]["properties"]["parameters"]["properties"]["speed"]
    assert "string" in speed["type"]
    assert re.search(speed["pattern"], "250 km/h")
