"""Station keeping in six degrees of freedom: a sampled PID controller of pose, and the allocation of its wrench to thrusters."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..core.component import Effect, Preset
from ..core.kernels import bind, kernel, kernel_tuple
from ..core.rotation import quaternion_of_angles, to_body, to_world
from ..core.sampled import SampledComponent, rows_in_use, sampled
from ..core.variables import input_, output, parameter
from .allocation import THRUSTERS, allocate, allocations, chosen
from .arrangement import EIGHT, columns, eight_arrangement, eight_places, places_of, wrench_matrix, y_arrangement
from .thrust_curve import ROWS, T200_COMMAND, T200_THRUST, check_curve, curve_command

POSES = 8
WAYS = ("north", "east", "depth", "roll", "pitch", "yaw")
POSITIONS, DIRECTIONS = (columns(table) for table in y_arrangement())
FURTHER_POSITIONS, FURTHER_DIRECTIONS = (columns(table[6:]) for table in eight_arrangement())
# the state: number of the next sample, commands, integrals of force (north, east, down) and moment, errors, scale; then the
# commands of further thrusters
COMMANDS, INTEGRALS, ERRORS, SCALE, STATES = 1, 7, 13, 19, 20


class InverseCurve(Effect):
    """Commands from the inverse of the thrusters' static curve, which steps over its dead band; off: in proportion to the limits.

    Numbers: T200 at 16 V, those of the effect `static_curve` of a thruster.
    """

    explicit_only = True

    command = parameter(T200_COMMAND, "1", "command of a row, not decreasing", size=ROWS, low=-1.0, high=1.0)
    thrust = parameter(T200_THRUST, "N", "thrust of a row, not decreasing", size=ROWS, nominal=10.0)


class Manoeuvre(Effect):
    """The set point moves through poses that are added to the constant one; each leg as 3 s² - 2 s³, at rest at both ends.

    Before the first time the first pose holds, after the last the last. Rows of equal time are a jump. A table with fewer
    rows than the arrays leaves the rest at 0. Angles are interpolated as roll, pitch and yaw.
    """

    explicit_only = True

    time = parameter(0.0, "s", "time of a pose, not decreasing", size=POSES)
    north = parameter(0.0, "m", "way to the north from the constant set point", size=POSES)
    east = parameter(0.0, "m", "way to the east from it", size=POSES)
    depth = parameter(0.0, "m", "way down from it", size=POSES)
    roll = parameter(0.0, "rad", "roll added to it", size=POSES)
    pitch = parameter(0.0, "rad", "pitch added to it", size=POSES)
    yaw = parameter(0.0, "rad", "yaw added to it", size=POSES)


class FurtherThrusters(Effect):
    """Thrusters 7 and 8 beside the six; the preset of eight thrusters moves all of them to its places."""

    explicit_only = True

    thruster_x = parameter(FURTHER_POSITIONS[0], "m", "place of thruster 7, 8, ahead", size=2)
    thruster_y = parameter(FURTHER_POSITIONS[1], "m", "place of thruster 7, 8, to starboard", size=2)
    thruster_z = parameter(FURTHER_POSITIONS[2], "m", "place of thruster 7, 8, down", size=2)
    thruster_direction_x = parameter(FURTHER_DIRECTIONS[0], "1", "direction of thrust, ahead", size=2)
    thruster_direction_y = parameter(FURTHER_DIRECTIONS[1], "1", "direction of thrust, to starboard", size=2)
    thruster_direction_z = parameter(FURTHER_DIRECTIONS[2], "1", "direction of thrust, down", size=2)

    available = input_(1.0, "1", "1 where thruster 7, 8 is there, 0 where it has failed", size=2)

    command = output("1", "command of thruster 7, 8, -1 to 1", size=2)


class RovController(SampledComponent):
    """PID controller of position and attitude with allocation to the thrusters, sampled, its commands held in between.

        force  = R' (I_p) + K_p R' (p_set - p) + K_v (R' p_set' - v),    I_p' = R K_i R' (p_set - p) + anti-windup
        moment = I_a + K_a e + K_w (w_set - w),                          I_a' = K_j e + anti-windup

    R turns body axes into north, east, down; e is the rotation vector from the present attitude to the wanted one, on the
    shorter way whichever sign the quaternion has. The integral of the position lives in north, east, down, where currents
    do. What limits and lost thrusters keep back of the wrench flows back into the integrals (back-calculation), so that they do
    not wind up. Samples are taken at the start and at whole multiples of the period; outputs at such an instant are its own.

    Defaults: gains for about 1.2 rad/s in position and 4 rad/s in attitude of a vehicle of 11.5 kg with its added mass, the
    Y-arrangement, T200 thrusters; all but the arrangement and the thrusters are choices of ours.
    """

    title = "Controller of an underwater vehicle"
    system = "rov"
    work_shape = (6, POSES)
    default_step = 0.02
    default_stop = 10.0
    start_inputs = (  # sampled at the start
        "position_north", "position_east", "depth", "quaternion_w", "quaternion_x", "quaternion_y", "quaternion_z", "surge",
        "sway", "heave", "roll_rate", "pitch_rate", "yaw_rate", "available", "further_thrusters.available")

    inverse_curve = InverseCurve
    manoeuvre = Manoeuvre
    further_thrusters = FurtherThrusters

    period = parameter(0.02, "s", "time between samples", low=1e-5)
    set_north = parameter(0.0, "m", "set point to the north")
    set_east = parameter(0.0, "m", "set point to the east")
    set_depth = parameter(0.0, "m", "set point of the depth")
    set_roll = parameter(0.0, "rad", "set point of the roll")
    set_pitch = parameter(0.0, "rad", "set point of the pitch")
    set_yaw = parameter(0.0, "rad", "set point of the heading")
    position_gain = parameter((24.0, 34.0, 37.0), "N/m", "force per error, along surge, sway, heave", size=3, low=0.0,
                              nominal=10.0)
    velocity_gain = parameter((35.0, 50.0, 55.0), "N.s/m", "force per error of the velocity", size=3, low=0.0, nominal=10.0)
    position_integral_gain = parameter((6.0, 8.0, 9.0), "N/m/s", "force per error and time", size=3,
                                       low=0.0)
    attitude_gain = parameter(4.0, "N.m/rad", "moment per error, about roll, pitch, yaw", size=3, low=0.0)
    rate_gain = parameter(1.8, "N.m.s/rad", "moment per error of the rate", size=3, low=0.0)
    attitude_integral_gain = parameter(1.5, "N.m/rad/s", "moment per error and time", size=3, low=0.0)
    reach = parameter(1.0, "m", "longest error of the position that is answered in full; a longer one counts as this long and is "
                      "not integrated, so that a long way or a place out of reach leaves thrust for depth and heading", low=1e-3)
    unwinding_time = parameter(1.0, "s", "time in which the integrals give up what is kept back of the wrench", low=1e-3)
    priority = parameter((1.0, 1.0, 100.0, 1.0, 1.0, 500.0), "1",
                         "weight of an axis's error where not all can be had; surge, sway, heave per N, roll, pitch, yaw per N.m",
                         size=6, low=1e-6)
    forward_limit = parameter(51.44, "N", "largest thrust ahead that is asked of a thruster", low=1e-6, nominal=10.0)
    reverse_limit = parameter(39.90, "N", "largest thrust astern", low=1e-6, nominal=10.0)
    thruster_x = parameter(POSITIONS[0], "m", "place of a thruster, ahead", size=THRUSTERS)
    thruster_y = parameter(POSITIONS[1], "m", "place of a thruster, to starboard", size=THRUSTERS)
    thruster_z = parameter(POSITIONS[2], "m", "place of a thruster, down", size=THRUSTERS)
    thruster_direction_x = parameter(DIRECTIONS[0], "1", "direction of thrust, ahead", size=THRUSTERS)
    thruster_direction_y = parameter(DIRECTIONS[1], "1", "direction of thrust, to starboard", size=THRUSTERS)
    thruster_direction_z = parameter(DIRECTIONS[2], "1", "direction of thrust, down", size=THRUSTERS)

    position_north = input_(0.0, "m", "position to the north")
    position_east = input_(0.0, "m", "position to the east")
    depth = input_(0.0, "m", "depth")
    quaternion_w = input_(1.0, "1", "attitude, body to north, east, down")
    quaternion_x = input_(0.0, "1", "attitude")
    quaternion_y = input_(0.0, "1", "attitude")
    quaternion_z = input_(0.0, "1", "attitude")
    surge = input_(0.0, "m/s", "velocity ahead")
    sway = input_(0.0, "m/s", "velocity to starboard")
    heave = input_(0.0, "m/s", "velocity down the body's axis")
    roll_rate = input_(0.0, "rad/s", "rate of roll")
    pitch_rate = input_(0.0, "rad/s", "rate of pitch")
    yaw_rate = input_(0.0, "rad/s", "rate of yaw")
    available = input_(1.0, "1", "1 where the thruster is there, 0 where it has failed", size=THRUSTERS)

    command = output("1", "command of a thruster, -1 to 1", size=THRUSTERS)
    error_north = output("m", "wanted position less the present one, to the north, at the last sample")
    error_east = output("m", "the same to the east")
    error_down = output("m", "the same downwards")
    error_roll = output("rad", "rotation from the present attitude to the wanted one, about the body's x")
    error_pitch = output("rad", "the same about y")
    error_yaw = output("rad", "the same about z")
    scale = output("1", "share of the wanted wrench that the limits of the thrusters allow")

    presets = {
        EIGHT: Preset(eight_places(), "the arrangement of the hull's preset of that name; gains are the component's own",
                      "recalled", ("further_thrusters",)),
    }

    def kernel_arguments(self) -> tuple[Any, ...]:
        """What the kernel gets: the control law, then the effects; curve and table of poses are checked."""
        p, e = self._declared_arguments()
        if e.inverse_curve is not None:
            check_curve(e.inverse_curve.command, e.inverse_curve.thrust, f"{self.name}: inverse_curve")
        if e.manoeuvre is not None:
            e = e._replace(manoeuvre=self._course(e.manoeuvre))
        matrix = wrench_matrix(*places_of(p, e.further_thrusters), self.name)
        law = Law(
            p.period, np.array([p.set_north, p.set_east, p.set_depth, p.set_roll, p.set_pitch, p.set_yaw]),
            np.concatenate((p.position_gain, p.attitude_gain)), np.concatenate((p.velocity_gain, p.rate_gain)),
            np.concatenate((p.position_integral_gain, p.attitude_integral_gain)), p.reach, p.unwinding_time,
            np.ascontiguousarray(matrix), allocations(matrix, p.priority), p.forward_limit, p.reverse_limit)
        return law, e

    def _course(self, manoeuvre: Any) -> Course:
        """Times and poses of the manoeuvre, its last row repeated to the end; an earlier time that is not 0 is refused."""
        poses = np.stack([getattr(manoeuvre, way) for way in WAYS], axis=1)
        rows = rows_in_use(f"{self.name}: manoeuvre", manoeuvre.time, poses)
        return Course(manoeuvre.time[rows], poses[rows])

    def initial_state(self, t: float) -> np.ndarray:
        """All zero."""
        return np.zeros(STATES + (2 if "further_thrusters" in self.on else 0))


@kernel_tuple
class Law(NamedTuple):
    """The control law for the kernels; gains (6,): surge, sway, heave, roll, pitch, yaw."""

    period: float
    set_point: np.ndarray  # (6,) north, east, depth, roll, pitch, yaw
    gain: np.ndarray
    rate_gain: np.ndarray
    integral_gain: np.ndarray
    reach: float
    unwinding_time: float
    matrix: np.ndarray  # (6, n), wrench per thrust
    allocations: np.ndarray  # (2^n, n, 6), thrusts per wrench
    forward_limit: float
    reverse_limit: float


@kernel_tuple
class Course(NamedTuple):
    """Times, (8,), and poses, (8, 6), of a manoeuvre for the kernels."""

    time: np.ndarray
    pose: np.ndarray


NORTH, QUATERNION, SURGE, ROLL_RATE, AVAILABLE = RovController.input_indices(
    "position_north", "quaternion_w", "surge", "roll_rate", "available[1]"
)


@kernel
def wanted(t, set_point, course, pose, rate):
    """Set point at time t: pose (6,), and its rate of change, (6,), angles as roll, pitch, yaw."""
    for j in range(6):
        pose[j], rate[j] = set_point[j], 0.0
    if course is not None:
        i = 0
        while i < POSES and course.time[i] <= t:
            i += 1
        before, after = max(i - 1, 0), min(i, POSES - 1)
        length = course.time[after] - course.time[before]
        share, share_rate = 0.0, 0.0
        if length > 0.0:
            s = (t - course.time[before]) / length
            share, share_rate = s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) / length
        for j in range(6):
            way = course.pose[after, j] - course.pose[before, j]
            pose[j] += course.pose[before, j] + share * way
            rate[j] = share_rate * way


@kernel
def turn_between(w, x, y, z, a, b, c, d):
    """Rotation vector from the attitude (w, x, y, z) to the attitude (a, b, c, d), in the axes of the first, rad.

    Both signs of either quaternion are one attitude and give one answer, at most half a turn long.
    """
    ew = w * a + x * b + y * c + z * d
    ex = w * b - x * a - y * d + z * c
    ey = w * c - y * a - z * b + x * d
    ez = w * d - z * a - x * c + y * b
    if ew < 0.0:
        ew, ex, ey, ez = -ew, -ex, -ey, -ez
    size = math.sqrt(ex * ex + ey * ey + ez * ez)
    scale = 2.0 * math.atan2(size, ew) / size if size > 0.0 else 0.0
    return scale * ex, scale * ey, scale * ez


@kernel
def command(thrust, law, e):
    """Command for a thrust in N."""
    if e.inverse_curve is not None:
        return curve_command(thrust, e.inverse_curve.command, e.inverse_curve.thrust)
    return thrust / (law.forward_limit if thrust > 0.0 else law.reverse_limit)


@kernel
def control_sample(t, u, x, work, law, e):
    """One sample at time t with the inputs u, (m,): commands, integrals and errors in x."""
    pose, rate, wrench, thrust, given = work[1], work[2], work[3], work[4], work[5]
    wanted(t, law.set_point, e.manoeuvre, pose, rate)
    qw, qx, qy, qz = u[QUATERNION], u[QUATERNION + 1], u[QUATERNION + 2], u[QUATERNION + 3]
    x[ERRORS], x[ERRORS + 1], x[ERRORS + 2] = pose[0] - u[NORTH], pose[1] - u[NORTH + 1], pose[2] - u[NORTH + 2]
    a, b, c, d = quaternion_of_angles(pose[3], pose[4], pose[5])
    x[ERRORS + 3], x[ERRORS + 4], x[ERRORS + 5] = turn_between(qw, qx, qy, qz, a, b, c, d)

    far = math.sqrt(x[ERRORS] ** 2 + x[ERRORS + 1] ** 2 + x[ERRORS + 2] ** 2)
    share, near = (law.reach / far, 0.0) if far > law.reach else (1.0, 1.0)
    error = to_body(qw, qx, qy, qz, share * x[ERRORS], share * x[ERRORS + 1], share * x[ERRORS + 2])
    v = to_body(qw, qx, qy, qz, rate[0], rate[1], rate[2])
    f = to_body(qw, qx, qy, qz, x[INTEGRALS], x[INTEGRALS + 1], x[INTEGRALS + 2])
    # angular velocity of the wanted attitude in its own axes, then in the world's, then in the body's
    sr, cr, sp, cp = math.sin(pose[3]), math.cos(pose[3]), math.sin(pose[4]), math.cos(pose[4])
    turn = to_world(a, b, c, d, rate[3] - rate[5] * sp, rate[4] * cr + rate[5] * cp * sr, rate[5] * cp * cr - rate[4] * sr)
    turn = to_body(qw, qx, qy, qz, turn[0], turn[1], turn[2])
    for j in range(3):
        wrench[j] = f[j] + law.gain[j] * error[j] + law.rate_gain[j] * (v[j] - u[SURGE + j])
        k = j + 3
        wrench[k] = x[INTEGRALS + k] + law.gain[k] * x[ERRORS + k] + law.rate_gain[k] * (turn[j] - u[ROLL_RATE + j])

    choice = chosen(u, AVAILABLE, THRUSTERS)
    if e.further_thrusters is not None:
        choice += chosen(u, e.further_thrusters.u, 2) << THRUSTERS
    x[SCALE] = allocate(wrench, law.allocations[choice], law.matrix, law.forward_limit, law.reverse_limit, thrust, given)
    for i in range(THRUSTERS):
        x[COMMANDS + i] = command(thrust[i], law, e)
    if e.further_thrusters is not None:
        for i in range(2):
            x[STATES + i] = command(thrust[THRUSTERS + i], law, e)

    for j in range(6):
        given[j] = (given[j] - wrench[j]) / law.unwinding_time
    gained = to_world(qw, qx, qy, qz, near * law.integral_gain[0] * error[0] + given[0],
                      near * law.integral_gain[1] * error[1] + given[1], near * law.integral_gain[2] * error[2] + given[2])
    for j in range(3):
        x[INTEGRALS + j] += law.period * gained[j]
        x[INTEGRALS + 3 + j] += law.period * (law.integral_gain[3 + j] * x[ERRORS + 3 + j] + given[3 + j])


@kernel
def control_outputs(x, y):
    """Commands, errors, scale and further commands of the last sample."""
    for i in range(THRUSTERS):
        y[i] = x[COMMANDS + i]
    for j in range(x.size - ERRORS):
        y[THRUSTERS + j] = x[ERRORS + j]


RovController.sample_kernel = control_sample
RovController.output_kernel = control_outputs
RovController.advance = bind(sampled, __name__, sample=control_sample, outputs=control_outputs)
