"""Positioning a sleeve by two wheels: a sampled cascade of position and rates, decoupled by the inverse kinematics."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.kernels import DONE, OWN, kernel
from ..core.sampled import SampledComponent, integrated, is_zero_behind, rows_in_use, sampled_kernels
from ..core.variables import choice, input_, output, parameter
from .kinematics import ANGLE, IDLE, LOST, idle_angle, layout_choice, lost_motion, sleeve_rates, wheel_rates

ROWS = 8
TIME_FALLS = OWN + 4  # status, behind those of kinematics.py
WHEELS = 1
# the state: number of the next sample, then pairs: voltages, integrals, errors, wanted way, integrals of the way, last encoders
VOLTAGES, INTEGRALS, ERRORS, WANTED, MOTION, LAST, STATES = 1, 3, 5, 7, 9, 11, 13


class Quantisation(Effect):
    """Sensors count whole steps; the rates of the wheels are differences of counts over a sample, instead of measured rates.

    Default of the wheels: 2000 counts a turn of a motor behind a gear of 19:1.
    """

    wheel_step = parameter(1.65e-4, "rad", "angle of a wheel per count", low=1e-12, nominal=1e-4)
    feed_step = parameter(1e-5, "m", "feed per count", low=1e-12, nominal=1e-5)
    rotation_step = parameter(1e-3, "rad", "rotation per count", low=1e-12, nominal=1e-3)


class Reference(Effect):
    """The set point follows a table that is added to the constant one: straight between the rows, a step where times are equal.

    Before the first time the first row holds, after the last the last. A table with fewer rows leaves the rest at 0.
    """

    explicit_only = True

    time = parameter((0.0, 0.5, *[0.0] * 6), "s", "time of a row, not decreasing", size=ROWS)
    feed = parameter((0.0, 0.02, *[0.0] * 6), "m", "feed added to the set point", size=ROWS, nominal=0.01)
    rotation = parameter((0.0, 1.0, *[0.0] * 6), "rad", "rotation added to the set point", size=ROWS)


class ServoController(SampledComponent):
    """Cascade for feed and rotation of a sleeve on two wheels; sampled, its voltages held in between.

        wanted motion   v = set' + K_p e + M,    M' = K_m e + (v_limited - v) / T       for feed and rotation; e: error
        wanted rates    w_set = inverse kinematics of v, both cut in proportion where one is above `rate_limit`
        voltage         V = F w_set + K_v (w_set - w) + I,    I' = K_i (w_set - w) + (V_limited - V) / T    for each wheel

    What the limits keep back of motion and voltage flows back into the integrals within the time T, so that they do not wind up.
    The way is measured at the sleeve, or taken from the wheels' angles without seeing slip. Without integrals, K_m = K_i = 0, the
    drive stands with an error where dry friction holds it; with them it may hunt. Samples are taken at whole multiples of the
    period and at the start; at a sample's instant the voltages are its own.

    Frączak (2013), known to us by its abstract, has a control system for such a drive; this cascade and its gains are ours, for
    some 20 1/s with the default motor.
    """

    title = "Controller of a friction-wheel drive"
    system = "friction_drive"
    start_inputs = ("first_angle", "second_angle", "first_rate", "second_rate", "feed", "rotation")  # sampled at the start

    quantisation = Quantisation
    reference = Reference

    layout = layout_choice()
    feedback = choice("sleeve", ("sleeve", "wheels"), "where the way is measured: feed and rotation, or the wheels' angles")
    wheel_radius = parameter(0.01, "m", "radius of the wheels", low=1e-6, nominal=0.01)
    sleeve_radius = parameter(0.005, "m", "radius of the sleeve", low=1e-6, nominal=0.01)
    angle = parameter(ANGLE, "rad", "angle of the wheels' directions with the axis, for skewed wheels")
    period = parameter(1e-3, "s", "time between samples", low=1e-6, nominal=1e-3)
    set_feed = parameter(0.0, "m", "set point of the feed", nominal=0.01, tunable=True)
    set_rotation = parameter(0.0, "rad", "set point of the rotation", tunable=True)
    feed_gain = parameter(20.0, "1/s", "feed rate per error of the feed", low=0.0, nominal=10.0, tunable=True)
    rotation_gain = parameter(20.0, "1/s", "rotation rate per error of the rotation", low=0.0, nominal=10.0, tunable=True)
    feed_integral_gain = parameter(0.0, "1/s2", "feed rate per error of the feed and time", low=0.0, nominal=100.0, tunable=True)
    rotation_integral_gain = parameter(
        0.0, "1/s2", "rotation rate per error of the rotation and time", low=0.0, nominal=100.0, tunable=True
    )
    rate_limit = parameter(20.0, "rad/s", "largest rate of a wheel that is asked for", low=1e-9, nominal=10.0, tunable=True)
    rate_gain = parameter(0.4, "V.s/rad", "voltage per error of a wheel's rate", low=0.0, tunable=True)
    rate_integral_gain = parameter(
        10.0, "V/rad", "voltage per error of a wheel's rate and time", low=0.0, nominal=10.0, tunable=True
    )
    feed_forward = parameter(
        0.4446, "V.s/rad", "voltage per wanted rate of a wheel; the default motor induces as much", low=0.0, tunable=True
    )
    voltage_limit = parameter(12.0, "V", "largest voltage that is asked for", low=1e-9, nominal=10.0, tunable=True)
    unwinding_time = parameter(0.02, "s", "time in which the integrals give up what the limit keeps back", low=1e-6, tunable=True)

    first_angle = input_(0.0, "rad", "angle of the first wheel, by its encoder")
    second_angle = input_(0.0, "rad", "angle of the second wheel")
    first_rate = input_(0.0, "rad/s", "rate of the first wheel")
    second_rate = input_(0.0, "rad/s", "rate of the second wheel")
    feed = input_(0.0, "m", "feed of the sleeve, by its own sensor", nominal=0.01)
    rotation = input_(0.0, "rad", "rotation of the sleeve")

    first_voltage = output("V", "voltage for the motor of the first wheel", nominal=10.0)
    second_voltage = output("V", "voltage for the motor of the second wheel", nominal=10.0)
    feed_error = output("m", "set point less measured feed at the last sample", nominal=0.01)
    rotation_error = output("rad", "set point less measured rotation at the last sample")
    wanted_feed = output("m", "set point of the feed at the last sample", nominal=0.01)
    wanted_rotation = output("rad", "set point of the rotation at the last sample")

    refusals = (
        IDLE
        | LOST
        | {
            TIME_FALLS: Refusal(
                "reference: time[{fall[0]}] = {fall[1]} s, then {fall[2]} s",
                "times that do not decrease, and zeros behind the last row",
            )
        }
    )

    def states(self) -> int:
        """See the top of the file."""
        return STATES

    def shapes(self) -> dict[str, Any]:
        """`rows`: (1,) in use of the reference.  `fall`: (3,) where its time falls: number of the row before, both times."""
        reference = "reference" in self.on
        return super().shapes() | {"rows": np.zeros(1, dtype=np.int64) if reference else None, "fall": 3 if reference else None}


IN = ServoController.input_places()
OUT = ServoController.output_places()


@kernel
def control_start(t, s, p, e):
    """All states are zero, except the encoders' counts."""
    status = lost_motion(p.layout, p.angle)
    if status == DONE:
        status = idle_angle(p.layout, p.angle)
    if e.reference is not None:
        time, rows = e.reference.time, rows_in_use(e.reference.time)
        s.rows[0] = rows
        if status == DONE and not (
            is_zero_behind(time, rows) and is_zero_behind(e.reference.feed, rows) and is_zero_behind(e.reference.rotation, rows)
        ):
            s.fall[0], s.fall[1], s.fall[2] = rows, time[rows - 1], time[rows]
            status = TIME_FALLS
    if e.quantisation is not None:  # as if the wheels had turned at their rates before
        for i in range(2):
            s.x[LAST + i] = counted(s.u[0, i] - p.period * s.u[0, 2 + i], e.quantisation.wheel_step)
    return status


@kernel
def counted(value, step):
    """The whole steps at or below a value, in its unit, as an encoder counts them."""
    return step * math.floor(value / step)


@kernel
def wanted(t, rows, p, reference):
    """(feed, rotation, their rates) of the set point at time t; rows: (1,) in use of the reference, or None."""
    feed, rotation, feed_rate, rotation_rate = p.set_feed, p.set_rotation, 0.0, 0.0
    if reference is not None:
        n, i = rows[0], 0
        while i < n and reference.time[i] <= t:
            i += 1
        before, after = max(i - 1, 0), min(i, n - 1)
        feed += reference.feed[before]
        rotation += reference.rotation[before]
        length = reference.time[after] - reference.time[before]
        if length > 0.0:
            feed_rate = (reference.feed[after] - reference.feed[before]) / length
            rotation_rate = (reference.rotation[after] - reference.rotation[before]) / length
            feed += feed_rate * (t - reference.time[before])
            rotation += rotation_rate * (t - reference.time[before])
    return feed, rotation, feed_rate, rotation_rate


@kernel
def wheel_sample(i, wanted_rate, rate, x, p):
    """One sample of one wheel: its voltage and integral in x."""
    error = wanted_rate - rate
    asked = p.feed_forward * wanted_rate + p.rate_gain * error + x[INTEGRALS + i]
    voltage = min(max(asked, -p.voltage_limit), p.voltage_limit)
    x[VOLTAGES + i] = voltage
    x[INTEGRALS + i] = integrated(x[INTEGRALS + i], p.rate_integral_gain, error, (voltage - asked) / p.unwinding_time, p.period)


@kernel
def control_sample(t, u, s, p, e):
    """One sample at time t with the inputs u: voltages, integrals, errors, set point and counts in the state."""
    x = s.x
    first_angle, second_angle, first_rate, second_rate, feed, rotation = (
        u[IN.first_angle],
        u[IN.second_angle],
        u[IN.first_rate],
        u[IN.second_rate],
        u[IN.feed],
        u[IN.rotation],
    )
    if e.quantisation is not None:
        first_angle, second_angle = (
            counted(first_angle, e.quantisation.wheel_step),
            counted(second_angle, e.quantisation.wheel_step),
        )
        first_rate, second_rate = (first_angle - x[LAST]) / p.period, (second_angle - x[LAST + 1]) / p.period
        x[LAST], x[LAST + 1] = first_angle, second_angle
        feed, rotation = counted(feed, e.quantisation.feed_step), counted(rotation, e.quantisation.rotation_step)
    if p.feedback == WHEELS:
        feed, rotation = sleeve_rates(first_angle, second_angle, p.layout, p.angle, p.wheel_radius, p.sleeve_radius)
    x[WANTED], x[WANTED + 1], feed_rate, rotation_rate = wanted(t, s.rows, p, e.reference)
    x[ERRORS], x[ERRORS + 1] = x[WANTED] - feed, x[WANTED + 1] - rotation
    feed_rate += p.feed_gain * x[ERRORS] + x[MOTION]
    rotation_rate += p.rotation_gain * x[ERRORS + 1] + x[MOTION + 1]
    first, second = wheel_rates(feed_rate, rotation_rate, p.layout, p.angle, p.wheel_radius, p.sleeve_radius)
    share = p.rate_limit / max(abs(first), abs(second), p.rate_limit)
    back = (share - 1.0) / p.unwinding_time
    x[MOTION] = integrated(x[MOTION], p.feed_integral_gain, x[ERRORS], back * feed_rate, p.period)
    x[MOTION + 1] = integrated(x[MOTION + 1], p.rotation_integral_gain, x[ERRORS + 1], back * rotation_rate, p.period)
    wheel_sample(0, share * first, first_rate, x, p)
    wheel_sample(1, share * second, second_rate, x, p)


@kernel
def control_outputs(t, s, p, e):
    """Voltages, errors and set point of the last sample."""
    x, y = s.x, s.y
    y[OUT.first_voltage], y[OUT.second_voltage] = x[VOLTAGES], x[VOLTAGES + 1]
    y[OUT.feed_error], y[OUT.rotation_error] = x[ERRORS], x[ERRORS + 1]
    y[OUT.wanted_feed], y[OUT.wanted_rotation] = x[WANTED], x[WANTED + 1]
    return DONE


ServoController.kernels = sampled_kernels(__name__, start=control_start, sample=control_sample, outputs=control_outputs)
