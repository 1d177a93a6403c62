"""Slip of the cage: traction at the inner race drives balls and cage round the shaft, the oil holds them.

The balls roll on the outer race, onto which their centrifugal force presses them, and slide on the inner one by u. With the speeds
omega of the inner ring, omega_c of the cage and kappa omega of a cage without slip,

    J d(omega_c)/dt = dm T - M_l - M_b,  T = mu Q tanh(u / u_s),  u = dm (kappa omega - omega_c),  J = 7/20 Z m dm² + J_c
    M_l = pi eta b d_l³ / (4 c) (omega_c - omega_g),  M_b = pi/64 C_D rho Z d² dm³ omega_c |omega_c|

Q is the sum of the loads at the inner race, omega_g the speed of the ring that guides the cage, 7/20 m dm² the inertia of a ball that
rolls: it turns about its own axis with omega_c dm/d, so that the inner race drives a surface that moves with omega_c dm. The traction is
that of a film whose shear stress has a limit, by the law of Bair and Winer (1979) and Gecim and Winer (1980), M_l that of Petroff, M_b the
drag of spheres: all three from memory. The balance is derived here; that drag is held against traction is the idea of T. A. Harris,
J. Lubr. Technol. 88 (1966). Not in it: slip at the outer race, rolling resistance, forces in the cage's pockets, a cage that whirls.

A step is one of a method of order two that is stable for any step (SDIRK, L-stable); its equations have one root each.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from ..core.component import Effect
from ..core.kernels import kernel, kernel_tuple
from ..core.variables import choice, input_, output, parameter
from .motion import EVERYTHING

GUIDES = ("outer", "inner")
INNER_GUIDE = 1
STAGE = 1.0 - math.sqrt(0.5)  # share of a step that each stage solves for
ITERATIONS = 100  # of Newton's method within a bracket; a dozen have been enough
SETTLED = 1e-12  # of the speeds, behind which one more step leaves rounding
AT_REST = 1e-9  # rad/s of the shaft, up to which a slip has no meaning
DRIVEN = (*EVERYTHING, ".viscosity")


class CageSlip(Effect):
    """The cage's speed follows from traction and drag: light loads, high speed and thick oil make it slip.

    Centrifugal force, defects, waves and the balls' spin go with the cage's own speed. The torque of `friction` does not know the slip.
    """

    requires = ("ball_inertia",)

    traction = parameter(0.05, "1", "mu, largest traction over load; that of mineral oil, as SKF's catalogue has it", low=0.0)
    sliding = parameter(
        0.1, "m/s", "u_s, sliding with which the traction has 76 % of its limit; a choice", low=1e-12, nominal=0.1
    )
    cage_inertia = parameter(1.4e-5, "kg.m2", "inertia of the cage about the shaft; 20 g of a 6207", low=1e-12, nominal=1e-5)
    guide = choice("outer", GUIDES, "ring that guides the cage: the one at rest holds it, the inner one drives it")
    land_diameter = parameter(0.06, "m", "diameter of the cage where it is guided", low=1e-6, nominal=0.1)
    land_width = parameter(3e-3, "m", "width of all guiding faces together", low=0.0, nominal=1e-3)
    land_gap = parameter(2e-4, "m", "radial gap at the guiding faces", low=1e-9, nominal=1e-4)
    drag_density = parameter(
        10.0, "kg/m3", "C_D rho: drag coefficient of a ball by the density of oil and air between the rings; a choice", low=0.0
    )
    start_slip = parameter(0.0, "1", "slip at the start; 1: cage at rest", low=0.0, high=1.0)

    viscosity = input_(0.03, "Pa.s", "viscosity of the oil at the guiding faces", nominal=0.02)

    cage_speed = output("rad/s", "speed of the cage", nominal=10.0)
    slip = output("1", "share by which the cage is slower than without slip; 0 at rest", feedthrough=("speed",))
    drive = output("N.m", "torque of the inner race on balls and cage", feedthrough=DRIVEN)
    drag = output("N.m", "torque of the oil on balls and cage", feedthrough=DRIVEN)
    power = output("W", "heat of sliding and of the oil's drag", feedthrough=DRIVEN)


@kernel_tuple
class CageDrive(NamedTuple):
    """What turns balls and cage for a while."""

    inertia: float  # J, kg.m²
    grip: float  # dm mu Q, N.m
    sliding: float  # u_s / dm, rad/s
    land: float  # of M_l, N.m.s
    churn: float  # of M_b, N.m.s²
    guided: float  # omega_g over omega


@kernel
def set_inertia(balls, ball_diameter, pitch_diameter, density, slip):
    """J, kg.m²; slip: the effect's values."""
    return 7.0 / 20.0 * balls * density * math.pi / 6.0 * ball_diameter**3 * pitch_diameter**2 + slip.cage_inertia


@kernel
def cage_drive(load, viscosity, inertia, balls, ball_diameter, pitch_diameter, slip):
    """The drive under a load of all balls together, N, in oil of a viscosity, Pa.s; inertia: J."""
    return CageDrive(
        inertia,
        pitch_diameter * slip.traction * load,
        slip.sliding / pitch_diameter,
        math.pi * viscosity * slip.land_width * slip.land_diameter**3 / (4.0 * slip.land_gap),
        math.pi / 64.0 * slip.drag_density * balls * ball_diameter**2 * pitch_diameter**3,
        1.0 if slip.guide == INNER_GUIDE else 0.0,
    )


@kernel
def oil_torque(cage, speed, k):
    """Torque of the oil on balls and cage, N.m."""
    return -k.land * (cage - k.guided * speed) - k.churn * cage * abs(cage)


@kernel
def slip_behind(start, gain, speed, rolling, guess, k):
    """The slip rolling - omega_c, rad/s, with omega_c = start + gain (torque at omega_c); rolling: speed of a cage without slip.

    The torque falls as omega_c rises, so that there is one root, and beyond all of start, 0 and omega_g it cannot be farther than `reach`.
    """
    reach, ring = gain * k.grip, k.guided * speed
    low = rolling - max(start, 0.0, ring) - reach
    high = rolling - min(start, 0.0, ring) + reach
    slip, before, last = min(max(guess, low), high), high - low, False
    for _ in range(ITERATIONS):
        cage, bent = rolling - slip, math.tanh(slip / k.sliding)
        left = start - cage + gain * (k.grip * bent + oil_torque(cage, speed, k))
        slope = 1.0 + gain * (k.grip / k.sliding * (1.0 - bent * bent) + k.land + 2.0 * k.churn * abs(cage))
        to = slip - left / slope
        if last:
            return to
        if left > 0.0:
            high = slip
        else:
            low = slip
        if not (low <= to <= high and abs(to - slip) <= 0.5 * before):
            to = 0.5 * (low + high)
        before = abs(to - slip)
        last = before <= SETTLED * (abs(rolling) + abs(start) + k.sliding)
        slip = to
    return slip


@kernel
def turned_cage(h, cage, u, ratio, k):
    """Speed of the cage behind a step h, rad/s, and by what it has turned less than without slip, rad; u: (3,) of the speed."""
    early, late = u[0] + STAGE * h * (u[1] + STAGE * h * u[2]), u[0] + h * (u[1] + h * u[2])
    gain = STAGE * h / k.inertia
    first = slip_behind(cage, gain, early, ratio * early, ratio * u[0] - cage, k)
    so_far = cage + (1.0 - STAGE) / STAGE * (ratio * early - first - cage)
    second = slip_behind(so_far, gain, late, ratio * late, first, k)
    return ratio * late - second, h * ((1.0 - STAGE) * first + STAGE * second)


@kernel
def put_slip(y, cage, speed, ratio, k):
    """The outputs of the effect; k: `CageDrive`."""
    behind = ratio * speed - cage
    drive, drag = k.grip * math.tanh(behind / k.sliding), oil_torque(cage, speed, k)
    y[0], y[1] = cage, behind / (ratio * speed) if abs(speed) > AT_REST else 0.0
    y[2], y[3] = drive, drag
    y[4] = drive * behind + k.land * (cage - k.guided * speed) ** 2 + k.churn * abs(cage) ** 3
