"""The five muscles of the forearm that move the wrist: excitation, activation, force, and torque on the hand by moment arms."""

from __future__ import annotations

import math
from typing import Any

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.integrators import RK4_STABILITY_RADIUS, OdeComponent, ode_kernels
from ..core.kernels import DONE, NOT_FINITE, OWN, kernel
from ..core.variables import input_, output, parameter

MUSCLES = ("fcr", "fcu", "ecrl", "ecrb", "ecu")
COUNT, ROWS = len(MUSCLES), 16
ORDER = "; FCR, FCU, ECRL, ECRB, ECU"
TIMES_FALL = OWN + 1  # status
TURNING = ("flexion", "deviation", "flexion_rate", "deviation_rate")


class Programme(Effect):
    """Excitations over time, added to the inputs: straight lines between rows, the first before them, the last after them.

    A table with fewer rows than the arrays leaves the rest at 0.
    """

    explicit_only = True

    time = parameter(0.0, "s", "time of a row, not decreasing", size=ROWS)
    fcr = parameter(0.0, "1", "excitation of flexor carpi radialis", size=ROWS, low=0.0, high=1.0)
    fcu = parameter(0.0, "1", "excitation of flexor carpi ulnaris", size=ROWS, low=0.0, high=1.0)
    ecrl = parameter(0.0, "1", "excitation of extensor carpi radialis longus", size=ROWS, low=0.0, high=1.0)
    ecrb = parameter(0.0, "1", "excitation of extensor carpi radialis brevis", size=ROWS, low=0.0, high=1.0)
    ecu = parameter(0.0, "1", "excitation of extensor carpi ulnaris", size=ROWS, low=0.0, high=1.0)


class Fibres(Effect):
    """Force by the length of the fibres: the active one falls as exp(-(l - 1)² / width), a stretched fibre pulls passively.

    Passive: (exp(4 s / stretch) - 1) / (exp(4) - 1) of the largest force at the strain s > 0. Form as in Thelen (2003), from memory.
    Lengths of FCR, FCU and ECU are read in OpenSim's model of the wrist, the others from memory; that the fibres have their best
    length in the neutral position is ours.
    """

    length = parameter((0.0628, 0.0509, 0.081, 0.0588, 0.0622), "m", "best length of the fibres" + ORDER, size=COUNT, low=1e-3)
    width = parameter(0.45, "1", "width of the active force, relative length squared", low=1e-3)
    stretch = parameter(0.6, "1", "strain at which a fibre pulls with the largest force, passively", low=1e-3)


class ForceVelocity(Effect):
    """Hill's hyperbola: shortening fibres pull less, none at the greatest rate; those that are lengthened pull more.

    Ten fibre lengths a second as the greatest rate is read in OpenSim's model of the wrist; the shape is quoted from memory.
    """

    greatest_rate = parameter(
        (0.628, 0.509, 0.81, 0.588, 0.622), "m/s", "rate of shortening without force" + ORDER, size=COUNT, low=1e-3
    )
    curvature = parameter(0.25, "1", "Hill's constant over the largest force; smaller is more curved", low=1e-3)
    lengthened = parameter(1.4, "1", "force of a quickly lengthened fibre over its isometric force", low=1.0 + 1e-6)


class VaryingArms(Effect):
    """Moment arms of flexion that change with the flexion; off, they stay as in the neutral position.

    FCR, ECRL, ECRB, ECU as in the table at biomed.bas.bg, "Moment Arms with Respect to Flexio/Extensio Axis", first order.
    """

    slope = parameter((-0.81e-3, 0.0, 3.1e-3, 1.8e-3, 2.8e-3), "m/rad", "moment arm per flexion" + ORDER, size=COUNT)


class ForearmTendons(OdeComponent):
    """Muscles pull the hand by tendons that run over it at given moment arms, and end beyond both rows.

        a' = (e - a) / T,  T: rise where e > a, else fall,   F = largest_force a * (length and velocity, if on)
        s = arm_f flexion + arm_d deviation,   torques = sum F (d s)/(d flexion), sum F (d s)/(d deviation),   power = sum F s'

    e: excitation within 0 and 1; a: activation; s: shortening from the neutral position. The torques belong to the angles of the
    hand: no tendon ends at a carpal bone (but FCU, by the pisiform, which is left out), and so they know nothing of the rows'
    axes, which divide them by the rows' motion. Fingers' and thumb's muscles are not here: measured torques of the whole
    forearm, 5.2 to 18.7 N.m in flexion (Delp, Grierson, Buchanan 1996), are larger than what these five give.
    Sources: that tendons load the linkage is the rule "load" of Sandow (2020), of which the abstract was at hand; the equations
    are ours. Largest forces of FCR, FCU, ECU: OpenSim's model of the wrist (Gonzalez, Buchanan, Delp 1997), read; of ECRL and
    ECRB: from memory. Arms of flexion but FCU's: table at biomed.bas.bg, read; the others and the times of activation: from memory.
    """

    title = "Muscles of the forearm with their tendons over the wrist"
    system = "wrist"
    start_inputs = ("excitation",)

    programme = Programme
    fibres = Fibres
    force_velocity = ForceVelocity
    varying_arms = VaryingArms

    largest_force = parameter(
        (59.7, 102.6, 110.0, 100.0, 117.0), "N", "force at full activation" + ORDER, size=COUNT, low=0.0, nominal=100.0
    )
    flexion_arm = parameter(
        (0.0177, 0.015, -0.0102, -0.0137, -0.0057),
        "m",
        "moment arm of flexion, negative: extends" + ORDER,
        size=COUNT,
        nominal=0.01,
    )
    radial_arm = parameter(
        (0.008, -0.014, 0.019, 0.013, -0.021),
        "m",
        "moment arm of radial deviation, negative: ulnar" + ORDER,
        size=COUNT,
        nominal=0.01,
    )
    rise_time = parameter(0.015, "s", "time constant of activation", low=1e-4)
    fall_time = parameter(0.05, "s", "time constant of relaxation", low=1e-4)
    substep = parameter(2e-3, "s", "longest internal step", low=1e-9, high=1.0)

    excitation = input_(0.0, "1", "excitation within 0 and 1" + ORDER, size=COUNT)
    flexion = input_(0.0, "rad", "flexion of the hand")
    deviation = input_(0.0, "rad", "radial deviation of the hand")
    flexion_rate = input_(0.0, "rad/s", "its rate")
    deviation_rate = input_(0.0, "rad/s", "rate of the deviation")

    flexion_torque = output("N.m", "torque on the hand that flexes", feedthrough=TURNING)
    deviation_torque = output("N.m", "torque on the hand towards the radius", feedthrough=TURNING)
    power = output("W", "power given to the hand", feedthrough=TURNING)
    activation = output("1", "activation" + ORDER, size=COUNT)
    force = output("N", "force of the tendon" + ORDER, size=COUNT, nominal=100.0, feedthrough=TURNING)

    refusals = {
        TIMES_FALL: Refusal(
            "programme.time[{fall[0]}] = {fall[1]} s, then {fall[2]} s",
            "times that do not decrease, and zeros behind the last row",
        )
    }

    def states(self) -> int:
        """The activations."""
        return COUNT

    def shapes(self) -> dict[str, Any]:
        """`fall`: of a programme whose times decrease, the number of the last row before, its time and the next one, s."""
        return super().shapes() | {"fall": 3}

    def energy(self) -> float:
        """Energy of the fibres' passive stretch, J; 0 without `fibres`."""
        _, p, e = self.arguments
        if e.fibres is None:
            return 0.0
        total = 0.0
        for i in range(COUNT):
            strain = -shortening(i, self.u[0], p, e.varying_arms)[0] / e.fibres.length[i]
            if strain > 0.0:
                s = min(strain / e.fibres.stretch, TORN)
                scale = p.largest_force[i] * e.fibres.length[i] * e.fibres.stretch
                total += scale * (math.expm1(STIFFENING * s) / STIFFENING - s) / math.expm1(STIFFENING)
        return total


IN = ForearmTendons.input_places()
OUT = ForearmTendons.output_places()
STIFFENING = 4.0  # of the passive stretch
TORN = 100.0  # of that stretch, beyond which it pulls no more: the exponential would overflow


@kernel
def programmed(i, row, programme):
    """Excitation of the muscle i in a row of the programme."""
    if i == 0:
        return programme.fcr[row]
    if i == 1:
        return programme.fcu[row]
    if i == 2:
        return programme.ecrl[row]
    if i == 3:
        return programme.ecrb[row]
    return programme.ecu[row]


@kernel
def wanted(i, t, u, programme):
    """Excitation of the muscle i at time t, within 0 and 1."""
    value = u[IN.excitation + i]
    if programme is not None:
        after = 0
        while after < ROWS and programme.time[after] <= t and (after == 0 or programme.time[after] >= programme.time[after - 1]):
            after += 1
        if after == 0:
            value += programmed(i, 0, programme)
        elif after == ROWS or programme.time[after] < programme.time[after - 1]:
            value += programmed(i, after - 1, programme)
        else:
            before = after - 1
            share = (t - programme.time[before]) / (programme.time[after] - programme.time[before])
            first, last = programmed(i, before, programme), programmed(i, after, programme)
            value += first + share * (last - first)
    return min(max(value, 0.0), 1.0)


@kernel
def programme_status(programme, fall):
    """Refuses times that decrease, unless all behind them is zero; fall: (3,) result, where they do."""
    last = 0
    while last < ROWS - 1 and programme.time[last + 1] >= programme.time[last]:
        last += 1
    for row in range(last + 1, ROWS):
        zero = programme.time[row] == 0.0
        for i in range(COUNT):
            zero = zero and programmed(i, row, programme) == 0.0
        if not zero:
            fall[0], fall[1], fall[2] = last + 1.0, programme.time[last], programme.time[last + 1]
            return TIMES_FALL
    return DONE


@kernel
def tendon_start(t, s, p, e):
    """Steady activations of the present excitations."""
    if e.programme is not None:
        status = programme_status(e.programme, s.fall)
        if status != DONE:
            return status
    for i in range(COUNT):
        s.x[i] = wanted(i, t, s.u[0], e.programme)
    return DONE


@kernel
def tendon_stable(t, s, p, e):
    """Limit of the internal step, s, for the shorter time constant."""
    return RK4_STABILITY_RADIUS * min(p.rise_time, p.fall_time)


@kernel
def shortening(i, u, p, arms):
    """(shortening of the muscle i in m, its moment arm of flexion in m)."""
    arm, pulled = p.flexion_arm[i], p.flexion_arm[i] * u[IN.flexion] + p.radial_arm[i] * u[IN.deviation]
    if arms is not None:
        pulled += 0.5 * arms.slope[i] * u[IN.flexion] * u[IN.flexion]
        arm += arms.slope[i] * u[IN.flexion]
    return pulled, arm


@kernel
def by_velocity(rate, curvature, lengthened):
    """Force over the isometric one at a rate of shortening over the greatest; both branches have one slope at 0."""
    if rate >= 1.0:
        return 0.0
    if rate >= 0.0:
        return (1.0 - rate) / (1.0 + rate / curvature)
    gained, slope = lengthened - 1.0, -rate * (1.0 + 1.0 / curvature)
    return 1.0 + gained * slope / (gained + slope)


@kernel
def tendon_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of x = the activations."""
    for i in range(COUNT):
        way = wanted(i, t, u, e.programme) - x[i]
        dx[i] = way / (p.rise_time if way > 0.0 else p.fall_time)


@kernel
def tendon_outputs(t, s, p, e):
    """Torques, power, activations, forces."""
    x, u, y = s.x, s.u[0], s.y
    y[OUT.flexion_torque], y[OUT.deviation_torque], y[OUT.power] = 0.0, 0.0, 0.0
    for i in range(COUNT):
        pulled, arm = shortening(i, u, p, e.varying_arms)
        rate = arm * u[IN.flexion_rate] + p.radial_arm[i] * u[IN.deviation_rate]
        share = x[i]
        if e.fibres is not None:
            strain = -pulled / e.fibres.length[i]
            share *= math.exp(-strain * strain / e.fibres.width)
        if e.force_velocity is not None:
            share *= by_velocity(
                rate / e.force_velocity.greatest_rate[i], e.force_velocity.curvature, e.force_velocity.lengthened
            )
        if e.fibres is not None and pulled < 0.0:
            passive = min(-pulled / (e.fibres.length[i] * e.fibres.stretch), TORN)
            share += math.expm1(STIFFENING * passive) / math.expm1(STIFFENING)
        force = p.largest_force[i] * share
        y[OUT.flexion_torque] += force * arm
        y[OUT.deviation_torque] += force * p.radial_arm[i]
        y[OUT.power] += force * rate
        y[OUT.activation + i], y[OUT.force + i] = x[i], force
    return DONE


_ode = ode_kernels(__name__, start=tendon_start, derivatives=tendon_derivatives, outputs=tendon_outputs, stable=tendon_stable)
_advance = _ode.step


@kernel
def tendon_step(t, h, s, p, e):
    """A step, refused for angles or rates that are no numbers: activations know nothing of them."""
    status = _advance(t, h, s, p, e)
    if status == DONE and not math.isfinite(s.y[OUT.flexion_torque] + s.y[OUT.deviation_torque] + s.y[OUT.power]):
        return NOT_FINITE
    return status


ForearmTendons.kernels = _ode._replace(step=tendon_step, derivatives=None)
