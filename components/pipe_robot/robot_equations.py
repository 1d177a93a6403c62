"""Equations of `PipeRobot`: forces, accelerations, energy. All kernels are scalar; SI units."""

from __future__ import annotations

import math

from ..core.kernels import kernel
from .contact import bristle_levels, bristle_rate
from .parts import spring_energy, spring_force

POSITION, VELOCITY, INNER, INNER_VELOCITY, CONTACT, PHASE, PHASE_RATE = range(7)


@kernel
def levels(u, p, bristles, route):
    """(forwards, backwards): kinetic friction, N, with the pipe's factor."""
    factor = u[route.u + 1] if route is not None else 1.0
    if bristles is not None:
        return bristle_levels(bristles, factor)
    return p.forward_friction * factor, p.backward_friction * factor


@kernel
def downhill(u, route):
    """Acceleration of gravity down the pipe, m/s²."""
    return route.acceleration * math.sin(u[route.u]) if route is not None else 0.0


@kernel
def prescribed_stretch(t, prescribed):
    """(way of the inner mass from the body, its rate, its acceleration) of the prescribed motion."""
    w, a = prescribed.frequency, prescribed.amplitude
    return a * math.sin(w * t), a * w * math.cos(w * t), -a * w * w * math.sin(w * t)


@kernel
def stretch_of(t, x, prescribed):
    """(way of the inner mass from the body, its rate)."""
    if prescribed is not None:
        way, rate, _ = prescribed_stretch(t, prescribed)
        return way, rate
    return x[INNER] - x[POSITION], x[INNER_VELOCITY] - x[VELOCITY]


@kernel
def drive_of(t, x, u, p, harmonic, prescribed, cubic, tow, route):
    """(force on the body without friction, mass that it moves); the inner mass belongs to it where its motion is prescribed."""
    drive = u[tow.u] if tow is not None else 0.0
    if prescribed is not None:
        _, _, acceleration = prescribed_stretch(t, prescribed)
        mass = p.body_mass + p.inner_mass
        return drive - mass * downhill(u, route) - p.inner_mass * acceleration, mass
    stretch, rate = stretch_of(t, x, prescribed)
    drive += spring_force(stretch, rate, p, cubic) - p.body_mass * downhill(u, route)
    if harmonic is not None:
        drive += u[harmonic.u] * math.sin(x[PHASE])
    return drive, p.body_mass


@kernel
def inner_accelerations(x, u, p, harmonic, unbalance, cubic, route):
    """(acceleration of the inner mass, of the unbalance's angle); not for a prescribed motion.

    With q = mass * radius of the unbalance, m the inner mass with it, and J its inertia about its shaft:

        m x'' + q cos(psi) psi'' = F + q sin(psi) psi'²,    q cos(psi) x'' + J psi'' = torque - damping psi' - q cos(psi) g
    """
    g = downhill(u, route)
    stretch, rate = x[INNER] - x[POSITION], x[INNER_VELOCITY] - x[VELOCITY]
    force = -spring_force(stretch, rate, p, cubic) - p.inner_mass * g
    if harmonic is not None:
        force -= u[harmonic.u] * math.sin(x[PHASE])
    if unbalance is not None:
        q, inertia = unbalance_of(unbalance)
        across = q * math.cos(x[PHASE])
        force += q * math.sin(x[PHASE]) * x[PHASE_RATE] ** 2
        torque = u[unbalance.u] - unbalance.damping * x[PHASE_RATE] - across * (g + force / p.inner_mass)
        angular = torque / (inertia - across * across / p.inner_mass)
        return (force - across * angular) / p.inner_mass, angular
    return force / p.inner_mass, 0.0


@kernel
def unbalance_of(unbalance):
    """(mass * radius in kg m, moment of inertia about the shaft in kg m²)."""
    q = unbalance.mass * unbalance.radius
    return q, unbalance.inertia + q * unbalance.radius


@kernel
def exciter_power(t, x, u, acceleration, p, harmonic, prescribed, unbalance, cubic, route):
    """Power that the exciter gives, W; acceleration: of the body."""
    stretch, rate = stretch_of(t, x, prescribed)
    if harmonic is not None:
        return -u[harmonic.u] * math.sin(x[PHASE]) * rate
    if prescribed is not None:
        _, _, relative = prescribed_stretch(t, prescribed)
        total = -p.inner_mass * (acceleration + relative + downhill(u, route))  # on the body, by spring, damper and exciter
        return -(total - spring_force(stretch, rate, p, cubic)) * rate
    if unbalance is not None:
        return u[unbalance.u] * x[PHASE_RATE]
    return 0.0


@kernel
def robot_energy(t, x, p, prescribed, unbalance, cubic, lugre):
    """Kinetic energy, energy of the spring and of LuGre's bristles, J."""
    stretch, rate = stretch_of(t, x, prescribed)
    inner = x[VELOCITY] + rate
    energy = 0.5 * (p.body_mass * x[VELOCITY] ** 2 + p.inner_mass * inner**2) + spring_energy(stretch, p, cubic)
    if unbalance is not None:
        q, inertia = unbalance_of(unbalance)
        energy += (q * math.cos(x[PHASE]) * inner + 0.5 * inertia * x[PHASE_RATE]) * x[PHASE_RATE]
    if lugre is not None:
        energy += 0.5 * lugre.stiffness * x[CONTACT] ** 2
    return energy


@kernel
def dissipated_power(t, x, friction, forward, backward, p, prescribed, unbalance, lugre):
    """Power lost in friction, damper and the unbalance's bearing, W; friction: against a positive velocity, N."""
    _, rate = stretch_of(t, x, prescribed)
    power = friction * x[VELOCITY] + p.damping * rate * rate
    if lugre is not None:  # what bends the bristles is not lost
        power -= lugre.stiffness * x[CONTACT] * bristle_rate(
            x[VELOCITY], x[CONTACT], forward, backward, p.static_ratio, lugre, p.substep)
    if unbalance is not None:
        power += unbalance.damping * x[PHASE_RATE] ** 2
    return power


@kernel
def weight_power(t, x, u, p, prescribed, unbalance, route):
    """Power that the weight gives, W, negative uphill."""
    _, rate = stretch_of(t, x, prescribed)
    momentum = p.body_mass * x[VELOCITY] + p.inner_mass * (x[VELOCITY] + rate)
    if unbalance is not None:
        momentum += unbalance.mass * unbalance.radius * math.cos(x[PHASE]) * x[PHASE_RATE]
    return -momentum * downhill(u, route)
