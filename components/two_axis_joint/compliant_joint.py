"""A rotary joint between two ends that gives a little: no mass, forces from the motion of both ends."""

from __future__ import annotations

import numpy as np

from ..core.component import Effect
from ..core.kernels import DONE, kernel
from ..core.stateless import StatelessComponent, stateless_kernels
from ..core.variables import input_, output, parameter

RATES = ("rotation.first_rate", "rotation.second_rate")
PLACES = ("first_x", "first_y", "second_x", "second_y")
X = (*PLACES, "first_velocity_x", "second_velocity_x")  # with play, the force along x depends on the place along y, too
Y = (*PLACES, "first_velocity_y", "second_velocity_y")


class Rotation(Effect):
    """Viscous damping of the rotation of the second end against the first, and a motor in the joint."""

    damping = parameter(0.05, "N.m.s/rad", "viscous damping of the rotation", low=0.0)
    first_rate = input_(0.0, "rad/s", "rate of the first end", nominal=3.0)
    second_rate = input_(0.0, "rad/s", "rate of the second end", nominal=3.0)
    motor_torque = input_(0.0, "N.m", "motor torque on the second end, and back on the first", nominal=1.0)
    first_torque = output("N.m", "torque on the first end", feedthrough=(*RATES, "rotation.motor_torque"))
    second_torque = output("N.m", "torque on the second end", feedthrough=(*RATES, "rotation.motor_torque"))


class Clearance(Effect):
    """Play: the ends move freely against each other within a circle; spring and damper take part by 1 - radius / distance."""

    radius = parameter(1e-4, "m", "radius of the play", low=0.0)


class CompliantJoint(StatelessComponent):
    """Spring and damper that hold two ends together; ends that no one drives stand still at the origin, as the ground does.

        F_second = -k (r_second - r_first) - c (r_second' - r_first'),    F_first = -F_second

    It stands for the rigid joint between bodies of different units: error of the held motion about F / k; what it brings in,
    is a vibration of sqrt(k / m) with m the ends' masses in series, damped by c.
    """

    title = "Compliant joint"
    system = "two_axis_joint"

    rotation = Rotation
    clearance = Clearance

    stiffness = parameter(1e5, "N/m", "stiffness between the ends, in every direction", low=0.0)
    damping = parameter(100.0, "N.s/m", "damping between the ends, in every direction", low=0.0)

    first_x = input_(0.0, "m", "place of the first end along x", nominal=1e-3)
    first_y = input_(0.0, "m", "place of the first end along y", nominal=1e-3)
    first_velocity_x = input_(0.0, "m/s", "velocity of the first end along x", nominal=1e-2)
    first_velocity_y = input_(0.0, "m/s", "velocity of the first end along y", nominal=1e-2)
    second_x = input_(0.0, "m", "place of the second end along x", nominal=2e-3)
    second_y = input_(0.0, "m", "place of the second end along y", nominal=2e-3)
    second_velocity_x = input_(0.0, "m/s", "velocity of the second end along x", nominal=2e-2)
    second_velocity_y = input_(0.0, "m/s", "velocity of the second end along y", nominal=2e-2)

    first_force_x = output("N", "force on the first end along x", nominal=10.0, feedthrough=X)
    first_force_y = output("N", "force on the first end along y", nominal=10.0, feedthrough=Y)
    second_force_x = output("N", "force on the second end along x", nominal=10.0, feedthrough=X)
    second_force_y = output("N", "force on the second end along y", nominal=10.0, feedthrough=Y)
    opening = output("m", "distance of the ends", nominal=1e-4, feedthrough=PLACES)

    def energy(self) -> float:
        """Energy of the spring, J."""
        _, p, e = self.arguments
        x1, y1, _, _, x2, y2, *_ = self.u[0]
        play = e.clearance.radius if e.clearance is not None else 0.0
        return 0.5 * p.stiffness * max(float(np.hypot(x2 - x1, y2 - y1)) - play, 0.0) ** 2


IN = CompliantJoint.input_places()
OUT = CompliantJoint.output_places()


@kernel
def joint_forces(t, s, p, e):
    """Forces and the ends' distance; with `rotation` the torques."""
    u, y = s.u[0], s.y
    x, z = u[IN.second_x] - u[IN.first_x], u[IN.second_y] - u[IN.first_y]
    y[OUT.first_force_x] = p.stiffness * x + p.damping * (u[IN.second_velocity_x] - u[IN.first_velocity_x])
    y[OUT.first_force_y] = p.stiffness * z + p.damping * (u[IN.second_velocity_y] - u[IN.first_velocity_y])
    y[OUT.opening] = np.hypot(x, z)
    if e.clearance is not None:
        share = 1.0 - e.clearance.radius / y[OUT.opening] if y[OUT.opening] > e.clearance.radius else 0.0
        y[OUT.first_force_x] *= share
        y[OUT.first_force_y] *= share
    y[OUT.second_force_x], y[OUT.second_force_y] = -y[OUT.first_force_x], -y[OUT.first_force_y]
    if e.rotation is not None:
        y[e.rotation.y] = e.rotation.damping * (u[e.rotation.u + 1] - u[e.rotation.u]) - u[e.rotation.u + 2]
        y[e.rotation.y + 1] = -y[e.rotation.y]
    return DONE


CompliantJoint.kernels = stateless_kernels(__name__, outputs=joint_forces)
