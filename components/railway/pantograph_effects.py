"""Optional parts of the pantograph: what the scene may switch on."""

from __future__ import annotations

import numpy as np

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.kernels import DONE, OWN, kernel
from ..core.table_curve import read_curve
from ..core.variables import SEED, input_, integer, output, parameter, text
from .sines import fill_bands, sum_of_sines

WRONG_ACCELERATION, WRONG_LENGTHS, WRONG_FREQUENCIES = range(OWN + 1, OWN + 4)  # statuses
REFUSALS = {
    WRONG_ACCELERATION: Refusal(
        "acceleration: rate = {acceleration.rate} m/s2 from {speed} to {acceleration.final_speed} m/s",
        "a rate that leads to the final speed",
        "Change its sign, or final_speed.",
    ),
    WRONG_LENGTHS: Refusal(
        "wire_unevenness: wave lengths from {wire_unevenness.shortest} to {wire_unevenness.longest} m",
        "a shortest one below the longest",
    ),
    WRONG_FREQUENCIES: Refusal(
        "lift_fluctuation: frequencies from {lift_fluctuation.lowest} to {lift_fluctuation.highest} Hz",
        "a lowest one below the highest",
    ),
}


class ContactLoss(Effect):
    """Unilateral contact: the head may leave the wire; off, the contact spring also pulls."""


class LowerFrame(Effect):
    """A third mass between the frame and the base (three-mass model); values of the EN 50318:2018 pantograph."""

    explicit_only = True

    mass = parameter(6.0, "kg", "mass of the lower frame", low=1e-6)
    stiffness = parameter(160.0, "N/m", "stiffness from the lower frame to the base", low=0.0)
    damping = parameter(100.0, "N.s/m", "damping from the lower frame to the base", low=0.0)


class TwoStrips(Effect):
    """Two collector strips on the head, each with its own contact point, and pitching of the head.

        m_s s_i'' = k_s (z1 ± theta d/2 - s_i) + c_s (z1' ± theta' d/2 - s_i') + L_i - F_i,    + at the front
        J theta'' = (Q_rear - Q_front) d/2 + mu (F_front + F_rear) e - k_p theta - c_p theta'

    Q_i: force from the head on strip i; theta raises the front; the wire's friction mu F draws the strips, e above the pivot, to
    the rear and so presses the front one. `head_mass` is that of the head without its strips; the head's contact point is the
    front strip's, either strip has a contact spring. Equations derived for this project; all numbers are choices of ours.
    """

    explicit_only = True

    excludes = ("outer_contact",)
    mass = parameter(2.0, "kg", "mass of a strip", low=1e-6)
    stiffness = parameter(2e4, "N/m", "stiffness of a strip's suspension on the head", low=1e-3)
    damping = parameter(20.0, "N.s/m", "damping of a strip's suspension", low=0.0)
    distance = parameter(0.58, "m", "distance of the strips along the track", low=1e-3)
    pitch_inertia = parameter(0.3, "kg.m2", "moment of inertia of the head about its pivot", low=1e-9)
    pitch_stiffness = parameter(50.0, "N.m/rad", "stiffness against pitching of the head", low=0.0)
    pitch_damping = parameter(1.0, "N.m.s/rad", "damping of the pitching", low=0.0)
    friction = parameter(0.0, "1", "coefficient of friction between strip and wire", low=0.0, high=2.0)
    contact_height = parameter(0.05, "m", "height of the contact over the pivot of the head", low=0.0)

    wire_height = input_(0.0, "m", "height of the contact wire at the rear strip", nominal=0.05)
    wire_compliance = input_(0.0, "m/N", "compliance of the wire at the rear strip that its model leaves out", nominal=1e-5)
    contact_force = output(
        "N",
        "force of the rear strip on the wire, positive upwards",
        nominal=100.0,
        feedthrough=(".wire_height", ".wire_compliance"),
    )
    contact_position = output("m", "position of the rear strip along the track", nominal=100.0)
    front_height = output("m", "height of the front strip", nominal=0.05)
    rear_height = output("m", "height of the rear strip", nominal=0.05)
    pitch = output("rad", "pitch of the head, positive with the front up", nominal=0.01)
    total_force = output(
        "N",
        "force of both strips",
        nominal=100.0,
        feedthrough=("wire_height", "wire_compliance", ".wire_height", ".wire_compliance"),
    )


class SecondWire(Effect):
    """A contact of its own with a second contact wire: of a twin, or where two sections of a line overlap.

        F_2 = max(0, k_c (z1 - w_2)),    head and frame bear F + F_2

    Which wire carries how much follows from both heights. Where there is no second wire, its height is out of reach.
    """

    explicit_only = True
    requires = ("contact_loss",)
    excludes = ("two_strips",)

    wire_height = input_(10.0, "m", "height of the second contact wire at the contact point", nominal=0.05)
    wire_compliance = input_(0.0, "m/N", "compliance of the second wire that its model leaves out", nominal=1e-5)
    contact_force = output(
        "N", "force on the second wire, positive upwards", nominal=100.0, feedthrough=(".wire_height", ".wire_compliance")
    )
    total_force = output(
        "N",
        "force on both wires",
        nominal=100.0,
        feedthrough=("wire_height", "wire_compliance", ".wire_height", ".wire_compliance"),
    )


class AerodynamicUplift(Effect):
    """Lift of the air stream on the lowest mass, coefficient * speed²."""

    coefficient = parameter(0.01301, "N.s2/m2", "lift per speed squared; DSA380, read in a public source", low=0.0)


class StripLift(Effect):
    """Lift of the air stream on each strip, coefficient * speed²; both numbers are choices of ours."""

    requires = ("two_strips",)
    explicit_only = True

    front = parameter(0.003, "N.s2/m2", "lift of the front strip per speed squared")
    rear = parameter(0.003, "N.s2/m2", "lift of the rear strip per speed squared")


class LiftFluctuation(Effect):
    """Fluctuation of every lift about its mean: sines of equal energy and random phase, other ones for each lift.

    Intensity: 5 to 10 % from memory for strips. The same for the same seed.
    """

    requires = ("aerodynamic_uplift",)
    explicit_only = True

    intensity = parameter(0.05, "1", "standard deviation over the mean lift", low=0.0, high=1.0)
    lowest = parameter(0.2, "Hz", "lowest frequency", low=1e-3)
    highest = parameter(20.0, "Hz", "highest frequency", low=1e-3)
    components = integer(40, "number of sines", low=1, high=1000, mesh="random")
    seed = integer(1, "of the random frequencies and phases", low=0, high=2**31 - 1, structural=SEED)


class WireUnevenness(Effect):
    """Unevenness of the wire at the contact, added to the height that the wire's model gives: sines with random phases.

        S(n) = S0 / (1 + (n / n0)^p),    1 / longest <= n <= 1 / shortest

    scaled to the standard deviation; the same for the same seed. Form and numbers are choices of ours: no measured spectrum with
    readable coefficients was found.
    """

    explicit_only = True
    read_by = ("initialize",)

    deviation = parameter(1e-3, "m", "standard deviation of the unevenness", low=0.0)
    longest = parameter(60.0, "m", "longest wave length, 1 / n0", low=1e-2)
    shortest = parameter(0.4, "m", "shortest wave length", low=1e-3)
    exponent = parameter(2.0, "1", "exponent p of the spectrum", low=0.0, high=10.0)
    components = integer(60, "number of sines", low=1, high=2000, mesh="random")
    seed = integer(1, "of the random wave lengths and phases", low=0, high=2**31 - 1, structural=SEED)


class MeasuredUnevenness(Effect):
    """Unevenness of the wire from a measurement, added to the height that the wire's model gives.

    A table of two columns with a header, separated by commas: position along the track, m, rising, and height, m. Straight from
    point to point, the first and the last height beyond them.
    """

    explicit_only = True
    excludes = ("wire_unevenness",)
    read_by = ()

    table = text("position [m],height [m]\n0,0\n1000,0\n", "measured heights as a CSV table; a scene may name its file")


class Acceleration(Effect):
    """The train accelerates or brakes from the parameter `speed` at time 0 to a final speed, and keeps that."""

    explicit_only = True

    rate = parameter(0.5, "m/s2", "acceleration, negative for braking", low=-10.0, high=10.0)
    final_speed = parameter(83.333333333333329, "m/s", "speed at which it ends", low=0.0, high=200.0)


class Actuator(Effect):
    """An actuator between base and lowest mass adds a force after a command, with a first-order lag and a limit.

        tau f' = limited(command) - f

    Time constant and limit are choices of ours, of the size of a pneumatic drive.
    """

    explicit_only = True

    time_constant = parameter(0.05, "s", "time constant of the lag", low=1e-6)
    limit = parameter(100.0, "N", "largest force to either side", low=0.0)
    command = input_(0.0, "N", "wanted force beside the static one, positive upwards", nominal=10.0)
    force = output("N", "force of the actuator", nominal=10.0)


class BumpStops(Effect):
    """Stiff springs at both ends of the head's travel relative to the frame; travel and stiffness are choices of ours."""

    travel = parameter(0.05, "m", "free travel of the head to either side of its relaxed position", low=0.0)
    stiffness = parameter(1e5, "N/m", "stiffness of a stop", low=0.0)


class FrameFriction(Effect):
    """Dry friction of the frame's joints, smoothed: level * tanh(velocity / width); both numbers are choices of ours."""

    level = parameter(5.0, "N", "friction force at the frame", low=0.0)
    width = parameter(0.01, "m/s", "velocity over which the friction changes sign", low=1e-6)


class BaseExcitation(Effect):
    """Motion of the vehicle's roof under the base."""

    explicit_only = True

    height = input_(0.0, "m", "height of the base above its place at rest")
    velocity = input_(0.0, "m/s", "vertical velocity of the base")


class OuterContact(Effect):
    """The force on the head comes from outside, where head and wire are integrated together; off, the head has a spring.

    The own contact spring then only serves the equilibrium at the start.
    """

    explicit_only = True

    excludes = ("contact_loss",)
    force = input_(0.0, "N", "force of the wire on the head, positive upwards", nominal=100.0)


# -- their part of the equations ---------------------------------------------------------------------------------------
@kernel
def limited(value, limit):
    """The value within -limit and limit."""
    return min(max(value, -limit), limit)


@kernel
def speed_at(t, p, e):
    """Speed of the train, m/s."""
    if e.acceleration is None or e.acceleration.rate == 0.0:
        return p.speed
    change = e.acceleration.rate * t
    if e.acceleration.rate > 0.0:
        return min(p.speed + change, e.acceleration.final_speed)
    return max(p.speed + change, e.acceleration.final_speed)


@kernel
def front_position(t, p, e):
    """Position of the contact point, or of the front one, m."""
    position = p.start_position + p.speed * t
    if e.acceleration is not None and e.acceleration.rate != 0.0:
        end = (e.acceleration.final_speed - p.speed) / e.acceleration.rate
        lasted = min(t, end)
        position += e.acceleration.rate * lasted * (t - 0.5 * lasted)
    return position


@kernel
def lift_at(t, coefficient, k, s, p, e):
    """Lift of the air stream, N; k: 0 lowest mass, 1 front strip, 2 rear strip."""
    speed = speed_at(t, p, e)
    lift = coefficient * speed * speed
    if e.lift_fluctuation is not None:
        lift *= 1.0 + sum_of_sines(t, k, s.fluctuation)
    return lift


@kernel
def fill_sines(s, e):
    """Sines of the random effects; a status."""
    if e.wire_unevenness is not None:
        waves = e.wire_unevenness
        if waves.shortest >= waves.longest:
            return WRONG_LENGTHS
        fill_bands(1.0 / waves.longest, 1.0 / waves.shortest, waves.longest, waves.exponent, waves.deviation, s.unevenness)
    if e.lift_fluctuation is not None:
        lifts = e.lift_fluctuation
        if lifts.lowest >= lifts.highest:
            return WRONG_FREQUENCIES
        fill_bands(lifts.lowest, lifts.highest, 1.0, 0.0, lifts.intensity, s.fluctuation)
    return DONE


POSITION, HEIGHT = range(2)  # rows of measured heights


@kernel
def height_between(x, table):
    """Height at a position, m: straight between the columns of `measured_heights`, that of the first and the last beyond them."""
    low, high = 0, table.shape[1] - 1
    if x <= table[POSITION, low]:
        return table[HEIGHT, low]
    if x >= table[POSITION, high]:
        return table[HEIGHT, high]
    while high - low > 1:
        middle = (low + high) // 2
        if table[POSITION, middle] <= x:
            low = middle
        else:
            high = middle
    share = (x - table[POSITION, low]) / (table[POSITION, high] - table[POSITION, low])
    return (1.0 - share) * table[HEIGHT, low] + share * table[HEIGHT, high]


@kernel
def uneven(wire, position, s):
    """Height of the wire with its unevenness at a position, m."""
    if s.unevenness is not None:
        wire += sum_of_sines(position, 0, s.unevenness)
    if s.measured is not None:
        wire += height_between(position, s.measured)
    return wire


def measured_heights(table: str, where: str) -> np.ndarray:
    """Positions, rising, and heights, (2, n) m, of `MeasuredUnevenness`; `BadInput` for another kind of table."""
    return read_curve(table, f"{where}: measured_unevenness.table", {"position": "m", "height": "m"})[1]
