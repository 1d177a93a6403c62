"""What an effect needs and what it excludes is refused by name, in a component and in a scene."""

import re

import pytest
from cosimo import BadInput, read_scene
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.variables import Causality
from cosimo.tests.contract.configurations import with_required

NEEDS = [(c, e, other) for c in CATALOGUE for e, effect in component_class(c).effects.items() for other in effect.requires]
CONFLICTS = [(c, e, other) for c in CATALOGUE for e, effect in component_class(c).effects.items() for other in effect.excludes]
EFFECTS = [(c, e) for c in CATALOGUE for e in component_class(c).effects]


def scene_of(component, effects, parameters=None):
    return {
        "stop_time": 1e-3,
        "master": {"step": 1e-3},
        "units": {"part": {"component": component, "effects": list(effects), "parameters": parameters or {}}},
    }


@pytest.mark.parametrize(("component", "effect", "other"), NEEDS)
def test_an_effect_without_what_it_needs_is_refused(component, effect, other):
    cls = component_class(component)
    on = [e for e in with_required(cls, effect) if (e != other and other not in with_required(cls, e)) or e == effect]
    with pytest.raises(BadInput, match=f"'{effect}' needs '{other}'"):
        cls(on)
    with pytest.raises(BadInput, match=f"part.*'{effect}' needs '{other}'"):
        read_scene(scene_of(component, on))


@pytest.mark.parametrize(("component", "effect", "other"), CONFLICTS)
def test_effects_that_exclude_each_other_are_refused_in_any_order(component, effect, other):
    cls = component_class(component)
    both = [*with_required(cls, effect), *with_required(cls, other)]
    for on in (both, both[::-1]):
        with pytest.raises(BadInput, match=rf"'({effect}|{other})' and '({effect}|{other})' exclude each other"):
            cls(on)
    with pytest.raises(BadInput, match=r"part.*exclude each other"):
        read_scene(scene_of(component, both))


@pytest.mark.parametrize(("component", "effect"), EFFECTS)
def test_a_number_of_an_effect_that_is_off_is_refused_in_a_scene(component, effect):
    cls = component_class(component)
    own = [n for n, v in cls.variables.items() if n.startswith(f"{effect}.") and v.causality is not Causality.OUTPUT]
    for name in own[:1]:
        with pytest.raises(BadInput, match=re.escape(name) + rf".*needs the effect '{effect}'"):
            read_scene(scene_of(component, (), {name: cls.variables[name].start}))


@pytest.mark.parametrize("component", [c for c in CATALOGUE if component_class(c).effects])
def test_a_misspelt_effect_is_refused_with_the_near_ones(component):
    effect = next(iter(component_class(component).effects))
    with pytest.raises(BadInput, match=rf"{effect}x.*Did you mean.*'{effect}'"):
        read_scene(scene_of(component, [effect + "x"]))
