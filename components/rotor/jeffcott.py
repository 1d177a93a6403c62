"""Jeffcott rotor: a disk in the middle of a massless shaft."""

from __future__ import annotations

import math
from typing import Any

from ..core.component import Effect
from ..core.high_order import SmoothComponent, smooth_kernels, stability_radius
from ..core.kernels import DONE, kernel
from ..core.spectrum import spectral_radius, step_within
from ..core.variables import input_, output, parameter
from .spin import TURN, RunUp, acceleration_at, angle_after, speed_at


class Unbalance(Effect):
    """Centre of mass beside the centre of the shaft."""

    eccentricity = parameter(1e-5, "m", "distance of the centre of mass from the shaft's centre", low=0.0)
    phase = parameter(0.0, "rad", "angle by which the centre of mass is ahead of the rotor's angle")


class InternalDamping(Effect):
    """Viscous damping in the turning shaft: -c (q' - Omega × q); it drives the rotor above an onset speed."""

    coefficient = parameter(10.0, "N.s/m", "damping coefficient in the turning frame", low=0.0)


class Gravity(Effect):
    """Weight, along -y."""

    acceleration = parameter(9.81, "m/s2", "acceleration of gravity")


class Orthotropy(Effect):
    """Supports of different stiffness along x and y: the critical speed splits, and the whirl is backward in between."""

    explicit_only = True

    ratio = parameter(1.2, "1", "stiffness along y over that along x", low=0.0)


class JeffcottRotor(SmoothComponent):
    """A disk of mass m in the middle of a massless elastic shaft, in its plane; x horizontal, y upwards.

        m x'' + c x' + k x = m e (w² cos phi + w' sin phi) + F_x
        m y'' + c y' + k y = m e (w² sin phi - w' cos phi) + F_y,    phi' = w

    The speed w is imposed. The force on the disk is an input: a bearing, a seal or a rub that answers its motion attaches there.
    Source: Jeffcott, Phil. Mag. 37 (1919) 304-314. Defaults are a choice of ours: 100 rad/s critical, 2 % damped.
    """

    title = "Jeffcott rotor"
    system = "rotor"
    default_stop = 2.0
    start_inputs = ("force_x", "force_y")

    unbalance = Unbalance
    internal_damping = InternalDamping
    gravity = Gravity
    orthotropy = Orthotropy
    run_up = RunUp

    mass = parameter(10.0, "kg", "mass of the disk", low=1e-9)
    stiffness = parameter(1e5, "N/m", "stiffness of the shaft at the disk", low=0.0)
    damping = parameter(40.0, "N.s/m", "external damping coefficient at the disk", low=0.0)
    start_speed = parameter(50.0, "rad/s", "speed of rotation at the start, positive from x to y")
    start_angle = parameter(0.0, "rad", "angle of the rotor at the start")
    substep = parameter(2e-4, "s", "longest internal step", low=1e-9, high=1.0)

    force_x = input_(0.0, "N", "force on the disk along x", nominal=10.0)
    force_y = input_(0.0, "N", "force on the disk along y", nominal=10.0)

    displacement_x = output("m", "displacement of the shaft's centre along x", nominal=1e-5)
    displacement_y = output("m", "displacement of the shaft's centre along y, upwards", nominal=1e-5)
    velocity_x = output("m/s", "velocity along x", nominal=1e-3)
    velocity_y = output("m/s", "velocity along y", nominal=1e-3)
    speed = output("rad/s", "speed of rotation", nominal=100.0)
    angle = output("rad", "angle of the rotor, in [0, 2 pi)")

    def states(self) -> int:
        """x, y, x', y', angle."""
        return 5

    def shapes(self) -> dict[str, Any]:
        """`matrix`: of the linear equations, and workspace."""
        return super().shapes() | {"matrix": (2, 4, 4)}

    def energy(self) -> float:
        """Energy of motion and of the shaft's bending, and of the height where there is gravity, J."""
        _, p, e = self.arguments
        x, y, vx, vy, _ = self.x
        ratio = e.orthotropy.ratio if e.orthotropy is not None else 1.0
        weight = p.mass * e.gravity.acceleration if e.gravity is not None else 0.0
        return 0.5 * (p.mass * (vx**2 + vy**2) + p.stiffness * (x**2 + ratio * y**2)) + weight * y


IN = JeffcottRotor.input_places()
OUT = JeffcottRotor.output_places()


@kernel
def jeffcott_start(t, s, p, e):
    """Equilibrium under the forces, or the straight shaft where nothing holds it."""
    x = s.x
    cross = e.internal_damping.coefficient * speed_at(t, p.start_speed, e.run_up) if e.internal_damping is not None else 0.0
    kx, ky = p.stiffness, p.stiffness * (e.orthotropy.ratio if e.orthotropy is not None else 1.0)
    fx, fy = s.u[0, IN.force_x], s.u[0, IN.force_y]
    if e.gravity is not None:
        fy -= p.mass * e.gravity.acceleration
    determinant = kx * ky + cross * cross
    if determinant > 0.0:
        x[0], x[1] = (ky * fx - cross * fy) / determinant, (kx * fy + cross * fx) / determinant
    x[4] = p.start_angle % TURN
    return DONE


@kernel
def jeffcott_stable(t, s, p, e):
    """Limit of the internal step, radius / max |eigenvalue|, at the highest speed."""
    c, cross = p.damping, 0.0
    if e.internal_damping is not None:
        fastest = abs(p.start_speed)
        if e.run_up is not None:
            fastest = max(fastest, abs(e.run_up.end_speed))
        c, cross = c + e.internal_damping.coefficient, e.internal_damping.coefficient * fastest
    ratio = e.orthotropy.ratio if e.orthotropy is not None else 1.0
    A = s.matrix[0]
    A[:] = 0.0
    A[0, 2], A[1, 3] = 1.0, 1.0
    A[2, 0], A[2, 1], A[2, 2] = -p.stiffness / p.mass, -cross / p.mass, -c / p.mass
    A[3, 0], A[3, 1], A[3, 3] = cross / p.mass, -ratio * p.stiffness / p.mass, -c / p.mass
    return step_within(stability_radius(e), spectral_radius(A, s.matrix[1]))


@kernel
def jeffcott_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = (x, y, x', y', angle)."""
    speed = speed_at(t, p.start_speed, e.run_up)
    fx = u[IN.force_x] - p.stiffness * x[0] - p.damping * x[2]
    if e.orthotropy is not None:
        fy = u[IN.force_y] - e.orthotropy.ratio * p.stiffness * x[1] - p.damping * x[3]
    else:
        fy = u[IN.force_y] - p.stiffness * x[1] - p.damping * x[3]
    if e.internal_damping is not None:
        fx -= e.internal_damping.coefficient * (x[2] + speed * x[1])
        fy -= e.internal_damping.coefficient * (x[3] - speed * x[0])
    if e.gravity is not None:
        fy -= p.mass * e.gravity.acceleration
    if e.unbalance is not None:
        moment, acceleration = p.mass * e.unbalance.eccentricity, acceleration_at(t, p.start_speed, e.run_up)
        cosine, sine = math.cos(x[4] + e.unbalance.phase), math.sin(x[4] + e.unbalance.phase)
        fx += moment * (speed * speed * cosine + acceleration * sine)
        fy += moment * (speed * speed * sine - acceleration * cosine)
    dx[0], dx[1] = x[2], x[3]
    dx[2], dx[3] = fx / p.mass, fy / p.mass
    dx[4] = speed


@kernel
def jeffcott_outputs(t, s, p, e):
    """Motion of the disk, speed and angle."""
    x, y = s.x, s.y
    y[OUT.displacement_x], y[OUT.displacement_y], y[OUT.velocity_x], y[OUT.velocity_y] = x[0], x[1], x[2], x[3]
    y[OUT.speed] = speed_at(t, p.start_speed, e.run_up)
    y[OUT.angle] = x[4]
    return DONE


_ode = smooth_kernels(
    __name__, start=jeffcott_start, derivatives=jeffcott_derivatives, outputs=jeffcott_outputs, stable=jeffcott_stable
)
_advance = _ode.step


@kernel
def jeffcott_step(t, h, s, p, e):
    """A step of the motion; the angle, whose rate is given, is exact at the end of every macro step, and wrapped."""
    angle = angle_after(s.x[4], t, h, p.start_speed, e.run_up)
    status = _advance(t, h, s, p, e)
    s.x[4] = angle
    s.y[OUT.angle] = angle
    return status


JeffcottRotor.kernels = _ode._replace(step=jeffcott_step, derivatives=None)
