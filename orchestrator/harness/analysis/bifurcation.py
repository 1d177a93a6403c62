"""Bifurcation diagrams: a component run in this process over the values of a parameter, looked at once per period."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from ....components.core.component import Component

Made = TypeVar("Made", bound=Component)


@dataclass(frozen=True)
class Bifurcation:
    """Stroboscopic points over the values of a parameter."""

    values: np.ndarray  # (n,)
    signals: tuple[str, ...]
    points: np.ndarray  # (n, k, len(signals))


def stroboscopic_points(
    component: Component, period: float, points: int, signals: Sequence[str], *, transient: int = 0
) -> np.ndarray:
    """Outputs at the end of each of `points` periods after `transient` more, (points, len(signals)).

    The component is initialized, and is left at the end of the run. Each period is one step of it, divided as its own
    accuracy asks for.
    """
    at, start, rows = component.output_positions(signals), component.t, np.empty((points, len(signals)))
    for k in range(transient + points):
        component.step(start + k * period, period)
        if k >= transient:
            rows[k - transient] = component.y[at]
    return rows


def bifurcation(
    make: Callable[[float], Made],
    values: Iterable[float],
    period: Callable[[Made], float],
    signals: Sequence[str],
    *,
    points: int = 100,
    transient: int = 100,
    follow: bool = False,
    progress: Callable[[float], None] | None = None,
) -> Bifurcation:
    """The component `make(value)` at each value, seen once per `period(component)`.

    follow: start each run from the end of the one before, not from the component's own start: upward and downward sweeps then
        show where two motions exist beside one another. All components must have the same state.
    progress: called with the share that is done.
    """
    given, rows, state = list(values), [], None
    for i, value in enumerate(given):
        component = make(value)
        component.initialize(0.0)
        if follow and state is not None:
            component.x[:] = state
        rows.append(stroboscopic_points(component, period(component), points, signals, transient=transient))
        state = component.x.copy()
        if progress is not None:
            progress((i + 1) / len(given))
    return Bifurcation(np.array(given), tuple(signals), np.array(rows))
