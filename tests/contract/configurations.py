"""What the contract tests run over: every component of the catalogue in every configuration of its effects."""

from collections import defaultdict
from collections.abc import Iterable, Iterator
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.component import Component
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.harness.studies.full_model import with_required
from cosimo.tests.contract.facts import Facts, all_facts

FACTS = defaultdict(Facts, all_facts())
SMALL = {name: dict(FACTS[name].small) for name in CATALOGUE}


def small(component: str, effects: Iterable[str]) -> dict[str, Any]:
    """Parameters for short runs, without those that these effects replace."""
    replaced = component_class(component).replaced(effects)
    return {n: v for n, v in SMALL[component].items() if n.partition("[")[0] not in replaced}


class Configuration(NamedTuple):
    """A component with some effects on and some parameters given."""

    component: str
    effects: tuple[str, ...]
    parameters: dict[str, Any]

    @property
    def label(self) -> str:
        """Name of the test case."""
        way = [str(v) for k, v in self.parameters.items() if k not in SMALL[self.component]]
        return "-".join([self.component, *way, "+".join(self.effects) or "none"])

    def make(self) -> Component:
        """A new instance with its parameters; not initialized."""
        return component_class(self.component)(self.effects, self.parameters)


def compatible(cls: type[Component], first: Iterable[str] = ()) -> tuple[str, ...]:
    """As many effects as go together: `first`, then the earlier declared ones first."""
    on: tuple[str, ...] = ()
    for effect in (*first, *cls.effects):
        group = with_required(cls, effect)
        if not any(a in cls.effects[b].excludes or b in cls.effects[a].excludes for a in group for b in on):
            on = tuple(n for n in cls.effects if n in {*on, *group})
    return on


def _configurations() -> Iterator[Configuration]:
    for name in CATALOGUE:
        cls = component_class(name)
        sets = [(), *(with_required(cls, e) for e in cls.effects), compatible(cls)]
        yield from (Configuration(name, effects, small(name, effects)) for effects in dict.fromkeys(sets))
        yield from (Configuration(name, effects, small(name, effects) | way) for way, effects in FACTS[name].other_ways)


def in_plain_python(cases: Iterable[Any]) -> list[Any]:
    """All cases where nothing is compiled, elsewhere one, which the marker `uncompiled` leaves out: the compiler would take
    minutes over kernels that run for a moment.

    tests/contract/test_plain_python.py runs the files that use this in a process without the compiler.
    """
    return list(islice(cases, 1 if COMPILED else None))


CONFIGURATIONS = list(_configurations())
EVERYTHING_ON = [Configuration(name, on, small(name, on)) for name in CATALOGUE for on in [compatible(component_class(name))]]


def excite(component: Component, share: float = 0.3) -> None:
    """Set every input away from its start by a share of its nominal value."""
    for name in component.inputs:
        variable = component.variables[name]
        component.set(name, variable.start + share * variable.nominal)


def slope_inputs(component: Component, rate: float = 0.5, half: float = -0.2) -> None:
    """Give every input a first and a second derivative for the next step: nominal values per s and s²."""
    nominal = np.array([component.variables[n].nominal for n in component.inputs]) * FACTS[type(component).__name__].slopes
    component.u[1], component.u[2] = rate * nominal, half * nominal


def span(component: Component) -> float:
    """A macro step of at least two internal steps, as many as fit into 2 ms, s."""
    substep = component.parameters.get("substep", 1e-3)
    return substep * max(2, round(2e-3 / substep))


def bits(component: Component) -> bytes:
    """Everything that must be equal where two components are to be the same: time, inputs, outputs, state."""
    return np.concatenate(([component.t], component.u.ravel(), component.y, component.x)).tobytes()
