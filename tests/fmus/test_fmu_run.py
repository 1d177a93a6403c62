"""An FMU is its component: bit-identical, for any effects, with polynomial inputs, with inputs set between steps."""

import math

import numpy as np
import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.fmus.build import built
from cosimo.tests.contract.configurations import compatible, in_plain_python, small
from cosimo.tests.fmus.driver import OK, Driven
from cosimo.tests.short_run import full_but

STEP = 1e-3  # s
STEPS = 25
SUBSTEP = 2.5e-4  # s, small enough for every effect

# smooth inputs, by the last part of their name, where a swing about the start value is not enough: value and derivatives at t
INPUTS = {
    "wire_height": lambda t: (0.01 * math.sin(9 * t), 0.09 * math.cos(9 * t), -0.81 * math.sin(9 * t)),
    "wire_compliance": lambda t: (1e-6 * (1 + t), 1e-6, 0.0),
    "height": lambda t: (0.002 * math.sin(30 * t), 0.06 * math.cos(30 * t), -1.8 * math.sin(30 * t)),
    "velocity": lambda t: (0.06 * math.cos(30 * t), -1.8 * math.sin(30 * t), -54 * math.cos(30 * t)),
    "contact_position": lambda t: (150.0 + 60.0 * t + t * t, 60.0 + 2 * t, 2.0),
    "contact_force": lambda t: (120.0 + 20.0 * math.sin(12 * t), 240.0 * math.cos(12 * t), -2880.0 * math.sin(12 * t)),
}


def smooth(component, t):
    return {n: INPUTS.get(n.rpartition(".")[2], swing(component.variables[n]))(t) for n in component.inputs}


def swing(variable):
    a = 0.1 * variable.nominal
    return lambda t: (variable.start + a * math.sin(9 * t), 9 * a * math.cos(9 * t), -81 * a * math.sin(9 * t))


@pytest.mark.parametrize("wanted", [True, False], ids=["all effects", "none"])
@pytest.mark.parametrize("name", in_plain_python(full_but((), CATALOGUE)))
@pytest.mark.uncompiled
def test_the_fmu_is_the_component_to_the_last_bit(name, wanted):
    effects = compatible(component_class(name)) if wanted else ()
    # a variant that knows all effects, with few elements
    chosen = {n: v for n, v in small(name, effects).items() if isinstance(v, str) or n == "element"}
    component = component_class(name)(effects, chosen)
    unit = Driven(built(name))
    start = chosen | {n: min(SUBSTEP, component[n]) for n in component.parameters if n == "substep" and not component.unused([n])}
    start |= {n: v for n, (v, _, _) in smooth(component, 0.0).items()}
    for n, v in start.items():
        component.set(n, v)
    component.initialize(0.0)
    unit.start({f"effects.{n}": True for n in effects} | start)

    for k in range(STEPS):
        t = k * STEP
        for i, (n, (value, slope, second)) in enumerate(smooth(component, t).items()):
            component.u[:, i] = value, slope, 0.5 * second
            unit.set({n: value, f"der({n})": slope, f"der({n},2)": second})
        component.step(t, STEP)
        assert unit.step(t, STEP) == OK, unit.log
        assert np.array([unit[n] for n in component.outputs], dtype=float).tobytes() == component.y.tobytes()
        assert np.isfinite(component.y).all()
    unit.free()


@pytest.mark.parametrize("name", in_plain_python(full_but((), CATALOGUE)))
@pytest.mark.uncompiled
def test_what_is_off_reads_its_start_value_and_takes_writes(name):
    component = component_class(name)()
    off = {n: v for n, v in component_class(name).variables.items() if not component.is_active(n)}
    unit = Driven(built(name)).start({n: v for n, (v, _, _) in smooth(component, 0.0).items()})

    for n, variable in off.items():
        read = unit[n]
        assert (read.decode() if isinstance(read, bytes) else read) == variable.start
        if variable.causality.value == "input":
            unit.set({n: 3.0})
            assert unit[n] == 3.0
    assert unit.step(0.0, STEP) == OK
    unit.free()


def test_an_input_set_between_steps_is_seen_at_once(new_probe):
    unit = new_probe().start({"signal": 1.0})
    assert unit.step(0.0, 0.1) == OK

    unit.set({"signal": 3.0})
    assert unit["level"] == 2.0 * 1.5 * 3.0  # gain * weight * signal
    assert unit["total"] == pytest.approx(0.1, abs=1e-15)  # one rounding; the state has not moved


def test_derivatives_hold_for_one_step_only(new_probe):
    unit = new_probe().start({"signal": 1.0})
    unit.set({"der(signal)": 2.0, "der(signal,2)": 4.0})
    assert unit.reals(["der(signal)", "der(signal,2)"]) == [2.0, 4.0]

    unit.step(0.0, 0.5)
    # integral of 1 + 2 s + 2 s² over half a unit: 0.5 + 0.25 + 1/12; then the end value 1 + 1 + 0.5
    assert unit["total"] == pytest.approx(0.5 + 0.25 + 1.0 / 12.0, abs=1e-15)
    assert unit.reals(["signal", "der(signal)", "der(signal,2)"]) == [2.5, 0.0, 0.0]


def test_a_slope_given_before_the_run_holds_for_the_first_step(new_probe):
    unit = new_probe().start({"signal": 1.0, "der(signal)": 2.0})
    unit.step(0.0, 1.0)

    assert unit["total"] == 2.0  # integral of 1 + 2 s


def test_outputs_are_consistent_in_initialization_mode(new_probe):
    unit = new_probe()
    unit.fmu.setupExperiment(startTime=0.0)
    unit.fmu.enterInitializationMode()
    for signal, gain in ((1.0, 2.0), (2.0, 2.0), (2.0, 5.0)):
        unit.set({"signal": signal, "gain": gain})
        assert unit["level"] == gain * 1.5 * signal
    unit.set({"effects.bias": True, "bias.tilt": 0.25})
    assert unit["level"] == 5.0 * 1.5 * 2.0 + 4.0
    assert unit["bias.seen"] == 0.25
    unit.fmu.exitInitializationMode()
    assert unit["level"] == 5.0 * 1.5 * 2.0 + 4.0


def test_parameters_of_all_kinds(new_probe):
    unit = new_probe()
    unit.set({"mode": "negative", "count": 5, "weights[1]": 3.0, "effects.bias": True, "bias.value": -1.0, "signal": 2.0})
    unit.start()

    assert unit["level"] == -2.0 * 3.0 * 2.0 - 1.0
    assert (unit["mode"], unit["count"], unit["effects.bias"], unit["effects.needy"]) == (b"negative", 5, 1, 0)


def test_the_start_time_reaches_the_component():
    unit = Driven(built("Pantograph")).start({"speed": 10.0, "start_position": 5.0}, at=2.0)

    assert unit["contact_position"] == 25.0  # start position + speed * time
    unit.free()
