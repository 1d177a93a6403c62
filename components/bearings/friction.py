"""Friction torque of a deep groove bearing: by a constant coefficient, or by load, speed and the viscosity of oil that warms.

Palmgren's and, as `skf_friction`, that of SKF's catalogues:

    M = M_0 + M_1,  M_1 = f_1 P dm,
    M_0 = 1e-7 f_0 max(nu n, 2000)^(2/3) dm³     N.mm, with nu in mm²/s, n in rpm, dm in mm
    lg lg(nu + 0.7) = A - B lg T,  through nu at 40 and at 100 degrees Celsius

Sources: G. Palmgren, Ball and Roller Bearing Engineering (1959), as in T. A. Harris, Rolling Bearing Analysis, and ISO 15312; viscosity by
Walther's equation, ASTM D341. The sources round 2000^(2/3) = 158.7 to 160. Formulas and factors are unconfirmed: from memory.

    M = phi_ish phi_rs G_rr (nu n)^0.6 + G_sl mu_sl                                  N.mm, with N, mm, mm²/s, rpm
    G_rr = R_1 dm^1.96 (F_r + R_2 / sin a F_a)^0.54,  G_sl = S_1 dm^-0.145 (F_r^5 + S_2 dm^1.5 / sin a F_a^4)^(1/3)
    a = 24.6 (F_a / C_0)^0.24 degrees;  without F_a: G_sl = S_1 dm^-0.26 F_r^(5/3)
    mu_sl = phi_bl mu_bl + (1 - phi_bl) mu_EHL,  phi_bl = exp(-2.6e-8 (nu n)^1.4 dm)
    phi_ish = 1 / (1 + 1.84e-9 (n dm)^1.28 nu^0.64),  phi_rs = exp(-K_rs nu n (d + D) (K_z / (2 (D - d)))^0.5)

Source: SKF, Rolling bearings, pages 104 and 105, read in a public copy: G, mu_sl, phi_bl, factors of friction; R and S of the series 60, 62
and 63 read in public code; phi_ish, phi_rs and K_z = 3.1 are from memory. dm is the catalogue's mean diameter, (d + D) / 2, of a 6205
1.4 % less than the diameter of the balls' circle. Seals and the drag of a deep oil bath are left out. The angle a is 90 degrees at
F_a = 222 C_0; beyond it, where the sine would fall again, there is no number. What SKF advises is noted, not refused: F_a up to 0.5 C_0,
0.25 C_0 of bores up to 12 mm and of the diameter series 8, 9, 0 and 1 (www.skf.com, deep groove ball bearings, loads: read), and a load
of at least, from memory,

    F_rm = k_r (nu n / 1000)^(2/3) (dm / 100)^2                                       kN, with mm²/s, rpm, mm
"""

from __future__ import annotations

import math

from ..core.component import Effect
from ..core.kernels import kernel
from ..core.variables import input_, output, parameter
from .motion import EVERYTHING

LEAST = 2000.0  # nu n, mm²/s rpm, below which M_0 does not fall any more
AXIAL = 1e-6  # of the radial load, from which on an axial one counts
CAGE = 3.1  # K_z of deep groove bearings of one row
UPRIGHT = (90.0 / 24.6) ** (1.0 / 0.24)  # F_a / C_0 with which a is 90 degrees
SMALL_BORE, SMALL_SHARE = 0.012, 0.25  # m, up to which F_a is to be at most this share of C_0
COLDEST, HOTTEST = 203.15, 643.15  # K, -70 and 370 degrees Celsius, the range of ASTM D341; from memory
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

    Outside of some -20 to 150 degrees Celsius the equation of the viscosity is an extrapolation; outside of -70 to 370 it is refused.
    """

    requires = ("friction",)
    replaces = ("friction.coefficient", "friction.bore_diameter")

    lubrication = parameter(2.0, "1", "factor f_0 of the lubrication: 2 in an oil bath, 1 with oil mist; from memory", low=0.0)
    load_factor = parameter(3e-4, "1", "factor f_1 of the load; below 0.001, from memory", low=0.0, nominal=1e-4)
    viscosity_40 = parameter(
        68e-6, "m2/s", "kinematic viscosity at 40 degrees Celsius; of ISO VG 68", low=1e-6, high=0.1, nominal=1e-5
    )
    viscosity_100 = parameter(
        8.7e-6, "m2/s", "kinematic viscosity at 100 degrees Celsius; mineral oil, from memory", low=1e-6, high=0.1, nominal=1e-5
    )

    temperature = input_(313.15, "K", "temperature of the oil", nominal=100.0)
    viscosity = output("m2/s", "kinematic viscosity", nominal=1e-4, feedthrough=(".temperature",))


class SkfFriction(Effect):
    """Friction as SKF's catalogues have it since 2003, in the place of Palmgren's: rolling, with its film starved and heated, and sliding.

    As there, the sliding part falls or rises by a factor where an axial load begins.
    """

    requires = ("oil_friction",)
    replaces = ("oil_friction.lubrication", "oil_friction.load_factor")
    restores = ("friction.bore_diameter",)

    rolling = parameter(3.9e-7, "1", "R_1; 4.1e-7 of the series 60, 3.9e-7 of 62, 3.7e-7 of 63", low=0.0, nominal=1e-7)
    rolling_thrust = parameter(1.7, "1", "R_2", low=0.0)
    sliding = parameter(3.23e-3, "1", "S_1; 3.73e-3 of the series 60, 3.23e-3 of 62, 2.84e-3 of 63", low=0.0, nominal=1e-3)
    sliding_thrust = parameter(36.5, "1", "S_2; 14.6 of the series 60, 36.5 of 62, 92.8 of 63", low=0.0, nominal=10.0)
    static_rating = parameter(15.3e3, "N", "basic static load rating C_0, from the bearing's data sheet", low=1.0, nominal=1e4)
    outside_diameter = parameter(0.072, "m", "D, from the data sheet; the bore is friction.bore_diameter", low=1e-6, nominal=0.1)
    boundary = parameter(0.15, "1", "mu_bl, sliding without a film", low=0.0)
    full_film = parameter(0.05, "1", "mu_EHL, sliding on a full film: 0.05 mineral oil, 0.04 synthetic", low=0.0)
    starvation = parameter(
        3e-8, "1", "K_rs: 3e-8 low oil bath and oil jet, 6e-8 grease and oil-air; from memory", low=0.0, nominal=1e-8
    )
    axial_share = parameter(
        0.5, "1", "largest axial load over C_0 that is advised: 0.25 of the diameter series 8, 9, 0 and 1", low=0.0
    )
    minimum_factor = parameter(
        0.025, "1", "k_r of the least load, from product tables; of 62 about 0.025, from memory; 0: none", low=0.0, nominal=0.01
    )


@kernel
def kinematic_viscosity(temperature, cold, hot):
    """Walther's equation: m²/s at a temperature above 0 K, from the viscosities at 40 and 100 degrees Celsius."""
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
def skf_torque(radial, axial, speed, bore, viscosity, skf):
    """M, N.m, under loads across and along the shaft, N, at a speed, rad/s; bore: m; skf: the effect's values."""
    turns, nu, dm = abs(speed) * 30.0 / math.pi, 1e6 * viscosity, 500.0 * (bore + skf.outside_diameter)
    push, slid = radial, skf.sliding * dm**-0.26 * radial ** (5.0 / 3.0)
    if axial > AXIAL * radial:
        sine = math.sin(math.radians(24.6 * min(axial / skf.static_rating, UPRIGHT) ** 0.24))
        push = radial + skf.rolling_thrust / sine * axial
        slid = skf.sliding * dm**-0.145 * (radial**5 + skf.sliding_thrust * dm**1.5 / sine * axial**4) ** (1.0 / 3.0)
    rolled = skf.rolling * dm**1.96 * push**0.54
    heated = 1.0 / (1.0 + 1.84e-9 * (turns * dm) ** 1.28 * nu**0.64)
    starved = math.exp(-skf.starvation * nu * turns * 2.0 * dm * math.sqrt(CAGE / (2e3 * (skf.outside_diameter - bore))))
    bare = math.exp(-2.6e-8 * (nu * turns) ** 1.4 * dm)
    coefficient = bare * skf.boundary + (1.0 - bare) * skf.full_film
    return 1e-3 * (heated * starved * rolled * (nu * turns) ** 0.6 + slid * coefficient)


@kernel
def put_friction(y, u, sums, speed, pitch_diameter, friction, oil, skf):
    """The outputs of the effects under the forces `sums`, N along x, y, z; friction, oil, skf: their values."""
    load = math.sqrt(sums[0] ** 2 + sums[1] ** 2 + sums[2] ** 2)
    if oil is None:
        torque = 0.5 * friction.coefficient * friction.bore_diameter * load
    else:
        y[oil.y] = kinematic_viscosity(u[oil.u], oil.viscosity_40, oil.viscosity_100)
        if skf is None:
            torque = palmgren_torque(load, speed, pitch_diameter, y[oil.y], oil)
        else:
            radial = math.sqrt(sums[0] ** 2 + sums[1] ** 2)
            torque = skf_torque(radial, abs(sums[2]), speed, friction.bore_diameter, y[oil.y], skf)
    y[friction.y] = -torque if speed > 0.0 else torque if speed < 0.0 else 0.0
    y[friction.y + 1] = torque * abs(speed)


@kernel
def note_advice(t, sums, speed, viscosity, friction, skf, noted):
    """The first load that is against the catalogue's advice, into noted (2, 4): too much along the shaft, and too little in all.

    A row is that load, N, the limit, N, and the time, s; the limit is 0 where there was none. sums: forces, N; viscosity: m²/s.
    """
    share = min(skf.axial_share, SMALL_SHARE) if friction.bore_diameter <= SMALL_BORE else skf.axial_share
    axial, most = abs(sums[2]), share * skf.static_rating
    if axial > most and noted[0, 1] == 0.0:
        noted[0, 0], noted[0, 1], noted[0, 2] = axial, most, t
    load = math.sqrt(sums[0] ** 2 + sums[1] ** 2 + sums[2] ** 2)
    mean, turning = 500.0 * (friction.bore_diameter + skf.outside_diameter), 1e6 * viscosity * abs(speed) * 30.0 / math.pi
    least = 1e3 * skf.minimum_factor * (1e-3 * turning) ** (2.0 / 3.0) * (0.01 * mean) ** 2
    if load < least and noted[1, 1] == 0.0:
        noted[1, 0], noted[1, 1], noted[1, 2] = load, least, t
