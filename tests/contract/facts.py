"""What the contract tests need to know of a component beyond its declaration: `facts.py` of its system, an entry for each."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Facts:
    """small: parameters that make the component quicker and the code no other; the tests use them everywhere.
    other_ways: a second way through the component that parameters choose, with the effects that change this way.
    moving: outputs that move although the component starts from rest ("*": all, it never rests).
    released: presets that start away from their equilibrium, as a loaded spring that is let go.
    slopes: share of the contract's slopes of inputs that leaves them within the range of the model.
    plain: effects and parameters with which compiled and plain Python are compared, and the number of steps of 1 ms.

    For the tests of vanishing effects:
    disturbance: inputs after the initialization.  step: s.
    strengths: number that makes an effect vanish -> the effect's other numbers, and a value whose next order does not show.
    roots: strengths whose effect grows with their square root.
    structural: effects that change what the model is and have no such number.  form: numbers that are none of strength.
    """

    small: Mapping[str, Any] = field(default_factory=dict)
    other_ways: tuple[tuple[dict[str, Any], tuple[str, ...]], ...] = ()
    moving: frozenset[str] = frozenset()
    released: frozenset[str] = frozenset()
    slopes: float = 1.0
    plain: tuple[tuple[str, ...], Mapping[str, Any], int] = ((), {}, 20)
    disturbance: Mapping[str, float] = field(default_factory=dict)
    step: float = 1e-3
    strengths: Mapping[str, tuple[Mapping[str, Any], float]] = field(default_factory=dict)
    roots: frozenset[str] = frozenset()
    structural: frozenset[str] = frozenset()
    form: frozenset[str] = frozenset()


def all_facts() -> dict[str, Facts]:
    """Component -> facts, of all systems."""
    found: dict[str, Facts] = {}
    for path in sorted((Path(__file__).parents[1] / "systems").glob("*/facts.py")):
        found |= import_module(f"cosimo.tests.systems.{path.parent.name}.facts").FACTS
    return found
