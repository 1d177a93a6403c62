"""Added mass as a unit of its own: accelerations in, the force of the accelerated water out."""

from __future__ import annotations

from ..core.kernels import DONE, kernel
from ..core.stateless import StatelessComponent, stateless_kernels
from ..core.variables import input_, output, parameter


class AddedMassForce(StatelessComponent):
    """Force of the water on an accelerated hull, f = -M_A nu', without a state of its own.

    A demonstrator. Added mass belongs into the hull's inertia, as `RovHull` has it. Exchanged as a force it closes a loop
    without a state: given once a step, it answers the acceleration before, a(k+1) = (F - m_A a(k)) / m, which grows with any
    step where m_A > m, as in sway and heave of published vehicles. Iterated with relaxation below 2 / (1 + m_A / m) it converges.
    Coriolis forces of the water are not in it. Defaults: added mass of a BlueROV2 after Wu (2018), as `RovHull`.
    """

    title = "Added mass as a force beside the hull"
    system = "rov"
    default_step = 0.02
    default_stop = 10.0

    surge = parameter(5.5, "kg", "added mass along x", low=0.0)
    sway = parameter(12.7, "kg", "added mass along y", low=0.0)
    heave = parameter(14.57, "kg", "added mass along z", low=0.0)
    roll = parameter(0.12, "kg.m2", "added inertia about x", low=0.0)
    pitch = parameter(0.12, "kg.m2", "added inertia about y", low=0.0)
    yaw = parameter(0.12, "kg.m2", "added inertia about z", low=0.0)

    acceleration_x = input_(0.0, "m/s2", "rate of change of the surge speed")
    acceleration_y = input_(0.0, "m/s2", "rate of change of the sway speed")
    acceleration_z = input_(0.0, "m/s2", "rate of change of the heave speed")
    angular_acceleration_x = input_(0.0, "rad/s2", "rate of change of the roll rate")
    angular_acceleration_y = input_(0.0, "rad/s2", "rate of change of the pitch rate")
    angular_acceleration_z = input_(0.0, "rad/s2", "rate of change of the yaw rate")

    force_x = output("N", "force on the hull ahead", nominal=10.0, feedthrough=("acceleration_x",))
    force_y = output("N", "force on the hull to starboard", nominal=10.0, feedthrough=("acceleration_y",))
    force_z = output("N", "force on the hull downwards in body axes", nominal=10.0, feedthrough=("acceleration_z",))
    moment_x = output("N.m", "moment on the hull about x", feedthrough=("angular_acceleration_x",))
    moment_y = output("N.m", "moment on the hull about y", feedthrough=("angular_acceleration_y",))
    moment_z = output("N.m", "moment on the hull about z", feedthrough=("angular_acceleration_z",))


IN = AddedMassForce.input_places()
OUT = AddedMassForce.output_places()


@kernel
def reaction(t, s, p, e):
    """Force against each acceleration."""
    u, y = s.u[0], s.y
    y[OUT.force_x], y[OUT.force_y], y[OUT.force_z] = (
        -p.surge * u[IN.acceleration_x],
        -p.sway * u[IN.acceleration_y],
        -p.heave * u[IN.acceleration_z],
    )
    y[OUT.moment_x], y[OUT.moment_y], y[OUT.moment_z] = (
        -p.roll * u[IN.angular_acceleration_x],
        -p.pitch * u[IN.angular_acceleration_y],
        -p.yaw * u[IN.angular_acceleration_z],
    )
    return DONE


AddedMassForce.kernels = stateless_kernels(__name__, reaction)
