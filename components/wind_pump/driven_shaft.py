"""The shaft that a transmission drives: an inertia that stands exactly until the drive exceeds the load, and never turns back.

A pump's torque is resistive, like dry friction of one direction: while the shaft stands, the pump answers whatever the drive
gives, up to the torque of the pressure on its piston; the pump's valves, or a backstop, keep the shaft from turning back. So
there are two modes, kept in the state as a number: TURNING, which holds while the speed is positive, and STANDING, which holds
while the drive is below the load. All transmissions share these kernels; they are bound by `event_kernels`.
"""

from __future__ import annotations

import math

from ..core.component import Effect
from ..core.events import EventComponent
from ..core.kernels import kernel
from ..core.variables import input_, output, parameter

STANDING, TURNING = 0.0, 1.0
SLOWEST = 1e-6  # rad/s, a turbine slower than that stands, for what is divided by its speed


class MeshFriction(Effect):
    """Friction of gear teeth and guides on the turbine's side: a share of the torque that is passed on, against the rotation."""

    coefficient = parameter(0.03, "1", "lost share of the torque; a choice of ours", low=0.0, high=1.0)
    width = parameter(0.01, "rad/s", "turbine speed over which the friction changes sign", low=1e-9)


class Transmission(EventComponent):
    """Between turbine and pump: turbine's speed and load in, torque on the turbine and speed of the driven shaft out."""

    system = "wind_pump"
    default_step = 1e-2
    default_stop = 60.0

    mesh_friction = MeshFriction

    start_speed = parameter(0.0, "rad/s", "speed of the driven shaft at the start", low=0.0)

    turbine_speed = input_(0.0, "rad/s", "speed of the turbine")
    load_torque = input_(0.0, "N.m", "torque that brakes the driven shaft", nominal=10.0)

    turbine_torque = output("N.m", "torque that brakes the turbine", nominal=10.0, feedthrough=("turbine_speed",))
    speed = output("rad/s", "speed of the driven shaft")
    driving_torque = output("N.m", "torque of the transmission on the driven shaft", nominal=10.0, feedthrough=("turbine_speed",))
    ratio = output(
        "1", "speed of the driven shaft over that of the turbine; 0 while the turbine stands", feedthrough=("turbine_speed",)
    )
    dissipation = output("W", "power lost in shaft, bearings and gear", nominal=10.0, feedthrough=("turbine_speed",))


IN = Transmission.input_places()
OUT = Transmission.output_places()


@kernel
def shaft_mode(speed, driving, load):
    """TURNING or STANDING, for a speed in rad/s and torques in N.m; a shaft without speed turns if the drive exceeds the load."""
    return TURNING if speed > 0.0 or driving > load else STANDING


@kernel
def switched_shaft(mode, driving, load):
    """The mode of a shaft at rest whose guard has reached zero; where drive and load are equal to the last bit, the other one.

    A drive and a load that are both 0, a calm and a piston at its dead centre, are equal: which mode lasts depends on which of
    them grows first, and the mode that does not last is left at once.
    """
    if driving == load:
        return STANDING if mode == TURNING else TURNING
    return TURNING if driving > load else STANDING


@kernel
def shaft_guard(mode, speed, driving, load):
    """Positive while the mode holds: the speed, or what the drive lacks to start the shaft."""
    return load - driving if mode == STANDING else speed


@kernel
def shaft_acceleration(mode, speed, driving, load, inertia, damping):
    """Angular acceleration, rad/s²: (drive - load - damping * speed) / inertia, and none while the shaft stands."""
    return 0.0 if mode == STANDING else (driving - load - damping * speed) / inertia


@kernel
def speed_ratio(speed, turbine_speed):
    """Speed of the driven shaft over that of the turbine; 0 where the turbine stands."""
    return speed / turbine_speed if abs(turbine_speed) > SLOWEST else 0.0


@kernel
def mesh_loss(torque, turbine_speed, mesh):
    """Friction torque on the turbine that comes with a torque passed on, N.m; `mesh`: values of `MeshFriction` or None."""
    if mesh is not None:
        return mesh.coefficient * abs(torque) * math.tanh(turbine_speed / mesh.width)
    return 0.0
