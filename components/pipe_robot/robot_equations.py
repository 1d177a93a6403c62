"""Equations of `PipeRobot`, in part of `RollingPipeRobot`: forces, accelerations, energy. All kernels are scalar; SI units."""

from __future__ import annotations

import math

from ..core.kernels import kernel
from .contact import bristle_levels, bristle_rate
from .parts import spring_energy, spring_force

POSITION, VELOCITY, INNER, INNER_VELOCITY, CONTACT, PHASE, PHASE_RATE = range(7)


@kernel
def levels_at(factor, p, bristles):
    """(forwards, backwards): kinetic friction, N, at a factor on the friction."""
    if bristles is not None:
        return bristle_levels(bristles, factor)
    return p.forward_friction * factor, p.backward_friction * factor


@kernel
def levels(u, p, bristles, route):
    """(forwards, backwards): kinetic friction, N, with the pipe's factor."""
    return levels_at(u[route.u + 1] if route is not None else 1.0, p, bristles)


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
def harmonic_force(x, u, harmonic):
    """Force of the exciter on the body, N."""
    return u[harmonic.u] * math.sin(x[PHASE])


@kernel
def shaken_drive(x, u, p, harmonic, cubic, tow, route):
    """Force on the body without friction, N, where the inner mass moves as it is driven."""
    drive = u[tow.u] if tow is not None else 0.0
    stretch, rate = x[INNER] - x[POSITION], x[INNER_VELOCITY] - x[VELOCITY]
    drive += spring_force(stretch, rate, p, cubic) - p.body_mass * downhill(u, route)
    if harmonic is not None:
        drive += harmonic_force(x, u, harmonic)
    return drive


@kernel
def drive_of(t, x, u, p, e):
    """(force on the body without friction, mass that it moves); the inner mass belongs to it where its motion is prescribed."""
    if e.prescribed_motion is not None:
        drive = u[e.tow.u] if e.tow is not None else 0.0
        _, _, acceleration = prescribed_stretch(t, e.prescribed_motion)
        mass = p.body_mass + p.inner_mass
        return drive - mass * downhill(u, e.route) - p.inner_mass * acceleration, mass
    return shaken_drive(x, u, p, e.harmonic_force, e.cubic_spring, e.tow, e.route), p.body_mass


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
        force -= harmonic_force(x, u, harmonic)
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
def exciter_power(t, x, u, acceleration, p, e):
    """Power that the exciter gives, W; acceleration: of the body."""
    stretch, rate = stretch_of(t, x, e.prescribed_motion)
    if e.harmonic_force is not None:
        return -harmonic_force(x, u, e.harmonic_force) * rate
    if e.prescribed_motion is not None:
        _, _, relative = prescribed_stretch(t, e.prescribed_motion)
        total = -p.inner_mass * (acceleration + relative + downhill(u, e.route))  # on the body, by spring, damper and exciter
        return -(total - spring_force(stretch, rate, p, e.cubic_spring)) * rate
    if e.unbalance is not None:
        return u[e.unbalance.u] * x[PHASE_RATE]
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
def dissipated_power(t, x, friction, forward, backward, p, e):
    """Power lost in friction, damper and the unbalance's bearing, W; friction: against a positive velocity, N."""
    _, rate = stretch_of(t, x, e.prescribed_motion)
    power = friction * x[VELOCITY] + p.damping * rate * rate
    if e.lugre_friction is not None:  # what bends the bristles is not lost
        power -= (
            e.lugre_friction.stiffness
            * x[CONTACT]
            * bristle_rate(x[VELOCITY], x[CONTACT], forward, backward, p.static_ratio, e.lugre_friction, p.substep)
        )
    if e.unbalance is not None:
        power += e.unbalance.damping * x[PHASE_RATE] ** 2
    return power


@kernel
def weight_power(t, x, u, p, prescribed, unbalance, route):
    """Power that the weight gives, W, negative uphill."""
    _, rate = stretch_of(t, x, prescribed)
    momentum = p.body_mass * x[VELOCITY] + p.inner_mass * (x[VELOCITY] + rate)
    if unbalance is not None:
        momentum += unbalance.mass * unbalance.radius * math.cos(x[PHASE]) * x[PHASE_RATE]
    return -momentum * downhill(u, route)
