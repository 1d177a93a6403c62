"""Hull of an underwater vehicle with six thrusters: a rigid body in water, in six degrees of freedom."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.integrators import RK4_STABILITY_RADIUS, OdeComponent, ode_kernels
from ..core.kernels import DONE, OWN, in_python, kernel
from ..core.rotation import angles, quaternion_of_angles, to_body, to_world
from ..core.spectrum import spectral_radius, step_within
from ..core.variables import flag, input_, output, parameter
from . import hull_equations
from .arrangement import REFUSALS, arrange, columns, eight_arrangement, y_arrangement
from .coupling import REFUSALS as OF_COUPLING
from .coupling import AddedMassCoupling, LinearDragCoupling, QuadraticDragCoupling, check_coupling, fill_masses, six
from .hull_equations import hull_derivatives, invert, least_moment, rigid_mass, tether_velocity, water_velocity, wrench
from .vehicles import VEHICLES

POSITIONS, DIRECTIONS = map(columns, y_arrangement())
FURTHER_POSITIONS, FURTHER_DIRECTIONS = (columns(table[6:]) for table in eight_arrangement())
TOP_SPEED, TOP_RATE = 2.0, 2.0  # m/s, rad/s: up to these the default step is stable; faster than the vehicles of the presets
TURN = 2.0 * math.pi
NO_BODY = OWN + 1  # status


class AddedMass(Effect):
    """Water that moves with the hull: its inertia, inverted together with the hull's own."""

    surge = parameter(5.5, "kg", "added mass along x", low=0.0)
    sway = parameter(12.7, "kg", "added mass along y", low=0.0)
    heave = parameter(14.57, "kg", "added mass along z", low=0.0)
    roll = parameter(0.12, "kg.m2", "added inertia about x", low=0.0)
    pitch = parameter(0.12, "kg.m2", "added inertia about y", low=0.0)
    yaw = parameter(0.12, "kg.m2", "added inertia about z", low=0.0)


class Coriolis(Effect):
    """Coriolis and centripetal forces of the hull and, where there is added mass, of the water, Munk's moment among them.

    Off, the equations hold for slow motion only.
    """


class LinearDrag(Effect):
    """Drag in proportion to the speed through the water."""

    surge = parameter(4.03, "N.s/m", "drag along x per speed", low=0.0)
    sway = parameter(6.22, "N.s/m", "drag along y per speed", low=0.0)
    heave = parameter(5.18, "N.s/m", "drag along z per speed", low=0.0)
    roll = parameter(0.07, "N.m.s", "drag moment about x per rate", low=0.0)
    pitch = parameter(0.07, "N.m.s", "drag moment about y per rate", low=0.0)
    yaw = parameter(0.07, "N.m.s", "drag moment about z per rate", low=0.0)


class QuadraticDrag(Effect):
    """Drag in proportion to the square of the speed through the water, of each axis for itself."""

    surge = parameter(18.18, "N.s2/m2", "drag along x per speed squared", low=0.0)
    sway = parameter(21.66, "N.s2/m2", "drag along y per speed squared", low=0.0)
    heave = parameter(36.99, "N.s2/m2", "drag along z per speed squared", low=0.0)
    roll = parameter(1.55, "N.m.s2", "drag moment about x per rate squared", low=0.0)
    pitch = parameter(1.55, "N.m.s2", "drag moment about y per rate squared", low=0.0)
    yaw = parameter(1.55, "N.m.s2", "drag moment about z per rate squared", low=0.0)


class Restoring(Effect):
    """Weight at the centre of gravity and buoyancy at the centre of buoyancy, fully submerged."""

    weight = parameter(112.8, "N", "weight", low=0.0)
    buoyancy = parameter(114.8, "N", "buoyancy", low=0.0)
    centre_of_buoyancy_x = parameter(0.0, "m", "centre of buoyancy ahead of the origin")
    centre_of_buoyancy_y = parameter(0.0, "m", "centre of buoyancy to starboard of the origin")
    centre_of_buoyancy_z = parameter(0.0, "m", "centre of buoyancy below the origin")


class Current(Effect):
    """Water that moves, the same all around the vehicle: drag and added mass see the motion relative to it."""

    velocity_north = input_(0.0, "m/s", "velocity of the water to the north")
    velocity_east = input_(0.0, "m/s", "velocity of the water to the east")
    velocity_down = input_(0.0, "m/s", "velocity of the water downwards")
    acceleration_north = input_(0.0, "m/s2", "acceleration of the water to the north; acts on the added mass")
    acceleration_east = input_(0.0, "m/s2", "acceleration of the water to the east; acts on the added mass")
    acceleration_down = input_(0.0, "m/s2", "acceleration of the water downwards; acts on the added mass")


class PressureGradient(Effect):
    """Force of the pressure gradient of accelerating water on the displaced volume (Froude and Krylov), rho V R^T v_c'.

    In a current that varies over hours it is nothing; in waves it is as large as that on the added mass, and a neutral vehicle
    without it does not move with the water. For bodies small beside the wavelength. Number: buoyancy of Wu (2018) over g.
    """

    requires = ("current",)
    explicit_only = True

    displaced_mass = parameter(114.8 / 9.80665, "kg", "mass of the displaced water", low=0.0)
    centre_x = parameter(0.0, "m", "centre of the displaced volume ahead of the origin")
    centre_y = parameter(0.0, "m", "centre of the displaced volume to starboard of the origin")
    centre_z = parameter(0.0, "m", "centre of the displaced volume below the origin")


class FurtherThrusters(Effect):
    """Thrusters 7 and 8 beside the six; the preset of eight thrusters moves all of them to its places."""

    explicit_only = True

    thruster_x = parameter(FURTHER_POSITIONS[0], "m", "place of thruster 7, 8 ahead of the origin", size=2)
    thruster_y = parameter(FURTHER_POSITIONS[1], "m", "place of thruster 7, 8 to starboard of the origin", size=2)
    thruster_z = parameter(FURTHER_POSITIONS[2], "m", "place of thruster 7, 8 below the origin", size=2)
    thruster_direction_x = parameter(FURTHER_DIRECTIONS[0], "1", "direction of a positive thrust on the hull, ahead", size=2)
    thruster_direction_y = parameter(FURTHER_DIRECTIONS[1], "1", "direction of a positive thrust, to starboard", size=2)
    thruster_direction_z = parameter(FURTHER_DIRECTIONS[2], "1", "direction of a positive thrust, downwards", size=2)

    thrust = input_(0.0, "N", "thrust of thruster 7, 8 on the hull along its direction", nominal=10.0, size=2)

    axial_speed = output(
        "m/s",
        "speed of the hull at thruster 7, 8, along its direction, through the water",
        size=2,
        feedthrough=tuple(f"current.velocity_{way}" for way in ("north", "east", "down")),
    )


class TetherLoad(Effect):
    """A force at a point of the hull, in world axes, and that point's motion: where a tether attaches."""

    attachment_x = parameter(-0.2, "m", "attachment ahead of the origin; a choice of ours")
    attachment_y = parameter(0.0, "m", "attachment to starboard of the origin")
    attachment_z = parameter(-0.1, "m", "attachment below the origin; a choice of ours")

    force_north = input_(0.0, "N", "force of the tether on the hull to the north", nominal=10.0)
    force_east = input_(0.0, "N", "force of the tether on the hull to the east", nominal=10.0)
    force_down = input_(0.0, "N", "force of the tether on the hull downwards", nominal=10.0)

    position_north = output("m", "position of the attachment to the north")
    position_east = output("m", "position of the attachment to the east")
    position_down = output("m", "position of the attachment downwards")
    velocity_north = output("m/s", "velocity of the attachment to the north")
    velocity_east = output("m/s", "velocity of the attachment to the east")
    velocity_down = output("m/s", "velocity of the attachment downwards")


FLOW = tuple(f"current.velocity_{way}" for way in ("north", "east", "down"))
LOADS = (
    *(f"thrust[{i}]" for i in range(1, 7)),
    "further_thrusters.thrust[1]",
    "further_thrusters.thrust[2]",
    *FLOW,
    *(f"current.acceleration_{way}" for way in ("north", "east", "down")),
    *(f"tether.force_{way}" for way in ("north", "east", "down")),
    *(f".{what}_{axis}" for what in ("force", "moment") for axis in "xyz"),
)


class External(Effect):
    """A further force and moment on the hull, in body axes, and the accelerations that answer at once."""

    force_x = input_(0.0, "N", "force ahead", nominal=10.0)
    force_y = input_(0.0, "N", "force to starboard", nominal=10.0)
    force_z = input_(0.0, "N", "force downwards in body axes", nominal=10.0)
    moment_x = input_(0.0, "N.m", "moment about x")
    moment_y = input_(0.0, "N.m", "moment about y")
    moment_z = input_(0.0, "N.m", "moment about z")

    acceleration_x = output("m/s2", "rate of change of the surge speed", feedthrough=LOADS)
    acceleration_y = output("m/s2", "rate of change of the sway speed", feedthrough=LOADS)
    acceleration_z = output("m/s2", "rate of change of the heave speed", feedthrough=LOADS)
    angular_acceleration_x = output("rad/s2", "rate of change of the roll rate", feedthrough=LOADS)
    angular_acceleration_y = output("rad/s2", "rate of change of the pitch rate", feedthrough=LOADS)
    angular_acceleration_z = output("rad/s2", "rate of change of the yaw rate", feedthrough=LOADS)


class RovHull(OdeComponent):
    """Position p in world axes (north, east, down), attitude q, velocities nu = (v, w) in body axes (ahead, starboard, down).

        p' = R(q) v,   q' = q (0, w) / 2,   nu_r = nu - (R(q)^T v_c, 0)
        (M_RB + M_A) nu' = T F + tau - C_RB(nu) nu - C_A(nu_r) nu_r - D nu_r - D2 |nu_r| nu_r - g(q) + M_A (R^T v_c)'
        C nu = (w × P, w × H + v × P)  with  (P, H) = M nu

    M_A, D and D2 have numbers beside their diagonals with the effects `added_mass_coupling`, `linear_drag_coupling` and
    `quadratic_drag_coupling`. F: thrusts; T: their wrench about the origin, from positions and directions; v_c: velocity of
    the water, uniform over the hull; tau: tether and external loads. Each term below the rigid body's inertia is an effect.
    The force of the pressure gradient on the displaced volume, which the source leaves out, is the effect `pressure_gradient`.
    Source of the equations: Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, Wiley 2011, chapters 6 to 8.
    Source of the thrusters' places: Kabanov, Kramar, Ermakov, Drones 5 (2021) 113; see `arrangement`. Mass and drag of their
    vehicle were not refused, and the numbers of a BlueROV2 of Wu (2018) stand in for them: the default vehicle is like theirs
    in its thrusters, not a model of it.
    The quaternion has norm 1 at the end of every macro step. Within 0.1 degrees of the vertical roll keeps its last value and
    yaw takes the rest, with `attitude_valid` 0.
    """

    title = "Hull of an underwater vehicle with six thrusters"
    system = "rov"
    start_inputs = ()
    default_step = 0.02
    default_stop = 10.0

    added_mass = AddedMass
    coriolis = Coriolis
    linear_drag = LinearDrag
    quadratic_drag = QuadraticDrag
    restoring = Restoring
    current = Current
    pressure_gradient = PressureGradient
    further_thrusters = FurtherThrusters
    tether = TetherLoad
    external = External
    added_mass_coupling = AddedMassCoupling
    linear_drag_coupling = LinearDragCoupling
    quadratic_drag_coupling = QuadraticDragCoupling

    mass = parameter(11.5, "kg", "mass", low=1e-6)
    inertia_x = parameter(0.16, "kg.m2", "moment of inertia about x through the origin", low=1e-9)
    inertia_y = parameter(0.16, "kg.m2", "moment of inertia about y through the origin", low=1e-9)
    inertia_z = parameter(0.16, "kg.m2", "moment of inertia about z through the origin", low=1e-9)
    centre_of_gravity_x = parameter(0.0, "m", "centre of gravity ahead of the origin")
    centre_of_gravity_y = parameter(0.0, "m", "centre of gravity to starboard of the origin")
    centre_of_gravity_z = parameter(0.02, "m", "centre of gravity below the origin")
    thruster_x = parameter(POSITIONS[0], "m", "place of the thruster ahead of the origin", size=6)
    thruster_y = parameter(POSITIONS[1], "m", "place of the thruster to starboard of the origin", size=6)
    thruster_z = parameter(POSITIONS[2], "m", "place of the thruster below the origin", size=6)
    thruster_direction_x = parameter(DIRECTIONS[0], "1", "direction of a positive thrust on the hull, ahead", size=6)
    thruster_direction_y = parameter(DIRECTIONS[1], "1", "direction of a positive thrust on the hull, to starboard", size=6)
    thruster_direction_z = parameter(DIRECTIONS[2], "1", "direction of a positive thrust on the hull, downwards", size=6)
    start_position_north = parameter(0.0, "m", "position to the north at the start")
    start_position_east = parameter(0.0, "m", "position to the east at the start")
    start_depth = parameter(0.0, "m", "depth at the start")
    start_roll = parameter(0.0, "rad", "roll at the start")
    start_pitch = parameter(0.0, "rad", "pitch at the start")
    start_yaw = parameter(0.0, "rad", "yaw at the start, 0 to the north, positive to the east")
    start_surge = parameter(0.0, "m/s", "speed over ground ahead at the start")
    start_sway = parameter(0.0, "m/s", "speed over ground to starboard at the start")
    start_heave = parameter(0.0, "m/s", "speed over ground downwards in body axes at the start")
    start_roll_rate = parameter(0.0, "rad/s", "angular velocity about x at the start")
    start_pitch_rate = parameter(0.0, "rad/s", "angular velocity about y at the start")
    start_yaw_rate = parameter(0.0, "rad/s", "angular velocity about z at the start")
    substep = parameter(0.01, "s", "longest internal step", low=1e-9, high=1.0)

    thrust = input_(0.0, "N", "thrust of the thruster on the hull along its direction", nominal=10.0, size=6)

    position_north = output("m", "position of the origin to the north")
    position_east = output("m", "position of the origin to the east")
    depth = output("m", "depth of the origin")
    quaternion_w = output("1", "attitude, body axes to world axes: scalar part of the quaternion")
    quaternion_x = output("1", "attitude: x of the quaternion")
    quaternion_y = output("1", "attitude: y of the quaternion")
    quaternion_z = output("1", "attitude: z of the quaternion")
    surge = output("m/s", "speed over ground ahead")
    sway = output("m/s", "speed over ground to starboard")
    heave = output("m/s", "speed over ground downwards in body axes")
    roll_rate = output("rad/s", "angular velocity about x")
    pitch_rate = output("rad/s", "angular velocity about y")
    yaw_rate = output("rad/s", "angular velocity about z")
    roll = output("rad", "roll, in (-pi, pi]")
    pitch = output("rad", "pitch, positive bow up, in [-pi/2, pi/2]")
    yaw = output("rad", "yaw, in (-pi, pi]")
    attitude_valid = flag("1 where roll and yaw are determinate, 0 within 0.1 degrees of the vertical")
    axial_speed = output(
        "m/s", "speed of the hull at the thruster, along its direction, through the water", size=6, feedthrough=FLOW
    )

    presets = VEHICLES

    refusals = (
        REFUSALS
        | OF_COUPLING
        | {
            NO_BODY: Refusal(
                "moments of inertia that leave {refused[0]} kg.m2 about the centre of gravity",
                "positive ones",
                "The inertia is about the origin: that about the centre of gravity plus mass times the square of the distance.",
            )
        }
    )

    def states(self) -> int:
        """Position, quaternion, velocities, roll kept."""
        return 14

    def shapes(self) -> dict[str, Any]:
        """Constants that masses, arrangement and weight determine; (X, Y, Z, K, M, N) in body axes about the origin.

        `rigid`: (6, 6) mass matrix of the rigid body.  `added`: (6,) masses.  `inverse`: (6, 6) of both.  `thrusters`: (6, n)
        wrench per thrust, those of `further_thrusters` last.  `righting`: see `hull_equations`.  `matrix`: of the linear equations, and
        workspace.  `refused`: (7,) numbers of a refusal.  `water`: (3, 6, 6) added mass, linear and quadratic drag beside their diagonals.
        """
        coupled = {"added_mass_coupling", "linear_drag_coupling", "quadratic_drag_coupling"} & {*self.on}
        n = 8 if "further_thrusters" in self.on else 6
        return super().shapes() | {
            "rigid": (6, 6),
            "added": 6,
            "inverse": (6, 6),
            "thrusters": (6, n),
            "righting": hull_equations.Righting,
            "matrix": (2, 12, 12),
            "refused": 7,
            "water": (3, 6, 6) if coupled else None,
        }

    def masses(self) -> tuple[np.ndarray, np.ndarray]:
        """Rigid body's and added mass matrix about the origin, (6, 6) each, of the present parameters."""
        (p, e), rigid, added = self._parameters(), np.zeros((6, 6)), np.zeros(6)
        in_python(rigid_mass)(p, rigid)
        if e.added_mass is not None:
            in_python(six)(e.added_mass, added)
        matrix = np.diag(added)
        if e.added_mass_coupling is not None:
            beside = np.zeros((6, 6))
            in_python(fill_masses)(e.added_mass_coupling, beside)
            matrix += beside
        return rigid, matrix

    @staticmethod
    def _moved(s: Any, e: Any) -> np.ndarray:
        """Added mass matrix, (6, 6), that the last initialization has computed."""
        return np.diag(s.added) if e.added_mass_coupling is None else np.diag(s.added) + s.water[0]

    def energy(self) -> float:
        """Energy of the hull's motion, of the water's relative to the current, and of weight and buoyancy, J."""
        (s, _, e), x = self.arguments, self.x
        velocity, q = x[7:13], tuple(x[3:7])
        relative = velocity.copy()
        if e.current is not None:
            relative[:3] -= to_body(*q, *self.u[0, e.current.u : e.current.u + 3])
        total = 0.5 * (velocity @ s.rigid @ velocity + relative @ self._moved(s, e) @ relative)
        if e.restoring is not None:
            total -= (e.restoring.weight - e.restoring.buoyancy) * x[2] + to_world(*q, *s.righting)[2]
        return float(total)


OUT = RovHull.output_places()


@kernel
def hull_start(t, s, p, e):
    """Masses, arrangement and righting moment; then the pose and the velocities given."""
    x = s.x
    s.refused[0] = least_moment(p)
    if not s.refused[0] > 0.0:
        return NO_BODY
    status = arrange(s.thrusters, s.refused, p, e.further_thrusters)
    if status != DONE:
        return status
    rigid_mass(p, s.rigid)
    if e.added_mass is not None:
        six(e.added_mass, s.added)
    status = check_coupling(s, e, s.work[0], s.matrix[0, :6, :6], s.matrix[1, :6, :6])
    if status != DONE:
        return status
    beside = s.water[0] if e.added_mass_coupling is not None else None
    status = invert(s.rigid, s.added, beside, s.inverse, s.matrix[0, :6, :6], s.matrix[1, 0, :6])
    if status != DONE:
        return status
    if e.restoring is not None:
        r = e.restoring
        s.righting.x = r.weight * p.centre_of_gravity_x - r.buoyancy * r.centre_of_buoyancy_x
        s.righting.y = r.weight * p.centre_of_gravity_y - r.buoyancy * r.centre_of_buoyancy_y
        s.righting.z = r.weight * p.centre_of_gravity_z - r.buoyancy * r.centre_of_buoyancy_z
    x[0], x[1], x[2] = p.start_position_north, p.start_position_east, p.start_depth
    x[3], x[4], x[5], x[6] = quaternion_of_angles(p.start_roll, p.start_pitch, p.start_yaw)
    x[7], x[8], x[9] = p.start_surge, p.start_sway, p.start_heave
    x[10], x[11], x[12] = p.start_roll_rate, p.start_pitch_rate, p.start_yaw_rate
    roll = np.fmod(p.start_roll, TURN)
    x[13] = roll - math.copysign(TURN, roll) if abs(roll) > 0.5 * TURN else roll
    return DONE


@kernel
def axial_speed(n, x, water, T):
    """Speed of thruster n along its direction through the water, m/s; T: `thrusters`."""
    cx, cy, cz = water
    return (
        T[0, n] * (x[7] - cx)
        + T[1, n] * (x[8] - cy)
        + T[2, n] * (x[9] - cz)
        + T[3, n] * x[10]
        + T[4, n] * x[11]
        + T[5, n] * x[12]
    )


@kernel
def hull_outputs(t, s, p, e):
    """Pose, velocities, angles, speed of each thruster through the water; the attachment's motion; the accelerations."""
    x, u, y = s.x, s.u[0], s.y
    for n in range(13):
        y[n] = x[n]
    y[OUT.roll], y[OUT.pitch], y[OUT.yaw], y[OUT.attitude_valid] = angles(x[3], x[4], x[5], x[6], x[13])
    water = water_velocity(x, u, e.current)
    for n in range(6):
        y[OUT.axial_speed + n] = axial_speed(n, x, water, s.thrusters)
    if e.further_thrusters is not None:
        for n in range(6, 8):
            y[e.further_thrusters.y + n - 6] = axial_speed(n, x, water, s.thrusters)
    if e.tether is not None:
        w, i, j, k = x[3], x[4], x[5], x[6]
        n = e.tether.y
        dx, dy, dz = to_world(w, i, j, k, e.tether.attachment_x, e.tether.attachment_y, e.tether.attachment_z)
        y[n], y[n + 1], y[n + 2] = x[0] + dx, x[1] + dy, x[2] + dz
        vx, vy, vz = tether_velocity(x, e.tether)
        y[n + 3], y[n + 4], y[n + 5] = to_world(w, i, j, k, vx, vy, vz)
    if e.external is not None:
        X, Y, Z, K, M, N = wrench(x, u, s, p, e)
        m = s.inverse
        for n in range(6):
            y[e.external.y + n] = m[n, 0] * X + m[n, 1] * Y + m[n, 2] * Z + m[n, 3] * K + m[n, 4] * M + m[n, 5] * N
    return DONE


@kernel
def steady_outputs(t, s, p, e):
    """End of a step: the quaternion back to norm 1, the roll that was last determinate is kept; then the outputs."""
    x = s.x
    norm = math.sqrt(x[3] * x[3] + x[4] * x[4] + x[5] * x[5] + x[6] * x[6])
    for n in range(3, 7):
        x[n] /= norm
    x[13] = angles(x[3], x[4], x[5], x[6], x[13])[0]
    return hull_outputs(t, s, p, e)


@kernel
def hull_stable(t, s, p, e):
    """RK4's limit, radius / max |eigenvalue| at the speeds of the start, or at 2 m/s and 2 rad/s if they are higher, s."""
    A, drag, square = s.matrix[0], s.work[0], s.work[1]
    drag[:] = 0.0
    square[:] = 0.0
    if e.linear_drag is not None:
        six(e.linear_drag, drag)
    if e.quadratic_drag is not None:
        six(e.quadratic_drag, square)
    A[:] = 0.0
    spin, stiffness = TOP_RATE, 0.0
    if e.restoring is not None:
        stiffness = math.sqrt(s.righting.x**2 + s.righting.y**2 + s.righting.z**2)
    for j in range(6):
        fastest = max(abs(s.x[7 + j]), TOP_SPEED if j < 3 else TOP_RATE)
        if j > 2:
            spin = max(spin, fastest)
        A[j, 6 + j] = 1.0
        for i in range(6):
            A[6 + i, j] = -s.inverse[i, j] * stiffness if j > 2 else 0.0
            A[6 + i, 6 + j] = -s.inverse[i, j] * (drag[j] + 2.0 * fastest * square[j])
            for k in range(6):
                if e.linear_drag_coupling is not None:
                    A[6 + i, 6 + j] -= s.inverse[i, k] * s.water[1, k, j]
                if e.quadratic_drag_coupling is not None:
                    A[6 + i, 6 + j] -= s.inverse[i, k] * 2.0 * fastest * s.water[2, k, j]
    return step_within(RK4_STABILITY_RADIUS, max(spectral_radius(A, s.matrix[1]), spin))


# the quaternion comes back to its length at the end of a step, not where outputs are looked at
RovHull.kernels = ode_kernels(
    __name__, start=hull_start, derivatives=hull_derivatives, outputs=steady_outputs, stable=hull_stable
)._replace(outputs=hull_outputs)
