"""Parameters that may change during a run: the change acts from the next step on, and is the same as having had the value all along."""

import fmpy
import numpy as np
import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.variables import Causality, Kind
from cosimo.fmus.build import build
from cosimo.fmus.native.build import own_target, pack
from cosimo.orchestrator.scene_fmu import build_scene_fmu
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.fmus.driver import run_script
from cosimo.tests.fmus.native.support import amplitudes, compiled, driven
from cosimo.tests.fmus.native.test_communication_steps import Host
from cosimo.tests.short_run import full_but
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

TUNED, SHIFT, STEPS = 5, 0.07, 25
# component -> what its inputs and parameters need to be for every law in it to act
PREPARED = {
    "ServoController": {"feed_integral_gain": 5.0, "rotation_integral_gain": 5.0},
    "GimbalController": {},
    "RovController": {},
    "WaterCurrent": {},
    "FrictionWheels": {},
    "FrictionDrive": {},
    "Pantograph": {},
}
QUIET = {  # parameters that act only where a limit is reached
    "ServoController": {"rate_limit", "voltage_limit", "unwinding_time"},
    "GimbalController": {"voltage_limit", "unwinding_time"},
    "RovController": {"unwinding_time"},
}


def test_every_tunable_parameter_is_in_this_table():
    tunable = {name for name in CATALOGUE for v in component_class(name).variables.values() if v.tunable}
    assert tunable == {*PREPARED}
    for name in CATALOGUE:
        for variable in component_class(name).variables.values():
            real = variable.causality is Causality.PARAMETER and variable.kind is Kind.REAL and not variable.structural
            assert real or not variable.tunable, (name, variable.name)


def outputs_of(component, start, moved, h, steps):
    rows = []
    for k in steps:
        component.u[0], component.u[1], curves = driven(component, start, moved, k, h)
        component.u[2] = 0.5 * np.array(curves)
        component.step(k * h, h)
        rows.append(component.y.copy())
    return np.array(rows)


def acting(name, effects, given):
    """The tunable parameters whose change acts; each of them acts as if the component had had the value all along.

    From the state at the change on: nothing that initialization has computed follows from the parameter.
    """
    cls = component_class(name)
    h = cls.default_step
    base = cls(effects, given)
    base.initialize(0.0)
    start = base.u[0].copy()
    moved = amplitudes(base, start, 0.05)
    outputs_of(base, start, moved, h, range(TUNED))
    state, found = base.save(), set()
    untouched = outputs_of(base, start, moved, h, range(TUNED, STEPS))
    for variable in (v for whole in cls.own_variables if whole.tunable for v in whole.scalars if v.name in base.parameters):
        value = given.get(variable.name, variable.start)
        value += SHIFT * (abs(value) or variable.nominal)
        other, tuned = cls(effects, {**given, variable.name: value}), cls(effects, given)
        for each in (other, tuned):
            each.initialize(0.0)
            each.restore(state)
        tuned.set(variable.name, value)
        expected = outputs_of(other, start, moved, h, range(TUNED, STEPS))
        assert outputs_of(tuned, start, moved, h, range(TUNED, STEPS)).tobytes() == expected.tobytes(), (effects, variable.name)
        if expected.tobytes() != untouched.tobytes():
            found.add(variable.name.partition("[")[0])
    return found


@pytest.mark.parametrize("name", full_but(["GimbalController", "WaterCurrent"], PREPARED))
def test_a_change_is_the_same_as_having_had_the_value_all_along(name):
    tunable = {v.name for v in component_class(name).own_variables if v.tunable}
    assert acting(name, (), PREPARED[name]) >= tunable - QUIET.get(name, set())


EFFECTS = """
from cosimo.components.catalogue import component_class
from cosimo.components.core.errors import BadInput
from cosimo.tests.fmus.native.test_tunable_parameters import PREPARED, acting

for name in PREPARED:
    for effect, declared in component_class(name).effects.items():
        try:
            acting(name, (*declared.requires, effect), PREPARED[name])
        except BadInput:
            continue  # an effect that needs a table, or another preset
        print(name, effect)
"""


@pytest.mark.full
def test_the_same_with_each_effect():
    """In plain Python: each effect is a layout of its own to compile."""
    assert len(run_script(EFFECTS, NUMBA_DISABLE_JIT="1")) >= 35


@pytest.mark.skipif(not own_target(), reason="this machine is no target of native FMUs")
def test_a_tunable_parameter_is_taken_during_the_run_and_a_fixed_one_refused(tmp_path):
    """In every packaging, and within a scene; a state carries the value along."""
    unit = {"component": "WaterCurrent"}
    scene = read_scene(
        {"stop_time": 1.0, "units": {"sea": unit}, "master": {"step": 0.1}, "record": {"signals": ["sea.velocity_down"]}}
    )
    files = [(pack(compiled("WaterCurrent"), tmp_path, version), "") for version in (2, 3)]
    files += [
        (build("WaterCurrent", tmp_path / "python"), ""),
        *((p, "sea.") for p in build_scene_fmu(scene, tmp_path, [own_target()], (2, 3))),
    ]
    for path, prefix in files:
        assert validate_fmu(str(path)) == []
        described = {v.name: v for v in fmpy.read_model_description(str(path)).modelVariables}
        assert described[f"{prefix}downwelling"].variability == "tunable"
        fixed = [n for n, v in described.items() if v.variability == "fixed" and v.type in ("Real", "Float64")]
        host = Host.of(path)
        assert host.step(0.0, 0.1) == 0
        assert host.get(f"{prefix}velocity_down") == [0.0]
        state = host.save()
        host.put(f"{prefix}downwelling", 0.7)
        assert host.step(0.1, 0.1) == 0
        assert host.get(f"{prefix}velocity_down", f"{prefix}downwelling") == [pytest.approx(0.7), 0.7]
        later = host.save()
        host.restore(state)
        assert host.step(0.1, 0.1) == 0
        assert host.get(f"{prefix}velocity_down", f"{prefix}downwelling") == [0.0, 0.0]
        host.restore(later)
        assert host.step(0.2, 0.1) == 0
        assert host.get(f"{prefix}velocity_down") == [pytest.approx(0.7)]
        for name in fixed[:1]:
            before = host.get(name)
            if path.parent.name == "python":  # where no call but a step can report a failure
                host.put(name, before[0] + 1.0)
            else:
                with pytest.raises(FMICallException):
                    host.put(name, before[0] + 1.0)
            assert host.get(name) == before
        host.end()
