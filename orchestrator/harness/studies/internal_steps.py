"""How long the internal step of a component may be before its integrator lets disturbances grow, and its own `stable_step()`.

The component runs alone with its inputs held, twice; in one of the runs the inputs are pushed for one step. Effects that are
off are measured, too: each alone with what it needs.
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
from ...judgement.disturbance import GrowthRate, IntrinsicGrowth, growth_of, longest_stable, sizes
from ...output import write_table
from ...run.progress import tracked
from ..journal import once
from .full_model import with_required

Making = Callable[[float], Component]  # with internal steps of so many seconds; initialized

STEPS = 600  # internal steps of a run that decides
SMALL = 1e-3  # of the largest first difference: a state that the push reaches late is not one that grows
FARTHEST = 30.0  # times the first step tried: beyond it no limit is looked for
PACE = 1.25  # from one trial to the next: far beyond a limit a motion reaches its bounds at once, and seems to rest there
PUSH = 1e-8  # of an input's value or nominal value: small, so that growth has room before something bounds it
FLOOR = 1e-12  # of a state: a difference below it is rounding
EVEN = 1.5  # a factor that beating modes may have; beyond its limit a method makes much more of them
FINE = 8.0  # part of the own limit at which intrinsic growth is measured


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
    steps: int = STEPS,
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
        key = (cls, one, dict(parameters or {}), preset, steps)
        measure = partial(_measured, cls, one, parameters or {}, preset, steps)
        limits.append(once("internal step", key, measure, InternalStep))
    return InternalSteps(name, cls.title, tuple(limits))


def _measured(
    cls: type[Component], effects: tuple[str, ...], parameters: Mapping[str, Any], preset: str, steps: int
) -> InternalStep:
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
        by_itself = IntrinsicGrowth(_sizes(make, usual / FINE, int(FINE * steps))[0], usual / FINE)
    except (BadInput, StepFailed) as error:
        return InternalStep(effects, math.nan, math.nan, str(error), math.nan)
    longest, seen, tried = longest_stable(
        lambda h: _growth(make, h, steps), by_itself, EVEN, usual, usual / FARTHEST, usual * FARTHEST, PACE
    )
    return InternalStep(effects, own, longest, seen, tried)


def _usual(component: Component) -> float:
    """The component's present internal step, s."""
    step = component.internal_step() if isinstance(component, OdeComponent) else float(component.get("substep"))
    return step if math.isfinite(step) else component.default_step


def _growth(make: Making, h: float, steps: int) -> GrowthRate:
    """Of a push of the inputs, in so many internal steps of length h, s."""
    try:
        differences, count = _sizes(make, h, steps)
    except (BadInput, StepFailed, ArithmeticError, np.linalg.LinAlgError) as error:  # what grows may end anywhere
        return GrowthRate(math.inf, steps * h, 0, str(error))
    return growth_of(differences, h, count)


def _sizes(make: Making, h: float, steps: int) -> tuple[np.ndarray, int]:
    """(sizes of a push's effect after each step of h, s; number of steps). Each state is scaled by the push's first effect on it."""
    calm, pushed = (_states(make(h), h, steps, push) for push in (0.0, PUSH))
    differences = pushed - calm
    early = np.abs(differences[: steps // 4]).max(axis=0, initial=0.0)
    scale = np.maximum(early, np.maximum(FLOOR * np.abs(calm).max(axis=0, initial=0.0), SMALL * early.max(initial=0.0)))
    return sizes(differences / np.where(scale > 0.0, scale, 1.0)), 2 * steps


def _states(component: Component, h: float, steps: int, push: float) -> np.ndarray:
    """States behind every internal step, (steps, n); in the first one the inputs are off by `push` of their sizes."""
    inputs = component.u[0].copy()
    component.u[0] += push * np.maximum(np.abs(inputs), [component.variables[n].nominal for n in component.inputs])
    rows = []
    for k in range(steps):
        component.step(k * h, h)
        component.u[0] = inputs
        rows.append(component.x.copy())
    return np.array(rows)
