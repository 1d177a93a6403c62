"""The FMI variables of a component, in the order of their value references.

Part of every FMU's bundle; works on a component class that is handed in, and imports none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Any

TYPES = {"real": "Real", "integer": "Integer", "boolean": "Boolean", "choice": "String", "text": "String"}


@dataclass(frozen=True)
class Scalar:
    """One FMI variable; its position in `interface` is its value reference."""

    name: str
    type: str  # "Real", "Integer", "Boolean" or "String"
    causality: str  # "parameter", "input" or "output"
    start: Any
    unit: str
    text: str
    low: float = -math.inf
    high: float = math.inf
    nominal: float = 1.0
    feedthrough: tuple[str, ...] = ()
    moving: bool = False  # of an input: a place that moves on
    relative: bool = False  # a difference: units to show it in have no offset
    order: int = 0  # of an input: 0 its value, 1 and 2 its derivatives
    tunable: bool = False  # of a parameter: it may change during a run
    discrete: bool = False  # of an input or an output: it changes at instants only

    @property
    def variability(self) -> str:
        """As FMI has it."""
        if self.causality in ("parameter", "local"):
            return "constant" if self.causality == "local" else "tunable" if self.tunable else "fixed"
        return "discrete" if self.discrete else "continuous"


@cache
def interface(component: Any) -> tuple[Scalar, ...]:
    """All variables of a component class: effects, parameters, inputs, their first and second derivatives, outputs."""
    declared = component.variables.values()
    by_causality = {c: [_declared(v) for v in declared if v.causality.value == c] for c in ("parameter", "input", "output")}
    inputs = by_causality["input"]
    return (
        *(_effect(name, effect) for name, effect in component.effects.items()),
        *by_causality["parameter"],
        *inputs,
        *(_derivative(v, 1) for v in inputs),
        *(_derivative(v, 2) for v in inputs),
        *by_causality["output"],
    )


def _declared(variable: Any) -> Scalar:
    text = variable.text + (": " + ", ".join(variable.choices) if variable.choices else "")
    return Scalar(
        variable.name,
        TYPES[variable.kind.value],
        variable.causality.value,
        variable.start,
        variable.unit,
        text,
        variable.low,
        variable.high,
        variable.nominal,
        variable.feedthrough,
        variable.moving,
        tunable=variable.tunable,
        discrete=variable.discrete,
    )


def _effect(name: str, effect: Any) -> Scalar:
    text = (effect.__doc__ or name).strip().splitlines()[0]
    needs = "".join(f" Needs {n}." for n in effect.requires) + "".join(f" Excludes {n}." for n in effect.excludes)
    return Scalar(f"effects.{name}", "Boolean", "parameter", False, "1", "Effect: " + text + needs)


def _derivative(variable: Scalar, order: int) -> Scalar:
    name = f"der({variable.name})" if order == 1 else f"der({variable.name},{order})"
    text = f"{'first' if order == 1 else 'second'} time derivative of {variable.name} for the next step; 0 again after it"
    return Scalar(name, "Real", "input", 0.0, variable.unit + "/s" * order, text, order=order)
