"""Exact solutions of wheels that slide on a sleeve: what simulations of them are compared with.

All are ours, from the planar law of Coulomb for two contacts of equal preload; none is published with the drive.
"""

import math

from cosimo.components.core.errors import BadInput
from cosimo.components.friction_drive.kinematics import LAYOUTS, ORTHOGONAL, SKEWED
from cosimo.components.friction_drive.sleeve import friction_level
from cosimo.components.friction_drive.wheels import FrictionWheels


def load_share(wheels: FrictionWheels, force: float, torque: float = 0.0) -> float:
    """Load over what both contacts can bear at most while they slide, 0 for none, 1 at the limit; force in N, torque in N.m.

    Plain wheels bear a circle of tractions each: together an ellipse of 2 mu N and 2 mu N r. With free rollers they bear a force
    in their directions only: a rhombus of 2 mu N cos a and 2 mu N r sin a for skewed ones, a rectangle for orthogonal ones.
    """
    p = wheels._parameters()[0]
    along, around = abs(force) / friction_level(p), abs(torque) / (p.sleeve_radius * friction_level(p))
    if p.layout == SKEWED:
        return 0.5 * math.hypot(along, around)
    if p.layout == ORTHOGONAL:
        return max(along, around)
    sine = math.sin(p.angle)
    if sine == 0.0 and around > 0.0:
        return math.inf
    return 0.5 * (along / math.cos(p.angle) + (around / sine if around > 0.0 else 0.0))


def loaded_feed(wheels: FrictionWheels, rate: float, force: float) -> tuple[float, float]:
    """(feed rate in m/s, power lost in W) of plain skewed wheels that both turn at `rate` and push against `force`.

    With f = force / (2 mu N): feed rate R w (cos a - sin a f / sqrt(1 - f²)), power 2 mu N R w sin a / sqrt(1 - f²). The wheels'
    slip around the sleeve, which cancels, turns their friction along it into a viscous one. At f = cos a the sleeve stands.
    """
    p = wheels._parameters()[0]
    if p.layout != SKEWED:
        raise BadInput(wheels.name, f"layout {LAYOUTS[p.layout]!r}", f"the layout {LAYOUTS[SKEWED]!r} for the speed under load")
    most = 2.0 * friction_level(p)
    share = force / most
    if abs(share) >= 1.0:
        raise BadInput(wheels.name, f"force = {force:g} N", f"less than {most:g} N, what both contacts bear")
    rim, root = p.wheel_radius * rate, math.sqrt(1.0 - share * share)
    return (rim * math.cos(p.angle) - abs(rim) * math.sin(p.angle) * share / root, most * abs(rim) * math.sin(p.angle) / root)
