"""Lumped pantograph: a head and a frame, optionally a third mass, and the contact spring towards the wire.

The pantograph owns the contact law (it gets the wire's height and gives the force). The head and the contact spring
form a 13 Hz oscillator inside the 20 Hz band of the standard; kept in one unit it is integrated without delay, and
only the wire, which answers a force like the dashpot 2 sqrt(T m), needs a prediction of the force.

Measured on the EN 50318:2002 scene at 250 km/h against an independent solution (`orchestrator/systems/railway/modal.py`),
catenary first, force extrapolated linearly: the 20 Hz-filtered force is off by 0.4 % of its standard deviation (rms) with a
macro step of 1 ms, 1.1 % with 2 ms (0.3 % extrapolated quadratically), 8 % with 5 ms, and no contact is lost up to 10 ms. Held
inputs leave 8 % (Jacobi) and 43 % (Gauss-Seidel, where the wire's height is that of the new instant at the old position) with
1 ms. With the effect `outer_contact` the contact is integrated elsewhere instead, together
with models of head and wire: the algorithm "interface-model" does so, and is off by 1.3 % with 5 ms.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..core.component import Preset
from ..core.contract import Refusal
from ..core.integrators import RK4_STABILITY_RADIUS, OdeComponent, find_slopes, ode_kernels
from ..core.kernels import DONE, OWN, bind, kernel
from ..core.linear import solve_dense
from ..core.spectrum import spectral_radius, step_within
from ..core.variables import input_, output, parameter
from .pantograph_effects import (
    REFUSALS,
    WRONG_ACCELERATION,
    Acceleration,
    Actuator,
    AerodynamicUplift,
    BaseExcitation,
    BumpStops,
    ContactLoss,
    FrameFriction,
    LiftFluctuation,
    LowerFrame,
    MeasuredUnevenness,
    OuterContact,
    SecondWire,
    StripLift,
    TwoStrips,
    WireUnevenness,
    fill_sines,
    front_position,
    lift_at,
    limited,
    measured_heights,
    uneven,
)
from .sines import random_phases

UNHELD = OWN + 4  # status
SUMS = 3  # of the fluctuation of lifts: lowest mass, front strip, rear strip


def bodies(*values: tuple[float, float, float]) -> dict[str, float]:
    """Parameters of head, frame and lower frame: the mass, kg, of each, its stiffness, N/m, and its damping, N.s/m."""
    names = zip(("head_", "frame_", "lower_frame."), values, strict=False)
    return {body + name: v for body, own in names for name, v in zip(("mass", "stiffness", "damping"), own, strict=True)}


class Pantograph(OdeComponent):
    """Pantograph with head, frame and contact spring; heights are positive upwards, 0 is the unloaded wire at a dropper.

        m1 z1'' = k1 (z2 - z1) + c1 (z2' - z1') - F
        m2 z2'' = F0 - k1 (z2 - z1) - c1 (z2' - z1') - k2 (z2 - z_work) - c2 z2'
        F = kc (z1 - w)

    z1, z2: head and frame, w: wire. With `lower_frame`, k2 and c2 act between frame and lower frame, and the static
    force, the lift and the base spring act on the lower frame.
    Source: EN 50318:2002 reference pantograph (numbers read in public sources, static force from memory).
    """

    title = "Lumped pantograph with contact spring"
    system = "railway"
    start_inputs = (
        "wire_height",
        "wire_compliance",
        "two_strips.wire_height",
        "two_strips.wire_compliance",
        "second_wire.wire_height",
        "second_wire.wire_compliance",
        "actuator.command",
        "base_excitation.height",
    )
    ports = {"contact": ("contact_position", "contact_force", "wire_height", "wire_compliance")}
    port_members = {"wire_compliance": "contact_compliance"}  # as the wire calls it
    output_sums = {
        "second_wire.total_force": ("contact_force", "second_wire.contact_force"),
        "two_strips.total_force": ("contact_force", "two_strips.contact_force"),
    }
    default_stop = 2.0

    contact_loss = ContactLoss
    lower_frame = LowerFrame
    two_strips = TwoStrips
    second_wire = SecondWire
    aerodynamic_uplift = AerodynamicUplift
    strip_lift = StripLift
    lift_fluctuation = LiftFluctuation
    wire_unevenness = WireUnevenness
    measured_unevenness = MeasuredUnevenness
    acceleration = Acceleration
    actuator = Actuator
    bump_stops = BumpStops
    frame_friction = FrameFriction
    base_excitation = BaseExcitation
    outer_contact = OuterContact

    speed = parameter(69.444444444444443, "m/s", "speed of the train", low=0.0, high=200.0, usual=(0.0, 118.0))
    start_position = parameter(30.0, "m", "position of the contact point at time 0")
    static_force = parameter(120.0, "N", "uplift force of the drive", low=0.0, tunable=True)
    head_mass = parameter(7.2, "kg", "mass of the head", low=1e-6)
    head_stiffness = parameter(4200.0, "N/m", "stiffness from the head to the frame", low=1e-3)
    head_damping = parameter(10.0, "N.s/m", "damping from the head to the frame", low=0.0)
    frame_mass = parameter(15.0, "kg", "mass of the frame", low=1e-6)
    frame_stiffness = parameter(50.0, "N/m", "stiffness from the frame to the base, or to the lower frame", low=0.0)
    frame_damping = parameter(90.0, "N.s/m", "damping from the frame to the base, or to the lower frame", low=0.0)
    contact_stiffness = parameter(50e3, "N/m", "stiffness of the contact spring", low=1e-3)
    working_height = parameter(0.0, "m", "height of the lowest mass at which the base spring is relaxed")
    substep = parameter(5e-4, "s", "longest internal step", low=1e-9, high=1.0)

    wire_height = input_(0.0, "m", "height of the contact wire at the contact point", nominal=0.05)
    wire_compliance = input_(
        0.0, "m/N", "compliance of the wire that its model leaves out, in series with the contact spring", nominal=1e-5
    )

    contact_force = output(
        "N",
        "force on the wire, positive upwards",
        nominal=100.0,
        feedthrough=("wire_height", "wire_compliance", "outer_contact.force"),
    )
    contact_position = output("m", "position of the contact point along the track", nominal=100.0)
    head_height = output("m", "height of the head", nominal=0.05)
    head_velocity = output("m/s", "vertical velocity of the head", nominal=0.1)
    frame_height = output("m", "height of the frame", nominal=0.05)

    presets = {
        "EN 50318:2002": Preset(
            bodies((7.2, 4200.0, 10.0), (15.0, 50.0, 90.0)) | {"static_force": 120.0, "contact_stiffness": 50e3},
            "masses, stiffnesses, damping: repository ChandraguptSharma07/faraway; static force from memory",
            "verbatim",
        ),
        "EN 50318:2018": Preset(
            bodies((7.5, 7000.0, 45.0), (9.0, 15500.0, 0.1), (6.0, 160.0, 100.0)) | {"contact_stiffness": 50e3},
            "masses and stiffnesses: two public repositories; order of the dampers and contact stiffness from memory",
            "unconfirmed",
            ("lower_frame",),
        ),
        "DSA380": Preset(
            bodies((7.12, 9430.0, 0.0), (6.0, 14100.0, 0.0), (5.8, 0.1, 70.0)) | {"static_force": 70.0},
            "IEEE-style paper on arcing, Tables I-III; repository pantograph-rigid-ocs-amm",
            "verbatim",
            ("lower_frame",),
        ),
        "DSA250": Preset(
            bodies((7.51, 8380.0, 0.0), (5.855, 6200.0, 0.0), (4.645, 80.0, 70.0)) | {"static_force": 120.0},
            "repository pantograph-rigid-ocs-amm",
            "verbatim",
            ("lower_frame",),
        ),
        "TSG18F": Preset(
            bodies((10.31, 53415.8, 29.60), (6.15, 6754.2, 0.20), (15.30, 40687.0, 1.14)) | {"static_force": 110.0},
            "repository pantograph-rigid-ocs-amm; first and third stiffness look odd there",
            "verbatim",
            ("lower_frame",),
        ),
    }

    refusals = {
        **REFUSALS,
        UNHELD: Refusal(
            "a lowest mass that no spring holds",
            "a start at rest on both strips",
            "Give the springs of frame and lower frame some stiffness.",
        ),
    }

    def states(self) -> int:
        """z1, z1', z2, z2', with `lower_frame` z3, z3', with `two_strips` heights of the front and the rear strip and pitch with
        their rates, with `actuator` its force."""
        return 4 + 2 * ("lower_frame" in self.on) + 6 * ("two_strips" in self.on) + ("actuator" in self.on)

    def shapes(self) -> dict[str, Any]:
        """`unevenness`, `fluctuation`: sines, see `sines`.  `measured`: positions and heights, (2, n) m.

        `slopes`: of the derivatives over the state, and workspace, (2, n, n).
        """
        n, get = self.states(), self.get
        unevenness = fluctuation = measured = None
        if "wire_unevenness" in self.on:
            unevenness = random_phases(get("wire_unevenness.components"), 1, get("wire_unevenness.seed"))
        if "lift_fluctuation" in self.on:
            fluctuation = random_phases(get("lift_fluctuation.components"), SUMS, get("lift_fluctuation.seed"))
        if "measured_unevenness" in self.on:
            measured = measured_heights(get("measured_unevenness.table"), self.name)
        return super().shapes() | {
            "unevenness": unevenness,
            "fluctuation": fluctuation,
            "measured": measured,
            "slopes": (2, n, n),
        }

    def energy(self) -> float:
        """Kinetic energy plus that of all springs, J; neither the static force nor a contact outside is counted."""
        s, p, e = self.arguments
        x = self.x
        springs = p.head_stiffness * (x[2] - x[0]) ** 2
        front, rear = contact_forces(self.t, x, self.u[0], s, p, e)
        if e.second_wire is not None:
            springs += rear**2 * (1.0 / p.contact_stiffness + self.u[0, e.second_wire.u + 1])
        if e.outer_contact is None:
            springs += front**2 * (1.0 / p.contact_stiffness + self.u[0, IN.wire_compliance])
        base_height = self.u[0, e.base_excitation.u] if e.base_excitation is not None else 0.0
        motion = p.head_mass * x[1] ** 2 + p.frame_mass * x[3] ** 2
        if e.lower_frame is None:
            springs += p.frame_stiffness * (x[2] - base_height - p.working_height) ** 2
        else:
            lower = e.lower_frame.stiffness * (x[4] - base_height - p.working_height) ** 2
            springs += p.frame_stiffness * (x[4] - x[2]) ** 2 + lower
            motion += e.lower_frame.mass * x[5] ** 2
        if e.bump_stops is not None:
            springs += e.bump_stops.stiffness * max(abs(x[0] - x[2]) - e.bump_stops.travel, 0.0) ** 2
        if e.two_strips is not None:
            strips, i = e.two_strips, first_strip(e)
            springs += rear**2 * (1.0 / p.contact_stiffness + self.u[0, strips.u + 1]) + strips.pitch_stiffness * x[i + 4] ** 2
            lift = 0.5 * strips.distance * x[i + 4]
            springs += strips.stiffness * ((x[0] + lift - x[i]) ** 2 + (x[0] - lift - x[i + 2]) ** 2)
            motion += strips.mass * (x[i + 1] ** 2 + x[i + 3] ** 2) + strips.pitch_inertia * x[i + 5] ** 2
        return 0.5 * (motion + springs)


IN = Pantograph.input_places()
OUT = Pantograph.output_places()


@kernel
def first_strip(e):
    """Index of the front strip in the state."""
    return 4 if e.lower_frame is None else 6


@kernel
def spring_force(approach, compliance, p, loss):
    """Force of a contact spring and the wire's own local compliance in series, N."""
    force = approach / (1.0 / p.contact_stiffness + compliance)
    if loss is not None:
        force = max(force, 0.0)
    return force


@kernel
def spring_forces(t, x, u, loss, s, p, e):
    """Force of the head or of its front strip, and of the rear strip or on the second wire, N; loss: None where contacts pull."""
    position = front_position(t, p, e)
    wire = uneven(u[IN.wire_height], position, s)
    if e.second_wire is not None:
        beside = x[0] - u[e.second_wire.u]
        return (spring_force(x[0] - wire, u[IN.wire_compliance], p, loss), spring_force(beside, u[e.second_wire.u + 1], p, loss))
    if e.two_strips is None:
        return spring_force(x[0] - wire, u[IN.wire_compliance], p, loss), 0.0
    i, rear = first_strip(e), uneven(u[e.two_strips.u], position - e.two_strips.distance, s)
    return (
        spring_force(x[i] - wire, u[IN.wire_compliance], p, loss),
        spring_force(x[i + 2] - rear, u[e.two_strips.u + 1], p, loss),
    )


@kernel
def contact_forces(t, x, u, s, p, e):
    """The result of `spring_forces`, or the force from outside, N."""
    if e.outer_contact is not None:
        return -u[e.outer_contact.u], 0.0
    return spring_forces(t, x, u, e.contact_loss, s, p, e)


@kernel
def strip_rates(t, x, dx, contact, s, p, e):
    """Rates of both strips and the pitch; the force of the strips on the head, N. contact: forces at front and rear, N."""
    strips, i = e.two_strips, first_strip(e)
    front, rear = contact
    reach = 0.5 * strips.distance
    to_front = strips.stiffness * (x[0] + reach * x[i + 4] - x[i]) + strips.damping * (x[1] + reach * x[i + 5] - x[i + 1])
    to_rear = strips.stiffness * (x[0] - reach * x[i + 4] - x[i + 2]) + strips.damping * (x[1] - reach * x[i + 5] - x[i + 3])
    on_front, on_rear = to_front - front, to_rear - rear
    if e.strip_lift is not None:
        on_front += lift_at(t, e.strip_lift.front, 1, s, p, e)
        on_rear += lift_at(t, e.strip_lift.rear, 2, s, p, e)
    moment = (to_rear - to_front) * reach + strips.friction * (front + rear) * strips.contact_height
    dx[i], dx[i + 2], dx[i + 4] = x[i + 1], x[i + 3], x[i + 5]
    dx[i + 1], dx[i + 3] = on_front / strips.mass, on_rear / strips.mass
    dx[i + 5] = (moment - strips.pitch_stiffness * x[i + 4] - strips.pitch_damping * x[i + 5]) / strips.pitch_inertia
    return to_front + to_rear


@kernel
def rates(t, x, u, dx, contact, s, p, e):
    """dx/dt of the state, see `Pantograph.states`; contact: the result of `contact_forces`."""
    head = p.head_stiffness * (x[2] - x[0]) + p.head_damping * (x[3] - x[1])
    if e.bump_stops is not None:
        travel = x[2] - x[0]
        head += e.bump_stops.stiffness * (max(travel - e.bump_stops.travel, 0.0) + min(travel + e.bump_stops.travel, 0.0))
    lift = p.static_force
    if e.aerodynamic_uplift is not None:
        lift += lift_at(t, e.aerodynamic_uplift.coefficient, 0, s, p, e)
    if e.actuator is not None:
        f = x.size - 1
        lift += x[f]
        dx[f] = (limited(u[e.actuator.u], e.actuator.limit) - x[f]) / e.actuator.time_constant
    base_height, base_velocity = p.working_height, 0.0
    if e.base_excitation is not None:
        base_height += u[e.base_excitation.u]
        base_velocity += u[e.base_excitation.u + 1]

    down = contact[0]
    if e.two_strips is not None:
        down = strip_rates(t, x, dx, contact, s, p, e)
    if e.second_wire is not None:
        down += contact[1]
    dx[0], dx[2] = x[1], x[3]
    dx[1] = (head - down) / p.head_mass
    if e.lower_frame is not None:
        frame = p.frame_stiffness * (x[4] - x[2]) + p.frame_damping * (x[5] - x[3])
        dx[4] = x[5]
        lower = e.lower_frame
        dx[5] = (lift - frame - lower.stiffness * (x[4] - base_height) - lower.damping * (x[5] - base_velocity)) / lower.mass
    else:
        frame = lift - p.frame_stiffness * (x[2] - base_height) - p.frame_damping * (x[3] - base_velocity)
    if e.frame_friction is not None:
        frame -= e.frame_friction.level * np.tanh((x[3] - base_velocity) / e.frame_friction.width)
    dx[3] = (frame - head) / p.frame_mass


@kernel
def pantograph_derivatives(t, x, u, dx, s, p, e):
    """dx/dt of the state."""
    rates(t, x, u, dx, contact_forces(t, x, u, s, p, e), s, p, e)


@kernel
def touching(t, x, u, dx, s, p, e):
    """dx/dt of the state with springs for contacts, which also pull: all is linear but friction and stops."""
    rates(t, x, u, dx, spring_forces(t, x, u, None, s, p, e), s, p, e)


slopes_touching = bind(find_slopes, __name__, derivatives=touching)  # exact as long as friction and stops stay as they are


@kernel
def pantograph_stable(t, s, p, e):
    """Limit of the internal step, radius / max |eigenvalue|, s: every spring engaged, friction where it is steepest."""
    x, u = s.work[0, : s.x.size], s.work[1, : s.u.shape[1]]
    x[:] = 0.0
    u[:] = 0.0
    if e.bump_stops is not None:
        x[2] = e.bump_stops.travel + 2.0
    if e.frame_friction is not None:
        x[3] = 40.0 * e.frame_friction.width  # where it is constant
    slopes_touching(t, x, u, 1.0, s, p, e)
    if e.frame_friction is not None:
        s.slopes[0, 3, 3] -= e.frame_friction.level / e.frame_friction.width / p.frame_mass
    return step_within(RK4_STABILITY_RADIUS, spectral_radius(s.slopes[0], s.slopes[1]))


@kernel
def rest_on_wire(lift, wire, contact, base_height, s, p, e):
    """Equilibrium with the head on a wire, into the state; contact: compliance of the contact, m/N."""
    x = s.x
    base_stiffness = p.frame_stiffness if e.lower_frame is None else e.lower_frame.stiffness
    above_wire = contact + 1.0 / p.head_stiffness  # height of the frame above the wire per force
    lowest = above_wire if e.lower_frame is None or p.frame_stiffness == 0.0 else above_wire + 1.0 / p.frame_stiffness
    force = (lift - base_stiffness * (wire - base_height - p.working_height)) / (1.0 + base_stiffness * lowest)
    x[0], x[2] = wire + force * contact, wire + force * above_wire
    if e.lower_frame is not None:
        x[4] = wire + force * lowest


@kernel
def rest_on_wires(lift, wire, base_height, s, p, e):
    """Equilibrium with the head on one of two wires or on both."""
    contact = 1.0 / p.contact_stiffness + s.u[0, IN.wire_compliance]
    rest_on_wire(lift, wire, contact, base_height, s, p, e)
    if e.second_wire is not None:
        second = s.u[0, e.second_wire.u]
        its = 1.0 / p.contact_stiffness + s.u[0, e.second_wire.u + 1]
        if s.x[0] > second:  # both springs as one, or the second alone
            joint = 1.0 / (1.0 / contact + 1.0 / its)
            rest_on_wire(lift, joint * (wire / contact + second / its), joint, base_height, s, p, e)
            if s.x[0] < wire:
                rest_on_wire(lift, second, its, base_height, s, p, e)


@kernel
def rest_on_strips(t, s, p, e):
    """Equilibrium with both strips on the wire, where the derivatives of the rates are zero; a status."""
    u, n = s.work[1, : s.u.shape[1]], s.x.size // 2
    for j in range(u.size):
        u[j] = s.u[0, j]
    if e.base_excitation is not None:
        u[e.base_excitation.u + 1] = 0.0
    by = 1.0
    if e.bump_stops is not None and e.bump_stops.travel > 0.0:
        by = min(by, e.bump_stops.travel)
    slopes_touching(t, s.x, u, by, s, p, e)
    A, b = s.slopes[1, :n, :n], s.work[5, :n]
    for i in range(n):
        b[i] = -s.work[2, 2 * i + 1]
        for j in range(n):
            A[i, j] = s.slopes[0, 2 * i + 1, 2 * j]
    if solve_dense(A, b) != DONE:
        return UNHELD
    for i in range(n):
        s.x[2 * i] = b[i]
    return DONE


@kernel
def pantograph_start(t, s, p, e):
    """Sines of the random effects, and equilibrium on the wire at its present height, the stops left alone."""
    if e.acceleration is not None and e.acceleration.rate * (e.acceleration.final_speed - p.speed) < 0.0:
        return WRONG_ACCELERATION
    status = fill_sines(s, e)
    if status != DONE:
        return status
    lift = p.static_force
    if e.aerodynamic_uplift is not None:
        lift += lift_at(t, e.aerodynamic_uplift.coefficient, 0, s, p, e)
    if e.actuator is not None:
        force = limited(s.u[0, e.actuator.u], e.actuator.limit)
        s.x[s.x.size - 1] = force
        lift += force
    if e.two_strips is not None:
        return rest_on_strips(t, s, p, e)
    base_height = s.u[0, e.base_excitation.u] if e.base_excitation is not None else 0.0
    rest_on_wires(lift, uneven(s.u[0, IN.wire_height], front_position(t, p, e), s), base_height, s, p, e)
    return DONE


@kernel
def pantograph_outputs(t, s, p, e):
    """Contact force, position of the contact point, heights and velocity."""
    x, y = s.x, s.y
    y[OUT.contact_force], rear = contact_forces(t, x, s.u[0], s, p, e)
    y[OUT.contact_position] = front_position(t, p, e)
    y[OUT.head_height], y[OUT.head_velocity], y[OUT.frame_height] = x[0], x[1], x[2]
    if e.two_strips is not None:
        i, k = first_strip(e), e.two_strips.y
        y[k], y[k + 1] = rear, y[OUT.contact_position] - e.two_strips.distance
        y[k + 2], y[k + 3], y[k + 4], y[k + 5] = x[i], x[i + 2], x[i + 4], y[OUT.contact_force] + rear
    if e.second_wire is not None:
        y[e.second_wire.y], y[e.second_wire.y + 1] = rear, y[OUT.contact_force] + rear
    if e.actuator is not None:
        y[e.actuator.y] = x[x.size - 1]
    return DONE


Pantograph.kernels = ode_kernels(
    __name__, start=pantograph_start, derivatives=pantograph_derivatives, outputs=pantograph_outputs, stable=pantograph_stable
)
