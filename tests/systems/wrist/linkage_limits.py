"""Where parts of a four-bar linkage turn back, by the law of cosines."""

import math

from cosimo.components.wrist.linkage import SAME


def rocker_extremes(crank: float, coupler: float, rocker: float, ground: float) -> tuple[float, float]:
    """Angles between rocker and ground, rad, at which the rocker of a crank-rocker turns back: crank and coupler in one line."""
    pair = []
    for reach in (coupler - crank, coupler + crank):
        pair.append(math.acos((rocker**2 + ground**2 - reach**2) / (2.0 * rocker * ground)))
    return pair[0], pair[1]


def transmission_extremes(crank: float, coupler: float, rocker: float, ground: float) -> tuple[float, float]:
    """Smallest and largest transmission angle over a turn of the crank, rad; the crank lies along the ground at both."""
    pair = []
    for diagonal in (abs(ground - crank), ground + crank):
        pair.append(math.acos((coupler**2 + rocker**2 - diagonal**2) / (2.0 * coupler * rocker)))
    return pair[0], pair[1]


def crank_limits(crank: float, coupler: float, rocker: float, ground: float) -> tuple[float, float] | None:
    """Crank angles, rad within 0 to pi, between which it moves (and in the mirror image); None for a crank that goes round.

    At a limit inside, coupler and rocker are in one line: toggle.
    """
    low = (crank**2 + ground**2 - (coupler - rocker) ** 2) / (2.0 * crank * ground)
    high = (crank**2 + ground**2 - (coupler + rocker) ** 2) / (2.0 * crank * ground)
    if low >= 1.0 - SAME and high <= -1.0 + SAME:
        return None
    return math.acos(min(low, 1.0)), math.acos(max(high, -1.0))
