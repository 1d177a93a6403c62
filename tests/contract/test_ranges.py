"""A run that leaves the range of a model says which input did it, its value, and the range."""

import numpy as np
import pytest
from cosimo import Component, StepFailed, component_class
from cosimo.tests.contract.configurations import in_plain_python

SHORT_LINE = {"spans": 2, "element": 2.0, "substep": 1e-4}
LEFT = [
    ("AveragedConverter", (), {}, "turbine_speed", 60.0, "turbine_speed = 60 rad/s, expected within -50 and 50 rad/s"),
    ("PlanetaryTransmission", ("centrifugal_brake",), {}, "turbine_speed", 600.0, "within -50 and 50 rad/s"),
    ("InertialConverter", (), {}, "turbine_speed", 600.0, "turbine_speed = 600 rad/s turns the crank at"),
    ("Catenary", (), SHORT_LINE, "contact_position", -5.0, "contact_position = -5 m moving at 0 m/s, expected from"),
    ("DeepGrooveBearing", (), {}, "displacement_x", 1e-3, "displacement_x = 0.001 m"),
    ("BearingTemperatures", (), {}, "friction_power", -500.0, "friction_power = -500 W"),
]


def steps(component: Component, h: float, count: int, states: list[np.ndarray] | None = None) -> None:
    """Steps of h until one fails; the temperatures before each go into `states`."""
    for k in range(count):
        if states is not None:
            states.append(component.x[:-2].copy())
        component.step(k * h, h)


@pytest.mark.parametrize(("name", "effects", "parameters", "signal", "value", "text"), in_plain_python(LEFT))
@pytest.mark.uncompiled
def test_an_input_that_leaves_the_range_is_named_with_its_value_and_the_range(name, effects, parameters, signal, value, text):
    component = component_class(name)(effects, parameters)
    component.initialize(0.0)
    component.set(signal, value)
    with pytest.raises(StepFailed, match="an input left the range of the model: ") as failure:
        steps(component, 100.0 if name == "BearingTemperatures" else 1e-3, 200)
    assert text in str(failure.value)


@pytest.mark.parametrize("effects", in_plain_python([(), ("housing",), ("radiation",), ("oil_flow", "shaft_heat")]))
@pytest.mark.uncompiled
def test_no_temperature_falls_below_zero_kelvin(effects):
    """Heat taken away for ever ends a run; until then every temperature is above zero."""
    component = component_class("BearingTemperatures")(effects)
    component.set("friction_power", -2000.0)
    component.initialize(0.0)
    states: list[np.ndarray] = []
    with pytest.raises(StepFailed, match="expected 0 K or more"):
        steps(component, 10.0, 10_000, states)
    assert (np.array(states) > 0.0).all()


@pytest.mark.parametrize(
    ("name", "inputs"), in_plain_python([("ServoMotor", ("voltage",)), ("FrictionDrive", ("first_voltage", "second_voltage"))])
)
@pytest.mark.uncompiled
def test_a_winding_with_inductance_starts_without_current_unless_one_is_given(name, inputs):
    for given, expected in (({}, 0.0), ({"inductance.start_current": 1.5}, 1.5)):
        motor = component_class(name)(("inductance",), given)
        for signal in inputs:
            motor.set(signal, 12.0)
        motor.initialize(0.0)
        currents = [motor[n] for n in motor.outputs if n.endswith("current")]
        np.testing.assert_array_equal(currents, expected)
