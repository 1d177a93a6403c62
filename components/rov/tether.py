"""A tether: an elastic cable in water from a fixed end to a vehicle, lumped into nodes, that pulls and never pushes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..core.component import Effect, Preset
from ..core.contract import Refusal
from ..core.integrators import RK4_STABILITY_RADIUS, OdeComponent, ode_kernels
from ..core.kernels import DONE, OWN, kernel
from ..core.spectrum import fastest_rate, step_within
from ..core.variables import input_, integer, output, parameter
from .tether_statics import ROWS, WAY, hanging_chain

FASTEST = 2.0  # m/s through the water, up to which the stable step holds
NO_SHAPE = OWN + 1  # status


class InternalDamping(Effect):
    """A damper along each segment while it is taut; together with the spring it never pushes."""

    coefficient = parameter(100.0, "N.s/m", "damping coefficient of a segment", low=0.0)


class Drag(Effect):
    """Drag across and along each segment, half on either end: rho d l C |v| v / 2 with its own part of the velocity for each."""

    normal_coefficient = parameter(1.2, "1", "drag coefficient across the cable", low=0.0)
    tangential_coefficient = parameter(0.01, "1", "drag coefficient along the cable, on the same area", low=0.0)


class TetherCurrent(Effect):
    """Water that moves, the same along the whole cable."""

    requires = ("drag",)

    velocity_north = input_(0.0, "m/s", "velocity of the water to the north")
    velocity_east = input_(0.0, "m/s", "velocity of the water to the east")
    velocity_down = input_(0.0, "m/s", "velocity of the water downwards")


LOADS = (
    *(f"{what}_{way}" for what in ("position", "velocity") for way in ("north", "east", "down")),
    *(f"current.velocity_{way}" for way in ("north", "east", "down")),
)


class Tether(OdeComponent):
    """A cable of n equal segments; masses at the nodes between them; north, east, down; positive z is downwards.

        m x_i'' = T_i+1 - T_i + w l e_z + (D_i + D_i+1) / 2,    T = max(0, E A (L - l) / l [+ c L'])  while L > l, else 0

    w: weight in water per length. Half a segment's weight and drag act on the vehicle, and its inertia, like the added mass of
    the cable, is left out. The cable starts at rest in still water, whatever the current.
    Model: von Benzon et al., J. Mar. Sci. Eng. 10 (2022) 1898. The copy of it in the repository ViktorNfa/bluerov2_dynamics has
    no weight, calls the normal part tangential and the other way round, and its internal damping drives; its comments doubt
    the modulus.
    """

    title = "Tether of lumped masses"
    system = "rov"
    start_inputs = ("position_north", "position_east", "position_down")
    default_step = 0.01
    default_stop = 10.0

    internal_damping = InternalDamping
    drag = Drag
    current = TetherCurrent

    segments = integer(10, "number of segments", low=2, high=500, mesh="more")
    length = parameter(35.0, "m", "length without tension", low=1e-3)
    diameter = parameter(7.5e-3, "m", "diameter", low=1e-6)
    youngs_modulus = parameter(6.437e7, "Pa", "modulus of elasticity", low=1.0)
    mass_per_length = parameter(0.043, "kg/m", "mass per length", low=1e-6)
    water_density = parameter(1000.0, "kg/m3", "density of the water", low=0.0)
    gravity = parameter(9.81, "m/s2", "acceleration of gravity", low=0.0)
    anchor_north = parameter(-20.0, "m", "place of the fixed end, to the north; that it is 20 m off is a choice of ours")
    anchor_east = parameter(0.0, "m", "place of the fixed end, to the east")
    anchor_down = parameter(0.0, "m", "place of the fixed end, downwards")
    substep = parameter(5e-4, "s", "longest internal step", low=1e-9, high=1.0)

    position_north = input_(0.0, "m", "position of the vehicle's end to the north")
    position_east = input_(0.0, "m", "position of the vehicle's end to the east")
    position_down = input_(0.0, "m", "position of the vehicle's end downwards")
    velocity_north = input_(0.0, "m/s", "velocity of the vehicle's end to the north")
    velocity_east = input_(0.0, "m/s", "velocity of the vehicle's end to the east")
    velocity_down = input_(0.0, "m/s", "velocity of the vehicle's end downwards")

    force_north = output("N", "force on the vehicle to the north", nominal=10.0, feedthrough=LOADS)
    force_east = output("N", "force on the vehicle to the east", nominal=10.0, feedthrough=LOADS)
    force_down = output("N", "force on the vehicle downwards", nominal=10.0, feedthrough=LOADS)
    tension = output("N", "tension of the vehicle's segment", nominal=10.0, feedthrough=LOADS)
    anchor_tension = output("N", "tension of the segment at the fixed end", nominal=10.0)
    lowest = output("m", "depth of the lowest node, the vehicle's end apart", nominal=10.0)

    presets = {
        "von Benzon 2022": Preset(
            {
                "length": 35.0,
                "diameter": 7.5e-3,
                "youngs_modulus": 6.437e7,
                "mass_per_length": 0.043,
                "internal_damping.coefficient": 100.0,
                "drag.normal_coefficient": 1.2,
                "drag.tangential_coefficient": 0.01,
            },
            "von Benzon et al. (2022), as copied in the repository ViktorNfa/bluerov2_dynamics",
            "verbatim",
            ("internal_damping", "drag"),
        )
    }

    refusals = {
        NO_SHAPE: Refusal(
            "no shape at rest was found between the ends", "ends between which a tether can hang", "Move an end of the tether."
        )
    }

    def states(self) -> int:
        """Positions of the inner nodes, then their velocities, three each."""
        return 6 * (self.get("segments") - 1)

    def shapes(self) -> dict[str, Any]:
        """`chain`: see `Chain`.  `statics`: workspace of the shape at rest."""
        return super().shapes() | {"chain": Chain, "statics": (ROWS, 3)}

    def energy(self) -> float:
        """Energy of motion, of strain and of height, half of the outermost segments' weight at the ends included, J."""
        s, p, _ = self.arguments
        length, stiffness, mass, weight = s.chain
        x = self.x.reshape(2, -1, 3)
        ends = np.array([[p.anchor_north, p.anchor_east, p.anchor_down]]), self.u[:1, :3]
        points = np.concatenate((ends[0], x[0], ends[1]))
        strain = np.maximum(np.linalg.norm(np.diff(points, axis=0), axis=1) - length, 0.0)
        depth = x[0, :, 2].sum() + 0.5 * (points[0, 2] + points[-1, 2])
        return float(0.5 * mass * (x[1] ** 2).sum() + 0.5 * stiffness / length * (strain**2).sum() - weight * depth)


IN = Tether.input_places()
OUT = Tether.output_places()


class Chain:
    """The record `s.chain`: what the parameters determine."""

    length: float  # m, of a segment without tension
    stiffness: float  # N, tension per strain
    mass: float  # kg, of a node
    weight: float  # N, of a node in water, downwards


@kernel
def tether_start(t, s, p, e):
    """Nodes at rest between the present ends; no shape between them is refused."""
    n, c, x, way = p.segments, s.chain, s.x, s.statics[WAY]
    c.length, c.stiffness = p.length / n, p.youngs_modulus * 0.25 * math.pi * p.diameter**2
    c.mass = p.mass_per_length * p.length / n
    c.weight = (p.mass_per_length - p.water_density * 0.25 * math.pi * p.diameter**2) * p.gravity * p.length / n
    anchor = p.anchor_north, p.anchor_east, p.anchor_down
    for j in range(3):
        way[j] = s.u[0, j] - anchor[j]
    area = 0.25 * math.pi * p.diameter**2  # in another order than above: where it starts, bit for bit
    load = (p.mass_per_length - p.water_density * area) * p.gravity * c.length
    if hanging_chain(x, s.statics, n, c.length, p.youngs_modulus * area, load) != DONE:
        return NO_SHAPE
    for i in range(n - 1):
        for j in range(3):
            x[3 * i + j] = anchor[j] + x[3 * i + j]
    return DONE


@kernel
def tether_stable(t, s, p, e):
    """RK4's limit, radius / max |eigenvalue| of the taut cable, in water that moves across it at up to 2 m/s, s."""
    c, damping = s.chain, 0.0
    if e.internal_damping is not None:
        damping += 4.0 * e.internal_damping.coefficient
    if e.drag is not None:
        largest = max(e.drag.normal_coefficient, e.drag.tangential_coefficient)
        damping += p.water_density * p.diameter * c.length * largest * FASTEST
    return step_within(RK4_STABILITY_RADIUS, fastest_rate(c.mass, damping, 4.0 * c.stiffness / c.length))


@kernel
def place(k, n, x, u, p):
    """Position of node k of 0 (fixed) to n (vehicle), m."""
    if k == 0:
        return p.anchor_north, p.anchor_east, p.anchor_down
    if k == n:
        return u[IN.position_north], u[IN.position_east], u[IN.position_down]
    i = 3 * (k - 1)
    return x[i], x[i + 1], x[i + 2]


@kernel
def motion(k, n, x, u):
    """Velocity of node k, m/s."""
    if k == 0:
        return 0.0, 0.0, 0.0
    if k == n:
        return u[IN.velocity_north], u[IN.velocity_east], u[IN.velocity_down]
    i = 3 * (n - 1 + k - 1)
    return x[i], x[i + 1], x[i + 2]


@kernel
def segment_forces(k, x, u, c, p, e):
    """Of the segment from node k to node k + 1: its pull on node k, N, half of its drag, N, and the tension, N; c: `Chain`."""
    n = p.segments
    ax, ay, az = place(k, n, x, u, p)
    bx, by, bz = place(k + 1, n, x, u, p)
    rx, ry, rz = bx - ax, by - ay, bz - az
    long = math.sqrt(rx * rx + ry * ry + rz * rz)
    inverse = 1.0 / long if long > 0.0 else 0.0
    rx, ry, rz = rx * inverse, ry * inverse, rz * inverse
    tension = 0.0
    if long > c.length:
        tension = c.stiffness * (long / c.length - 1.0)
        if e.internal_damping is not None:
            ax, ay, az = motion(k, n, x, u)
            bx, by, bz = motion(k + 1, n, x, u)
            tension += e.internal_damping.coefficient * ((bx - ax) * rx + (by - ay) * ry + (bz - az) * rz)
            tension = max(tension, 0.0)
    dx, dy, dz = 0.0, 0.0, 0.0
    if e.drag is not None:
        ax, ay, az = motion(k, n, x, u)
        bx, by, bz = motion(k + 1, n, x, u)
        wx, wy, wz = -0.5 * (ax + bx), -0.5 * (ay + by), -0.5 * (az + bz)  # the water past the middle of the segment
        if e.current is not None:
            wx, wy, wz = wx + u[e.current.u], wy + u[e.current.u + 1], wz + u[e.current.u + 2]
        slip = wx * rx + wy * ry + wz * rz
        wx, wy, wz = wx - slip * rx, wy - slip * ry, wz - slip * rz
        half = 0.25 * p.water_density * p.diameter * c.length
        across = half * e.drag.normal_coefficient * math.sqrt(wx * wx + wy * wy + wz * wz)
        along = half * e.drag.tangential_coefficient * abs(slip) * slip
        dx, dy, dz = across * wx + along * rx, across * wy + along * ry, across * wz + along * rz
    return tension * rx, tension * ry, tension * rz, dx, dy, dz, tension


@kernel
def tether_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of the positions and velocities of the inner nodes."""
    n, c = p.segments, s.chain
    size = 3 * (n - 1)
    for i in range(n - 1):
        for j in range(3):
            dx[3 * i + j] = x[size + 3 * i + j]
            dx[size + 3 * i + j] = 0.0
        dx[size + 3 * i + 2] = c.weight
    for k in range(n):
        tx, ty, tz, ex, ey, ez, _ = segment_forces(k, x, u, c, p, e)
        if k > 0:
            i = size + 3 * (k - 1)
            dx[i] += tx + ex
            dx[i + 1] += ty + ey
            dx[i + 2] += tz + ez
        if k < n - 1:
            i = size + 3 * k
            dx[i] += ex - tx
            dx[i + 1] += ey - ty
            dx[i + 2] += ez - tz
    for i in range(size, 2 * size):
        dx[i] /= c.mass


@kernel
def tether_outputs(t, s, p, e):
    """Force on the vehicle, tensions at both ends, depth of the lowest node."""
    n, c, x, u, y = p.segments, s.chain, s.x, s.u[0], s.y
    y[OUT.anchor_tension] = segment_forces(0, x, u, c, p, e)[6]
    tx, ty, tz, ex, ey, ez, tension = segment_forces(n - 1, x, u, c, p, e)
    y[OUT.force_north], y[OUT.force_east], y[OUT.force_down], y[OUT.tension] = ex - tx, ey - ty, ez - tz + 0.5 * c.weight, tension
    y[OUT.lowest] = p.anchor_down
    for i in range(n - 1):
        y[OUT.lowest] = max(y[OUT.lowest], x[3 * i + 2])
    return DONE


Tether.kernels = ode_kernels(
    __name__, start=tether_start, derivatives=tether_derivatives, outputs=tether_outputs, stable=tether_stable
)
