"""Kinematics of two wheels on a sleeve: directions, and the rates of wheels and sleeve without load.

Wheel k pulls the sleeve's surface in the direction t_k = (cos a_k, sin a_k): along the axis, and around it. By layout:

- skewed: a_1 = a, a_2 = -a, plain wheels. They slip across whenever the sleeve moves. At equal normal forces the unloaded sleeve
  may have any velocity between those of the two wheels' surfaces; its mean, which even wheels and symmetry give, stands here:
  feed rate R (w_1 + w_2) cos a / 2, surface rate R (w_1 - w_2) sin a / 2.
- skewed_free_rollers: the same directions, rollers on the wheels that turn freely across: t_k . v = R w_k, without slip.
- orthogonal: a_1 = 0, a_2 = 90 degrees, with free rollers; plain wheels would hold each other's motion.

The abstract of Frączak (2013) has wheels that move a sleeve in two degrees of freedom; the arrangements are ours.
"""

from __future__ import annotations

import math

from ..core.contract import Refusal
from ..core.kernels import DONE, OWN, kernel
from ..core.variables import Variable, choice

LAYOUTS = ("skewed", "skewed_free_rollers", "orthogonal")
SKEWED, FREE_ROLLERS, ORTHOGONAL = range(3)
ANGLE = math.pi / 6.0  # rad, of skewed wheels by default
WORST = 1e3  # condition of the map of rates, above which one degree of freedom counts as lost
IDLE_ANGLE, LOST_ROTATION, LOST_FEED = OWN + 1, OWN + 2, OWN + 3  # statuses
IDLE = {
    IDLE_ANGLE: Refusal(
        "angle = {angle} rad in the layout '{layout}'",
        "a layout of skewed wheels, or no angle",
        "Orthogonal wheels stand along the axis and across it.",
    )
}
LOST = {status: Refusal("angle = {angle} rad in the layout '{layout}'",
                        f"wheels that give feed and rotation, a condition number of at most {WORST:g}",
                        f"The {lost} is lost; take an angle well between 0 and {math.pi / 2:.4g} rad.")
        for status, lost in ((LOST_ROTATION, "rotation"), (LOST_FEED, "feed"))}  # fmt: skip


def layout_choice() -> Variable:
    """The parameter `layout`, the same for the wheels and for who commands them."""
    return choice("skewed", LAYOUTS, "how the wheels stand on the sleeve")


@kernel
def directions(layout, angle):
    """(cos a_1, sin a_1, cos a_2, sin a_2) of the two wheels' directions."""
    if layout == ORTHOGONAL:
        return 1.0, 0.0, 0.0, 1.0
    cosine, sine = math.cos(angle), math.sin(angle)
    return cosine, sine, cosine, -sine


@kernel
def sleeve_rates(first, second, layout, angle, wheel_radius, sleeve_radius):
    """(feed rate in m/s, rotation rate in rad/s) of a sleeve without load, for the wheels' rates in rad/s."""
    if layout == ORTHOGONAL:
        return wheel_radius * first, wheel_radius * second / sleeve_radius
    along, around = math.cos(angle), math.sin(angle)
    if layout == FREE_ROLLERS:
        along, around = 1.0 / along, 1.0 / around
    return (0.5 * wheel_radius * (first + second) * along, 0.5 * wheel_radius * (first - second) * around / sleeve_radius)


@kernel
def wheel_rates(feed_rate, rotation_rate, layout, angle, wheel_radius, sleeve_radius):
    """(first, second) rates of the wheels in rad/s that give a sleeve without load these rates: the inverse of `sleeve_rates`."""
    along, around = feed_rate / wheel_radius, sleeve_radius * rotation_rate / wheel_radius
    if layout == ORTHOGONAL:
        return along, around
    cosine, sine = math.cos(angle), math.sin(angle)
    if layout == FREE_ROLLERS:
        along, around = along * cosine, around * sine
    else:
        along, around = along / cosine, around / sine
    return along + around, along - around


@kernel
def condition(layout, angle):
    """Condition number of the map from the wheels' to the sleeve's surface rates: 1 / angle towards 0; 1 if orthogonal."""
    if layout == ORTHOGONAL:
        return 1.0
    sine, cosine = abs(math.sin(angle)), abs(math.cos(angle))
    small, large = min(sine, cosine), max(sine, cosine)
    return math.inf if small == 0.0 else large / small


@kernel
def idle_angle(layout, angle):
    """The status of an angle: refused where it is given to orthogonal wheels, which have none."""
    return IDLE_ANGLE if layout == ORTHOGONAL and angle != ANGLE else DONE


@kernel
def lost_motion(layout, angle):
    """The status of wheels for who has to command them: refused where they cannot give both degrees of freedom."""
    if condition(layout, angle) > WORST:
        return LOST_ROTATION if abs(math.sin(angle)) < abs(math.cos(angle)) else LOST_FEED
    return DONE
