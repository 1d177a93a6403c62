"""Station keeping in six degrees of freedom: a sampled PID controller of pose, and the allocation of its wrench to thrusters."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..core.component import Effect, Preset
from ..core.contract import Refusal
from ..core.kernels import DONE, OWN, in_python, kernel
from ..core.rotation import quaternion_of_angles, to_body, to_world
from ..core.sampled import SampledComponent, is_zero_behind, rows_in_use, sampled_kernels
from ..core.variables import input_, output, parameter
from .allocation import THRUSTERS, allocate, chosen, fill_allocation, share_out
from .arrangement import EIGHT, REFUSALS, arrange, columns, eight_arrangement, eight_places, y_arrangement
from .thrust_curve import ROWS, T200_COMMAND, T200_THRUST, check_curve, curve_command, curve_refusals

POSES = 8
TIME_FALLS = OWN + 4  # status
POSITIONS, DIRECTIONS = (columns(table) for table in y_arrangement())
FURTHER_POSITIONS, FURTHER_DIRECTIONS = (columns(table[6:]) for table in eight_arrangement())
NAVIGATION = ("position_north", "position_east", "depth", "quaternion_w", "quaternion_x", "quaternion_y", "quaternion_z",
              "surge", "sway", "heave", "roll_rate", "pitch_rate", "yaw_rate")  # fmt: skip
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

        force  = R^T I_p + K_p R^T (p_set - p) + K_v (R^T p_set' - v),    I_p' = R K_i R^T (p_set - p) + anti-windup
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
    ports = {"navigation": NAVIGATION}
    start_inputs = (  # sampled at the start
        *NAVIGATION,
        "available",
        "further_thrusters.available",
    )

    inverse_curve = InverseCurve
    manoeuvre = Manoeuvre
    further_thrusters = FurtherThrusters

    period = parameter(0.02, "s", "time between samples", low=1e-5)
    set_north = parameter(0.0, "m", "set point to the north", tunable=True)
    set_east = parameter(0.0, "m", "set point to the east", tunable=True)
    set_depth = parameter(0.0, "m", "set point of the depth", tunable=True)
    set_roll = parameter(0.0, "rad", "set point of the roll", tunable=True)
    set_pitch = parameter(0.0, "rad", "set point of the pitch", tunable=True)
    set_yaw = parameter(0.0, "rad", "set point of the heading", tunable=True)
    position_gain = parameter(
        (24.0, 34.0, 37.0), "N/m", "force per error, along surge, sway, heave", size=3, low=0.0, nominal=10.0, tunable=True
    )
    velocity_gain = parameter(
        (35.0, 50.0, 55.0), "N.s/m", "force per error of the velocity", size=3, low=0.0, nominal=10.0, tunable=True
    )
    position_integral_gain = parameter((6.0, 8.0, 9.0), "N/m/s", "force per error and time", size=3, low=0.0, tunable=True)
    attitude_gain = parameter(4.0, "N.m/rad", "moment per error, about roll, pitch, yaw", size=3, low=0.0, tunable=True)
    rate_gain = parameter(1.8, "N.m.s/rad", "moment per error of the rate", size=3, low=0.0, tunable=True)
    attitude_integral_gain = parameter(1.5, "N.m/rad/s", "moment per error and time", size=3, low=0.0, tunable=True)
    reach = parameter(
        1.0,
        "m",
        "longest error of the position that is answered in full; a longer one counts as this long and is "
        "not integrated, so that a long way or a place out of reach leaves thrust for depth and heading",
        low=1e-3,
    )
    unwinding_time = parameter(
        1.0, "s", "time in which the integrals give up what is kept back of the wrench", low=1e-3, tunable=True
    )
    priority = parameter(
        (1.0, 1.0, 100.0, 1.0, 1.0, 500.0),
        "1",
        "weight of an axis's error where not all can be had; surge, sway, heave per N, roll, pitch, yaw per N.m",
        size=6,
        low=1e-6,
    )
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
        EIGHT: Preset(
            eight_places(),
            "the arrangement of the hull's preset of that name; gains are the component's own",
            "unconfirmed",
            ("further_thrusters",),
        )
    }

    refusals = (
        REFUSALS
        | curve_refusals("inverse_curve")
        | {
            TIME_FALLS: Refusal(
                "manoeuvre: time[{refused[0]}] = {refused[1]} s, then {refused[2]} s",
                "times that do not decrease, and zeros behind the last row",
            )
        }
    )

    def states(self) -> int:
        """See the top of the file."""
        return STATES + (2 if "further_thrusters" in self.on else 0)

    def shapes(self) -> dict[str, Any]:
        """Constants that the arrangement and the table of poses determine.

        `matrix`: (6, n) wrench per thrust.  `table`: (n, 6) thrusts per wrench, of the thrusters whose bits are in `choice`,
        (1,).  `rows`: (1,) in use of the manoeuvre.  `allocation`: workspace, and `free`, `sharing` where some thrusters are at their
        limits.  `refused`: (4,) numbers of a refusal.
        """
        further = "further_thrusters" in self.on
        n = THRUSTERS + (2 if further else 0)
        return super().shapes() | {
            "matrix": (6, n),
            "table": (n, 6),
            "choice": np.zeros(1, dtype=np.int64),
            "allocation": (4, n, n + 6),
            "free": (n, 6) if further else None,
            "sharing": (6, n) if further else None,
            "refused": 4,
            "rows": np.zeros(1, dtype=np.int64) if "manoeuvre" in self.on else None,
        }

    def set_points(self, times: np.ndarray) -> np.ndarray:
        """Wanted pose at some times, (n, 6): north, east, depth in m, roll, pitch, yaw in rad."""
        (p, e), poses, rate = self._parameters(), np.zeros((len(times), 6)), np.zeros(6)
        rows = [0 if e.manoeuvre is None else in_python(rows_in_use)(e.manoeuvre.time)]
        for t, pose in zip(times, poses, strict=True):
            in_python(wanted)(t, p, e.manoeuvre, rows, pose, rate)
        return poses


IN = RovController.input_places()


@kernel
def control_start(t, s, p, e):
    """Curve, table of poses and arrangement are checked; all states are zero before the first sample."""
    if e.inverse_curve is not None:
        status = check_curve(e.inverse_curve.command, e.inverse_curve.thrust, s.refused)
        if status != DONE:
            return status
    if e.manoeuvre is not None:
        m = e.manoeuvre
        rows = rows_in_use(m.time)
        s.rows[0] = rows
        if not (
            is_zero_behind(m.time, rows)
            and is_zero_behind(m.north, rows)
            and is_zero_behind(m.east, rows)
            and is_zero_behind(m.depth, rows)
            and is_zero_behind(m.roll, rows)
            and is_zero_behind(m.pitch, rows)
            and is_zero_behind(m.yaw, rows)
        ):
            s.refused[0], s.refused[1], s.refused[2] = rows, m.time[rows - 1], m.time[rows]
            return TIME_FALLS
    s.choice[0] = -1  # no table yet
    return arrange(s.matrix, s.refused, p, e.further_thrusters)


@kernel
def on_leg(way, before, after, share, share_rate):
    """A way at a share of the leg between two rows, and its rate."""
    length = way[after] - way[before]
    return way[before] + share * length, share_rate * length


@kernel
def wanted(t, p, manoeuvre, rows, pose, rate):
    """Set point at time t: pose (6,), and its rate of change, (6,), angles as roll, pitch, yaw."""
    pose[0], pose[1], pose[2] = p.set_north, p.set_east, p.set_depth
    pose[3], pose[4], pose[5] = p.set_roll, p.set_pitch, p.set_yaw
    for j in range(6):
        rate[j] = 0.0
    if manoeuvre is not None:
        time, n, i = manoeuvre.time, rows[0], 0
        while i < n and time[i] <= t:
            i += 1
        before, after = max(i - 1, 0), min(i, n - 1)
        length = time[after] - time[before]
        share, share_rate = 0.0, 0.0
        if length > 0.0:
            r = (t - time[before]) / length
            share, share_rate = r * r * (3.0 - 2.0 * r), 6.0 * r * (1.0 - r) / length
        north, rate[0] = on_leg(manoeuvre.north, before, after, share, share_rate)
        east, rate[1] = on_leg(manoeuvre.east, before, after, share, share_rate)
        depth, rate[2] = on_leg(manoeuvre.depth, before, after, share, share_rate)
        roll, rate[3] = on_leg(manoeuvre.roll, before, after, share, share_rate)
        pitch, rate[4] = on_leg(manoeuvre.pitch, before, after, share, share_rate)
        yaw, rate[5] = on_leg(manoeuvre.yaw, before, after, share, share_rate)
        pose[0], pose[1], pose[2] = pose[0] + north, pose[1] + east, pose[2] + depth
        pose[3], pose[4], pose[5] = pose[3] + roll, pose[4] + pitch, pose[5] + yaw


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
    scale = 2.0 * math.atan2(size, ew) / size if size > 0.0 else 2.0 / ew  # its limit: without a turn it is to be right, too
    return scale * ex, scale * ey, scale * ez


@kernel
def command(thrust, p, e):
    """Command for a thrust in N."""
    if e.inverse_curve is not None:
        return curve_command(thrust, e.inverse_curve.command, e.inverse_curve.thrust)
    return thrust / (p.forward_limit if thrust > 0.0 else p.reverse_limit)


@kernel
def control_sample(t, u, s, p, e):
    """One sample at time t with the inputs u, (m,): commands, integrals and errors in the state."""
    x, pose, rate, wrench, thrust, given = s.x, s.work[1], s.work[2], s.work[3], s.work[4], s.work[5]
    wanted(t, p, e.manoeuvre, s.rows, pose, rate)
    qw, qx, qy, qz = u[IN.quaternion_w], u[IN.quaternion_x], u[IN.quaternion_y], u[IN.quaternion_z]
    x[ERRORS], x[ERRORS + 1], x[ERRORS + 2] = (
        pose[0] - u[IN.position_north],
        pose[1] - u[IN.position_east],
        pose[2] - u[IN.depth],
    )
    a, b, c, d = quaternion_of_angles(pose[3], pose[4], pose[5])
    x[ERRORS + 3], x[ERRORS + 4], x[ERRORS + 5] = turn_between(qw, qx, qy, qz, a, b, c, d)

    far = math.sqrt(x[ERRORS] ** 2 + x[ERRORS + 1] ** 2 + x[ERRORS + 2] ** 2)
    share, near = (p.reach / far, 0.0) if far > p.reach else (1.0, 1.0)
    error = to_body(qw, qx, qy, qz, share * x[ERRORS], share * x[ERRORS + 1], share * x[ERRORS + 2])
    v = to_body(qw, qx, qy, qz, rate[0], rate[1], rate[2])
    f = to_body(qw, qx, qy, qz, x[INTEGRALS], x[INTEGRALS + 1], x[INTEGRALS + 2])
    # angular velocity of the wanted attitude in its own axes, then in the world's, then in the body's
    sr, cr, sp, cp = math.sin(pose[3]), math.cos(pose[3]), math.sin(pose[4]), math.cos(pose[4])
    turn = to_world(a, b, c, d, rate[3] - rate[5] * sp, rate[4] * cr + rate[5] * cp * sr, rate[5] * cp * cr - rate[4] * sr)
    turn = to_body(qw, qx, qy, qz, turn[0], turn[1], turn[2])
    for j in range(3):
        wrench[j] = f[j] + p.position_gain[j] * error[j] + p.velocity_gain[j] * (v[j] - u[IN.surge + j])
        k = j + 3
        wrench[k] = x[INTEGRALS + k] + p.attitude_gain[j] * x[ERRORS + k] + p.rate_gain[j] * (turn[j] - u[IN.roll_rate + j])

    choice = chosen(u, IN.available, THRUSTERS)
    if e.further_thrusters is not None:
        choice += chosen(u, e.further_thrusters.u, 2) << THRUSTERS
    if choice != s.choice[0]:
        fill_allocation(s.table, s.matrix, p.priority, choice, s.allocation)
        s.choice[0] = choice
    x[SCALE] = allocate(wrench, s.table, s.matrix, p.forward_limit, p.reverse_limit, thrust, given)
    if e.further_thrusters is not None and x[SCALE] < 1.0:
        x[SCALE] = share_out(
            wrench, p.priority, s.matrix, choice, p.forward_limit, p.reverse_limit, thrust, given, s.free, s.allocation, s.sharing
        )
    for i in range(THRUSTERS):
        x[COMMANDS + i] = command(thrust[i], p, e)
    if e.further_thrusters is not None:
        for i in range(2):
            x[STATES + i] = command(thrust[THRUSTERS + i], p, e)

    for j in range(6):
        given[j] = (given[j] - wrench[j]) / p.unwinding_time
    gained = to_world(
        qw,
        qx,
        qy,
        qz,
        near * p.position_integral_gain[0] * error[0] + given[0],
        near * p.position_integral_gain[1] * error[1] + given[1],
        near * p.position_integral_gain[2] * error[2] + given[2],
    )
    for j in range(3):
        x[INTEGRALS + j] += p.period * gained[j]
        x[INTEGRALS + 3 + j] += p.period * (p.attitude_integral_gain[j] * x[ERRORS + 3 + j] + given[3 + j])


@kernel
def control_outputs(t, s, p, e):
    """Commands, errors, scale and further commands of the last sample."""
    x, y = s.x, s.y
    for i in range(THRUSTERS):
        y[i] = x[COMMANDS + i]
    for j in range(x.size - ERRORS):
        y[THRUSTERS + j] = x[ERRORS + j]
    return DONE


RovController.kernels = sampled_kernels(__name__, control_start, control_sample, control_outputs)
