"""What a component declares: names, units, descriptions, limits, presets."""

import math
import re

import numpy as np
import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.contract import KernelComponent
from cosimo.components.core.errors import BadInput
from cosimo.components.core.measure import parse
from cosimo.components.core.variables import Causality, Kind, gathered
from cosimo.tests.contract.configurations import FACTS, SMALL, compatible, in_plain_python

CORE = KernelComponent.__module__.rpartition(".")[0]
VARIABLES = [(c, v) for c in CATALOGUE for v in component_class(c).variables]


@pytest.mark.parametrize("component", CATALOGUE)
def test_variables_are_described(component):
    for name, variable in component_class(component).variables.items():
        assert variable.name == name
        assert variable.text.strip(), f"{name} has no description"
        assert not variable.text.endswith("."), f"{name}: a description is no sentence"
        assert "\n" not in variable.text
        parse(variable.unit)  # raises for an unknown symbol
        assert variable.nominal > 0.0


@pytest.mark.parametrize("component", CATALOGUE)
def test_names_are_snake_case(component):
    pattern = re.compile(r"([a-z][a-z0-9_]*\.)?[a-z][a-z0-9_]*(\[\d+\])?")
    assert [n for n in component_class(component).variables if not pattern.fullmatch(n)] == []


@pytest.mark.parametrize("component", CATALOGUE)
def test_no_variable_takes_the_place_of_what_every_component_has(component):
    """A parameter named `layout` once stood for the layout of the block, and blocks of other effects got the wrong machine code."""
    shared = [base for base in component_class(component).__mro__ if base.__module__.startswith(CORE)]
    assert {n for n in component_class(component).variables if any(n in vars(base) for base in shared)} == set()


@pytest.mark.parametrize("component", CATALOGUE)
def test_starts_are_within_their_limits(component):
    for name, variable in component_class(component).variables.items():
        if variable.kind is Kind.CHOICE:
            assert variable.start in variable.choices, name
        elif variable.kind is Kind.TEXT:
            assert isinstance(variable.start, str), name
        else:
            assert variable.low <= variable.start <= variable.high, name
            assert math.isfinite(variable.start), name


@pytest.mark.parametrize("component", CATALOGUE)
def test_feedthrough_names_inputs(component):
    cls = component_class(component)
    inputs = {n for n, v in cls.variables.items() if v.causality is Causality.INPUT}
    for name, variable in cls.variables.items():
        assert set(variable.feedthrough) <= inputs, name
        assert variable.causality is Causality.OUTPUT or not variable.feedthrough, name
    assert cls.start_inputs is not None, "from which inputs the start follows; () where from none"
    assert set(cls.start_inputs) <= inputs | {n.partition("[")[0] for n in inputs}


@pytest.mark.parametrize("component", CATALOGUE)
def test_sums_are_outputs_in_the_unit_of_their_parts(component):
    cls = component_class(component)
    for name, parts in cls.output_sums.items():
        assert {cls.variables[n].causality for n in (name, *parts)} == {Causality.OUTPUT}
        assert {cls.variables[n].unit for n in parts} == {cls.variables[name].unit}
        assert len(parts) > 1


@pytest.mark.parametrize("component", CATALOGUE)
def test_ports_name_signals_and_each_has_one_of_a_name(component):
    cls = component_class(component)
    signals = [v.name for v in cls.own_variables if v.causality is not Causality.PARAMETER]
    signals += [
        f"{e}.{v.name}" for e, effect in cls.effects.items() for v in effect.variables if v.causality is not Causality.PARAMETER
    ]
    taken = [s for port in cls.ports.values() for s in port]
    assert len(taken) == len(set(taken))
    assert set(taken) <= {*signals, *(f"{e}.*" for e in cls.effects)}
    assert {*cls.port_members} <= {s.rpartition(".")[2] for s in signals}
    assert sum(map(len, gathered(signals, cls.ports, cls.port_members).values())) == len(
        signals
    )  # none took the place of another
    assert not {*cls.ports} & {*cls.effects, "signals", "derivatives"}


@pytest.mark.parametrize("component", CATALOGUE)
def test_effects_are_described_and_know_each_other(component):
    cls = component_class(component)
    for name, effect in cls.effects.items():
        assert effect.__doc__, name
        assert {*effect.requires, *effect.excludes} <= cls.effects.keys() - {name}


@pytest.mark.parametrize(("component", "preset"), in_plain_python((c, p) for c in CATALOGUE for p in component_class(c).presets))
@pytest.mark.uncompiled
def test_presets_start_from_rest(component, preset):
    published = component_class(component).presets[preset].parameters
    made = component_class(component)(preset=preset, parameters={n: v for n, v in SMALL[component].items() if n not in published})
    for name, value in published.items():
        assert made[name] == value
    made.initialize(0.0)
    before = made.y.copy()
    made.step(0.0, 1e-3)
    if preset in FACTS[component].released:
        assert np.abs(made.y - before).max() > 1e-6
        return
    # An equilibrium stays one: what moves in a step is at most rounding of the largest forces, far below 1e-6 nominal,
    # and outputs that are functions of time move with their own speed.
    assert np.isfinite(made.y).all()
    for i, name in enumerate(made.outputs):
        if not {name, "*"} & FACTS[component].moving:
            assert abs(made.y[i] - before[i]) <= 1e-6 * made.variables[name].nominal, name


@pytest.mark.parametrize("component", CATALOGUE)
def test_misspelt_names_are_refused_with_the_near_ones(component):
    cls = component_class(component)
    parameter = next(n for n, v in cls.variables.items() if v.causality is Causality.PARAMETER and v.kind is Kind.REAL)
    with pytest.raises(BadInput, match=f"Did you mean.*'{re.escape(parameter)}'"):
        cls(parameters={parameter + "x": 1.0})
    with pytest.raises(BadInput, match=f"Did you mean.*'{re.escape(parameter)}'"):
        cls().get(parameter + "x")
    for effect in list(cls.effects)[:1]:
        with pytest.raises(BadInput, match=f"Did you mean.*'{effect}'"):
            cls([effect + "x"])
    for preset in list(cls.presets)[:1]:
        with pytest.raises(BadInput, match=f"Did you mean.*'{re.escape(preset)}'"):
            cls(preset=preset + "x")


@pytest.mark.parametrize("component", CATALOGUE)
def test_variables_of_an_effect_that_is_off_are_refused(component):
    cls = component_class(component)
    for name in (n for n in cls.variables if "." in n):
        effect = name.partition(".")[0]
        with pytest.raises(BadInput, match=f"needs the effect '{effect}'"):
            cls().get(name)
        with pytest.raises(BadInput, match=f"needs the effect '{effect}'"):
            cls(parameters={name: 1.0})


@pytest.mark.parametrize("component", CATALOGUE)
def test_values_outside_the_limits_are_refused(component):
    cls = component_class(component)
    made = cls(compatible(cls))
    for name, variable in cls.variables.items():
        if variable.causality is not Causality.PARAMETER or name not in made.parameters:
            continue
        wrong = {Kind.CHOICE: ["nonsense"], Kind.TEXT: [1.0, None]}.get(
            variable.kind, [math.nan, math.inf, "1", True, None, [1.0]]
        )
        wrong += [variable.start + 0.5] if variable.kind is Kind.INTEGER else []
        if math.isfinite(variable.low):
            wrong.append(variable.low - 1.0)
        if math.isfinite(variable.high):
            wrong.append(variable.high + 1.0)
        for value in wrong:
            with pytest.raises(BadInput, match=re.escape(name)):
                made.set(name, value)
        assert made[name] == variable.start  # the refused value left nothing behind
