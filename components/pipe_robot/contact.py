"""Friction between robot and pipe, with levels that differ forwards and backwards."""

from __future__ import annotations

import math

from ..core.component import Effect
from ..core.friction import directed_friction, directed_guard, directed_switch, lugre_force, lugre_rate, smoothed_friction
from ..core.kernels import kernel
from ..core.variables import parameter

LOCKED = 1e-6  # of the moment balance of a straight bristle, below which a bristle counts as locked
LEAST = 1e-9  # N, of a LuGre level, which is divided by


class Bristles(Effect):
    """Levels from inclined elastic bristles, instead of forward_friction and backward_friction.

    A bristle of length L at the angle theta to the pipe's axis, its tip trailing, is pressed on by a moment M0 at its root. The
    balance of moments about the root gives the force across the pipe, and with it the friction of all `count`:

        N = M0 / (L (cos theta ± mu sin theta)),    F = count mu N        (+ moving forwards, - backwards)

    From mu tan(theta) = 1 on it is locked: no force moves it backwards. It then bears 1e6 times the load of a straight leg.
    Own derivation; the paper speaks of elastic elements, and its abstract gives no law.
    """

    explicit_only = True

    count = parameter(8.0, "1", "number of bristles", low=0.0)
    length = parameter(0.03, "m", "length of a bristle", low=1e-9)
    angle = parameter(1.0472, "rad", "angle of a bristle to the pipe's axis", low=0.0, high=1.57)
    moment = parameter(0.019, "N.m", "moment of the preload at the root of a bristle", low=0.0)
    friction = parameter(0.3, "1", "coefficient of friction of a tip on the pipe", low=0.0)


class SmoothedFriction(Effect):
    """Friction as level * tanh(velocity / width): cheap, and it creeps where real friction would stick."""

    explicit_only = True

    excludes = ("lugre_friction",)
    width = parameter(5e-3, "m/s", "velocity over which the friction changes sign", low=1e-9)


class LuGreFriction(Effect):
    """Friction by elastic bristles in the sense of LuGre; their fastest relaxation is held to one per substep.

    Source: Canudas de Wit, Olsson, Åström, Lischinsky, IEEE Transactions on Automatic Control 40 (1995) 419-425; here with a
    level for each direction, which is ours.
    """

    explicit_only = True

    excludes = ("smoothed_friction",)
    stiffness = parameter(1e5, "N/m", "stiffness of the bristles", low=0.0)
    damping = parameter(316.2, "N.s/m", "damping of the bristles", low=0.0)
    stribeck_velocity = parameter(1e-3, "m/s", "velocity over which friction falls from static to kinetic", low=1e-9)


@kernel
def bristle_levels(bristles, factor):
    """(forwards, backwards), N, for a coefficient of friction that is `factor` times the given one."""
    mu = bristles.friction * factor
    straight = bristles.count * mu * bristles.moment / (bristles.length * math.cos(bristles.angle))
    lean = mu * math.tan(bristles.angle)
    return straight / (1.0 + lean), straight / max(1.0 - lean, LOCKED)


@kernel
def smoothed_directed(v, forward, backward, smoothed):
    """Friction against a positive velocity, N, by the level of its direction."""
    return smoothed_friction(v, forward if v > 0.0 else backward, smoothed.width)


@kernel
def bristle_rate(v, z, forward, backward, ratio, lugre, substep):
    """Rate of the LuGre bristles' deflection, m/s."""
    level = max(forward if v > 0.0 else backward, LEAST)
    return lugre_rate(v, z, lugre.stiffness, level, ratio * level, lugre.stribeck_velocity, 1.0 / substep)


@kernel
def friction_on_body(v, contact, drive, forward, backward, p, smoothed, lugre):
    """Friction against a positive velocity, N; contact: the mode, or LuGre's deflection."""
    if smoothed is not None:
        return smoothed_directed(v, forward, backward, smoothed)
    if lugre is not None:
        rate = bristle_rate(v, contact, forward, backward, p.static_ratio, lugre, p.substep)
        return lugre_force(v, contact, rate, lugre.stiffness, lugre.damping, 0.0)
    return directed_friction(contact, drive, forward, backward)


@kernel
def contact_guard(v, mode, drive, forward, backward, ratio):
    """Guard: positive while the mode lasts; `forward` and `backward` are kinetic levels, `ratio` leads to the static ones."""
    return directed_guard(mode, v, drive, ratio * forward, ratio * backward)


@kernel
def contact_switch(mode, drive, forward, backward, ratio):
    """The mode after one that has ended at velocity zero."""
    return directed_switch(mode, drive, ratio * forward, ratio * backward)


@kernel
def direction(v):
    """1, -1 or 0: the mode of friction that has none of its own."""
    return math.copysign(1.0, v) if v != 0.0 else 0.0
