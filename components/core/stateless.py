"""Components without a state: massless couplings, tables, courses over time."""

from __future__ import annotations

from typing import ClassVar

from .component import Component
from .kernels import DONE, hold_inputs


class StatelessComponent(Component):
    """Its outputs are functions of its inputs and of time; a subclass gives `_outputs`, and `_initialize` if it settles more."""

    counters: ClassVar[tuple[str, ...]] = ("steps",)

    def _initialize(self, t: float) -> int:
        self.settled = self._settled()
        return DONE

    def _step(self, t: float, h: float) -> int:
        self.counts[0] += 1
        hold_inputs(self.u, h)
        self._outputs(t + h)
        return DONE
