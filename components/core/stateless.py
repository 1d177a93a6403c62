"""Components without a state: massless couplings, tables, courses over time."""

from __future__ import annotations

from typing import ClassVar

from .component import Component
from .kernels import DONE, hold_inputs


class StatelessComponent(Component):
    """Outputs are functions of inputs and time; a subclass gives `_outputs`, and `_initialize` if parameters need preparation."""

    counters: ClassVar[tuple[str, ...]] = ("steps",)
    start_inputs = ()

    def _initialize(self, t: float) -> int:
        self.arguments = self._declared_arguments()
        return DONE

    def _step(self, t: float, h: float) -> int:
        self.counts[0] += 1
        hold_inputs(self.u, h)
        self._outputs(t + h)
        return DONE
