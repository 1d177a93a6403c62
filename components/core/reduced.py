"""Two bodies in contact over one macro step, each reduced to its inertia or its impedance: kernels.

    m z'' = -+F + r  or  Z z' = -+F + r      F = law(g, g')      g = z1 - z2 - clearance

F acts on the first body against the direction of z, on the second one along it. r is the sum of all other forces on a body,
a polynomial over the step. A body with an impedance has no inertia: a string under a point load, which moves with F/Z.
"""

from __future__ import annotations

import math

from .kernels import kernel

LAWS = ("spring", "unilateral", "hertz")
FINE = 20.0  # micro steps in the time 1/rate of the fastest motion; RK4's error is then below 1e-6 of the force
LEAST, MOST = 10, 2000  # micro steps in a macro step


@kernel
def law_force(law, stiffness, damping, gap, rate, mobility):
    """Force for an indentation and its rate, N.

    mobility: m/(N.s), by how much `rate` falls with the force itself, because bodies have an impedance and no inertia.
    """
    if law == 0:
        return (stiffness * gap + damping * rate) / (1.0 + damping * mobility)
    if gap < 0.0:  # at 0 a body that comes has the damper's force already
        return 0.0
    if law == 1:
        return max((stiffness * gap + damping * rate) / (1.0 + damping * mobility), 0.0)
    force = stiffness * gap * math.sqrt(gap)
    return max(force * (1.0 + damping * rate) / (1.0 + damping * force * mobility), 0.0)


@kernel
def force_in_series(law, stiffness, damping, gap, rate, compliance):
    """Force of the law and a compliance, m/N, in series: F = law(gap - compliance F, rate), N."""
    force = law_force(law, stiffness, damping, gap, rate, 0.0)
    if compliance == 0.0 or force == 0.0:
        return force
    if law < 2:
        return force / (1.0 + compliance * stiffness)
    low, high = 0.0, min(force, gap / compliance)
    for _ in range(60):  # halved until no bit is left; what falls with F meets what rises with it once
        middle = 0.5 * (low + high)
        if law_force(law, stiffness, damping, gap - compliance * middle, rate, 0.0) > middle:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@kernel
def micro_steps(h, law, stiffness, damping, gap, rate, inverse_mass, mobility):
    """Number of equal micro steps for a macro step; inverse_mass: sum of 1/m, mobility: sum of 1/Z."""
    if law == 2:
        deepest = max(gap, gap + h * rate, 0.0)
        damping *= stiffness * deepest * math.sqrt(deepest)
        stiffness *= 1.5 * math.sqrt(deepest)
    fastest = math.sqrt(stiffness * inverse_mass) + damping * inverse_mass + stiffness * mobility / (1.0 + damping * mobility)
    return int(min(max(math.ceil(FINE * h * fastest), LEAST), MOST))


@kernel
def reduced_step(
    h,
    law,
    stiffness,
    damping,
    clearance,
    z1,
    v1,
    z2,
    v2,
    inverse_mass1,
    mobility1,
    inverse_mass2,
    mobility2,
    a1,
    b1,
    c1,
    a2,
    b2,
    c2,
):
    """The contact force over a macro step: (∫F ds, ∫s F ds, F at the end), by the classic Runge-Kutta method.

    loose: 1/m, or 0 for a body with impedance; yield: 1/Z, or 0 for one with inertia; r = a + b s + c s² of each body.
    """
    mobility = mobility1 + mobility2
    gap, rate = z1 - z2 - clearance, v1 - v2 + a1 * mobility1 - a2 * mobility2
    n = micro_steps(h, law, stiffness, damping, gap, rate, inverse_mass1 + inverse_mass2, mobility)
    d = h / n
    impulse, moment, force = 0.0, 0.0, 0.0
    if mobility1 > 0.0:
        v1 = 0.0
    if mobility2 > 0.0:
        v2 = 0.0
    for step in range(n):
        s, x1, x2, u1, u2 = step * d, z1, z2, v1, v2
        sum_x1, sum_x2, sum_u1, sum_u2, sum_f, sum_sf = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for stage in range(4):
            r1, r2 = a1 + s * (b1 + s * c1), a2 + s * (b2 + s * c2)
            force = law_force(law, stiffness, damping, x1 - x2 - clearance, u1 + r1 * mobility1 - u2 - r2 * mobility2, mobility)
            dx1, du1 = u1 + (r1 - force) * mobility1, (r1 - force) * inverse_mass1
            dx2, du2 = u2 + (r2 + force) * mobility2, (r2 + force) * inverse_mass2
            weight = 1.0 if stage == 0 or stage == 3 else 2.0
            sum_x1 += weight * dx1
            sum_x2 += weight * dx2
            sum_u1 += weight * du1
            sum_u2 += weight * du2
            sum_f += weight * force
            sum_sf += weight * s * force
            if stage < 3:
                ahead = d if stage == 2 else 0.5 * d
                s = step * d + ahead
                x1, u1, x2, u2 = z1 + ahead * dx1, v1 + ahead * du1, z2 + ahead * dx2, v2 + ahead * du2
        z1 += d / 6.0 * sum_x1
        v1 += d / 6.0 * sum_u1
        z2 += d / 6.0 * sum_x2
        v2 += d / 6.0 * sum_u2
        impulse += d / 6.0 * sum_f
        moment += d / 6.0 * sum_sf
    r1, r2 = a1 + h * (b1 + h * c1), a2 + h * (b2 + h * c2)
    force = law_force(law, stiffness, damping, z1 - z2 - clearance, v1 + r1 * mobility1 - v2 - r2 * mobility2, mobility)
    return impulse, moment, force
