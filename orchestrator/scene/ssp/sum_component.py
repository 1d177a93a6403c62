"""The sum of a system structure as a component: what libcosim's functions `Sum` and `VectorSum` give."""

from __future__ import annotations

from ....components.core.kernels import DONE, kernel
from ....components.core.stateless import StatelessComponent, stateless_kernels
from ....components.core.variables import input_, output

MOST = 32  # terms of a sum; those that nothing drives are zero


class Sum(StatelessComponent):
    """Outputs the sum of its inputs at the same instant, whatever their unit of measure."""

    title = "Sum"
    system = "system structure"

    term = input_(0.0, "1", "a term", size=MOST)
    out = output("1", "sum of the terms", feedthrough=("term",))


@kernel
def added(t, s, p, e):
    """The sum of the terms."""
    total = 0.0
    for k in range(MOST):
        total += s.u[0, k]
    s.y[0] = total
    return DONE


Sum.kernels = stateless_kernels(__name__, outputs=added)
