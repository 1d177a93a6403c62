"""What every configuration of every component keeps: initialization, steps, saved states, outputs, counters."""

import math

import numpy as np
import pytest
from cosimo import BadInput, Component, OdeComponent
from cosimo.components.core.errors import StepFailed
from cosimo.components.core.high_order import STAGES
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.contract.configurations import CONFIGURATIONS, EVERYTHING_ON, bits, excite, slope_inputs, span
from cosimo.tests.short_run import ONE_A_SYSTEM

# Machine code of all components takes the compiler minutes: here one a system without effects, which others compile, too; all of
# them against plain Python in test_processes.py. Plain Python with nothing and with everything on is in every run.
pytestmark = [pytest.mark.full] if COMPILED else []
EPSILON = np.finfo(float).eps
MACHINE_CODE = [c for c in CONFIGURATIONS if c.effects == () and c.component in ONE_A_SYSTEM]


def over(cases):
    """In every run nothing and everything on, in the complete one all; compiled: nothing on, one a system."""
    return pytest.mark.parametrize(
        "configuration",
        [
            pytest.param(c, id=c.label, marks=() if COMPILED or c.effects == () or c in EVERYTHING_ON else pytest.mark.full)
            for c in cases
            if c in MACHINE_CODE or not COMPILED
        ],
    )


configurations = over(CONFIGURATIONS)


def started(configuration, steps=3):
    """An instance that has made some steps with moving inputs."""
    component = configuration.make()
    excite(component)
    component.initialize(0.0)
    h = span(component)
    for k in range(steps):
        slope_inputs(component, rate=0.5 + 0.3 * k)
        component.step(k * h, h)
    return component


@configurations
def test_initialize_is_repeatable(configuration):
    component = started(configuration)
    assert any(component.work.values())
    excite(component)
    component.initialize(0.0)
    fresh = configuration.make()
    excite(fresh)
    fresh.initialize(0.0)
    assert bits(component) == bits(fresh)
    assert not any(component.work.values())
    assert np.isfinite(component.x).all()
    assert np.isfinite(component.y).all()


@configurations
def test_initialize_follows_inputs_that_still_change(configuration):
    """A master initializes again and again until the inputs settle: only the last ones count."""
    component, fresh = configuration.make(), configuration.make()
    for share in (0.1, -0.05, 0.3):
        excite(component, share)
        component.initialize(0.0)
    excite(fresh, 0.3)
    fresh.initialize(0.0)
    assert bits(component) == bits(fresh)


@configurations
def test_a_repeated_step_is_the_same_to_the_last_bit(configuration):
    component = started(configuration)
    h = span(component)
    state = component.save()
    slope_inputs(component)
    component.step(3 * h, h)
    once, t = bits(component), component.t
    slope_inputs(component, rate=-2.0, half=3.0)
    component.step(4 * h, h)
    assert bits(component) != once
    component.restore(state)
    assert component.save() == state
    slope_inputs(component)
    component.step(3 * h, h)
    assert bits(component) == once
    assert component.t == t


@configurations
def test_a_state_holds_everything_a_step_depends_on(configuration):
    """Restored into an instance that has another past, and with another step length before."""
    component = started(configuration)
    h = span(component)
    state = component.save()
    slope_inputs(component)
    component.step(3 * h, h)
    other = configuration.make()
    excite(other, -0.1)
    other.initialize(0.0)
    other.step(0.0, 0.7 * h)
    other.restore(state)
    slope_inputs(other)
    other.step(3 * h, h)
    assert bits(other) == bits(component)


@configurations
def test_a_state_of_another_size_is_refused(configuration):
    component = started(configuration, 0)
    with pytest.raises(BadInput, match="numbers"):
        component.restore(component.save()[:-8])


@configurations
def test_refresh_without_a_change_changes_nothing(configuration):
    component = started(configuration)
    before = bits(component)
    component.refresh()
    assert bits(component) == before


@configurations
def test_outputs_follow_their_declared_inputs_only(configuration):
    """After `refresh` an output may differ only if it declares one of the changed inputs as feed-through."""
    component = started(configuration)
    before = component.y.copy()
    for name in component.inputs:
        state = component.save()
        component.set(name, component[name] + 0.1 * component.variables[name].nominal)
        component.refresh()
        changed = [n for n, a, b in zip(component.outputs, component.y, before, strict=True) if a != b]
        assert [n for n in changed if name not in component.variables[n].feedthrough] == [], name
        component.restore(state)


@configurations
def test_the_start_follows_from_its_declared_inputs_only(configuration):
    """Initialized with another value of an input that is not declared, and given the usual one afterwards, nothing differs."""
    usual = configuration.make()
    assert usual.start_inputs is not None, "a component of the catalogue declares start_inputs"
    excite(usual)
    usual.initialize(0.0)
    for name in usual.inputs:
        if not {name, name.partition("[")[0]} & set(usual.start_inputs):
            for share in (0.1, -0.7):
                other = configuration.make()
                excite(other)
                value = other[name]
                other.set(name, value + share * other.variables[name].nominal)
                other.initialize(0.0)
                other.set(name, value)
                other.refresh()
                assert bits(other) == bits(usual), name


@over([c for c in CONFIGURATIONS if "cage_slip" not in c.effects])  # its steps are the master's, of order two: test_cage_slip.py
def test_one_step_is_two_of_half_its_length(configuration):
    """The macro step belongs to the master: it must not show, where the internal steps are the same ones.

    The inputs are the same polynomial, developed again in the middle. What is left is rounding of the times at which it is
    evaluated, 1e-16 relative, times the largest force per output, 1e5 in the stiff springs; 1e-8 nominal leaves room.
    """
    whole, halves = started(configuration, 0), started(configuration, 0)
    h = span(whole)
    for component in (whole, halves):
        slope_inputs(component, rate=2.0, half=-30.0)
    whole.step(0.0, 2 * h)
    halves.step(0.0, h)
    slope_inputs(halves, rate=2.0 - 2 * 30.0 * h, half=-30.0)
    halves.step(h, h)
    if "substep" in whole.parameters:  # else every macro step is one of its own
        assert whole.work["steps"] == halves.work["steps"]
    for name, a, b in zip(whole.outputs, whole.y, halves.y, strict=True):
        assert abs(a - b) <= 1e-8 * whole.variables[name].nominal, name


@configurations
def test_inputs_end_where_their_polynomials_lead(configuration):
    component = started(configuration, 0)
    h = span(component)
    start = component.u[0].copy()
    slope_inputs(component, rate=2.0, half=-30.0)
    slope, half = component.u[1].copy(), component.u[2].copy()
    component.step(0.0, h)
    terms = np.array([start, h * slope, h * h * half])
    assert (np.abs(component.u[0] - terms.sum(axis=0)) <= 4.0 * EPSILON * np.abs(terms).sum(axis=0)).all()  # four roundings
    assert not component.u[1:].any()


@configurations
def test_work_is_counted(configuration):
    component = started(configuration, 1)
    h = span(component)
    once = component.work
    assert set(once) == set(component.counters)
    if "substep" in component.parameters:
        assert once["steps"] == max(1, math.ceil(h / component["substep"] * (1.0 - 1e-9)))
    component.step(h, h)
    assert component.work["steps"] == 2 * once["steps"]
    if isinstance(component, OdeComponent):
        work = component.work
        if work.get("events"):  # cut substeps are made again
            assert work["derivative_calls"] > 4 * work["steps"]
        else:
            assert work["derivative_calls"] == (STAGES if "high_order" in component.on else 4) * work["steps"]  # stages


@configurations
def test_energy_and_stable_step_are_numbers(configuration):
    component = started(configuration)
    if type(component).energy is not Component.energy:
        assert math.isfinite(component.energy())
    assert component.stable_step() > 0.0
    assert component.parameters.get("substep", 0.0) <= component.stable_step()  # the defaults are stable


@configurations
def test_whoever_writes_a_parameter_it_is_what_the_next_start_computes_with(configuration):
    """Set before or after the layout, between questions, and behind a start with another value."""
    asked, fresh = started(configuration), configuration.make()
    changed = {
        name: value * 1.01
        for name, value in asked.parameters.items()
        if isinstance(value, float) and not asked.variables[name].structural and value * 1.01 != value
    }
    for name, value in changed.items():
        try:
            asked.variables[name].checked(value, "")
        except BadInput:  # at a limit
            continue
        for component in (asked, fresh):
            component.set(name, value)
    asked.stable_step()
    ends = []
    for component in (asked, fresh):
        excite(component)
        try:
            component.initialize(0.0)
            component.step(0.0, span(component))
            ends.append(bits(component))
        except (BadInput, StepFailed) as error:  # values that do not go together, for both
            ends.append(str(error))
    assert ends[0] == ends[1]
