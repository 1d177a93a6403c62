"""What the figures of every system need of a run: samples after the transient, recorded columns, what drives an input."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ....components.core.errors import BadInput
from ...units.component import make

if TYPE_CHECKING:
    from ....components.core.component import Component
    from ...results import Result
    from ...scene.scene import Scene

KINDS: dict[str, Callable[[np.ndarray], Any]] = {  # statistics of a signal
    "minimum": np.min,
    "maximum": np.max,
    "mean": np.mean,
    "standard deviation": np.std,
}


def after_transient(result: Result) -> slice:
    """The samples from [analysis] transient on; all without it."""
    transient = result.scene.analysis.transient
    first = int(np.searchsorted(result.time, transient))
    if first >= result.time.size - 1:
        where, length = f"{result.scene.name}: analysis.transient", result.time[-1]
        raise BadInput(where, f"{transient:g} s", f"less than the length of the run, {length:g} s")
    return slice(first, None)


def component_of(scene: Scene, unit: str) -> Component | None:
    """The unit's component with the scene's effects and parameters, not initialized; None for an FMU."""
    given = scene.units[unit]
    return make(unit, given) if given.component else None


def source(scene: Scene, unit: str, name: str) -> str:
    """ "unit.output" that drives an input; "" if nothing does."""
    return next((".".join(link.source) for link in scene.coupling.links if link.target == (unit, name)), "")


def recorded(result: Result, unit: str, name: str) -> str:
    """The column that holds a variable of a unit, its own or that of the output that drives it; "" if neither was recorded."""
    own = f"{unit}.{name}"
    if own in result.columns:
        return own
    driving = source(result.scene, unit, name)
    return driving if driving in result.columns else ""
