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

from typing import NamedTuple

import numpy as np

from ..core.banded import add_product
from ..core.component import Effect
from ..core.kernels import kernel, kernel_tuple
from ..core.variables import Causality, input_, output, parameter
from .model import DOFS
from .ports import STIFFNESS, Bearing

LOADS = tuple(f"bearing_{end}.{scalar.name}" for end in "ab" for v in Bearing.variables for scalar in v.scalars
              if v.causality is Causality.INPUT)


class FrameRotation(Effect):
    """The frame that holds the bearings turns slowly: gyroscopic load on disks and shaft, moment on the frame."""

    requires = ("gyroscopic",)

    position = parameter(0.75, "m", "place along the shaft about which the moment is taken: where the frame's axes are")

    rate_x = input_(0.0, "rad/s", "rate at which the frame turns about x")
    rate_y = input_(0.0, "rad/s", "rate at which the frame turns about y")

    moment_x = output("N.m", "moment about x on the frame, of all supports and bearings", feedthrough=LOADS)
    moment_y = output("N.m", "moment about y on the frame, of all supports and bearings", feedthrough=LOADS)


@kernel_tuple
class Frame(NamedTuple):
    """What the kernels need of a frame that turns."""

    u: int  # positions of rate_x and moment_x
    y: int
    about_x: np.ndarray  # (N,) gyroscopic force per speed and rate, G r_x
    about_y: np.ndarray
    supports: np.ndarray  # (k, 6) first degree of freedom, lever in m, stiffness and damping along x and y
    levers: np.ndarray  # (ports,) m


def turning_frame(values, gyroscopic: np.ndarray, nodes: np.ndarray, supports: np.ndarray, ports: np.ndarray) -> Frame:
    """The frame of a rotor with these nodes, (n,) m.

    values: values of the effect.  gyroscopic: (N, 15).  supports: (k, 5) node, stiffness and damping along x and y.
    ports: (k, 3) node, first input, first output.
    """
    levers = nodes - values.position
    rigid_x, rigid_y, about_x, about_y = np.zeros((4, DOFS * nodes.size))
    rigid_x[1::DOFS], rigid_x[2::DOFS] = -levers, 1.0
    rigid_y[0::DOFS], rigid_y[3::DOFS] = levers, 1.0
    add_product(gyroscopic, rigid_x, about_x)
    add_product(gyroscopic, rigid_y, about_y)
    at = supports[:, 0].astype(int)
    held = np.column_stack((DOFS * at, levers[at], supports[:, 1:]))
    return Frame(values.u, values.y, about_x, about_y, held, levers[ports[:, 0]])


@kernel
def add_frame_load(s, speed, frame, u, b):
    """Add the gyroscopic forces of the frame's rates at time s of the macro step to b, (N,)."""
    i = frame.u
    by_x = speed * (u[0, i] + s * (u[1, i] + s * u[2, i]))
    by_y = speed * (u[0, i + 1] + s * (u[1, i + 1] + s * u[2, i + 1]))
    for j in range(b.size):
        b[j] -= by_x * frame.about_x[j] + by_y * frame.about_y[j]


@kernel
def frame_outputs(frame, ports, q, v, u, y):
    """Moment of supports and bearings on the frame: the opposite of theirs on the shaft."""
    about_x, about_y = 0.0, 0.0
    for i in range(frame.supports.shape[0]):
        j, lever = int(frame.supports[i, 0]), frame.supports[i, 1]
        about_x -= lever * (frame.supports[i, 3] * q[j + 1] + frame.supports[i, 5] * v[j + 1])
        about_y += lever * (frame.supports[i, 2] * q[j] + frame.supports[i, 4] * v[j])
    for i in range(ports.shape[0]):
        j, first = DOFS * ports[i, 0], ports[i, 1]
        for row in range(4):
            load = u[0, first + row]
            for column in range(4):
                place = first + STIFFNESS + 5 * (row + (row > 1)) + column + (column > 1)
                load -= u[0, place] * q[j + column] + u[0, place + 25] * v[j + column]
            if row == 0:
                about_y -= frame.levers[i] * load
            elif row == 1:
                about_x += frame.levers[i] * load
            elif row == 2:
                about_x -= load
            else:
                about_y -= load
    y[frame.y] = about_x
    y[frame.y + 1] = about_y
