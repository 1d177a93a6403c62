"""A bearing that is a spring and a damper: plain forces, or with its tangent, for the stability of the coupling."""

import numpy as np
from cosimo.components.core.component import Component, Effect
from cosimo.components.core.kernels import DONE, hold_inputs
from cosimo.components.core.variables import input_, output, parameter

MOTION = ("displacement_x", "displacement_y", "velocity_x", "velocity_y")


class Tangent(Effect):
    """The line of the load instead of the load."""

    force_x = output("N", "force along x at zero motion")
    force_y = output("N", "force along y at zero motion")
    stiffness = output("1", "tangent by displacement", size=25)
    damping = output("1", "tangent by velocity", size=25)


class LinearBearing(Component):
    """F = -k q - d q' in the plane."""

    title = "Spring and damper"
    system = "rotor"
    counters = ("steps",)

    tangent = Tangent

    k = parameter(1e8, "N/m", "stiffness")
    d = parameter(1e4, "N.s/m", "damping")

    displacement_x = input_(0.0, "m", "displacement along x")
    displacement_y = input_(0.0, "m", "displacement along y")
    velocity_x = input_(0.0, "m/s", "velocity along x")
    velocity_y = input_(0.0, "m/s", "velocity along y")

    force_x = output("N", "force along x", feedthrough=("displacement_x", "velocity_x"))
    force_y = output("N", "force along y", feedthrough=("displacement_y", "velocity_y"))

    def _initialize(self, t: float) -> int:
        self.arguments = self._declared_arguments()
        return DONE

    def _step(self, t: float, h: float) -> int:
        hold_inputs(self.u, h)
        self._outputs(t + h)
        self.counts += 1
        return DONE

    def _outputs(self, t: float) -> None:
        p, effects = self.arguments
        self.y[:2] = -p.k * self.u[0, :2] - p.d * self.u[0, 2:4]
        if (tangent := effects.tangent) is not None:
            for first, value in ((tangent.y + 2, p.k), (tangent.y + 27, p.d)):
                self.y[first : first + 25] = np.diag([value, value, 0.0, 0.0, 0.0]).ravel()
