"""Parameters and start values that an instance of a native FMU can be given: the bits of the component in process with them."""

import numpy as np
import pytest
from cosimo.components.catalogue import component_class
from cosimo.fmus.native.build import own_target
from cosimo.tests.fmus.native.support import compiled, in_process, maker, native, opened
from cosimo.tests.short_run import ONE_A_SYSTEM, full_but
from fmpy.fmi1 import FMICallException

pytestmark = pytest.mark.skipif(own_target() != "linux64", reason="runs on Linux")
SHIFT = 0.07  # relative, and of the nominal value
QUICK = ("PlanarLink", "RovHull")  # with a start entry, and with start values that are written into the state
SOME = full_but(QUICK[:1], dict.fromkeys((*QUICK, *ONE_A_SYSTEM)))


def other_values(found):
    """Another value, within the limits, for each parameter that can be set and for each input whose start value is free."""
    variables, values = type(found.component).variables, {}
    for variable in found.variables:
        name, start = variable.scalar.name, variable.scalar.start
        if variable.role == "PARAMETER" or (variable.role == "INPUT" and not variable.bound):
            shift = (SHIFT if variable.role == "PARAMETER" else 1e-3 * SHIFT) * (abs(start) or variables[name].nominal)
            values[name] = start + shift if start + shift <= variables[name].high else start - shift
    return values


@pytest.mark.parametrize("name", SOME)
def test_values_that_are_set_give_the_bits_of_the_component_with_them(name, tmp_path):
    found = compiled(name)
    values = other_values(found)
    h = component_class(name).default_step
    expected = in_process(maker(name, (), values)(), h, 200)
    assert np.isfinite(expected).all()
    np.testing.assert_array_equal(native(found, tmp_path, h, 200, values=values), expected)
    np.testing.assert_array_equal(native(found, tmp_path, h, 200, values=values, restored_at=57), expected)


def test_what_can_be_set_are_the_parameters_that_nothing_else_follows_from():
    found = compiled("PlanarLink")
    roles = {v.scalar.name: v.role for v in found.variables}
    assert {roles[n] for n in ("mass", "length", "start_angle", "start_rate", "start_x", "start_velocity_y")} == {"PARAMETER"}
    assert not any(v.bound for v in found.variables)


def test_a_parameter_is_set_before_the_run_within_its_limits_and_stays_over_a_reset_of_the_state(tmp_path):
    fmu, references = opened(compiled("PlanarLink"), tmp_path)
    mass, angle = references["mass"], references["start_angle"]
    fmu.setReal([mass], [3.0])
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    for value in (-1.0, float("nan"), float("inf")):
        with pytest.raises(FMICallException):
            fmu.setReal([mass], [value])
    fmu.setReal([angle], [0.25])
    assert fmu.getReal([mass, angle, references["angle"]]) == [3.0, 0.25, 0.25]
    state = fmu.getFMUstate()
    fmu.exitInitializationMode()
    with pytest.raises(FMICallException):
        fmu.setReal([mass], [4.0])
    other, _ = opened(compiled("PlanarLink"), tmp_path)
    other.setFMUstate(other.deSerializeFMUstate(fmu.serializeFMUstate(state)))
    assert other.getReal([mass, references["angle"]]) == [3.0, 0.25]
    other.reset()
    other.setupExperiment(startTime=0.0)
    other.enterInitializationMode()
    assert other.getReal([mass, angle]) == [1.0, 0.0]
    for instance in (fmu, other):
        instance.freeInstance()
