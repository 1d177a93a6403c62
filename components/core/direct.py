"""Components without a state: massless couplings, tables, courses over time. Kernels as templates.

What a component supplies: `outputs(t, s, p, e) -> status`, and where something follows from the parameters a kernel `start` of
the same form.
"""

from __future__ import annotations

from typing import Any, ClassVar

from .contract import KernelComponent, Kernels
from .kernels import DONE, bind, hold_inputs, kernel
from .ode import outputs


@kernel
def nothing(t, s, p, e):
    """The start of a component of whose parameters nothing follows."""
    return DONE


def direct_step(t, h, s, p, e):
    """The outputs at the end of a step."""
    s.counts[0] += 1
    hold_inputs(s.u, h)
    return outputs(t + h, s, p, e)


def direct_kernels(module: str, outputs: Any, start: Any = nothing) -> Kernels:
    """The kernels of a `DirectComponent`; module: its `__name__`."""
    return Kernels(start, bind(direct_step, module, outputs=outputs), outputs)


class DirectComponent(KernelComponent):
    """Outputs are functions of inputs and time; a subclass gives `kernels` by `direct_kernels`."""

    counters: ClassVar[tuple[str, ...]] = ("steps",)
    start_inputs = ()
