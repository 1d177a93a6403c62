"""Components without a state: massless couplings, tables, time histories. Kernels as templates.

A component supplies `outputs(t, s, p, e) -> status`, and where constants follow from the parameters a kernel `start` of
the same form.
"""

from __future__ import annotations

from typing import Any, ClassVar

from .contract import KernelComponent, Kernels
from .integrators import outputs
from .kernels import DONE, bind, hold_inputs, kernel


@kernel
def nothing(t, s, p, e):
    """The start of a component of whose parameters nothing follows."""
    return DONE


def stateless_step(t, h, s, p, e):
    """The outputs at the end of a step."""
    s.counts[0] += 1
    hold_inputs(s.u, h)
    return outputs(t + h, s, p, e)


def stateless_kernels(module: str, outputs: Any, start: Any = nothing) -> Kernels:
    """The kernels of a `StatelessComponent`; module: its `__name__`."""
    return Kernels(start, bind(stateless_step, module, outputs=outputs), outputs)


class StatelessComponent(KernelComponent):
    """Outputs are functions of inputs and time; a subclass gives `kernels` by `stateless_kernels`."""

    counters: ClassVar[tuple[str, ...]] = ("steps",)
    start_inputs = ()
