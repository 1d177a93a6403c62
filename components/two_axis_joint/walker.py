"""Two legs that walk down a slope without a motor: the compass gait, and the simplest walker as its limit."""

from __future__ import annotations

import math

from ..core.component import Preset
from ..core.contract import Refusal
from ..core.errors import StepFailed
from ..core.events import EventComponent, event_kernels
from ..core.integrators import RK4_STABILITY_RADIUS
from ..core.kernels import DONE, OUT_OF_RANGE, OWN, kernel
from ..core.variables import count, input_, output, parameter

WITHOUT_INERTIA, LYING = OWN + 1, OWN + 2  # statuses
SWINGS, AHEAD = 0.0, 1.0  # modes: the swing foot has not been ahead of the other and above the ground since the last step; it has
CAUGHT, FALLEN, LIFTED = 2.0, 3.0, 4.0  # modes in which these equations end
ENDS = {
    CAUGHT: ("both feet stay on the ground after an impact: the walker stands", "Start it faster, or on a steeper slope"),
    FALLEN: ("the hip is at the ground: the walker has fallen", "Start it closer to a gait"),
    LIFTED: ("the standing foot leaves the ground: the walker falls, or would have to run", "Start it closer to a gait"),
}

ANY_END = ("the walker stands, has fallen, or its standing foot leaves the ground", "Start it closer to a gait")


class PassiveWalker(EventComponent):
    """Two legs alike, joined at the hip, on a slope: one foot stands, the other leg swings, and a step ends with its impact.

        A th'' - B cos d ps'' = B sin d ps'² + W1 sin(th - g) - T,    d = th - ps
        C ps'' - B cos d th'' = -B sin d th'² - W2 sin(ps - g) + T
        A = M l² + m (l - c)² + I + m l²,  B = m l c,  C = I + m c²
        W1 = G (M l + m (l - c) + m l),  W2 = G m c

    th: standing leg, ps: swinging leg, from the normal of the slope; th > 0 leans uphill, ps > 0 has its foot downhill of the hip.
    M: hip, m, c, I: leg, its centre of mass from the hip, its inertia about it; g: slope, G: gravity, T: torque in the hip.

    The foot that comes down ahead of the other takes over at once: it neither slips nor rebounds, and the other leaves the ground
    without an impulse. So the moment of momentum of both legs about the new foot, and that of the other leg about the hip, go on:

        [[A, -B cos d], [-B cos d, C]] (th'+, ps'+) = ((M l² + 2 m l (l - c)) cos d th' + J ps', J th'),    J = I - m c (l - c)

    and the legs change names. Straight legs would scuff where they pass each other; this contact is left out. Walking is downhill,
    to positive x. Garcia, Chatterjee, Ruina and Coleman (1998), legs without mass and with feet of hardly any; Goswami, Thuilot and
    Espiau (1998), the compass gait. The equations are derived here; those papers have the same ones in other coordinates.
    """

    title = "Passive walker"
    system = "two_axis_joint"
    default_stop = 10.0
    start_inputs = ()
    guards_count = 3
    refusals = {
        WITHOUT_INERTIA: Refusal(
            "a leg without inertia about the hip: nothing says how it swings",
            "a leg_mass away from the hip, or a leg_inertia",
            "Give feet of a billionth of the hip_mass for legs without mass.",
        ),
        LYING: Refusal("a standing leg of {start_stance_angle} rad at the start", "a hip above the ground"),
    }

    hip_mass = parameter(10.0, "kg", "mass at the hip", low=0.0)
    leg_mass = parameter(5.0, "kg", "mass of each leg", low=0.0)
    leg_length = parameter(1.0, "m", "length of each leg, from the hip to the foot", low=1e-9)
    leg_centre = parameter(0.5, "m", "distance of a leg's centre of mass from the hip", low=0.0)
    leg_inertia = parameter(0.0, "kg.m2", "moment of inertia of a leg about its centre of mass", low=0.0)
    slope = parameter(math.radians(3.0), "rad", "angle of the slope, downhill", low=-1.5, high=1.5)
    gravity = parameter(9.81, "m/s2", "acceleration of gravity", low=1e-9)
    start_stance_angle = parameter(0.27, "rad", "standing leg at the start, from the normal of the slope, positive uphill")
    start_swing_angle = parameter(-0.27, "rad", "swinging leg at the start, positive with its foot downhill of the hip")
    start_stance_rate = parameter(-1.09, "rad/s", "rate of the standing leg at the start")
    start_swing_rate = parameter(-0.38, "rad/s", "rate of the swinging leg at the start")
    substep = parameter(1e-3, "s", "longest internal step", low=1e-9, high=1.0)

    hip_torque = input_(0.0, "N.m", "torque in the hip, on the swinging leg and back on the standing one", nominal=1.0)

    stance_angle = output("rad", "standing leg, from the normal of the slope")
    swing_angle = output("rad", "swinging leg, from the normal of the slope")
    stance_rate = output("rad/s", "rate of the standing leg")
    swing_rate = output("rad/s", "rate of the swinging leg")
    clearance = output("m", "height of the swinging foot over the slope; below 0 where straight legs pass each other")
    foot_position = output("m", "place of the standing foot along the slope, downhill")
    steps = count("number of steps that have ended")
    step_length = output("m", "length of the last step, 0 before the first")
    step_duration = output("s", "duration of the last step, 0 before the first")
    strike_angle = output("rad", "standing leg right after the last impact, or at the start")
    strike_rate = output("rad/s", "its rate right after the last impact, or at the start")
    strike_swing_rate = output("rad/s", "rate of the swinging leg right after the last impact, or at the start")
    mechanical_energy = output("J", "kinetic energy and height, over the first foot's place", nominal=10.0)
    lost_energy = output("J", "energy lost in impacts so far", nominal=10.0)
    normal_force = output("N", "force of the ground on the standing foot along the slope's normal", nominal=100.0,
                          feedthrough=("hip_torque",))  # fmt: skip
    tangential_force = output(
        "N", "force of the ground on the standing foot, downhill", nominal=100.0, feedthrough=("hip_torque",)
    )

    presets = {
        "compass gait": Preset(
            {"hip_mass": 10.0, "leg_mass": 5.0, "leg_length": 1.0, "leg_centre": 0.5, "leg_inertia": 0.0, "gravity": 9.8,
             "slope": math.radians(3.0), "start_stance_angle": 0.2187 + math.radians(3.0),
             "start_swing_angle": -0.3234 + math.radians(3.0), "start_stance_rate": -1.0918, "start_swing_rate": -0.3772},
            "Goswami, Thuilot and Espiau 1998, masses, lengths and the gait at 3 degrees from memory", "unconfirmed"),
        "simplest walker": Preset(
            {"hip_mass": 1000.0, "leg_mass": 1.0, "leg_length": 1.0, "leg_centre": 1.0, "leg_inertia": 0.0, "gravity": 1.0,
             "slope": 0.009, "start_stance_angle": 0.200161072169750, "start_swing_angle": -0.200161072169762,
             "start_stance_rate": -0.199906060087682, "start_swing_rate": -0.199906060087682 + 0.015805473227965},
            "P. A. Bhounsule, passivewalker.m, 2009: Garcia's walker with a leg of a thousandth of the hip; its fixed point to all "
            "digits given there", "verbatim"),
    }  # fmt: skip

    def states(self) -> int:
        """(th, ps, th', ps', mode), the foot's place, steps, energy lost, time since the last impact, and what that impact left."""
        return 14

    def _check(self, status: int) -> None:
        if status == OUT_OF_RANGE:
            reason, remedy = ENDS.get(float(self.x[MODE]), ANY_END)
            raise StepFailed(self.name, self.t, reason, remedy)
        super()._check(status)

    def energy(self) -> float:
        """The output `mechanical_energy`, J."""
        return float(self.get("mechanical_energy"))


OUT = PassiveWalker.output_places()
TH, PS, TH_RATE, PS_RATE, MODE, FOOT, STEPS, LOST, SINCE, ANGLE, RATE, SWING_RATE, LENGTH, DURATION = range(14)  # of the state


@kernel
def inertias(difference, p):
    """(A, B cos d, C, determinant), kg.m2; the determinant is a sum of terms that cannot be negative."""
    m, length, c = p.leg_mass, p.leg_length, p.leg_centre
    own = p.hip_mass * length * length + m * (length - c) * (length - c) + p.leg_inertia
    swing, coupling, sine = p.leg_inertia + m * c * c, m * length * c, math.sin(difference)
    determinant = own * swing + m * length * length * p.leg_inertia + coupling * coupling * sine * sine
    return own + m * length * length, coupling * math.cos(difference), swing, determinant


@kernel
def weights(p):
    """(W1, W2), N.m."""
    lifted = p.hip_mass * p.leg_length + p.leg_mass * (2.0 * p.leg_length - p.leg_centre)
    return p.gravity * lifted, p.gravity * p.leg_mass * p.leg_centre


@kernel
def accelerations(x, torque, p):
    """(th'', ps''), rad/s2."""
    d = x[TH] - x[PS]
    a, coupled, c, determinant = inertias(d, p)
    w1, w2 = weights(p)
    turning = p.leg_mass * p.leg_length * p.leg_centre * math.sin(d)
    first = turning * x[PS_RATE] * x[PS_RATE] + w1 * math.sin(x[TH] - p.slope) - torque
    second = -turning * x[TH_RATE] * x[TH_RATE] - w2 * math.sin(x[PS] - p.slope) + torque
    return (c * first + coupled * second) / determinant, (a * second + coupled * first) / determinant


@kernel
def walker_energy(x, p):
    """Kinetic energy and height, J; the first foot's place has none."""
    a, coupled, c, _ = inertias(x[TH] - x[PS], p)
    w1, w2 = weights(p)
    moving = 0.5 * a * x[TH_RATE] * x[TH_RATE] + 0.5 * c * x[PS_RATE] * x[PS_RATE] - coupled * x[TH_RATE] * x[PS_RATE]
    down = (p.hip_mass + 2.0 * p.leg_mass) * p.gravity * math.sin(p.slope) * x[FOOT]
    return moving + w1 * math.cos(x[TH] - p.slope) - w2 * math.cos(x[PS] - p.slope) - down


@kernel
def walker_start(t, s, p, e):
    """Angles and rates as given."""
    x = s.x
    a, _, c, stretched = inertias(0.0, p)
    if stretched <= 1e-14 * a * c:  # also both zero
        return WITHOUT_INERTIA
    x[TH], x[PS], x[TH_RATE], x[PS_RATE] = p.start_stance_angle, p.start_swing_angle, p.start_stance_rate, p.start_swing_rate
    x[SINCE], x[ANGLE], x[RATE], x[SWING_RATE] = 0.0, x[TH], x[TH_RATE], x[PS_RATE]
    return LYING if math.cos(x[TH]) <= 0.0 else DONE


@kernel
def walker_derivatives(t, x, u, dx, s, p, e):
    """dx/dt; between impacts only angles, rates and the time since the last one change."""
    dx[:] = 0.0
    dx[SINCE] = 1.0
    dx[TH], dx[PS] = x[TH_RATE], x[PS_RATE]
    dx[TH_RATE], dx[PS_RATE] = accelerations(x, u[0], p)


@kernel
def over_ground(x):
    """(height, place ahead of the standing foot) of the swinging foot, over the leg's length."""
    return math.cos(x[TH]) - math.cos(x[PS]), math.sin(x[PS]) - math.sin(x[TH])


@kernel
def ground_force(x, torque, p):
    """Force of the ground on the standing foot, N: (along the normal of the slope, downhill)."""
    th2, ps2 = accelerations(x, torque, p)
    carried, swung = p.hip_mass * p.leg_length + p.leg_mass * (2.0 * p.leg_length - p.leg_centre), p.leg_mass * p.leg_centre
    weight = (p.hip_mass + 2.0 * p.leg_mass) * p.gravity
    st, ct, sp, cp = math.sin(x[TH]), math.cos(x[TH]), math.sin(x[PS]), math.cos(x[PS])
    t2, p2 = x[TH_RATE] * x[TH_RATE], x[PS_RATE] * x[PS_RATE]
    normal = weight * math.cos(p.slope) - carried * (th2 * st + t2 * ct) + swung * (ps2 * sp + p2 * cp)
    return normal, -weight * math.sin(p.slope) - carried * (th2 * ct - t2 * st) + swung * (ps2 * cp - p2 * sp)


@kernel
def walker_guards(t, x, u, g, s, p, e):
    """While the foot has not been ahead and above: what is missing. Then: its height. The hip's height, the ground's force."""
    g[0], g[1], g[2] = 1.0, 1.0, 1.0
    if x[MODE] <= AHEAD:
        height, ahead = over_ground(x)
        g[0] = -min(height, ahead) if x[MODE] == SWINGS else height
        g[1] = math.cos(x[TH])
        g[2], _ = ground_force(x, u[0], p)


@kernel
def walker_switch(which, t, x, u, s, p, e):
    """The foot is ahead and above; or it comes down: the impact, after which the legs have changed names."""
    _, ahead = over_ground(x)
    if which > 0:
        x[MODE] = FALLEN if which == 1 else LIFTED
    elif x[MODE] == SWINGS:
        x[MODE] = AHEAD
    elif ahead <= 0.0:  # it has swung back, and passes the standing foot
        x[MODE] = SWINGS
    else:
        m, length, c = p.leg_mass, p.leg_length, p.leg_centre
        before = walker_energy(x, p)
        a, coupled, swing, determinant = inertias(x[TH] - x[PS], p)
        own = p.leg_inertia - m * c * (length - c)
        both = (p.hip_mass * length * length + 2.0 * m * length * (length - c)) * math.cos(x[TH] - x[PS]) * x[TH_RATE] + own * x[
            PS_RATE
        ]
        other = own * x[TH_RATE]
        x[TH], x[PS] = x[PS], x[TH]
        x[TH_RATE], x[PS_RATE] = (swing * both + coupled * other) / determinant, (a * other + coupled * both) / determinant
        leaves = x[PS_RATE] * math.sin(x[PS]) - x[TH_RATE] * math.sin(x[TH])
        x[MODE] = SWINGS if leaves > 0.0 else CAUGHT
        x[LENGTH], x[DURATION] = length * ahead, x[SINCE]
        x[FOOT] += x[LENGTH]
        x[STEPS] += 1.0
        x[LOST] += before - walker_energy(x, p)
        x[SINCE], x[ANGLE], x[RATE], x[SWING_RATE] = 0.0, x[TH], x[TH_RATE], x[PS_RATE]


@kernel
def walker_outputs(t, s, p, e):
    """Legs, foot, the last step, energies and the force of the ground."""
    x, y = s.x, s.y
    y[OUT.stance_angle], y[OUT.swing_angle], y[OUT.stance_rate], y[OUT.swing_rate] = x[TH], x[PS], x[TH_RATE], x[PS_RATE]
    height, _ = over_ground(x)
    y[OUT.clearance], y[OUT.foot_position], y[OUT.steps] = p.leg_length * height, x[FOOT], x[STEPS]
    y[OUT.step_length], y[OUT.step_duration] = x[LENGTH], x[DURATION]
    y[OUT.strike_angle], y[OUT.strike_rate], y[OUT.strike_swing_rate] = x[ANGLE], x[RATE], x[SWING_RATE]
    y[OUT.mechanical_energy], y[OUT.lost_energy] = walker_energy(x, p), x[LOST]
    y[OUT.normal_force], y[OUT.tangential_force] = ground_force(x, s.u[0, 0], p)
    return DONE


@kernel
def walker_stable(t, s, p, e):
    """Half of RK4's limit for the legs side by side, s: one falls, the other swings. From 0.6 of it on a gait is lost (measured)."""
    a, _, c, determinant = inertias(0.0, p)
    w1, w2 = weights(p)
    half, product = 0.5 * (a * w2 - c * w1), w1 * w2 * determinant
    square = (abs(half) + math.sqrt(half * half + product)) / determinant
    return 0.5 * RK4_STABILITY_RADIUS / math.sqrt(square) if square > 0.0 else math.inf


_events = event_kernels(
    __name__,
    start=walker_start,
    derivatives=walker_derivatives,
    outputs=walker_outputs,
    stable=walker_stable,
    guards=walker_guards,
    switch=walker_switch,
)
_step = _events.step


@kernel
def walker_step(t, h, s, p, e):
    """A step with events, refused where the walker has not gone on walking."""
    status = _step(t, h, s, p, e)
    return OUT_OF_RANGE if status == DONE and s.x[MODE] > AHEAD else status


PassiveWalker.kernels = _events._replace(step=walker_step)
