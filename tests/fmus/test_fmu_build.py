"""The files: reproducible, complete, conforming."""

import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile

import pytest
from cosimo import BadInput, check
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.fmus.build import build, built, sources
from cosimo.fmus.description import RELEASED, initial_dependencies
from cosimo.fmus.loader import same_sources, stable_copy
from cosimo.tests.short_run import ONE_A_SYSTEM, full_but
from fmpy.validation import validate_fmu


def description(path):
    with zipfile.ZipFile(path) as file:
        return ET.fromstring(file.read("modelDescription.xml"))


@pytest.mark.full
@pytest.mark.parametrize("name", ONE_A_SYSTEM)
def test_two_builds_are_the_same_bytes(name, tmp_path):
    one, other = build(name, tmp_path / "one"), build(name, tmp_path / "other")

    assert one.name == f"{name}.fmu"
    assert one.read_bytes() == other.read_bytes()


@pytest.mark.full
@pytest.mark.parametrize("name", CATALOGUE)
def test_fmpy_finds_no_problems(name):
    assert validate_fmu(str(built(name))) == []


# the slave is one for all; each component's own is in test_fmu_run.py
@pytest.mark.parametrize("name", full_but(ONE_A_SYSTEM[:1], ONE_A_SYSTEM))
def test_every_check_passes(name):
    findings = check(built(name))

    assert len(findings) == 8
    assert [f for f in findings if not f.ok] == []
    assert [f.name for f in findings if "not offered" in f.detail] == ["evidence"]  # which it was not built with


def test_an_unknown_name_is_answered_with_the_near_one(tmp_path):
    with pytest.raises(BadInput, match="Pantograph"):
        build("Pantgraph", tmp_path)


def test_the_bundle_holds_the_import_closure_and_no_more():
    files = set(sources("railway.pantograph"))

    assert {"__init__.py", "core/__init__.py", "railway/__init__.py", "railway/pantograph.py", "core/integrators.py"} <= files
    assert {"catalogue.py", "railway/catenary.py"} & files == set()


def test_the_date_is_that_of_the_source(tmp_path, monkeypatch):
    monkeypatch.delenv("SOURCE_DATE_EPOCH", raising=False)
    root = description(build("Pantograph", tmp_path))
    assert root.get("generationDateAndTime") == RELEASED
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    assert description(build("Pantograph", tmp_path)).get("generationDateAndTime") == "1970-01-02T00:00:00Z"
    with zipfile.ZipFile(tmp_path / "Pantograph.fmu") as file:
        assert {info.date_time for info in file.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        assert file.namelist() == sorted(file.namelist())


def test_units_carry_their_si_exponents(tmp_path):
    root = description(build("Pantograph", tmp_path, derivatives=True))
    units = {u.get("name"): u.find("BaseUnit").attrib for u in root.find("UnitDefinitions")}

    # N.s/m = kg m s-2 s m-1 = kg s-1; N = kg m s-2: by hand
    assert units["N.s/m"] == {"kg": "1", "s": "-1"}
    assert units["N"] == {"kg": "1", "m": "1", "s": "-2"}
    assert units["m/s/s"] == {"m": "1", "s": "-2"}


def test_variables_of_the_pantograph(tmp_path):
    root = description(build("Pantograph", tmp_path, derivatives=True))
    scalars = list(root.find("ModelVariables"))
    variables = {v.get("name"): v for v in scalars}

    assert [int(v.get("valueReference")) for v in scalars] == list(range(len(scalars)))
    mass = variables["head_mass"]
    assert (mass.get("causality"), mass.get("variability"), mass.get("initial")) == ("parameter", "fixed", "exact")
    assert mass.find("Real").attrib == {"declaredType": "Mass", "unit": "kg", "min": "1e-06", "nominal": "7.2", "start": "7.2"}
    assert variables["speed"].find("Real").get("max") == "200.0"
    assert variables["contact_force"].find("Real").attrib == {"declaredType": "Force", "unit": "N", "nominal": "100.0"}
    assert variables["effects.bump_stops"].find("Boolean").get("start") == "false"
    assert variables["der(wire_height,2)"].find("Real").attrib == {"unit": "m/s/s", "nominal": "1.0", "start": "0.0"}
    assert variables["der(base_excitation.height)"].get("causality") == "input"


def test_outputs_name_the_inputs_they_depend_on(tmp_path):
    root = description(build("Pantograph", tmp_path))
    scalars = list(root.find("ModelVariables"))
    names = {str(i): v.get("name") for i, v in enumerate(scalars, 1)}
    structure = root.find("ModelStructure")
    depends = {names[u.get("index")]: [names[i] for i in u.get("dependencies").split()] for u in structure.find("Outputs")}

    assert [names[u.get("index")] for u in structure.find("InitialUnknowns")] == [*depends]
    own = {name: inputs for name, inputs in depends.items() if "." not in name}  # those of no effect
    assert "wire_height" in own.pop("contact_force")
    assert own == {n: [] for n in ("contact_position", "head_height", "head_velocity", "frame_height")}


def test_outputs_at_the_start_name_what_they_depend_on(tmp_path):
    """Equilibrium on the wire: its height counts for all outputs, the velocity of the base for none; parameters always may."""
    root = description(build("Pantograph", tmp_path))
    scalars = list(root.find("ModelVariables"))
    parameters = {v.get("name") for v in scalars if v.get("causality") == "parameter"}
    for unknown in root.find("ModelStructure/InitialUnknowns"):
        indices = [int(i) for i in unknown.get("dependencies").split()]
        names = {scalars[i - 1].get("name") for i in indices}
        assert indices == sorted(indices)
        assert parameters | {"wire_height", "wire_compliance", "actuator.command", "base_excitation.height"} <= names
        assert "base_excitation.velocity" not in names
    assert validate_fmu(str(tmp_path / "Pantograph.fmu")) == []


def test_who_computes_another_start_declares_its_inputs_anew():
    """Dependencies at the start that are not declared are left out, which means all variables."""

    class Link(component_class("PlanarLink")):
        pass

    class Loaded(Link):
        kernels = Link.kernels._replace(initialize=lambda t, s, p, e: 0)

    assert (Link.start_inputs, Loaded.start_inputs) == ((), None)
    assert initial_dependencies(Link(), {3, 1}, [2]) == {"dependencies": "1 2 3"}
    assert initial_dependencies(Loaded(), {3, 1}, [2]) == {}


def test_kinds_of_variables_and_effects(probe):
    root = description(probe[0])
    scalars = list(root.find("ModelVariables"))
    kinds = {v.get("name"): v[0] for v in scalars}
    names = {str(i): v.get("name") for i, v in enumerate(scalars, 1)}
    depends = {names[u.get("index")]: u.get("dependencies") for u in root.find("ModelStructure/Outputs")}

    assert (kinds["mode"].tag, kinds["mode"].attrib) == ("String", {"start": "plain"})
    assert (kinds["count"].tag, kinds["count"].attrib) == ("Integer", {"min": "1", "max": "9", "start": "3"})
    assert kinds["weights[2]"].get("unit") == "N/m"
    assert names[depends["bias.seen"]] == "bias.tilt"
    assert next(v for v in scalars if v.get("name") == "effects.needy").get("description").endswith("Needs bias.")
    assert validate_fmu(str(probe[0])) == []


def test_the_fmpy_command_alone_simulates(tmp_path):
    command = [sys.executable, "-m", "fmpy", "simulate", str(built("Pantograph")), "--output-file", str(tmp_path / "out.csv")]
    subprocess.run(command, check=True, capture_output=True, cwd=tmp_path)

    lines = (tmp_path / "out.csv").read_text().splitlines()
    assert lines[0].replace('"', "").split(",")[:2] == ["time", "contact_force"]
    assert float(lines[-1].split(",")[0]) == pytest.approx(2.0, abs=1e-9)  # the end time, summed from steps by FMPy


def test_the_stable_copy_is_made_repaired_and_given_up(tmp_path, monkeypatch):
    source = tmp_path / "bundle_0123"
    source.mkdir()
    (source / "__init__.py").write_text("x = 1\n")
    monkeypatch.setenv("COSIMO_CACHE", str(tmp_path / "cache"))

    copy = stable_copy(str(source))
    assert copy.startswith(str(tmp_path / "cache"))
    (tmp_path / "cache" / "bundles" / "bundle_0123" / "__init__.py").write_text("damaged\n")
    assert stable_copy(str(source)) == copy
    assert same_sources(str(source), copy)

    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("COSIMO_CACHE", str(tmp_path / "file"))
    assert stable_copy(str(source)) == str(source)
