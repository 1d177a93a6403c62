"""Rating life of a deep groove bearing under the present loads of its balls, and its factors for lubrication and reliability.

    Q_ci = C / (0.407 Z) (1 + g^(10/3))^0.3,  Q_ce = C / (0.389 Z) (1 + g^(-10/3))^0.3,
    g = 1.044 ((1 - γ) / (1 + γ))^1.72 (r_i / r_e (2 r_e - D) / (2 r_i - D))^0.41
    1 / L_10r = ((Q_ei / Q_ci)^(10/3) + (Q_ee / Q_ce)^(10/3))^0.9,  P = C / L_10r^(1/3)

Q_ei is the mean of the balls' loads with the exponent 3 on the ring that turns under the load, Q_ee that with 10/3 on the ring that
stands under it; L_10r in 10^6 revolutions. The life of a run with loads that change is that of Miner's sum: the mean of the rate.
Source: ISO/TS 16281:2008, equations 19 to 29, as the public code minzhun/ISO16281 writes them; case `iso16281` compares with a commercial
program. The factor a_ISO is that of ISO 281:2007 for radial ball bearings; its numbers are unconfirmed: from memory and from public code.
Public code has 0.019087 for the exponent 0.19087 of the middle range, with which the curve would jump by a factor.
"""

from __future__ import annotations

import math

from ..core.component import Effect
from ..core.kernels import kernel
from ..core.variables import choice, output, parameter
from .motion import EVERYTHING

TURNING_LOADS = ("standing", "turning")
TURNING = 1
INNER_SHARE, OUTER_SHARE, GROOVE = 0.407, 0.389, 1.044
WEIBULL = 10.0 / 9.0  # slope of the distribution of lives of contacts at points
MOST = 50.0  # of a_ISO
REVOLUTIONS = 1e6  # of a rating life of 1


class RatingLife(Effect):
    """How fast the bearing's rating life passes: reference rating life after ISO/TS 16281 by the present loads of the balls.

    The life in hours, at 90 % reliability, is 1 / (3600 mean rate). It counts fatigue alone, of a bearing whose rings do not slip.
    """

    load_rating = parameter(
        25.5e3, "N", "basic dynamic radial load rating C, from the bearing's data sheet", low=1.0, nominal=1e4
    )
    load = choice(
        "standing", TURNING_LOADS, "whether the load stands still, or turns with the shaft as that of an unbalance does"
    )

    equivalent_load = output("N", "equivalent reference load P: the life is (C / P)³", nominal=100.0, feedthrough=EVERYTHING)
    rate = output("1/s", "share of the rating life that passes in a second", nominal=1e-8, feedthrough=EVERYTHING)


class LifeFactor(Effect):
    """The rate of life with a_1 for reliability and a_ISO for lubrication and contamination, ISO 281:2007; at most 50."""

    requires = ("rating_life",)

    viscosity_ratio = parameter(1.0, "1", "kappa, viscosity of the oil over the one that is needed", low=0.1, high=4.0)
    contamination = parameter(0.5, "1", "e_C, 1 for clean, towards 0 for heavily contaminated oil", low=0.0, high=1.0)
    fatigue_load_limit = parameter(1.1e3, "N", "C_u, from the bearing's data sheet", low=0.0, nominal=1e3)
    reliability = parameter(1.0, "1", "a_1, 1 for 90 %", low=1e-3, high=1.0)

    a_iso = output("1", "factor for lubrication and contamination", feedthrough=EVERYTHING)


@kernel
def ring_ratings(balls, gamma, inner_conformity, outer_conformity, rating):
    """Loads of a ball, N, at which each ring has a rating life of 1: inner, outer. Conformities: groove radius over ball diameter."""
    grooves = inner_conformity / outer_conformity * (2.0 * outer_conformity - 1.0) / (2.0 * inner_conformity - 1.0)
    g = (GROOVE * ((1.0 - gamma) / (1.0 + gamma)) ** 1.72 * grooves**0.41) ** (3.0 * WEIBULL)
    inner = rating / (INNER_SHARE * balls) * (1.0 + g) ** 0.3
    return inner, rating / (OUTER_SHARE * balls) * (1.0 + 1.0 / g) ** 0.3


@kernel
def life_share(inner_loads, outer_loads, inner, outer, turning):
    """1 / L_10r of the balls' loads at both rings, (Z,) N. inner, outer: of `ring_ratings`. turning: the load, with the shaft."""
    on_inner, on_outer = ring_load(inner_loads, not turning), ring_load(outer_loads, turning)
    return ((on_inner / inner) ** (3.0 * WEIBULL) + (on_outer / outer) ** (3.0 * WEIBULL)) ** (1.0 / WEIBULL)


@kernel
def ring_load(loads, rolled):
    """Mean of the balls' loads, (Z,) N, on a ring; rolled: whether the ring turns under the load."""
    total, exponent = 0.0, 3.0 if rolled else 3.0 * WEIBULL
    for j in range(loads.size):
        if loads[j] > 0.0:
            total += loads[j] ** exponent
    return (total / loads.size) ** (1.0 / exponent)


@kernel
def lubrication_factor(kappa, contamination, limit, load):
    """a_ISO of a radial ball bearing with a fatigue load limit, N, under an equivalent load, N."""
    if load <= 0.0:
        return MOST
    factor, exponent = 1.9987, 0.071739
    if kappa < 0.4:
        factor, exponent = 2.2649, 0.054381
    elif kappa < 1.0:
        exponent = 0.19087
    left = 1.0 - (2.5671 - factor / kappa**exponent) ** 0.83 * (contamination * limit / load) ** (1.0 / 3.0)
    if left <= (10.0 * MOST) ** (-1.0 / 9.3):
        return MOST
    return 0.1 * left**-9.3


@kernel
def put_life(y, inner_loads, outer_loads, speed, k, rating, factor):
    """The outputs of both effects; loads: (Z,) N, at each ring. k: `Constants` with the rings' ratings. rating, factor: of the effects."""
    share = life_share(inner_loads, outer_loads, k.inner_rating, k.outer_rating, rating.load == TURNING)
    equivalent = rating.load_rating * share ** (1.0 / 3.0)
    rate = abs(speed) / (2.0 * math.pi) * share / REVOLUTIONS
    if factor is not None:
        y[factor.y] = lubrication_factor(factor.viscosity_ratio, factor.contamination, factor.fatigue_load_limit, equivalent)
        rate /= factor.reliability * y[factor.y]
    y[rating.y], y[rating.y + 1] = equivalent, rate
