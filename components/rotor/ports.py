"""Ports where bearings attach: the rotor gives motion, the bearing gives its load as a straight line in that motion.

    F(q, q') = F_0 - K q - C q'

F_0, K and C are inputs: the tangent of the bearing's load at its last motion, and where that tangent meets zero motion. Within
a macro step the rotor solves with this line, so that a stiff bearing is as good as a spring in the rotor itself, however
long the step; the bearing need not pass directional derivatives. What the master extrapolates in time are F_0, K and C,
which change as balls pass and as the line follows a curved law: the motion itself is counted once. In the first sweeps of a
master each initialization is a step of Newton's method. With K = C = 0 and F_0 the load this is plain force coupling.

Measured: a rotor of 0.6 m with a disk of 8 kg at 500 rad/s on two deep groove bearings with damping d = 25 us * stiffness,
substep 10 us; largest error of the journals' motion over its range, after the start, for macro steps in us.

    diametral clearance 10 um                 20      50     100     200     500    1000
    tangent, bearings first, linear       0.10 %  0.26 %  0.92 %     9 %    70 %   110 %
    tangent, jacobi, held                 0.46 %   1.0 %   2.7 %     8 %    49 %   110 %
    tangent, jacobi, linear               0.16 %   1.1 %   8.4 %  unstable from here on
    force, jacobi or sequential, linear   0.37 %  unstable from here on
    force, jacobi, held                    7.1 %  unstable from here on
    preload of 10 um
    tangent, bearings first, linear         5e-6    5e-6    6e-6    8e-6    2e-5    2e-4
    tangent, jacobi, linear                 5e-6    5e-6    6e-6    2e-5    3e-4    1e-3
    force, jacobi, linear                   84 %  unstable from here on

Where balls lose contact the macro step must resolve their passing, here 3.5 ms from ball to ball; where they do not, it need
not even do that. Plain coupling with held forces is stable below 2 d/k (measured for a linear spring-damper of 1e8 N/m
and d/k = 10 us: up to 1.0 times that, not at 1.1), without damping never; it also needs a spectral radius below 1 (0.8 above).
With a linear bearing the tangent coupling has no limit: 1e9 N/m at steps of 2 ms give the motion of supports in the rotor.
"""

from __future__ import annotations

from ..core.component import Effect
from ..core.kernels import kernel
from ..core.variables import input_, output, parameter

STIFFNESS = 4  # position of a port's tangent behind its first input; the damping follows it


class Bearing(Effect):
    """A port for a bearing, or anything else that answers the shaft's motion with a force and a moment.

    Stiffness and damping are -d(force, moment)/d(x, y, z, tilt_x, tilt_y) and by their rates, row by row; force and moment
    are those of the linearised bearing at zero displacement and velocity. Where a bearing has no tangent to offer, they are
    what it gives now. The rotor has no axial motion: what belongs to z does not count.
    """

    either_in = ("initialize",)

    position = parameter(0.0, "m", "place of the bearing on the shaft", low=0.0)

    force_x = input_(0.0, "N", "force on the shaft along x at zero motion", nominal=100.0)
    force_y = input_(0.0, "N", "force on the shaft along y at zero motion", nominal=100.0)
    moment_x = input_(0.0, "N.m", "moment on the shaft about x at zero motion")
    moment_y = input_(0.0, "N.m", "moment on the shaft about y at zero motion")
    stiffness = input_(0.0, "1", "tangent by displacement, N/m for the translations, N.m/rad for the tilts", size=25, nominal=1e7)
    damping = input_(0.0, "1", "tangent by velocity, N.s/m for the translations, N.m.s/rad for the tilts", size=25, nominal=1e3)

    displacement_x = output("m", "displacement along x", nominal=1e-5)
    displacement_y = output("m", "displacement along y, upwards", nominal=1e-5)
    tilt_x = output("rad", "rotation of the section about x", nominal=1e-5)
    tilt_y = output("rad", "rotation of the section about y", nominal=1e-5)
    velocity_x = output("m/s", "velocity along x", nominal=1e-2)
    velocity_y = output("m/s", "velocity along y", nominal=1e-2)
    tilt_rate_x = output("rad/s", "rate of tilt_x", nominal=1e-2)
    tilt_rate_y = output("rad/s", "rate of tilt_y", nominal=1e-2)
    speed = output("rad/s", "speed of the shaft", nominal=100.0)


@kernel
def follow_tangents(since, ports, u, tangents):
    """The ports' tangents at a time, s, within the macro step; True if they differ from the former content.

    ports: (k, 3) node, first input, first output.  u: (3, m).  tangents: (k, 2, 4, 4) result: stiffness and damping for the
    order x, y, tilt_x, tilt_y.
    """
    changed = False
    for i in range(ports.shape[0]):
        for term in range(2):
            first = ports[i, 1] + STIFFNESS + 25 * term
            for row in range(4):
                for column in range(4):
                    j = first + 5 * (row + (row > 1)) + column + (column > 1)  # without the row and the column of z
                    value = u[0, j] + since * (u[1, j] + since * u[2, j])
                    if tangents[i, term, row, column] != value:
                        tangents[i, term, row, column] = value
                        changed = True
    return changed


@kernel
def add_loads(since, ports, u, b):
    """Add the ports' loads at zero motion at a time within the macro step to b, (N,)."""
    for i in range(ports.shape[0]):
        j, first = 4 * ports[i, 0], ports[i, 1]
        for row in range(4):
            b[j + row] += u[0, first + row] + since * (u[1, first + row] + since * u[2, first + row])


@kernel
def add_tangents(ports, tangents, stiffness_share, damping_share, band):
    """Add shares of the ports' stiffness and damping to a band."""
    half = band.shape[1] // 2
    for i in range(ports.shape[0]):
        j = 4 * ports[i, 0]
        for row in range(4):
            for k in range(4):
                band[j + row, half + k - row] += stiffness_share * tangents[i, 0, row, k] + damping_share * tangents[i, 1, row, k]


@kernel
def port_outputs(ports, q, v, speed, y):
    """Motion of the shaft at the ports."""
    for i in range(ports.shape[0]):
        j, first = 4 * ports[i, 0], ports[i, 2]
        for k in range(4):
            y[first + k] = q[j + k]
            y[first + 4 + k] = v[j + k]
        y[first + 8] = speed
