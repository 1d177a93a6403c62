"""Dry friction in one place: smoothed, with bristles (LuGre), and with exact standstill.

All kernels are scalar and know no component: `v` is the rate at which two surfaces slide, in m/s or rad/s, and levels and
results are forces in N or torques in N.m to match. A friction that is positive acts against a positive rate.

- Smoothed: the cheapest. Surfaces under a constant load creep; nothing ever rests.
- LuGre: elastic bristles hold the surfaces at rest, but for their own vibration; one state z per contact.
- Exact: two levels, kinetic while sliding and static at rest, and a mode: 1 or -1, the direction of sliding, or 0, at rest.
  The mode lies in the component's state: `stick_mode` at the start, `stick_guard` for the event finder, `stick_switch` at events.
  Surfaces at rest bear HOLDS times the static level, so that a drive of just that level is not undone by its rounding.
"""

from __future__ import annotations

import math

from .kernels import kernel

HOLDS = 1.0 + 1e-9


@kernel
def smoothed_friction(v, level, width):
    """level * tanh(v / width): 76 % of the level at the width, 99.5 % at three times it."""
    return level * math.tanh(v / width)


@kernel
def lugre_level(v, kinetic, static, stribeck):
    """Friction at constant rate without its viscous part: from static at rest to kinetic, over the Stribeck rate."""
    ratio = v / stribeck
    return kinetic + (static - kinetic) * math.exp(-ratio * ratio)


@kernel
def lugre_rate(v, z, stiffness, kinetic, static, stribeck, fastest):
    """Rate of the bristles' deflection z: v - stiffness |v| z / level (Canudas de Wit and others, IEEE TAC 40, 1995, 419-425).

    The deflection relaxes with stiffness |v| / level, 1/s, which grows with the rate without bound. It is kept to `fastest`,
    1/s: what an explicit method of step h follows is 1 / h. Where it holds back, the friction at constant rate stays what it
    was, and only the few microns of sliding that it takes to get there become longer.
    """
    relaxation = stiffness * abs(v) / lugre_level(v, kinetic, static, stribeck)
    rate = v - relaxation * z
    if relaxation > fastest:
        rate *= fastest / relaxation
    return rate


@kernel
def lugre_force(v, z, rate, stiffness, damping, viscous):
    """Friction of bristles that are deflected by z and follow at the given rate: spring, dashpot, and viscous part."""
    return stiffness * z + damping * rate + viscous * v


@kernel
def stick_mode(v, drive, static):
    """Mode for a rate and the drive, the force that sets the surfaces in motion, friction apart: 1, -1, or 0 for rest.

    Without friction, at static 0, nothing is ever at rest, and the mode says nothing.
    """
    if v > 0.0 or (v == 0.0 and drive > HOLDS * static) or static == 0.0:
        return 1.0
    if v < 0.0 or (v == 0.0 and drive < -HOLDS * static):
        return -1.0
    return 0.0


@kernel
def stick_guard(mode, v, drive, static):
    """Positive while the mode holds: the rate in its direction, or at rest what is missing to break loose."""
    if static == 0.0:
        return 1.0
    if mode == 0.0:
        return HOLDS * static - abs(drive)
    return mode * v


@kernel
def stick_switch(mode, drive, static):
    """Mode after one that has ended, at rate zero: from rest into the direction of the drive, from sliding as `stick_mode`.

    A rest that has ended is left even where the drive is at the very level: else the event would call for itself for ever.
    """
    if mode == 0.0:
        return math.copysign(1.0, drive)
    return stick_mode(0.0, drive, static)


@kernel
def stick_friction(mode, drive, kinetic):
    """Friction in a mode: the kinetic level while sliding; at rest the force that balances the drive."""
    if mode == 0.0:
        return drive
    return mode * kinetic


# -- exact, with levels that differ in the two directions --------------------------------------------------------------
@kernel
def directed_mode(v, drive, forward, backward):
    """`stick_mode` where the static level is `forward` against motion to the positive side, `backward` to the negative one."""
    if v > 0.0 or (v == 0.0 and drive > HOLDS * forward):
        return 1.0
    if v < 0.0 or (v == 0.0 and drive < -HOLDS * backward):
        return -1.0
    return 0.0


@kernel
def directed_guard(mode, v, drive, forward, backward):
    """`stick_guard` for two static levels; levels that fall to zero let go."""
    if mode == 0.0:
        return min(HOLDS * forward - drive, HOLDS * backward + drive)
    return mode * v


@kernel
def directed_switch(mode, drive, forward, backward):
    """`stick_switch` for two static levels: from rest into the direction of whichever level has been passed.

    Without friction a motion that has ended goes on backwards: a rest would end at once, and where the drive is zero, too, in no
    direction.
    """
    if mode == 0.0:
        return 1.0 if forward - drive < backward + drive else -1.0
    if forward == 0.0 and backward == 0.0:
        return -mode
    return directed_mode(0.0, drive, forward, backward)


@kernel
def directed_friction(mode, drive, forward, backward):
    """Friction in a mode, against a positive rate, for two kinetic levels; at rest the force that balances the drive."""
    if mode == 0.0:
        return drive
    return forward if mode > 0.0 else -backward


# In the plane of contact: slip s and deflection z are vectors (x, y), and friction acts against the slip, whatever its direction.
SLIDES = 1.0  # the mode of a planar contact that slides; 0, at rest, as above


@kernel
def smoothed_planar(sx, sy, level, damping):
    """(x, y) of level * tanh(damping |s| / level) in the direction of the slip: damping * s where the slip is small."""
    slip = math.hypot(sx, sy)
    share = damping * slip
    if share == 0.0 or level == 0.0:
        return 0.0, 0.0
    share = level * math.tanh(share / level) / slip
    return share * sx, share * sy


@kernel
def planar_lugre_rate(sx, sy, zx, zy, stiffness, level, fastest):
    """Rate of the bristles' deflection in the plane, s - stiffness |s| z / level, kept to `fastest` as `lugre_rate` is.

    level: `lugre_level` of |s|.
    """
    relaxation = stiffness * math.hypot(sx, sy) / level
    rx, ry = sx - relaxation * zx, sy - relaxation * zy
    if relaxation > fastest:
        rx *= fastest / relaxation
        ry *= fastest / relaxation
    return rx, ry


@kernel
def planar_stick_rate(mode, sx, sy, zx, zy, fastest):
    """Rate of the deflection of a contact that holds elastically and slides: all of the slip at rest; else its direction only.

    While the contact slides, the deflection keeps its length and turns into the direction of the slip, within a path of that
    length, though no faster than `fastest`, 1/s. So two contacts that stick share a load as their stiffness has it, where
    rigid ones would leave it open, and nothing creeps: at rest the deflection is a function of the place alone.
    """
    if mode != SLIDES:
        return sx, sy
    squared = zx * zx + zy * zy
    if squared == 0.0:
        return 0.0, 0.0
    along = (sx * zx + sy * zy) / squared
    rx, ry = sx - along * zx, sy - along * zy
    relaxation = math.sqrt((sx * sx + sy * sy) / squared)
    if relaxation > fastest:
        rx *= fastest / relaxation
        ry *= fastest / relaxation
    return rx, ry


@kernel
def planar_stick_deflection(mode, zx, zy, sliding):
    """The deflection that bears: at rest as it is, while sliding at the length of a contact that slides."""
    length = math.hypot(zx, zy)
    if mode != SLIDES or length == 0.0:
        return zx, zy
    return sliding / length * zx, sliding / length * zy


@kernel
def planar_stick_guard(mode, sx, sy, zx, zy, breakaway):
    """Positive while the mode holds: what is missing of the deflection that breaks loose, or the slip along the deflection."""
    length = math.hypot(zx, zy)
    if mode != SLIDES:
        return HOLDS * breakaway - length
    return (sx * zx + sy * zy) / length if length > 0.0 else 0.0


@kernel
def planar_stick_switch(mode, zx, zy, sliding):
    """(mode, zx, zy) after a mode has ended: the other one, at the deflection of a contact that slides."""
    zx, zy = planar_stick_deflection(SLIDES, zx, zy, sliding)
    return SLIDES - mode, zx, zy
