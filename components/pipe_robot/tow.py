"""A coupling between two robots in a pipe: no mass, forces from the motion of both ends."""

from __future__ import annotations

from ..core.component import Effect
from ..core.kernels import DONE, kernel
from ..core.stateless import StatelessComponent, stateless_kernels
from ..core.variables import input_, output, parameter

ENDS = ("rear_position", "front_position")
MOTION = (*ENDS, "rear_velocity", "front_velocity")


class Slack(Effect):
    """A rope instead of a bar: no force while it is shorter than its length, and it never pushes.

    Its damping grows with the stretch up to `onset`, so that a rope that tightens suddenly does not jerk.
    """

    explicit_only = True

    onset = parameter(1e-3, "m", "stretch from which on the damping is whole", low=1e-12)


class TowCoupling(StatelessComponent):
    """Spring and damper along the pipe between a robot in front and one behind, which it keeps `length` apart.

        e = x_front - x_rear - length,    F_rear = k e + c e',    F_front = -F_rear

    Both ends give position and velocity and get a force, positive forwards: it goes to `tow.force` of a robot. Robots in tow are
    ours; of Matuliauskas and Spruogis (2002), whose robot this is for, only the abstract is known to us.
    """

    title = "Coupling for towing"
    system = "pipe_robot"

    slack = Slack

    stiffness = parameter(500.0, "N/m", "stiffness", low=0.0)
    damping = parameter(5.0, "N.s/m", "damping", low=0.0)
    length = parameter(0.5, "m", "distance of the ends without force", low=0.0)

    rear_position = input_(0.0, "m", "position of the end behind", nominal=0.1)
    rear_velocity = input_(0.0, "m/s", "velocity of the end behind")
    front_position = input_(0.5, "m", "position of the end in front", nominal=0.2)
    front_velocity = input_(0.0, "m/s", "velocity of the end in front")

    rear_force = output("N", "force on the end behind, positive forwards", nominal=10.0, feedthrough=MOTION)
    front_force = output("N", "force on the end in front, positive forwards", nominal=10.0, feedthrough=MOTION)
    stretch = output("m", "distance of the ends beyond the length", nominal=0.1, feedthrough=ENDS)

    def energy(self) -> float:
        """Energy of the spring, J."""
        _, p, e = self.arguments
        stretch = float(self.u[0, IN.front_position] - self.u[0, IN.rear_position]) - p.length
        return 0.5 * p.stiffness * (max(stretch, 0.0) if e.slack is not None else stretch) ** 2


IN = TowCoupling.input_places()
OUT = TowCoupling.output_places()


@kernel
def tow_forces(t, s, p, e):
    """Forces on both ends, and the stretch."""
    u, y = s.u[0], s.y
    stretch, rate = u[IN.front_position] - u[IN.rear_position] - p.length, u[IN.front_velocity] - u[IN.rear_velocity]
    force = p.stiffness * stretch + p.damping * rate
    if e.slack is not None:
        force = max(p.stiffness * stretch + p.damping * min(stretch / e.slack.onset, 1.0) * rate, 0.0) if stretch > 0.0 else 0.0
    y[OUT.rear_force], y[OUT.front_force], y[OUT.stretch] = force, -force, stretch
    return DONE


TowCoupling.kernels = stateless_kernels(__name__, tow_forces)
