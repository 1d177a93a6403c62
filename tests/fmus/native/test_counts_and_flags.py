"""Counts and flags of components are Integer and Boolean in every packaging, discrete, with the values of the component."""

import fmpy
import numpy as np
import pytest
from cosimo import SampledComponent, read_scene
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.variables import Causality, Kind
from cosimo.fmus.build import build
from cosimo.fmus.interface import interface
from cosimo.fmus.native.build import own_target, pack
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene_fmu import build_scene_fmu
from cosimo.tests.fmus.native.support import compiled, maker
from cosimo.tests.fmus.native.test_communication_steps import Host
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

pytestmark = pytest.mark.skipif(not own_target(), reason="this machine is no target of native FMUs")
NAME, EFFECTS, H = "ServoMotor", ("shaft_friction",), 0.01
WORDS = ("number of", "1 while", "1 where", ", -1")  # of outputs without a unit: what is counted or told


def test_what_is_counted_or_told_is_declared_so():
    found = 0
    for name in CATALOGUE:
        cls = component_class(name)
        for variable in cls.variables.values():
            if variable.causality is Causality.OUTPUT:
                told = variable.unit == "1" and "command" not in variable.text and any(word in variable.text for word in WORDS)
                declared = variable.kind is not Kind.REAL
                assert told == declared, (name, variable.name, variable.text)
                found += declared
        for scalar in interface(cls):
            held = issubclass(cls, SampledComponent) or scalar.type != "Real"
            assert (scalar.variability == "discrete") == (scalar.causality == "output" and held), scalar
    assert found >= 14


def values_of(host, names, kind):
    references = [host.references[n] for n in names]
    if host.version == 2:
        return {"Boolean": host.fmu.getBoolean, "Integer": host.fmu.getInteger, "Real": host.fmu.getReal}[kind](references)
    return {"Boolean": host.fmu.getBoolean, "Integer": host.fmu.getInt32, "Real": host.fmu.getFloat64}[kind](references)


def test_a_flag_is_boolean_and_the_same_in_every_packaging(tmp_path):
    component = maker(NAME, EFFECTS)()
    component.initialize(0.0)
    expected = []
    for k in range(12):
        component.set("voltage", 0.3 * k)
        component.step(k * H, H)
        expected.append(bool(component["shaft_friction.stuck"]))
    assert {True, False} == {*expected}
    files = [pack(compiled(NAME, EFFECTS), tmp_path, version) for version in (2, 3)]
    files.append(build(NAME, tmp_path / "python"))
    for path in files:
        assert validate_fmu(str(path)) == []
        described = {v.name: v for v in fmpy.read_model_description(str(path)).modelVariables}["shaft_friction.stuck"]
        assert (described.type, described.variability, described.causality) == ("Boolean", "discrete", "output")
        host, seen = started(path), []
        for k in range(12):
            host.put("voltage", 0.3 * k)
            assert host.step(k * H, H) == 0
            seen += [bool(v) for v in values_of(host, ["shaft_friction.stuck"], "Boolean")]
        assert seen == expected, path
        if path.parent.name != "python":  # where no call but a step can report a failure
            with pytest.raises(FMICallException):
                values_of(host, ["shaft_friction.stuck"], "Integer")
        host.end()


def started(path):
    """An instance in step mode, its effects on where they can be set."""
    host = Host.of(path, before=lambda fmu, references: fmu.setBoolean([references[f"effects.{e}"] for e in EFFECTS], [True])
                   if path.parent.name == "python" else None)  # fmt: skip
    return host


def directions_are_differences(host, output, known, by):
    """The derivative of a real output; of a count there is none."""
    z, v = host.references[output], host.references[known]
    along = host.fmu.getDirectionalDerivative([z], [v], [1.0])[0]
    (at,), values = host.get(known), []
    for sign in (1.0, -1.0):
        host.put(known, at + sign * by)
        values += host.get(output)
    host.put(known, at)
    assert along == pytest.approx((values[0] - values[1]) / (2.0 * by), rel=1e-3)
    assert along != 0.0
    with pytest.raises(FMICallException):
        host.fmu.getDirectionalDerivative([host.references["loaded_balls"]], [v], [1.0])


def test_counts_of_a_bearing_in_python_and_native(tmp_path):
    for path in (pack(compiled("AngularContactConductance"), tmp_path, 2), pack(compiled("AngularContactConductance"), tmp_path, 3),
                 build("AngularContactConductance", tmp_path / "python")):  # fmt: skip
        assert validate_fmu(str(path)) == []
        host = Host.of(path)
        host.put("axial_force", 100.0)
        component = component_class("AngularContactConductance")()
        component.initialize(0.0)
        component.set("axial_force", 100.0)
        component.refresh()
        assert values_of(host, ["loaded_balls"], "Integer") == [round(component["loaded_balls"])]
        assert component["loaded_balls"] >= 1.0
        if path.parent.name != "python":
            directions_are_differences(host, "conductance", "axial_force", 0.5)
        host.end()


SCENE = {
    "stop_time": 0.12,
    "units": {"motor": {"component": NAME, "effects": list(EFFECTS), "parameters": {"voltage": 3.0}}},
    "master": {"step": H},
    "record": {"signals": ["motor.rate", "motor.shaft_friction.stuck"]},
}


def test_flags_of_scenes_and_of_fmus_in_scenes_are_those_of_the_run_in_process(tmp_path):
    shares = {"outputs": {"share": "motor.shaft_friction.stuck, mean", "stuck": "motor.shaft_friction.stuck"}}
    scene = read_scene(SCENE | {"interface": shares})
    reference = run(read_scene(SCENE), in_process=True)
    column = np.asarray(reference["motor.shaft_friction.stuck"])
    for path in build_scene_fmu(scene, tmp_path, [own_target()], (2, 3)):
        assert validate_fmu(str(path)) == []
        described = {v.name: (v.type, v.variability) for v in fmpy.read_model_description(str(path)).modelVariables}
        real = "Real" if path.name.count(".") == 1 else "Float64"
        assert (described["stuck"], described["share"]) == (("Boolean", "discrete"), (real, "continuous"))
        host = Host.of(path)
        for k in range(12):
            assert host.step(k * H, H) == 0
            assert values_of(host, ["stuck"], "Boolean") == [bool(column[k + 1])]
        assert host.get("share") == [pytest.approx(column.mean())]
        host.end()
    file = pack(compiled(NAME, EFFECTS), tmp_path, 2)
    units = {"motor": {"fmu": str(file), "parameters": {"voltage": 3.0}}}
    of_file = run(read_scene(SCENE | {"units": units}))
    of_packaging = run(read_scene(SCENE))
    for other in (of_file, of_packaging):
        assert list(other.columns) == list(reference.columns)
        for name, values in reference.columns.items():
            assert np.asarray(other[name]).tobytes() == np.asarray(values).tobytes(), name
