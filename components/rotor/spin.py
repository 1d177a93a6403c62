"""Speed and angle of a rotor whose speed is given: constant, or a run-up at constant acceleration to an end speed."""

from __future__ import annotations

import math

from ..core.component import Effect
from ..core.kernels import kernel
from ..core.variables import parameter

TURN = 2.0 * math.pi


class RunUp(Effect):
    """The speed changes at a constant rate to an end speed, up or down; it is imposed, whatever torque that takes."""

    explicit_only = True
    either_in = ("initialize",)

    acceleration = parameter(20.0, "rad/s2", "magnitude of the rate of change of the speed", low=0.0)
    end_speed = parameter(200.0, "rad/s", "speed that is kept at the end")
    start_time = parameter(0.0, "s", "time at which the speed begins to change")


@kernel
def speed_at(t, speed, run_up):
    """Speed at time t, rad/s; `run_up`: its values or None."""
    if run_up is not None:
        change = run_up.end_speed - speed
        gained = run_up.acceleration * max(t - run_up.start_time, 0.0)
        return speed + math.copysign(min(gained, abs(change)), change)
    return speed


@kernel
def acceleration_at(t, speed, run_up):
    """Rate of change of the speed just after time t, rad/s²."""
    if run_up is not None:
        change = run_up.end_speed - speed
        if t >= run_up.start_time and run_up.acceleration * (t - run_up.start_time) < abs(change):
            return math.copysign(run_up.acceleration, change)
    return 0.0


@kernel
def angle_after(angle, t, d, speed, run_up):
    """Angle at t + d from that at t, exact and wrapped into [0, 2 pi)."""
    now = speed_at(t, speed, run_up)
    turned = now * d
    if run_up is not None:
        then = speed_at(t + d, speed, run_up)
        if then != now:
            begin = min(max(run_up.start_time - t, 0.0), d)  # the part of d in which the speed changes
            end = min(run_up.start_time + abs(run_up.end_speed - speed) / run_up.acceleration - t, d)
            turned = now * begin + 0.5 * (now + then) * (end - begin) + then * (d - end)
    wrapped = (angle + turned) % TURN
    return wrapped if wrapped < TURN else 0.0  # rounding of a small negative angle
