"""An effect whose strength goes to zero tends to the effect being off, in proportion to its strength."""

from __future__ import annotations

import numpy as np
import pytest

from components.catalogue import CATALOGUE, component_class
from components.core.variables import Causality

from .configurations import SMALL

STEPS, H = 100, 1e-3
# Component, the other numbers of the effect, and its strength: small enough that the next order does not show.
CASES = {
    "aerodynamic_uplift.coefficient": ("Pantograph", {}, 1e-4),
    "bump_stops.stiffness": ("Pantograph", {"bump_stops.travel": 0.0}, 1.0),
    "frame_friction.level": ("Pantograph", {}, 1e-3),
    "base_excitation.height": ("Pantograph", {}, 1e-4),
    "inerter.reference_force": ("LumpedCatenary", {}, 1.0),
    "damping.alpha": ("Catenary", {"damping.beta": 0.0}, 1e-3),
    "damping.beta": ("Catenary", {"damping.alpha": 0.0}, 1e-7),
    "bending_stiffness.contact_wire": ("Catenary", {"bending_stiffness.messenger": 0.0}, 1e-2),
    "bending_stiffness.messenger": ("Catenary", {"bending_stiffness.contact_wire": 0.0}, 1e-2),
    "steady_arm.stiffness": ("Catenary", {}, 1e-1),
    "pre_sag.depth": ("Catenary", {}, 1e-4),
    "second_pantograph.contact_force": ("Catenary", {"second_pantograph.contact_position": 50.0}, 1.0),
}
# Effects that change what the model is and have no number that makes them vanish, and numbers that are none of strength.
STRUCTURAL = {"contact_loss", "lower_frame", "dropper_slackening", "gravity_sag", "level_support", "moving_window",
              "wire_profile"}
FORM = {"bump_stops.travel", "frame_friction.width", "base_excitation.velocity", "steady_arm.mass",
        "second_pantograph.contact_position"}


def disturbed(component: str, effects, parameters) -> np.ndarray:
    """Outputs of the component without effects at every step after a change of its inputs, (STEPS, k)."""
    cls = component_class(component)
    made = cls(effects, SMALL.get(component, {}) | parameters)
    own = [i for i, n in enumerate(made.outputs) if "." not in n and n != "static_residual"]
    made.initialize(0.0)
    for name, value in {"wire_height": 0.003, "contact_position": 52.0, "contact_force": 100.0}.items():
        if name in made.inputs:
            made.set(name, value)
    rows = []
    for k in range(STEPS):
        made.step(k * H, H)
        rows.append(made.y[own].copy())
    return np.array(rows)


@pytest.mark.parametrize("strength", CASES)
def test_a_vanishing_effect_tends_to_no_effect(strength):
    component, parameters, small = CASES[strength]
    off = disturbed(component, (), {})
    on = [strength.partition(".")[0]]

    def difference(value: float) -> float:
        return float(np.abs(disturbed(component, on, parameters | {strength: value}) - off).max())

    assert difference(0.0) == 0.0
    one, tenth = difference(small), difference(0.1 * small)
    assert tenth > 0.0
    # First order in the strength: 10. The next order is below 5 % at these strengths, rounding far below.
    assert one / tenth == pytest.approx(10.0, rel=0.05)


def test_every_number_of_every_effect_is_in_one_of_the_lists():
    """So that a new effect is either shown to vanish with its strength, or said to have none."""
    found = {n for c in CATALOGUE for n, v in component_class(c).variables.items()
             if "." in n and v.causality is not Causality.OUTPUT and n.partition(".")[0] not in STRUCTURAL}
    assert found == CASES.keys() | FORM
