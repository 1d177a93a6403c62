"""A spring and damper to the ground as a controller has them: it looks at the motion at whole multiples of a period."""

from __future__ import annotations

from cosimo.components.core.kernels import DONE, kernel
from cosimo.components.core.sampled import SampledComponent, sampled_kernels
from cosimo.components.core.stateless import nothing
from cosimo.components.core.variables import input_, output, parameter


@kernel
def sample(t, u, s, p, e):
    s.x[1] = -p.stiffness * u[0] - p.damping * u[1]


@kernel
def outputs(t, s, p, e):
    s.y[0] = s.x[1]
    return DONE


class SampledSpring(SampledComponent):
    """Its force is that of the last sample."""

    start_inputs = ("x", "v")
    period = parameter(0.01, "s", "time between samples", low=1e-6)
    stiffness = parameter(100.0, "N/m", "force per way", low=0.0)
    damping = parameter(4.0, "N.s/m", "force per velocity", low=0.0)
    x = input_(0.0, "m", "position")
    v = input_(0.0, "m/s", "velocity")
    force = output("N", "force")
    kernels = sampled_kernels(__name__, nothing, sample, outputs)

    def states(self):
        return 2
