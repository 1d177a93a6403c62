"""Power and torque coefficients of wind turbines over the tip speed ratio, for a blade pitch where the curve knows one.

A model turns with the torque coefficient: C_p / ratio is 0/0 at standstill. Below the ratio SLOW it keeps its value;
the exponential of the published curves has faded to less than 1e-8 there, so nothing but the 0/0 is taken away. Between
there and FAST a negative power coefficient counts as none; beyond FAST, where the fits say nothing (one of them grows again),
it is none throughout. The straight line of the farm windmill needs neither, and brakes a rotor that overruns the wind.
"""

from __future__ import annotations

import math

from ..core.kernels import kernel

BETZ = 16.0 / 27.0  # largest power coefficient
CURVES = ("farm", "heier", "simple", "variant")
FARM, HEIER, SIMPLE, VARIANT = range(4)
SLOW, FAST = 0.5, 100.0


@kernel
def power_fit(curve, ratio, pitch):
    """C_p of the exponential fits at a positive tip speed ratio and a pitch in degrees, 0 or more; may be negative.

    With 1/l = 1/(ratio + 0.08 pitch) - 0.035/(pitch³ + 1):

        heier    0.5176 (116/l - 0.4 pitch - 5) exp(-21/l) + 0.0068 ratio
        simple   0.5 (116/l - 0.4 pitch - 5) exp(-21/l)
        variant  0.22 (116/l - 0.4 pitch - 5) exp(-12.5/l)
    """
    inverse = 1.0 / (ratio + 0.08 * pitch) - 0.035 / (pitch * pitch * pitch + 1.0)
    lift = 116.0 * inverse - 0.4 * pitch - 5.0
    if curve == HEIER:
        return 0.5176 * lift * math.exp(-21.0 * inverse) + 0.0068 * ratio
    if curve == SIMPLE:
        return 0.5 * lift * math.exp(-21.0 * inverse)
    return 0.22 * lift * math.exp(-12.5 * inverse)


@kernel
def torque_coefficient(curve, ratio, pitch, standstill, runaway):
    """C_Q = C_p / ratio at any tip speed ratio, also 0 or negative, and a pitch in degrees.

    standstill, runaway: of the farm windmill, C_Q = standstill (1 - ratio / runaway).
    """
    if curve == FARM:
        return standstill * (1.0 - ratio / runaway)
    if ratio > FAST:
        return 0.0
    held = max(ratio, SLOW)
    return max(power_fit(curve, held, max(pitch, 0.0)), 0.0) / held
