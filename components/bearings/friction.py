"""Friction torque of a deep groove bearing: by a constant coefficient, or by load, speed and the viscosity of oil that warms.

    M = M_0 + M_1,  M_1 = f_1 P dm,
    M_0 = 1e-7 f_0 max(nu n, 2000)^(2/3) dm³     N.mm, with nu in mm²/s, n in rpm, dm in mm
    lg lg(nu + 0.7) = A - B lg T,  through nu at 40 and at 100 degrees Celsius

Sources: G. Palmgren, Ball and Roller Bearing Engineering (1959), as in T. A. Harris, Rolling Bearing Analysis, and ISO 15312; viscosity by
Walther's equation, ASTM D341. The sources round 2000^(2/3) = 158.7 to 160. Formulas and factors are unconfirmed: from memory.
"""

from __future__ import annotations

import math

from ..core.component import Effect
from ..core.kernels import kernel
from ..core.variables import input_, output, parameter
from .motion import EVERYTHING

LEAST = 2000.0  # nu n, mm²/s rpm, below which M_0 does not fall any more
COLD, HOT = 313.15, 373.15  # K, at which the viscosity is given


class Friction(Effect):
    """Torque 0.5 mu d P with the bore d and the resultant force P; mu from bearing catalogues, from memory."""

    coefficient = parameter(0.0015, "1", "mu", low=0.0)
    bore_diameter = parameter(0.035, "m", "diameter of the bore", low=1e-6)

    torque = output(
        "N.m", "torque on the shaft, against its speed; 0 at rest", feedthrough=(*EVERYTHING, "oil_friction.temperature")
    )
    power = output("W", "heat, torque times speed", feedthrough=(*EVERYTHING, "oil_friction.temperature"))


class OilFriction(Effect):
    """Friction by Palmgren: a part of the load, and a part of speed and viscosity, which follows the oil's temperature.

    Outside of some -20 to 150 degrees Celsius the equation of the viscosity is an extrapolation.
    """

    requires = ("friction",)
    replaces = ("friction.coefficient", "friction.bore_diameter")

    lubrication = parameter(2.0, "1", "factor f_0 of the lubrication: 2 in an oil bath, 1 with oil mist; from memory", low=0.0)
    load_factor = parameter(3e-4, "1", "factor f_1 of the load; below 0.001, from memory", low=0.0, nominal=1e-4)
    viscosity_40 = parameter(68e-6, "m2/s", "kinematic viscosity at 40 degrees Celsius; of ISO VG 68", low=1e-6, nominal=1e-5)
    viscosity_100 = parameter(
        8.7e-6, "m2/s", "kinematic viscosity at 100 degrees Celsius; mineral oil, from memory", low=1e-6, nominal=1e-5
    )

    temperature = input_(313.15, "K", "temperature of the oil", nominal=100.0)
    viscosity = output("m2/s", "kinematic viscosity", nominal=1e-4, feedthrough=(".temperature",))


@kernel
def kinematic_viscosity(temperature, cold, hot):
    """Walther's equation: m²/s at a temperature, K, from the viscosities at 40 and 100 degrees Celsius; NaN below 0 K."""
    if temperature <= 0.0:
        return math.nan
    high, low = math.log10(math.log10(1e6 * cold + 0.7)), math.log10(math.log10(1e6 * hot + 0.7))
    share = math.log10(temperature / COLD) / math.log10(HOT / COLD)
    return 1e-6 * (10.0**10.0 ** (high + (low - high) * share) - 0.7)


@kernel
def palmgren_torque(load, speed, pitch_diameter, viscosity, oil):
    """M, N.m, under a load, N, at a speed, rad/s; oil: the effect's values."""
    turning = max(1e6 * viscosity * abs(speed) * 30.0 / math.pi, LEAST)
    return (
        1e-10 * oil.lubrication * turning ** (2.0 / 3.0) * (1e3 * pitch_diameter) ** 3 + oil.load_factor * load * pitch_diameter
    )


@kernel
def put_friction(y, u, load, speed, pitch_diameter, friction, oil):
    """The outputs of both effects under a load, N; friction, oil: their values."""
    if oil is None:
        torque = 0.5 * friction.coefficient * friction.bore_diameter * load
    else:
        y[oil.y] = kinematic_viscosity(u[oil.u], oil.viscosity_40, oil.viscosity_100)
        torque = palmgren_torque(load, speed, pitch_diameter, y[oil.y], oil)
    y[friction.y] = -torque if speed > 0.0 else torque if speed < 0.0 else 0.0
    y[friction.y + 1] = torque * abs(speed)
