"""The wrist: two rows of carpal bones that carry the hand, with four rules of motion as effects."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..core.component import Effect, Preset
from ..core.errors import BadInput, StepFailed
from ..core.integrators import RK4_STABILITY_RADIUS, OdeComponent, rk4
from ..core.kernels import NOT_FINITE, bind
from ..core.variables import choice, input_, output, parameter
from .kinematics import COUPLING_MODELS, DISTAL_TILT, PROXIMAL_TILT, ROW_OFFSET, Axes, check_axes, pose
from .ligament_springs import COUNT, Ligaments, make_ligaments
from .ligaments import Constraint
from .rigid_ligaments import rigid_ligaments
from .wrist_equations import TENDONS, Hand, Held, mass_matrix, wrist_derivatives, wrist_energy, wrist_outputs, wrist_pose


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
    flexion_arm = parameter((0.015, 0.016, -0.012, -0.006), "m", "arms in flexion: radial flexor, ulnar flexor, radial extensor, "
                            "ulnar extensor", size=TENDONS)
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
    preset's stiffness. Mass and inertia of the hand are recalled orders of magnitude.
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
            "matrix with its soft direction 26.6 degrees from flexion", "computed"),
    }

    def axes(self) -> Axes:
        """Where the axes lie at rest."""
        p, e = self._declared_arguments()
        if e.morphology is None:
            return Axes(p.coupling_model, PROXIMAL_TILT, DISTAL_TILT, 0.0)
        return Axes(p.coupling_model, e.morphology.proximal_tilt, e.morphology.distal_tilt, e.morphology.row_offset)

    def _ligaments(self, constraint: Any) -> Ligaments:
        springs = make_ligaments(constraint)
        if self.get("constraint.kind") == "springs":
            return springs
        of_springs = ("toe", "damping", *(f"stiffness[{j + 1}]" for j in range(COUNT)))
        for name in (f"constraint.{n}" for n in of_springs):
            if self.get(name) != type(self).variables[name].start:
                raise BadInput(self.name, f"{name} = {self.get(name):g} of rigid ligaments", "springs, or no such number",
                               "Leave it out: rigid ligaments have none.")
        return rigid_ligaments(self.axes(), springs, constraint.cut, self.initial_state(), self.name)

    def kernel_arguments(self) -> tuple[Any, ...]:
        """Axes and hand, then the effects; of the constraint, the ligaments."""
        p, e = self._declared_arguments()
        hand = Hand(self.axes(), p.hand_mass, p.hand_distance, p.transverse_inertia, p.axial_inertia, p.row_inertia,
                    p.flexion_stiffness, p.deviation_stiffness, p.coupling_stiffness, p.proximal_damping, p.distal_damping,
                    p.substep)
        held = None if e.constraint is None else Held(e.constraint.y, self._ligaments(e.constraint))
        return hand, e._replace(constraint=held)

    def _initialize(self, t: float) -> int:
        p, e = self._declared_arguments()
        check_axes(self.axes(), self.name)
        if p.flexion_stiffness * p.deviation_stiffness < p.coupling_stiffness**2:
            raise BadInput(self.name, f"coupling_stiffness = {p.coupling_stiffness:g} N.m/rad",
                           f"at most {math.sqrt(p.flexion_stiffness * p.deviation_stiffness):.4g} N.m/rad either way",
                           "Beyond, the passive wrist gives way by itself.")
        if e.interaction is not None:
            for limit in ("flexion", "deviation", "contact"):
                lower, upper = self.get(f"interaction.{limit}_lower"), self.get(f"interaction.{limit}_upper")
                if not lower < upper:
                    raise BadInput(self.name, f"limits of {limit} at {lower:g} and {upper:g} rad", "first the lower")
        m11, m12, m22 = mass_matrix(pose(0.0, 0.0, self.axes()), self.kernel_arguments()[0])
        if not m11 * m22 - m12 * m12 > 1e-12 * m11 * m22:  # also both zero
            raise BadInput(self.name, "a hand without inertia in one of its motions: the mass matrix is singular",
                           "inertia in both", "Give transverse_inertia, or hand_mass and hand_distance.")
        return super()._initialize(t)

    def initial_state(self) -> np.ndarray:
        """(q1, q2, q1', q2') of the parameters."""
        p = self._declared_arguments()[0]
        return np.array([p.start_proximal_angle, p.start_distal_angle, p.start_proximal_rate, p.start_distal_rate])

    def energy(self) -> float:
        """The output `mechanical_energy`, J."""
        hand, e = self.arguments
        return float(wrist_energy(wrist_pose(self.x, hand, e.morphology), self.x, hand, e.constraint, e.interaction, e.load))

    def stable_step(self) -> float:
        """RK4's limit, radius / max |eigenvalue|, with every limit touched and every ligament at its longest arm, s."""
        hand, e = self.kernel_arguments()
        K = np.array([[hand.flexion_stiffness, hand.coupling_stiffness], [hand.coupling_stiffness, hand.deviation_stiffness]])
        own = np.zeros(2)
        if e.interaction is not None:
            K = K + e.interaction.stiffness * np.eye(2)
            own[1] = e.interaction.contact_stiffness
        if e.constraint is not None:
            ligaments = e.constraint.ligaments
            arms = np.linalg.norm(ligaments.ends.reshape(COUNT, 2, 3), axis=2).max(axis=1)
            own += float(ligaments.stiffness @ arms**2)
        if e.load is not None:
            own += hand.mass * hand.distance * math.hypot(e.load.gravity_x, e.load.gravity_y, e.load.gravity_z)
        D = np.diag([hand.proximal_damping, hand.distal_damping])
        largest = 0.0
        for q1, q2 in ((0.0, 0.0), (0.0, 0.8), (0.0, -0.8), (0.8, 0.0), (-0.8, 0.0)) if e.morphology is not None else ((0.0,
                                                                                                                        0.0),):
            at = pose(q1, q2, hand.axes)
            m11, m12, m22 = mass_matrix(at, hand)
            M = np.array([[m11, m12], [m12, m22]])
            if not np.linalg.det(M) > 0.0:
                return math.inf  # refused by `_initialize`
            J = np.array([[at.flexion_1, at.flexion_2], [at.deviation_1, at.deviation_2]])
            A = np.block([[np.zeros((2, 2)), np.eye(2)],
                          [-np.linalg.solve(M, J.T @ K @ J + np.diag(own)), -np.linalg.solve(M, D)]])
            largest = max(largest, float(np.abs(np.linalg.eigvals(A)).max()))
        return RK4_STABILITY_RADIUS / largest if largest > 0.0 else math.inf

    def _check(self, status: int) -> None:
        if status == NOT_FINITE:
            reason = "the hand is turned farther than angles of a wrist can tell, or a row by over a radian within a substep"
            raise StepFailed(self.name, self.t, reason, "Give the effect interaction, which has limits, or reduce the loads")
        super()._check(status)


Wrist.advance = bind(rk4, __name__, derivatives=wrist_derivatives, outputs=wrist_outputs)
Wrist.output_kernel = wrist_outputs
