"""Effects that a kernel does not read: it gets none of them, so that its machine code serves with each and without."""

import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.block import ENTRIES
from cosimo.components.core.contract import KernelComponent
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.contract.configurations import bits, compatible, excite, in_plain_python, slope_inputs, small, with_required

SOME = [
    (c, e)
    for c in CATALOGUE
    if issubclass(cls := component_class(c), KernelComponent)
    for e, effect in cls.effects.items()
    if set(effect.read_by) != set(ENTRIES)
]


def differs(cls, name: str, on) -> bool:
    """Whether anything is another where all kernels get all effects: start, two steps, outputs."""
    everything = type(cls.__name__, (cls,), {})
    everything.unread, everything.Values, rows = {}, cls.Values, []
    for made in (cls(on, small(name, on)), everything(on, small(name, on))):
        excite(made)
        made.initialize(0.0)
        rows.append([bits(made)])
        for k in range(2):
            slope_inputs(made, rate=0.5)
            made.step(1e-3 * k, 1e-3)
            rows[-1].append(bits(made))
        made.refresh()
        rows[-1].append(bits(made))
    return rows[0] != rows[1]


@pytest.mark.parametrize(("component", "effect"), in_plain_python(SOME))
@pytest.mark.uncompiled
def test_a_kernel_does_not_read_what_it_does_not_get(component, effect):
    cls = component_class(component)
    assert not differs(cls, component, with_required(cls, effect))


@pytest.mark.parametrize("component", in_plain_python(dict(SOME)))
@pytest.mark.uncompiled
def test_nor_where_all_others_are_on(component):
    cls = component_class(component)
    assert not differs(cls, component, compatible(cls))


@pytest.mark.uncompiled
def test_an_effect_that_is_read_all_the_same_is_seen():
    cls = component_class("Catenary")
    wrong = type("Catenary", (cls,), {})
    wrong.unread = {**cls.unread, "step": (*cls.unread["step"], "damping")}
    assert differs(wrong, "Catenary", ["damping"])


@pytest.mark.skipif(not COMPILED, reason="nothing is compiled")
def test_scenes_of_one_line_share_the_code_of_its_steps():
    """As many forms of code as sets of effects that a kernel reads."""
    cls = component_class("Catenary")
    sets = [(), ("steady_arm",), ("level_support",), ("steady_arm", "gravity_sag"), ("second_pantograph",), ("line_table",)]
    handed = {k: {repr(made.block.handed(k, made.arguments)[2]) for made in map(cls, sets)} for k in ENTRIES}
    assert {k: len(texts) for k, texts in handed.items()} == {"initialize": 2, "step": 1, "outputs": 1}
