"""The sleeve under two wheels: effects and equations that the wheels' unit and the whole drive have in common.

State: feed, rotation, their rates; with bristles, exact stick or rolling creep the deflections of both contacts and, with exact
stick, their modes; with friction of the trocar the seal's deflection and mode. What else a unit holds stands behind. First number of a pair
is along the axis, second around it; the surface of the sleeve is taken as a plane.

All tractions are laws at full preload times the share of it that is left: a contact without preload bears nothing.
"""

from __future__ import annotations

import math
from collections.abc import Collection

from ..core.component import Effect
from ..core.friction import (
    SLIDES,
    lugre_level,
    planar_lugre_rate,
    planar_stick_deflection,
    planar_stick_guard,
    planar_stick_rate,
    planar_stick_switch,
    smoothed_planar,
)
from ..core.kernels import kernel
from ..core.variables import flag, parameter
from .kinematics import SKEWED, directions

FEED, ROTATION, FEED_RATE, ROTATION_RATE, DEFLECTIONS = range(5)
MODES = DEFLECTIONS + 4  # with exact stick
GUARDS = 3  # two contacts and the seal


class SmoothedSlip(Effect):
    """Friction that grows with the slip as the parameter `creep` has it, and ends at the level: level * tanh(creep |s| / level).

    The cheapest law; under a load that should stand the sleeve creeps.
    """

    excludes = ("lugre_slip", "exact_slip", "rolling_slip")


class LuGreSlip(Effect):
    """Friction by elastic bristles in the plane of contact (LuGre); their fastest relaxation is held to one per substep."""

    excludes = ("smoothed_slip", "exact_slip", "rolling_slip")
    static_ratio = parameter(1.2, "1", "static over kinetic friction", low=1.0)
    stiffness = parameter(6e4, "N/m", "stiffness of the bristles of a contact at full preload", low=0.0, nominal=1e4)
    damping = parameter(60.0, "N.s/m", "damping of the bristles of a contact at full preload", low=0.0, nominal=10.0)
    viscous = parameter(0.4, "N.s/m", "viscous friction of a contact at full preload", low=0.0)
    stribeck_rate = parameter(5e-3, "m/s", "slip over which friction falls from static to kinetic", low=1e-9)


class ExactSlip(Effect):
    """Friction that holds: a contact at rest is an elastic one, and slides from the static level on, found as an event.

    Rigid contacts would leave the tractions of two wheels at rest open; the elastic ones share a load by their deflections.
    """

    excludes = ("smoothed_slip", "lugre_slip", "rolling_slip")
    static_ratio = parameter(1.2, "1", "static over kinetic friction", low=1.0)
    deflection = parameter(1e-4, "m", "elastic deflection at the kinetic level", low=1e-9, nominal=1e-4)
    damping_time = parameter(1e-3, "s", "damping over stiffness of the contact", low=0.0, nominal=1e-3)

    first_stuck = flag("1 while the first contact holds, 0 while it slides")
    second_stuck = flag("1 while the second contact holds, 0 while it slides")


class RollingSlip(Effect):
    """Creep of elastic contacts that roll: the wheel's turning carries their deflection out, at its speed V over the length.

        z' = s - |V| z / length,    Q = -friction * normal_force (1 - (1 - |z| / Z)^power) z / |z|,    Z = full_slip * length

    At a load the slip over the rolling speed, the creepage, is constant; from `full_slip` on all of the contact slides. A wheel
    that stands holds. power 2: rollers in line contact, full_slip = friction * half-width (1 / R + 1 / r) (Carter 1926). power 3:
    points of contact, full_slip = 3 friction * normal_force / (G a b C) with Kalker's C (Vermeulen and Johnson 1964; Shen, Hedrick
    and Elkins 1983). Both from memory; the defaults are a choice of ours for a rubber tread.
    """

    excludes = ("smoothed_slip", "lugre_slip", "exact_slip")
    full_slip = parameter(0.05, "1", "slip over rolling speed from which on all of the contact slides", low=1e-6, nominal=0.01)
    length = parameter(
        2e-3, "m", "length over which a deflection is carried out, about that of the contact", low=1e-4, nominal=1e-3
    )
    power = parameter(2.0, "1", "2 for rollers in line contact (Carter), 3 for points of contact (Kalker)", low=1.0, high=4.0)
    damping_time = parameter(1e-3, "s", "damping over stiffness of the contact", low=0.0, nominal=1e-3)


class TrocarFriction(Effect):
    """Friction of the trocar's seal on the sleeve, in the direction of its motion; it holds as `exact_slip` does."""

    level = parameter(2.0, "N", "kinetic friction of the seal", low=0.0)
    static_ratio = parameter(1.3, "1", "static over kinetic friction", low=1.0)
    deflection = parameter(5e-4, "m", "elastic deflection of the seal at the kinetic level", low=1e-9, nominal=1e-4)
    damping_time = parameter(1e-3, "s", "damping over stiffness of the seal", low=0.0, nominal=1e-3)

    stuck = flag("1 while the seal holds the sleeve, 0 while it slides")


class Gravity(Effect):
    """Weight of the sleeve along its axis."""

    acceleration = parameter(9.81, "m/s2", "acceleration of gravity", low=0.0, nominal=10.0)
    inclination = parameter(0.5, "rad", "angle by which the feed rises above the horizontal")


class PreloadLoss(Effect):
    """Wheels lose a share of their normal force, over a time, smoothly."""

    explicit_only = True

    start = parameter(0.5, "s", "instant at which the loss begins")
    duration = parameter(0.05, "s", "time that the loss takes", low=1e-6)
    first = parameter(1.0, "1", "share of its preload that the first wheel loses", low=0.0, high=1.0)
    second = parameter(0.0, "1", "share of its preload that the second wheel loses", low=0.0, high=1.0)


@kernel
def preload_share(k, t, loss):
    """Share of its preload that contact k has at t."""
    if loss is None:
        return 1.0
    passed = min(max((t - loss.start) / loss.duration, 0.0), 1.0)
    return 1.0 - (loss.first if k == 0 else loss.second) * passed * passed * (3.0 - 2.0 * passed)


@kernel
def slip(k, x, rate, p):
    """Slip of the sleeve on wheel k that turns at `rate`, m/s; with free rollers along the wheel's direction only."""
    c1, s1, c2, s2 = directions(p.layout, p.angle)
    c, s = (c1, s1) if k == 0 else (c2, s2)
    sx, sy = x[FEED_RATE] - p.wheel_radius * rate * c, p.sleeve_radius * x[ROTATION_RATE] - p.wheel_radius * rate * s
    if p.layout != SKEWED:
        along = sx * c + sy * s
        return along * c, along * s
    return sx, sy


@kernel
def friction_level(p):
    """Kinetic friction of a contact at full preload, N."""
    return p.friction * p.normal_force


@kernel
def rolling_rate(sx, sy, zx, zy, speed, rolling, fastest):
    """Rate of the deflection of a contact that rolls at a speed; beyond a full deflection it goes back as fast as steps allow."""
    full, length = rolling.full_slip * rolling.length, math.hypot(zx, zy)
    leaving = abs(speed) / rolling.length
    if length > full:
        leaving += fastest * (1.0 - full / length)
    return sx - leaving * zx, sy - leaving * zy


@kernel
def rolling_share(zx, zy, rolling):
    """Share of the friction that a deflection bears, over its length, 1/m."""
    full = rolling.full_slip * rolling.length
    if zx == 0.0 and zy == 0.0:
        return rolling.power / full
    length = math.hypot(zx, zy)
    if length >= full:
        return 1.0 / length
    return (1.0 - (1.0 - length / full) ** rolling.power) / length


@kernel
def deflection_rate(k, x, rate, sx, sy, p, e):
    """Rate of the deflection of contact k with a wheel that turns at `rate`; zero for laws without one."""
    if e.rolling_slip is not None:
        z = DEFLECTIONS + 2 * k
        return rolling_rate(sx, sy, x[z], x[z + 1], p.wheel_radius * rate, e.rolling_slip, 1.0 / p.substep)
    if e.lugre_slip is not None:
        lugre, kinetic, z = e.lugre_slip, friction_level(p), DEFLECTIONS + 2 * k
        level = lugre_level(math.hypot(sx, sy), kinetic, lugre.static_ratio * kinetic, lugre.stribeck_rate)
        return planar_lugre_rate(sx, sy, x[z], x[z + 1], lugre.stiffness, level, 1.0 / p.substep)
    if e.exact_slip is not None:
        z = DEFLECTIONS + 2 * k
        return planar_stick_rate(x[MODES + k], sx, sy, x[z], x[z + 1], 1.0 / p.substep)
    return 0.0, 0.0


@kernel
def traction(k, t, x, rate, sx, sy, p, e):
    """Force of wheel k, which turns at `rate`, on the sleeve, N."""
    share = preload_share(k, t, e.preload_loss)
    if e.smoothed_slip is not None:
        fx, fy = smoothed_planar(sx, sy, friction_level(p), p.creep)
        return -share * fx, -share * fy
    rx, ry = deflection_rate(k, x, rate, sx, sy, p, e)
    if e.lugre_slip is not None:
        lugre, z = e.lugre_slip, DEFLECTIONS + 2 * k
        return (
            -share * (lugre.stiffness * x[z] + lugre.damping * rx + lugre.viscous * sx),
            -share * (lugre.stiffness * x[z + 1] + lugre.damping * ry + lugre.viscous * sy),
        )
    if e.rolling_slip is not None:
        rolling, z, level = e.rolling_slip, DEFLECTIONS + 2 * k, share * friction_level(p)
        bearing = level * rolling_share(x[z], x[z + 1], rolling)
        damping = level * rolling.power / (rolling.full_slip * rolling.length) * rolling.damping_time
        return -bearing * x[z] - damping * rx, -bearing * x[z + 1] - damping * ry
    if e.exact_slip is not None:
        exact, z = e.exact_slip, DEFLECTIONS + 2 * k
        stiffness = share * friction_level(p) / exact.deflection
        zx, zy = planar_stick_deflection(x[MODES + k], x[z], x[z + 1], exact.deflection)
        return -stiffness * (zx + exact.damping_time * rx), -stiffness * (zy + exact.damping_time * ry)
    return -share * p.creep * sx, -share * p.creep * sy


@kernel
def contacts(t, x, first, second, p, e):
    """Slips and tractions of both contacts, along and around: (slip 1, slip 2, traction 1, traction 2), eight numbers."""
    ax, ay = slip(0, x, first, p)
    bx, by = slip(1, x, second, p)
    qx, qy = traction(0, t, x, first, ax, ay, p, e)
    rx, ry = traction(1, t, x, second, bx, by, p, e)
    return ax, ay, bx, by, qx, qy, rx, ry


@kernel
def wheel_loads(qx, qy, rx, ry, p):
    """Loads of both wheels for their tractions, N.m, against a positive rate."""
    c1, s1, c2, s2 = directions(p.layout, p.angle)
    return p.wheel_radius * (qx * c1 + qy * s1), p.wheel_radius * (rx * c2 + ry * s2)


@kernel
def seal_place(lugre, exact, rolling):
    """Place of the seal's deflection in the state."""
    if lugre is not None or rolling is not None:
        return DEFLECTIONS + 4
    if exact is not None:
        return DEFLECTIONS + 6
    return DEFLECTIONS


@kernel
def seal_rate(x, p, lugre, exact, rolling):
    """Rate of the seal's deflection."""
    z = seal_place(lugre, exact, rolling)
    return planar_stick_rate(x[z + 2], x[FEED_RATE], p.sleeve_radius * x[ROTATION_RATE], x[z], x[z + 1], 1.0 / p.substep)


@kernel
def sleeve_derivatives(t, x, first, second, external, dx, p, e):
    """dx/dt of the sleeve's part of the state for the wheels' rates; returns the loads of the wheels, N.m.

    external: (force, torque) on the sleeve, N and N.m.
    """
    dx[FEED], dx[ROTATION] = x[FEED_RATE], x[ROTATION_RATE]
    ax, ay, bx, by, qx, qy, rx, ry = contacts(t, x, first, second, p, e)
    force, torque = external
    along, around = qx + rx + force, qy + ry + torque / p.sleeve_radius
    if e.lugre_slip is not None or e.exact_slip is not None or e.rolling_slip is not None:
        dx[DEFLECTIONS], dx[DEFLECTIONS + 1] = deflection_rate(0, x, first, ax, ay, p, e)
        dx[DEFLECTIONS + 2], dx[DEFLECTIONS + 3] = deflection_rate(1, x, second, bx, by, p, e)
    if e.exact_slip is not None:
        dx[MODES] = dx[MODES + 1] = 0.0
    if e.trocar_friction is not None:
        z, stiffness = (
            seal_place(e.lugre_slip, e.exact_slip, e.rolling_slip),
            e.trocar_friction.level / e.trocar_friction.deflection,
        )
        dx[z], dx[z + 1] = seal_rate(x, p, e.lugre_slip, e.exact_slip, e.rolling_slip)
        dx[z + 2] = 0.0
        zx, zy = planar_stick_deflection(x[z + 2], x[z], x[z + 1], e.trocar_friction.deflection)
        along -= stiffness * (zx + e.trocar_friction.damping_time * dx[z])
        around -= stiffness * (zy + e.trocar_friction.damping_time * dx[z + 1])
    if e.gravity is not None:
        along -= p.mass * e.gravity.acceleration * math.sin(e.gravity.inclination)
    dx[FEED_RATE] = along / p.mass
    dx[ROTATION_RATE] = p.sleeve_radius * around / p.inertia
    return wheel_loads(qx, qy, rx, ry, p)


@kernel
def sleeve_guards(x, first, second, g, p, lugre, exact, rolling, trocar):
    """Guards: positive while the modes of both contacts and the seal last; absent modes last for ever."""
    g[0] = g[1] = g[2] = 1.0
    if exact is not None:
        breakaway = exact.static_ratio * exact.deflection
        ax, ay = slip(0, x, first, p)
        bx, by = slip(1, x, second, p)
        z = DEFLECTIONS
        g[0] = planar_stick_guard(x[MODES], ax, ay, x[z], x[z + 1], breakaway)
        g[1] = planar_stick_guard(x[MODES + 1], bx, by, x[z + 2], x[z + 3], breakaway)
    if trocar is not None and trocar.level > 0.0:
        z = seal_place(lugre, exact, rolling)
        g[2] = planar_stick_guard(
            x[z + 2], x[FEED_RATE], p.sleeve_radius * x[ROTATION_RATE], x[z], x[z + 1], trocar.static_ratio * trocar.deflection
        )


@kernel
def sleeve_switch(which, x, lugre, exact, rolling, trocar):
    """A contact or the seal breaks loose, or comes to rest."""
    if exact is not None and which < 2:
        m, z = MODES + which, DEFLECTIONS + 2 * which
        x[m], x[z], x[z + 1] = planar_stick_switch(x[m], x[z], x[z + 1], exact.deflection)
    if trocar is not None and which == 2:
        z = seal_place(lugre, exact, rolling)
        x[z + 2], x[z], x[z + 1] = planar_stick_switch(x[z + 2], x[z], x[z + 1], trocar.deflection)


@kernel
def rolling_store(length, rolling):
    """Twice the energy of a deflection over the friction level, m: the integral of the share that it bears."""
    full, more = rolling.full_slip * rolling.length, rolling.power + 1.0
    left = (1.0 - length / full) ** more if length < full else 0.0
    return 2.0 * (length - full / more * (1.0 - left))


@kernel
def sleeve_energy(t, x, p, e):
    """Kinetic energy of the sleeve, its energy of height above feed zero, and that of the deflections, J."""
    twice = p.mass * x[FEED_RATE] * x[FEED_RATE] + p.inertia * x[ROTATION_RATE] * x[ROTATION_RATE]
    for k in range(2):
        z, share = DEFLECTIONS + 2 * k, preload_share(k, t, e.preload_loss)
        if e.lugre_slip is not None:
            twice += share * e.lugre_slip.stiffness * (x[z] * x[z] + x[z + 1] * x[z + 1])
        if e.rolling_slip is not None:
            twice += share * friction_level(p) * rolling_store(math.hypot(x[z], x[z + 1]), e.rolling_slip)
        if e.exact_slip is not None:
            twice += share * friction_level(p) / e.exact_slip.deflection * (x[z] * x[z] + x[z + 1] * x[z + 1])
    if e.trocar_friction is not None:
        z = seal_place(e.lugre_slip, e.exact_slip, e.rolling_slip)
        twice += e.trocar_friction.level / e.trocar_friction.deflection * (x[z] * x[z] + x[z + 1] * x[z + 1])
    energy = 0.5 * twice
    if e.gravity is not None:
        energy += p.mass * e.gravity.acceleration * math.sin(e.gravity.inclination) * x[FEED]
    return energy


@kernel
def contact_outputs(t, x, first, second, y, at, p, e):
    """Slips and tractions of both contacts, margin and power of the contacts into y[at:]; returns the loads of the wheels."""
    ax, ay, bx, by, qx, qy, rx, ry = contacts(t, x, first, second, p, e)
    y[at], y[at + 1], y[at + 2], y[at + 3] = ax, ay, bx, by
    y[at + 4], y[at + 5], y[at + 6], y[at + 7] = qx, qy, rx, ry
    y[at + 8] = min(
        free_share(math.hypot(qx, qy), preload_share(0, t, e.preload_loss) * friction_level(p)),
        free_share(math.hypot(rx, ry), preload_share(1, t, e.preload_loss) * friction_level(p)),
    )
    y[at + 9] = -(qx * ax + qy * ay + rx * bx + ry * by)
    return wheel_loads(qx, qy, rx, ry, p)


@kernel
def stuck_outputs(x, y, lugre, exact, rolling, trocar):
    """Which contacts hold, and whether the seal does."""
    if exact is not None:
        y[exact.y], y[exact.y + 1] = 1.0 if x[MODES] != SLIDES else 0.0, 1.0 if x[MODES + 1] != SLIDES else 0.0
    if trocar is not None:
        y[trocar.y] = 1.0 if x[seal_place(lugre, exact, rolling) + 2] != SLIDES else 0.0


@kernel
def free_share(force, level):
    """Share of the kinetic friction that a traction leaves; 0 where there is none."""
    return 1.0 - force / level if level > 0.0 else 0.0


def sleeve_states(on: Collection[str]) -> int:
    """Number of the sleeve's states where these effects are on."""
    contact = 6 if "exact_slip" in on else 4 if {"lugre_slip", "rolling_slip"} & {*on} else 0
    return DEFLECTIONS + contact + (3 if "trocar_friction" in on else 0)


@kernel
def sleeve_start(x, p):
    """The sleeve's part of the state at the start: contacts and seal, which are zero, are relaxed and at rest."""
    x[FEED], x[ROTATION] = p.start_feed, p.start_rotation
    x[FEED_RATE], x[ROTATION_RATE] = p.start_feed_rate, p.start_rotation_rate
