"""How long the internal step of a component may be before its integrator lets disturbances grow, and its own `stable_step()`.

The component runs alone with its inputs held. Tangents tell what becomes of a push of the inputs in the first step. Effects that are off
are measured, too: each alone with what it needs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ....components.catalogue import component_class
from ....components.core.component import Component
from ....components.core.errors import BadInput, StepFailed
from ....components.core.integrators import OdeComponent
from ...derivatives.component import TangentComponent
from ...judgement.growth import Growth, growth_rate, longest_stable
from ...output import write_table
from ...run.progress import tracked
from ..journal import once
from .full_model import with_required

Making = Callable[[float], Component]  # with internal steps of so many seconds; initialized

STEPS = 600  # internal steps in which a disturbance is followed
SMALL = 1e-3  # of the largest first tangent: a state that the push reaches late is not one that grows
FARTHEST = 30.0  # times the first step tried: beyond it no limit is looked for
ACCURACY = 1.005  # of a limit
FINE = 8.0  # part of the own limit that shows what grows by itself


@dataclass(frozen=True)
class InternalStep:
    """One set of effects. own: s, of `stable_step()`, infinite where there is no limit. longest, seen, tried: as of a `Limit`."""

    effects: tuple[str, ...]
    own: float
    longest: float
    seen: str
    tried: float

    @property
    def margin(self) -> float:
        """Measured over own limit: below 1 the component's `stable_step()` is too long. NaN where one of them is not known."""
        known = math.isfinite(self.own) and math.isfinite(self.longest) and self.own > 0.0
        return self.longest / self.own if known else math.nan


@dataclass(frozen=True)
class InternalSteps:
    """Limits of a component with several sets of effects."""

    component: str
    title: str
    steps: tuple[InternalStep, ...]

    def save(self, directory: str | Path) -> Path:
        """Write stability.csv: one row for each set of effects."""
        header = ["effects", "longest stable internal step, s", "own limit, s", "margin, 1", "seen", "tried, s"]
        return write_table(
            directory,
            "stability.csv",
            header,
            [(" ".join(s.effects), s.longest, s.own, s.margin, s.seen, s.tried) for s in self.steps],
        )


def internal_steps(
    name: str,
    *,
    effects: Sequence[str] | None = None,
    parameters: Mapping[str, Any] | None = None,
    preset: str = "",
    progress: bool = False,
) -> InternalSteps:
    """Measure the limits of a component of the catalogue, with the effects given or with none and each alone.

    Raises `BadInput` for a component without internal steps or without inputs, and for what cannot be set.
    """
    cls = component_class(name)
    if not (issubclass(cls, OdeComponent) or "substep" in cls.variables):
        raise BadInput(f"component:{name}", "no internal steps", "a component that integrates with steps of its own")
    on = set(cls.presets[preset].effects) if preset in cls.presets else set()
    each = ((), *(with_required(cls, effect) for effect in cls.effects if effect not in on))
    sets = [tuple(effects)] if effects is not None else [*each]
    chosen = tracked(list(dict.fromkeys(sets)), name, progress)
    limits = []
    for one in chosen:
        key = (cls, one, dict(parameters or {}), preset)
        measure = partial(_measured, cls, one, parameters or {}, preset)
        limits.append(once("internal step", key, measure, InternalStep))
    return InternalSteps(name, cls.title, tuple(limits))


def _measured(cls: type[Component], effects: tuple[str, ...], parameters: Mapping[str, Any], preset: str) -> InternalStep:
    def make(h: float | None) -> Component:
        """The component, which takes internal steps of h, s; of its own length for None."""
        component = cls(effects, parameters, preset=preset)
        if h is not None and isinstance(component, OdeComponent):  # it would refuse to be measured beyond its own limit
            component.force_internal_step(h)
        elif h is not None:
            component.set("substep", h)
        component.initialize(0.0)
        return component

    try:
        present = make(None)
        if not present.inputs:
            raise BadInput(present.name, "no inputs", "a component that can be pushed")
        own = present.stable_step()
        usual = own if math.isfinite(own) else _usual(present)
        by_itself = _rate(make, usual / FINE)
    except (BadInput, StepFailed) as error:
        return InternalStep(effects, math.nan, math.nan, str(error), math.nan)

    def grows(h: float) -> str:
        try:
            growth = Growth(h, STEPS * h, _rate(make, h), by_itself, constant=False)
        except (BadInput, StepFailed, ArithmeticError, np.linalg.LinAlgError) as error:  # what grows may end anywhere
            return str(error)
        return growth.text if growth.unstable else ""

    limit = longest_stable(grows, usual, usual / FARTHEST, usual * FARTHEST, ACCURACY)
    return InternalStep(effects, own, *limit)


def _usual(component: Component) -> float:
    """The component's present internal step, s."""
    step = component.internal_step() if isinstance(component, OdeComponent) else float(component.get("substep"))
    return step if math.isfinite(step) else component.default_step


def _rate(make: Making, h: float) -> float:
    """How fast a push of the inputs grows with internal steps of h, 1/s."""
    component = make(h)
    moved = TangentComponent(component, 1)
    sizes = np.maximum(np.abs(component.u[0]), [component.variables[n].nominal for n in component.inputs])
    moved.seed(np.arange(sizes.size), sizes[:, None], of_inputs=True)
    rows = []
    for k in range(STEPS):
        moved.step(k * h, h)
        moved.hold()
        rows.append(np.abs(moved.tangents[:, 0]))
    tangents = np.array(rows)
    early = tangents[: STEPS // 4].max(axis=0, initial=0.0)
    scale = np.maximum(early, SMALL * early.max(initial=0.0))
    return growth_rate(np.linalg.norm(tangents / np.where(scale > 0.0, scale, 1.0), axis=1), h)
