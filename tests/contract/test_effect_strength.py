"""An effect whose strength goes to zero tends to the effect being off, in proportion to its strength."""

import functools

import numpy as np
import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.variables import Causality
from cosimo.tests.contract.configurations import FACTS, SMALL, in_plain_python, with_required
from cosimo.tests.short_run import full_but

STEPS = 40
LATE = {"steady_arm.stiffness": 100, "gust.amplitude": 100}  # steps until a wave is at the support, until the gust is there
CASES = [(c, s) for c in CATALOGUE for s in FACTS[c].strengths]


def disturbed(component: str, effects, parameters, steps: int) -> np.ndarray:
    """Outputs of the component without effects at every step after a change of its inputs, (steps, k)."""
    cls = component_class(component)
    facts = FACTS[component]
    made = cls(effects, SMALL[component] | parameters)
    own = [i for i, n in enumerate(made.outputs) if "." not in n and n != "static_residual"]
    made.initialize(0.0)
    for name, value in facts.disturbance.items():
        made.set(name, value)
    rows = []
    for k in range(steps):
        made.step(k * facts.step, facts.step)
        rows.append(made.y[own].copy())
    return np.array(rows)


@functools.cache
def without(component: str, effects: tuple[str, ...], steps: int) -> np.ndarray:
    """The same for all strengths of an effect."""
    return disturbed(component, effects, {}, steps)


@pytest.mark.parametrize(("component", "strength"), in_plain_python(full_but((), CASES)))
@pytest.mark.uncompiled
def test_a_vanishing_effect_tends_to_no_effect(component, strength):
    parameters, small = FACTS[component].strengths[strength]
    effect = strength.partition(".")[0]
    on = with_required(component_class(component), effect)
    steps = LATE.get(strength, STEPS)
    off = without(component, tuple(e for e in on if e != effect), steps)

    def difference(value: float) -> float:
        return float(np.abs(disturbed(component, on, parameters | {strength: value}, steps) - off).max())

    assert difference(0.0) == 0.0
    one, tenth = difference(small), difference(0.1 * small)
    assert tenth > 0.0
    # First order in the strength, or in its root. The next order is below 5 % at these strengths, rounding far below.
    order = 0.5 if strength in FACTS[component].roots else 1.0
    assert one / tenth == pytest.approx(10.0**order, rel=0.05)


@pytest.mark.parametrize("component", CATALOGUE)
def test_every_number_of_every_effect_is_in_one_of_the_lists(component):
    """So that a new effect is either shown to vanish with its strength, or said to have none."""
    facts, cls = FACTS[component], component_class(component)
    found = {
        n.partition("[")[0]
        for n, v in cls.variables.items()
        if "." in n and v.causality is not Causality.OUTPUT and n.partition(".")[0] not in facts.structural
    }
    assert found == {n.partition("[")[0] for n in facts.strengths} | facts.form
    assert facts.structural <= cls.effects.keys()
