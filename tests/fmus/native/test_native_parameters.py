"""Parameters and start values that an instance of a native FMU can be given: the bits of the component in process with them."""

import numpy as np
import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.errors import BadInput
from cosimo.components.core.variables import Causality, Kind
from cosimo.fmus.native.build import own_target, pack
from cosimo.tests.fmus.driver import Driven
from cosimo.tests.fmus.native.support import compiled, in_process, maker, native, opened
from cosimo.tests.short_run import ONE_A_SYSTEM, full_but
from fmpy.fmi1 import FMICallException

pytestmark = pytest.mark.skipif(own_target() != "linux64", reason="runs on Linux")
SHIFT = 0.07  # relative, and of the nominal value
QUICK = ("PlanarLink", "RovHull")  # with a start entry, and with start values that are written into the state
SOME = full_but(QUICK[:1], dict.fromkeys((*QUICK, *ONE_A_SYSTEM)))


def other_values(found):
    """Another value, within the limits, for each parameter that can be set but the substep, and for each input."""
    variables, values = type(found.component).variables, {}
    for variable in found.variables:
        name, start = variable.scalar.name, variable.scalar.start
        if variable.role in ("PARAMETER", "INPUT") and name != "substep":
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


# what a user of these components turns first, and a value that they refuse together with the words of the refusal
TURNED = [
    ("BallBearing", ("clearance",), {"clearance.radial_clearance": 31e-6, "contact_stiffness": 7e9}, {"substep": 0.9}, "substep"),
    ("Pantograph", (), {"static_force": 82.5, "head_mass": 6.3}, {"substep": 0.9}, "substep"),
    ("Catenary", ("dropper_slackening",), {"contact_wire_tension": 18e3, "messenger_mass": 1.2}, {"substep": 0.09}, "substep"),
    ("PlanarLink", ("pinned", "gravity"), {"mass": 2.5, "length": 1.25}, {"substep": 0.9}, "substep"),
]


@pytest.mark.parametrize(("name", "effects", "values", "refused", "words"), full_but(TURNED[-1:], TURNED))
def test_what_follows_from_a_parameter_is_computed_where_it_is_set(name, effects, values, refused, words, tmp_path):
    found = compiled(name, effects)
    h = component_class(name).default_step
    expected = in_process(maker(name, effects, values)(), h, 50)
    assert not np.array_equal(expected, in_process(maker(name, effects)(), h, 50))
    np.testing.assert_array_equal(native(found, tmp_path, h, 50, values=values), expected)
    with pytest.raises(BadInput, match=words) as caught:
        maker(name, effects, refused)().initialize(0.0)
    unit = Driven(pack(found, tmp_path, 2))
    with pytest.raises(FMICallException):
        unit.start(refused)
    assert str(caught.value).partition(": ")[2] in unit.log[-1][1]
    unit.fmu.freeInstance()


def test_parameters_are_structural_for_a_reason_and_few_are():
    """Of the real ones 19 in 20 at least can be set in every native FMU."""
    of_all = [
        v
        for name in CATALOGUE
        for v in component_class(name).variables.values()
        if v.causality is Causality.PARAMETER and v.kind is Kind.REAL
    ]
    structural = [v.name for v in of_all if v.structural]
    assert len(structural) <= 0.05 * len(of_all), structural
    assert all(len(v.structural) > 10 for v in of_all if v.structural)


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
