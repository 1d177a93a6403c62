"""The wrist: two rows of carpal bones that carry the hand, with four rules of motion as effects."""

from __future__ import annotations

import math
from typing import Any

from ..core.component import Effect, Preset
from ..core.contract import Refusal
from ..core.errors import StepFailed
from ..core.integrators import RK4_STABILITY_RADIUS, OdeComponent, ode_kernels
from ..core.kernels import DONE, NOT_FINITE, OWN, kernel
from ..core.spectrum import spectral_radius, step_within
from ..core.variables import choice, input_, output, parameter
from .kinematics import (
    COUPLING_MODELS,
    DISTAL_TILT,
    PROXIMAL_TILT,
    ROW_OFFSET,
    Axes,
    axes_refusals,
    axes_status,
    combined,
    crossing,
    pose,
)
from .ligament_springs import COLUMNS, COUNT, SPRING, make_ligaments, write_bundle
from .ligaments import Constraint
from .rigid_ligaments import RIGID_REFUSALS, make_rigid
from .wrist_equations import (
    Q1,
    Q2,
    RATE_1,
    RATE_2,
    TENDONS,
    axes_of,
    hand_of,
    mass_matrix,
    motion,
    point_turning,
    power_lost,
    row_flexion,
    wrist_derivatives,
    wrist_energy,
    wrist_pose,
)

GIVES_WAY, FLEXION_LIMITS, DEVIATION_LIMITS, CONTACT_LIMITS, SINGULAR = range(OWN + 3, OWN + 8)  # statuses
RIGID = 1  # of the choice `constraint.kind`
CROSSING, MOST_COUPLING = range(2)  # of the array `checked`


class Morphology(Effect):
    """Finite rotations about the rows' oblique axes, of which the distal one is carried; off, small angles about default axes."""

    proximal_tilt = parameter(PROXIMAL_TILT, "rad", "tilt of the proximal row's axis from that of flexion, towards deviation")
    distal_tilt = parameter(DISTAL_TILT, "rad", "tilt of the distal row's axis from that of flexion, the other way")
    row_offset = parameter(ROW_OFFSET, "m", "distance of the distal row's axis from the proximal one's along the hand", low=0.0)


class Interaction(Effect):
    """Contact: limits of flexion, of deviation and of the rows against each other, stiffness * depth * (1 + d * rate).

    With the coupling model `opensim_half` the contact limits the second coordinate, that of deviation.
    """

    flexion_lower = parameter(-1.22173, "rad", "limit of extension")
    flexion_upper = parameter(1.22173, "rad", "limit of flexion")
    deviation_lower = parameter(-0.436332, "rad", "limit of ulnar deviation")
    deviation_upper = parameter(0.610865, "rad", "limit of radial deviation")
    stiffness = parameter(200.0, "N.m/rad", "stiffness of the limits", low=0.0)
    contact_lower = parameter(-0.8, "rad", "distal row angle at which the rows touch in extension of the distal row")
    contact_upper = parameter(0.8, "rad", "distal row angle at which the rows touch in its flexion")
    contact_stiffness = parameter(200.0, "N.m/rad", "stiffness of the contact of the rows", low=0.0)
    dissipation = parameter(0.2, "s/rad", "d, growth of the torques with the rate into a limit", low=0.0)


class Load(Effect):
    """Tendons with constant moment arms, the weight of the hand, and a force at a point on its long axis."""

    requires = ("morphology",)

    gravity_x = parameter(-9.81, "m/s2", "gravity in the radius along x; by default the forearm is level and the palm faces down")
    gravity_y = parameter(0.0, "m/s2", "gravity in the radius along y, towards the hand")
    gravity_z = parameter(0.0, "m/s2", "gravity in the radius along z, towards the thumb")
    flexion_arm = parameter(
        (0.015, 0.016, -0.012, -0.006),
        "m",
        "arms in flexion: radial flexor, ulnar flexor, radial extensor, ulnar extensor",
        size=TENDONS,
    )
    deviation_arm = parameter((0.008, -0.016, 0.015, -0.020), "m", "arms of the same in deviation, radial positive", size=TENDONS)
    tool_distance = parameter(0.1, "m", "distance from the wrist's centre of the point on the long axis that bears the force")

    flexor_radial = input_(0.0, "N", "force of the radial flexor of the wrist", nominal=10.0)
    flexor_ulnar = input_(0.0, "N", "force of the ulnar flexor", nominal=10.0)
    extensor_radial = input_(0.0, "N", "force of the radial extensors", nominal=10.0)
    extensor_ulnar = input_(0.0, "N", "force of the ulnar extensor", nominal=10.0)
    tip_force_x = input_(0.0, "N", "force on the point of the hand along x of the radius")
    tip_force_y = input_(0.0, "N", "force on the point of the hand along y")
    tip_force_z = input_(0.0, "N", "force on the point of the hand along z")

    flexor_radial_rate = output("m/s", "rate at which the radial flexor shortens", nominal=0.1)
    flexor_ulnar_rate = output("m/s", "rate at which the ulnar flexor shortens", nominal=0.1)
    extensor_radial_rate = output("m/s", "rate at which the radial extensors shorten", nominal=0.1)
    extensor_ulnar_rate = output("m/s", "rate at which the ulnar extensor shortens", nominal=0.1)
    tip_x = output("m", "place of the point of the hand along x of the radius", nominal=0.1)
    tip_y = output("m", "place of the point along y", nominal=0.1)
    tip_z = output("m", "place of the point along z", nominal=0.1)
    tip_velocity_x = output("m/s", "velocity of the point along x")
    tip_velocity_y = output("m/s", "velocity of the point along y")
    tip_velocity_z = output("m/s", "velocity of the point along z")


class Wrist(OdeComponent):
    """Two rows that carry the hand, each on its own axis (see `kinematics`), with the four rules of Sandow (2020) as effects.

        M(q) q'' + h(q, q') + D q' + J^T K e = J^T (tau_flexion, tau_deviation) + (proximal torque, distal torque) + effects

    e = (flexion, deviation), J = de/dq, q the angles of the rows; K is the passive stiffness of the wrist as a whole. A torque
    times the rate of its angle is its power, so tau_deviation bends about an axis that flexes with the hand. Without effects
    the angles are small, J, M are constant, and the wrist is a linear oscillator of two degrees of freedom.
    With the coupling model `opensim_half` q are a flexion and a deviation of which each row makes one half; the angles, rates and
    torques named proximal and distal are then those of these two. The hand's own flexion and deviation are the same for small
    angles, and for one of them alone: half turns that follow one another mix by 7 % at 57 and 34 degrees.
    From the paper, known to us by its abstract, are two degrees of freedom with roll largely prevented, the four rules
    morphology, constraint, interaction and load, and the signs of the rows' motion. Axes, equations and numbers are ours, but for
    the limits of flexion and deviation (wrist model of Gonzalez, Buchanan and Delp, 1997, as it comes with OpenSim) and the
    preset's stiffness. Mass and inertia of the hand are orders of magnitude from memory.
    """

    title = "Wrist of two rows"
    system = "wrist"
    start_inputs = ()
    default_stop = 2.0

    morphology = Morphology
    constraint = Constraint
    interaction = Interaction
    load = Load

    coupling_model = choice("rules", COUPLING_MODELS, "how the rows share the motion: own oblique axes, or half of all each")
    hand_mass = parameter(0.45, "kg", "mass of the hand", low=0.0)
    hand_distance = parameter(0.07, "m", "distance of the hand's centre of mass from the wrist's centre", low=0.0)
    transverse_inertia = parameter(1e-3, "kg.m2", "moment of inertia of the hand across its long axis, centre of mass", low=0.0)
    axial_inertia = parameter(4e-4, "kg.m2", "moment of inertia of the hand about its long axis", low=0.0)
    row_inertia = parameter(1e-5, "kg.m2", "moment of inertia of the proximal row, about any axis", low=0.0)
    flexion_stiffness = parameter(1.0, "N.m/rad", "passive stiffness in flexion", low=0.0)
    deviation_stiffness = parameter(1.0, "N.m/rad", "passive stiffness in deviation", low=0.0)
    coupling_stiffness = parameter(0.0, "N.m/rad", "torque in flexion by deviation, and the other way round")
    proximal_damping = parameter(0.025, "N.m.s/rad", "damping of the proximal row", low=0.0)
    distal_damping = parameter(0.025, "N.m.s/rad", "damping of the distal row against the proximal one", low=0.0)
    start_proximal_angle = parameter(0.0, "rad", "angle of the proximal row at the start")
    start_distal_angle = parameter(0.0, "rad", "angle of the distal row at the start")
    start_proximal_rate = parameter(0.0, "rad/s", "rate of the proximal row at the start")
    start_distal_rate = parameter(0.0, "rad/s", "rate of the distal row at the start")
    substep = parameter(1e-3, "s", "longest internal step", low=1e-9, high=1.0)

    tau_flexion = input_(0.0, "N.m", "torque on the hand in flexion")
    tau_deviation = input_(0.0, "N.m", "torque on the hand in radial deviation")
    proximal_torque = input_(0.0, "N.m", "torque on the proximal row's angle, as from ligaments and tendons")
    distal_torque = input_(0.0, "N.m", "torque on the distal row's angle, as from ligaments and tendons")

    flexion = output("rad", "flexion of the hand")
    deviation = output("rad", "radial deviation of the hand")
    roll = output("rad", "roll of the hand about its long axis, which the rows cause on the way", nominal=0.1)
    flexion_rate = output("rad/s", "rate of the flexion")
    deviation_rate = output("rad/s", "rate of the radial deviation")
    proximal_angle = output("rad", "angle of the proximal row about its axis")
    distal_angle = output("rad", "angle of the distal row about its axis, against the proximal row")
    proximal_rate = output("rad/s", "rate of the proximal row")
    distal_rate = output("rad/s", "rate of the distal row against the proximal row")
    proximal_flexion = output("rad", "what the proximal row contributes to flexion")
    distal_flexion = output("rad", "what the distal row contributes to flexion")
    mechanical_energy = output("J", "energy of motion, stiffness, ligaments, limits and height over the hand at rest")
    dissipation = output("W", "power lost in damping, limits and ligaments")

    presets = {
        "cadaver": Preset(
            {"flexion_stiffness": 11.466, "deviation_stiffness": 20.048, "coupling_stiffness": 5.736},
            "0.15 N m/deg in ulnar flexion and 0.40 N m/deg in radial flexion, six wrists, PMC3016043; put together by us as a "
            "matrix with its soft direction 26.6 degrees from flexion",
            "computed",
        )
    }

    refusals = {
        **axes_refusals("{morphology.proximal_tilt}", "{morphology.distal_tilt}", f"{{checked[{CROSSING}]}}"),
        **RIGID_REFUSALS,
        GIVES_WAY: Refusal(
            "coupling_stiffness = {coupling_stiffness} N.m/rad",
            f"at most {{checked[{MOST_COUPLING}]}} N.m/rad either way",
            "Beyond, the passive wrist gives way by itself.",
        ),
        SINGULAR: Refusal(
            "a hand without inertia in one of its motions: the mass matrix is singular",
            "inertia in both",
            "Give transverse_inertia, or hand_mass and hand_distance.",
        ),
        **{
            status: Refusal(
                f"limits of {limit} at {{interaction.{limit}_lower}} and {{interaction.{limit}_upper}} rad", "first the lower"
            )
            for status, limit in ((FLEXION_LIMITS, "flexion"), (DEVIATION_LIMITS, "deviation"), (CONTACT_LIMITS, "contact"))
        },
    }

    def states(self) -> int:
        """q1, q2, q1', q2'."""
        return 4

    def shapes(self) -> dict[str, Any]:
        """`ligaments`: see `ligament_springs`.  `held`: 1 for a row that rigid ones hold.  `lengths`: of a refused one, mm.

        `checked`: sine of the angle between the axes, largest coupling stiffness, N.m/rad.  `matrix`: of the linear equations,
        and workspace.
        """
        held = "constraint" in self.on
        return super().shapes() | {
            "ligaments": (COUNT, COLUMNS) if held else None,
            "held": 2 if held else None,
            "lengths": 2 if held else None,
            "checked": 2,
            "matrix": (2, 4, 4),
        }

    def axes(self) -> Axes:
        """Where the axes lie at rest."""
        return axes_of(*self._parameters())

    def energy(self) -> float:
        """The output `mechanical_energy`, J."""
        s, p, e = self.arguments
        hand = hand_of(p, e)
        return float(wrist_energy(wrist_pose(self.x, hand, e.morphology), self.x, hand, s.ligaments, e.interaction, e.load))

    def _check(self, status: int) -> None:
        if status == NOT_FINITE:
            reason = "the hand is turned farther than angles of a wrist can tell, or a row by over a radian within a substep"
            raise StepFailed(self.name, self.t, reason, "Give the effect interaction, which has limits, or reduce the loads")
        super()._check(status)


OUT = Wrist.output_places()


@kernel
def limits_status(interaction):
    """Refuses a lower limit that is not below the upper one."""
    if not interaction.flexion_lower < interaction.flexion_upper:
        return FLEXION_LIMITS
    if not interaction.deviation_lower < interaction.deviation_upper:
        return DEVIATION_LIMITS
    return DONE if interaction.contact_lower < interaction.contact_upper else CONTACT_LIMITS


@kernel
def wrist_start(t, s, p, e):
    """The state that the parameters say, and the ligaments."""
    hand = hand_of(p, e)
    s.checked[CROSSING] = crossing(hand.axes)
    status = axes_status(hand.axes)
    if status != DONE:
        return status
    s.checked[MOST_COUPLING] = math.sqrt(p.flexion_stiffness * p.deviation_stiffness)
    if p.flexion_stiffness * p.deviation_stiffness < p.coupling_stiffness * p.coupling_stiffness:
        return GIVES_WAY
    if e.interaction is not None:
        status = limits_status(e.interaction)
        if status != DONE:
            return status
    m11, m12, m22 = mass_matrix(pose(0.0, 0.0, hand.axes), hand)
    if not m11 * m22 - m12 * m12 > 1e-12 * m11 * m22:  # also both zero
        return SINGULAR
    s.x[0], s.x[1], s.x[2], s.x[3] = p.start_proximal_angle, p.start_distal_angle, p.start_proximal_rate, p.start_distal_rate
    if e.constraint is not None:
        make_ligaments(e.constraint, s.ligaments)
        if e.constraint.kind == RIGID:
            return make_rigid(hand.axes, e.constraint, s)
    return DONE


@kernel
def wrist_outputs(t, s, p, e):
    """Angles and rates of the hand and of the rows, energy, and the outputs of effects."""
    x, y, c = s.x, s.y, hand_of(p, e)
    at = wrist_pose(x, c, e.morphology)
    y[OUT.flexion], y[OUT.deviation], y[OUT.roll] = at.flexion, at.deviation, at.roll
    y[OUT.flexion_rate] = at.flexion_1 * x[RATE_1] + at.flexion_2 * x[RATE_2]
    y[OUT.deviation_rate] = at.deviation_1 * x[RATE_1] + at.deviation_2 * x[RATE_2]
    y[OUT.proximal_angle], y[OUT.distal_angle], y[OUT.proximal_rate], y[OUT.distal_rate] = x[Q1], x[Q2], x[RATE_1], x[RATE_2]
    y[OUT.proximal_flexion], y[OUT.distal_flexion] = row_flexion(x, c)
    y[OUT.mechanical_energy] = wrist_energy(at, x, c, s.ligaments, e.interaction, e.load)
    y[OUT.dissipation] = power_lost(at, x, c, s.ligaments, e.interaction)
    if e.constraint is not None:
        write_bundle(x[Q1], x[Q2], x[RATE_1], x[RATE_2], y, e.constraint.y, c.axes, s.ligaments)
        k = e.constraint.y + 2 * COUNT
        _, _, y[k], y[k + 1] = motion(at, x, s.u[0], c, s, e)
    if e.load is not None:
        for j in range(TENDONS):
            y[e.load.y + j] = e.load.flexion_arm[j] * y[OUT.flexion_rate] + e.load.deviation_arm[j] * y[OUT.deviation_rate]
        k, offset = e.load.y + TENDONS, c.axes.offset
        y[k], y[k + 1], y[k + 2] = combined(offset, at.row, e.load.tool_distance - offset, at.hand)
        tip_1, tip_2 = point_turning(at, e.load.tool_distance, c)
        y[k + 3], y[k + 4], y[k + 5] = combined(x[RATE_1], tip_1, x[RATE_2], tip_2)
    return DONE


@kernel
def longest_arm(j, ligaments):
    """Distance from the wrist's centre of the farther end of ligament j, m."""
    first, second = 0.0, 0.0
    for k in range(3):
        first += ligaments[j, k] * ligaments[j, k]
        second += ligaments[j, 3 + k] * ligaments[j, 3 + k]
    return math.sqrt(max(first, second))


@kernel
def fastest_at(q1, q2, own_1, own_2, more, s, hand):
    """Largest |eigenvalue| at a position, 1/s; 0 without inertia, which is refused.

    own_1, own_2: stiffness of the coordinates; more: of flexion and of deviation besides the passive one, N.m/rad.
    """
    at = pose(q1, q2, hand.axes)
    m11, m12, m22 = mass_matrix(at, hand)
    determinant = m11 * m22 - m12 * m12
    if not determinant > 0.0:
        return 0.0
    flexing, deviating, both = hand.flexion_stiffness + more, hand.deviation_stiffness + more, hand.coupling_stiffness
    by_1, by_2 = flexing * at.flexion_1 + both * at.deviation_1, flexing * at.flexion_2 + both * at.deviation_2
    to_1, to_2 = both * at.flexion_1 + deviating * at.deviation_1, both * at.flexion_2 + deviating * at.deviation_2
    k11, k12 = at.flexion_1 * by_1 + at.deviation_1 * to_1 + own_1, at.flexion_1 * by_2 + at.deviation_1 * to_2
    k22 = at.flexion_2 * by_2 + at.deviation_2 * to_2 + own_2
    d1, d2 = hand.proximal_damping, hand.distal_damping
    A = s.matrix[0]
    A[:] = 0.0
    A[0, 2], A[1, 3] = 1.0, 1.0
    A[2, 0], A[2, 1] = (m12 * k12 - m22 * k11) / determinant, (m12 * k22 - m22 * k12) / determinant
    A[3, 0], A[3, 1] = (m12 * k11 - m11 * k12) / determinant, (m12 * k12 - m11 * k22) / determinant
    A[2, 2], A[2, 3] = -m22 * d1 / determinant, m12 * d2 / determinant
    A[3, 2], A[3, 3] = m12 * d1 / determinant, -m11 * d2 / determinant
    return spectral_radius(A, s.matrix[1])


@kernel
def wrist_stable(t, s, p, e):
    """Limit of the internal step, radius / max |eigenvalue|, s: every limit touched, every ligament at its longest arm."""
    hand, own, contact, more = hand_of(p, e), 0.0, 0.0, 0.0
    if e.interaction is not None:
        more, contact = e.interaction.stiffness, e.interaction.contact_stiffness
    if s.ligaments is not None:
        for j in range(COUNT):
            arm = longest_arm(j, s.ligaments)
            own += s.ligaments[j, SPRING] * arm * arm
    if e.load is not None:
        pull = e.load.gravity_x * e.load.gravity_x + e.load.gravity_y * e.load.gravity_y + e.load.gravity_z * e.load.gravity_z
        own += hand.mass * hand.distance * math.sqrt(pull)
    fastest = fastest_at(0.0, 0.0, own, own + contact, more, s, hand)
    if e.morphology is not None:
        for way in (-0.8, 0.8):
            fastest = max(
                fastest,
                fastest_at(0.0, way, own, own + contact, more, s, hand),
                fastest_at(way, 0.0, own, own + contact, more, s, hand),
            )
    return step_within(RK4_STABILITY_RADIUS, fastest)


Wrist.kernels = ode_kernels(
    __name__, start=wrist_start, derivatives=wrist_derivatives, outputs=wrist_outputs, stable=wrist_stable
)
