"""The files and the runtime of native FMUs: conforming, reproducible, without Python, and no misuse without a message."""

import re
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree as ET

import fmpy
import pytest
from cosimo.components.catalogue import component_class
from cosimo.fmus.interface import interface
from cosimo.fmus.native import build
from cosimo.fmus.native.build import library, own_target, pack
from cosimo.tests.fmus.native.support import by_type, compiled, maker, opened, read
from cosimo.tests.fmus.native.test_communication_steps import Host
from fmpy import simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

HEADERS = Path(fmpy.__file__).parent / "c-code"
NAME = "ServoMotor"
pytestmark = pytest.mark.skipif(own_target() != "linux64", reason="runs on Linux")


@pytest.fixture
def motor(tmp_path):
    """An instance (FMI 2) and its value references."""
    fmu, references = opened(compiled(NAME), tmp_path)
    yield fmu, references
    fmu.freeInstance()


def in_step_mode(fmu):
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("name", [NAME, *(pytest.param(n, marks=pytest.mark.full) for n in ("RovHull", "FourBar"))])
def test_fmpy_finds_no_problems_and_simulates(name, version, tmp_path):
    path = pack(compiled(name), tmp_path, version)
    assert validate_fmu(str(path)) == []
    rows = simulate_fmu(str(path), stop_time=0.1, step_size=0.004, output_interval=0.004)
    assert (len(rows), rows["time"][-1]) == (26, pytest.approx(0.1))


def test_two_builds_are_the_same_bytes(tmp_path, linked_anew):
    found = [library("WaterCurrent", maker("WaterCurrent", ["tide"]), [own_target()]) for _ in range(2)]
    assert len(linked_anew) == 2
    for version in (2, 3):
        first, second = (pack(f, tmp_path / str(k), version).read_bytes() for k, f in enumerate(found))
        assert first == second


def test_what_has_been_linked_is_linked_no_more(monkeypatch):
    found = compiled(NAME)
    monkeypatch.setattr(build, "_linked", lambda *_: pytest.fail("linked once more"))
    assert library(NAME, maker(NAME), [own_target()]).binaries == found.binaries
    monkeypatch.setattr(build, "FLAGS", (*build.FLAGS, "-g"))
    with pytest.raises(pytest.fail.Exception, match="linked once more"):
        library(NAME, maker(NAME), [own_target()])


def test_variables_are_those_of_the_pythonfmu_fmu(tmp_path):
    found = compiled(NAME)
    with zipfile.ZipFile(pack(found, tmp_path, 2)) as file:
        root = ET.fromstring(file.read("modelDescription.xml"))
    scalars = interface(component_class(NAME))
    seen = {v.get("name"): v for v in root.iter("ScalarVariable")}
    off = {f"{e}." for e in component_class(NAME).effects}
    assert set(seen) == {s.name for s in scalars if not s.name.removeprefix("der(").startswith(tuple(off))}
    constants = {v.scalar.name for v in found.variables if v.role == "CONSTANT"}
    assert constants == {s.name for s in scalars if s.name.startswith("effects.")}
    assert {"resistance", "substep", "rotor_inertia", "start_angle"} <= {
        v.scalar.name for v in found.variables if v.role == "PARAMETER"
    }
    for reference, scalar in enumerate(scalars):
        if scalar.name in seen:
            variable = seen[scalar.name]
            assert int(variable.get("valueReference")) == reference
            constant = scalar.name in constants
            assert variable.get("causality") == ("local" if constant else scalar.causality)
            assert (variable.get("variability") == "constant") == constant
            assert ("fixed at build" in variable.get("description")) == constant
            assert variable[0].get("unit") == (scalar.unit if scalar.type == "Real" else None)


@pytest.mark.full
def test_a_constant_has_the_value_of_the_build_and_keeps_it(tmp_path):
    found = library("BeamRotor", maker("BeamRotor", (), {"element": 0.25}), [own_target()])
    fmu, references = opened(found, tmp_path)
    fmu.setupExperiment(startTime=0.0)
    with pytest.raises(FMICallException):
        fmu.setReal([references["element"]], [0.2])
    fmu.enterInitializationMode()
    assert fmu.getReal([references["element"]]) == [0.25]
    fmu.exitInitializationMode()
    fmu.freeInstance()


@pytest.mark.full
def test_arrays_are_arrays_in_fmi_3(tmp_path):
    with zipfile.ZipFile(pack(compiled("LigamentBundle"), tmp_path, 3)) as file:
        root = ET.fromstring(file.read("modelDescription.xml"))
    tension = next(v for v in root.iter("Float64") if v.get("name") == "tension")
    scalars = [v for v in component_class("LigamentBundle").variables if v.startswith("tension[")]
    assert tension.find("Dimension").get("start") == str(len(scalars)) != "1"


def test_outputs_at_the_start_depend_on_their_inputs_parameters_and_the_time(tmp_path):
    with zipfile.ZipFile(pack(compiled("CompliantJoint"), tmp_path, 3)) as file:
        root = ET.fromstring(file.read("modelDescription.xml"))
    variables = {v.get("valueReference"): v for v in root.find("ModelVariables")}
    force = next(r for r, v in variables.items() if v.get("name") == "first_force_x")
    unknown = next(u for u in root.iter("InitialUnknown") if u.get("valueReference") == force)
    found = [variables[r] for r in unknown.get("dependencies").split()]
    parameters = [v for v in variables.values() if v.get("causality") == "parameter"]
    assert parameters
    assert all(v in found for v in parameters)
    assert sorted(v.get("name") for v in found if v not in parameters) == [
        "first_velocity_x",
        "first_x",
        "first_y",
        "second_velocity_x",
        "second_x",
        "second_y",
        "time",
    ]  # not velocities along y


def test_library_needs_only_libc_and_libm_and_exports_the_whole_standard(tmp_path):
    path = tmp_path / "unit.so"
    path.write_bytes(compiled(NAME).binaries["linux64"])
    assert path.stat().st_size < 1_000_000
    symbols = subprocess.run(["nm", "-D", path], capture_output=True, text=True, check=True).stdout
    needed = subprocess.run(["objdump", "-p", path], capture_output=True, text=True, check=True).stdout
    assert set(re.findall(r"NEEDED +(\S+)", needed)) <= {"libc.so.6", "libm.so.6"}
    assert not re.search(r"\b(_?Py|NRT_|numba)", symbols)
    exported = set(re.findall(r" T (\w+)", symbols))
    headers = {v: (HEADERS / f"fmi{v}FunctionTypes.h").read_text() for v in (2, 3)}
    declared = {f"fmi{v}{name}" for v, text in headers.items() for name in re.findall(rf"fmi{v}(\w+)TYPE\b", text)}
    assert exported == declared


@pytest.mark.parametrize("call", [
    lambda fmu, r: fmu.doStep(0.0, -1e-3),
    lambda fmu, r: fmu.doStep(0.0, float("nan")),
    lambda fmu, r: fmu.doStep(0.0, 0.0),
    lambda fmu, r: fmu.doStep(0.5, 1e-3),
    lambda fmu, r: fmu.setReal([r["voltage"]], [float("nan")]),
    lambda fmu, r: fmu.setReal([r["rate"]], [0.0]),
    lambda fmu, r: fmu.setReal([99999], [0.0]),
    lambda fmu, r: fmu.getReal([99999]),
    lambda fmu, r: fmu.getInteger([r["voltage"]]),
    lambda fmu, r: fmu.enterInitializationMode(),
    lambda fmu, r: fmu.exitInitializationMode(),
    lambda fmu, r: fmu.getRealOutputDerivatives([r["rate"]], [1]),
])  # fmt: skip
def test_misuse_is_an_error_that_changes_nothing(motor, call, capfd):
    fmu, references = motor
    in_step_mode(fmu)
    fmu.setReal([references["voltage"]], [6.0])
    fmu.getReal([references["rate"]])  # computes the outputs that belong to it
    before = fmu.serializeFMUstate(fmu.getFMUstate())
    with pytest.raises(FMICallException) as caught:
        call(fmu, references)
    assert caught.value.status == 3
    assert fmu.serializeFMUstate(fmu.getFMUstate()) == before
    fmu.doStep(0.0, 1e-3)


def test_values_and_steps_wait_for_their_mode(motor):
    fmu, references = motor
    calls = (lambda: fmu.doStep(0.0, 1e-3), lambda: fmu.getReal([references["rate"]]), fmu.terminate, fmu.exitInitializationMode)
    for call in calls:
        with pytest.raises(FMICallException):
            call()
    in_step_mode(fmu)
    fmu.doStep(0.0, 1e-3)
    fmu.reset()
    in_step_mode(fmu)
    assert fmu.getReal([references["rate"]]) == [0.0]


def test_a_state_of_another_fmu_is_refused(motor, tmp_path):
    fmu, _ = motor
    in_step_mode(fmu)
    bytes_ = fmu.serializeFMUstate(fmu.getFMUstate())
    other, _ = opened(compiled("CompliantJoint"), tmp_path)
    for content in (bytes_, bytes_[:-1], b""):
        with pytest.raises(FMICallException):
            other.deSerializeFMUstate(content)
    changed = bytearray(bytes_)
    changed[len(changed) // 2] ^= 1
    with pytest.raises(FMICallException):
        fmu.deSerializeFMUstate(bytes(changed))
    other.freeInstance()


def test_a_wrong_guid_gives_no_instance(tmp_path):
    with pytest.raises(Exception, match="nstantiate"):
        opened(compiled(NAME), tmp_path, guid="{00000000-0000-0000-0000-000000000000}")


def test_directional_derivatives_of_a_spring_are_its_constants(tmp_path):
    found = compiled("CompliantJoint")
    fmu, references = opened(found, tmp_path)
    in_step_mode(fmu)
    stiffness, damping = fmu.getReal([references["stiffness"], references["damping"]])
    outputs = [references["first_force_x"], references["second_force_x"], references["first_force_y"]]
    inputs = [references["second_x"], references["second_velocity_x"]]
    state = fmu.serializeFMUstate(fmu.getFMUstate())
    along = fmu.getDirectionalDerivative(outputs, inputs, [1e-3, 2.0])
    assert along == pytest.approx([1e-3 * stiffness + 2.0 * damping, -1e-3 * stiffness - 2.0 * damping, 0.0], rel=1e-15)
    assert fmu.serializeFMUstate(fmu.getFMUstate()) == state
    fmu.freeInstance()


@pytest.mark.full
@pytest.mark.parametrize("version", [2, 3])
def test_the_rocker_s_rate_is_its_angle_s_derivative_along_the_crank_s_rate(version, tmp_path):
    host = Host.of(pack(compiled("FourBar"), tmp_path, version))
    for angle in (0.7, 1.5, 2.6):
        host.put("input_angle", angle)
        host.put("input_rate", 3.0)
        along = host.fmu.getDirectionalDerivative([host.references["output_angle"]], [host.references["input_angle"]], [3.0])
        assert along == pytest.approx(host.get("output_rate"), rel=1e-14)
    host.fmu.terminate()
    host.fmu.freeInstance()


@pytest.mark.full
def test_the_initial_state_is_that_of_the_inputs_at_the_start(tmp_path):
    bearing = component_class("BallBearing")()  # statics that iterate
    fmu, references = opened(compiled("BallBearing"), tmp_path)
    fmu.setupExperiment(startTime=0.25)
    fmu.enterInitializationMode()
    load = fmu.getReal([references["load"]])[0]
    outputs = by_type(compiled("BallBearing"), bearing.outputs)
    for change in (12.0, 1e-7 * load, -0.5 * load):
        fmu.setReal([references["load"]], [load + change])
        bearing.set("load", load + change)
        bearing.initialize(0.25)
        assert read(fmu, outputs, references, 2).tolist() == bearing.y.tolist()
    fmu.exitInitializationMode()
    fmu.freeInstance()


LIFE = """
import resource, sys
from fmpy.fmi2 import FMU2Slave
fmu = FMU2Slave(guid=sys.argv[1], unzipDirectory=sys.argv[2], instanceName="unit", modelIdentifier=sys.argv[3])
def life():
    fmu.instantiate(); fmu.setupExperiment(startTime=0.0); fmu.enterInitializationMode(); fmu.exitInitializationMode()
    fmu.doStep(0.0, 1e-3); state = fmu.getFMUstate(); fmu.setFMUstate(state); fmu.freeFMUstate(state); fmu.terminate()
    fmu.fmi2FreeInstance(fmu.component)
for k in range(200): life()
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
for k in range(2000): life()
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


def test_two_thousand_lives_leave_memory_flat(tmp_path):
    found = compiled(NAME)
    folder = fmpy.extract(str(pack(found, tmp_path, 2)))
    done = subprocess.run([sys.executable, "-c", LIFE, found.token, folder, NAME], capture_output=True, text=True, check=True)
    assert int(done.stdout) * 1024 < 2000 * 64  # fewer than 64 bytes a life; an instance has a thousand
