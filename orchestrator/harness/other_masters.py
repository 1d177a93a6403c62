"""What a packed scene gives in other tools: they exchange values once per step, by Jacobi's scheme with held inputs.

libcosim and Ecos read the step of an SSP package and no more: no order of units, no extrapolation, no outputs that follow
their inputs within an instant, no iteration, no rates, no faults. A run of the scene under such a master shows how far that
is from the scene itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np

from ...components.core.errors import BadInput
from ..run.run import run
from ..scene.scene import Scene
from .studies.quantities import Quantity, TimeHistory, quantities_of, recording

HALVINGS = 6  # of the macro step, in search of one that other masters get along with
MOST_STEPS = 2_000_000  # of a run on that search


@dataclass(frozen=True)
class SharedQuantity:
    """One quantity: here and there (the mean, of a time history), and the difference over the range of the signal."""

    quantity: Quantity
    here: float
    there: float
    difference: float


@dataclass(frozen=True)
class MasterComparison:
    """A scene with its own master and with held inputs at a macro step, s. `failure`: why the latter did not reach the end."""

    step: float
    rows: tuple[SharedQuantity, ...]
    failure: str

    @property
    def difference(self) -> float:
        """The largest one; infinite for a run that failed."""
        return inf if self.failure else max((row.difference for row in self.rows), default=0.0)


def as_other_masters(scene: Scene, step: float | None = None) -> Scene:
    """The scene as other masters step it; `step`: s, in the place of its own."""
    coupling = scene.coupling
    master = {"algorithm": "jacobi", "step": step or scene.master.step}
    master |= {"extrapolation": 0, "moving_places": "held"} if coupling.links else {}
    master |= {"feedthrough": "delayed"} if coupling.feedthrough_schedule else {}
    return scene.with_changes({"master": master, "faults": [], **{f"units.{name}.every": 1 for name in coupling.rates}})


class OtherMasters:
    """The scene's own run, and comparisons with it. Raises `BadInput` where the scene itself does not reach its end."""

    def __init__(self, scene: Scene):
        self._scene = recording(scene)
        self._quantities = quantities_of(scene)
        own = run(self._scene, in_process=True).unless_stopped()
        if own.outcome != "done":
            raise BadInput(scene.name, own.message, "a scene that runs to its end", "--force packs it all the same.")
        self._own = TimeHistory(own.time, own.columns)

    def compare(self, step: float | None = None) -> MasterComparison:
        """With held inputs at a macro step, s; by default the scene's own."""
        other = run(as_other_masters(self._scene, step), in_process=True).unless_stopped()
        there = TimeHistory(other.time, other.columns)
        rows = tuple(
            SharedQuantity(q, _shown(q, self._own), _shown(q, there), q.error(there, self._own)) for q in self._quantities
        )
        return MasterComparison(step or self._scene.master.step, rows, "" if other.outcome == "done" else other.message)

    def step_within(self, tolerance: float) -> MasterComparison | None:
        """With the first halved macro step that keeps the tolerance; None where none is found."""
        step = self._scene.master.step
        for _ in range(HALVINGS):
            step /= 2.0
            if self._scene.duration > MOST_STEPS * step:
                return None
            try:
                comparison = self.compare(step)
            except BadInput:  # a unit with steps of its own length
                return None
            if comparison.difference <= tolerance:
                return comparison
        return None


def _shown(quantity: Quantity, history: TimeHistory) -> float:
    if history.time.size == 0:
        return float("nan")
    return float(np.mean(history.columns[quantity.signal])) if quantity.kind == "time history" else quantity.value(history)
