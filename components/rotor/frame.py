"""A frame that turns slowly under its rotor: the gyroscopic load on the rotor, and the moment on the frame.

The rotor's displacements are those relative to the frame, which turns at the rates w_x and w_y. The absolute rate at which a
section tilts is the relative one and the frame's, so that the gyroscopic forces become

    -Omega G (q' + r_x w_x + r_y w_y)

with r_x and r_y the rigid rotations of the whole shaft about x and y, deflections included. A rigid rotor of polar inertia I_p
then loads its bearings with I_p Omega (-w_y, w_x): the moment it exerts on the frame. What a vehicle's turn does to the
bearings of its turbine is the classical case: Friswell, Penny, Garvey & Lees, Dynamics of Rotating Machines (2010), chapter 3.

Slow: of second order in the rates, and left out, are centrifugal and Coriolis forces of the frame's rotation. The inertia of the
rotor against a change of the rates is not in it, either: its mass and its moments of inertia belong to the frame's, so that
two inertias are not coupled rigidly. Gravity keeps its direction in the frame. With constant rates nothing but the centrifugal
and Coriolis forces is missing, and the work on the frame is what the rotor loses: the gyroscopic forces do none in all.
"""

from __future__ import annotations

from ..core.component import Effect
from ..core.kernels import kernel
from ..core.linear import add_product
from ..core.variables import Causality, input_, output, parameter
from .model import DOFS
from .ports import STIFFNESS, Bearing
from .supports import LEVER, NODE, support_force

LOADS = tuple(
    f"bearing_{end}.{scalar.name}"
    for end in "ab"
    for v in Bearing.variables
    for scalar in v.scalars
    if v.causality is Causality.INPUT
)


class FrameRotation(Effect):
    """The frame that holds the bearings turns slowly: gyroscopic load on disks and shaft, moment on the frame."""

    requires = ("gyroscopic",)

    position = parameter(0.75, "m", "place along the shaft about which the moment is taken: where the frame's axes are")

    rate_x = input_(0.0, "rad/s", "rate at which the frame turns about x")
    rate_y = input_(0.0, "rad/s", "rate at which the frame turns about y")

    moment_x = output("N.m", "moment about x on the frame, of all supports and bearings", feedthrough=LOADS)
    moment_y = output("N.m", "moment about y on the frame, of all supports and bearings", feedthrough=LOADS)


@kernel
def turn_frame(nodes, gyroscopic, s, frame):
    """Numbers of a turning frame for the outputs and the load: `s.about`, `s.levers` and the levers in `s.supports`.

    nodes: (n,) m.  gyroscopic: (N, 15).  frame: values of the effect.  Whose nodes the supports and the ports hold is known.
    """
    N = DOFS * nodes.size
    rigid_x, rigid_y = s.room[0, :N], s.room[1, :N]
    rigid_x[:] = 0.0
    rigid_y[:] = 0.0
    for i in range(nodes.size):
        lever = nodes[i] - frame.position
        rigid_x[DOFS * i + 1], rigid_x[DOFS * i + 2] = -lever, 1.0
        rigid_y[DOFS * i], rigid_y[DOFS * i + 3] = lever, 1.0
    add_product(gyroscopic, rigid_x, s.about[0, :N])
    add_product(gyroscopic, rigid_y, s.about[1, :N])
    for i in range(s.supports.shape[0]):
        s.supports[i, LEVER] = nodes[int(s.supports[i, NODE]) // DOFS] - frame.position
    for i in range(s.ports.shape[0]):
        s.levers[i] = nodes[s.ports[i, 0]] - frame.position


@kernel
def add_frame_load(since, speed, s, frame, b):
    """Add the gyroscopic forces of the frame's rates at a time within the macro step to b, (N,)."""
    i, u = frame.u, s.u
    by_x = speed * (u[0, i] + since * (u[1, i] + since * u[2, i]))
    by_y = speed * (u[0, i + 1] + since * (u[1, i + 1] + since * u[2, i + 1]))
    for j in range(b.size):
        b[j] -= by_x * s.about[0, j] + by_y * s.about[1, j]


@kernel
def frame_outputs(s, frame, q, v):
    """Moment of supports and bearings on the frame: the opposite of theirs on the shaft."""
    about_x, about_y = 0.0, 0.0
    supports, ports, u = s.supports, s.ports, s.u
    for i in range(supports.shape[0]):
        about_x -= supports[i, LEVER] * support_force(supports[i], 1, q, v)
        about_y += supports[i, LEVER] * support_force(supports[i], 0, q, v)
    for i in range(ports.shape[0]):
        j, first = DOFS * ports[i, 0], ports[i, 1]
        for row in range(4):
            load = u[0, first + row]
            for column in range(4):
                place = first + STIFFNESS + 5 * (row + (row > 1)) + column + (column > 1)
                load -= u[0, place] * q[j + column] + u[0, place + 25] * v[j + column]
            if row == 0:
                about_y -= s.levers[i] * load
            elif row == 1:
                about_x += s.levers[i] * load
            elif row == 2:
                about_x -= load
            else:
                about_y -= load
    s.y[frame.y] = about_x
    s.y[frame.y + 1] = about_y
