"""An effect that is off is absent: no state, no variable, no trace in the result."""

import numpy as np
import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.component import Effect
from cosimo.tests.contract.configurations import (
    SMALL,
    bits,
    compatible,
    excite,
    in_plain_python,
    slope_inputs,
    small,
    with_required,
)

pytestmark = pytest.mark.interpreted
SINGLE = [(c, e) for c in CATALOGUE for e in component_class(c).effects]


class Undeclared(Effect):
    """Stands where an effect was declared; it declares nothing, and kernels get None for it."""


def stripped(cls, *effects):
    """The component written without these effects: their variables exist nowhere."""
    body = {v.name: v for v in cls.own_variables} | {n: Undeclared if n in effects else e for n, e in cls.effects.items()}
    bare = type(cls.__name__, (cls,), body)
    assert bare.Values._fields == cls.Values._fields
    bare.Values = cls.Values  # the same type of parameters: the same machine code, not compiled once more
    return bare


def trajectory(component) -> list[bytes]:
    """Ten steps with moving inputs, every bit of them."""
    excite(component)
    component.initialize(0.0)
    rows = [bits(component)]
    for k in range(10):
        slope_inputs(component, rate=0.5 + 0.1 * k)
        component.step(k * 1e-3, 1e-3)
        rows.append(bits(component))
    return rows


@pytest.mark.parametrize("component", CATALOGUE)
def test_nothing_of_an_effect_is_there_while_it_is_off(component):
    cls = component_class(component)
    off = cls(parameters=SMALL[component])
    off.initialize(0.0)
    assert [n for n in (*off.parameters, *off.inputs, *off.outputs) if "." in n] == []
    assert off.u.shape == (3, len(off.inputs))
    assert off.y.shape == (len(off.outputs),)
    bare = stripped(cls, *cls.effects)(parameters=SMALL[component])
    bare.initialize(0.0)
    assert (off.x.size, off.inputs, off.outputs) == (bare.x.size, bare.inputs, bare.outputs)
    assert off.parameters == bare.parameters
    assert {value is None for value in off.arguments[-1]} == {True}  # what kernels get, and Numba prunes


@pytest.mark.parametrize(("component", "effect"), SINGLE)
def test_one_effect_adds_its_own_and_nothing_else(component, effect):
    cls = component_class(component)
    on = with_required(cls, effect)
    off, one = cls(), cls(on)
    for before, after in ((off.parameters, one.parameters), (off.inputs, one.inputs), (off.outputs, one.outputs)):
        added = set(after) - set(before)
        assert set(before) <= set(after)
        assert {n.partition(".")[0] for n in added} <= set(on)


@pytest.mark.parametrize("component", in_plain_python(CATALOGUE))
@pytest.mark.uncompiled
def test_off_is_the_component_without_the_declaration_to_the_last_bit(component):
    cls = component_class(component)
    here, bare = cls(parameters=SMALL[component]), stripped(cls, *cls.effects)(parameters=SMALL[component])
    assert trajectory(here) == trajectory(bare)


@pytest.mark.parametrize(("component", "effect"), SINGLE)
def test_the_others_do_not_notice_an_effect_that_is_off(component, effect):
    """Everything else on, one effect off, against the component that never had it: kernels get the same, number by number."""
    cls = component_class(component)
    others = [e for e in compatible(cls) if effect not in with_required(cls, e)]
    given = small(component, others)
    here, bare = cls(others, given), stripped(cls, effect)(others, given)
    assert (here.inputs, here.outputs, here.parameters) == (bare.inputs, bare.outputs, bare.parameters)
    assert here.u.tobytes() == bare.u.tobytes()
    given, wanted = (one._declared_arguments() for one in (here, bare))
    given, wanted = ((p, *e) for p, e in (given, wanted))
    assert [None if g is None else len(g) for g in given] == [None if w is None else len(w) for w in wanted]
    for g, w in zip(given, wanted, strict=True):
        for one, other in zip(g or (), w or (), strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("component", in_plain_python(CATALOGUE))
@pytest.mark.uncompiled
def test_effects_take_part_once_they_are_on(component):
    """The counterpart of the tests above: they would pass, too, if effects never did anything."""
    cls = component_class(component)
    off = cls(parameters=SMALL[component])
    trajectory(off)
    on = cls(compatible(cls), small(component, compatible(cls)))
    trajectory(on)
    if cls.effects:
        assert not np.array_equal(off.y, on.y[: off.y.size])
