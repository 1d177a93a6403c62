"""Sensors between a vehicle and its controller: acoustic position, depth, velocity log, gyros and attitude, each at its own rate."""

from __future__ import annotations

import math
from typing import Any

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.kernels import DONE, OWN, kernel
from ..core.random_numbers import normal_number, uniform_number
from ..core.sampled import SampledComponent, sampled_kernels
from ..core.variables import SEED, flag, input_, integer, output, parameter
from .controller import NAVIGATION

HOUR = 3600.0  # s
USBL, DEPTH, DVL, IMU = range(4)
# axes with an error of their own: two of the position, depth, three of velocity, rate and attitude each
FIRST, AXES = (0, 2, 3, 6), 12
# the state: number of the next sample, whether there was one, what was measured; then biases, then which sensors are lost
BEGUN, MEASURED, BIASES = 1, 2, 15
NOISE, WALK, START, LOSS, CHANNELS = 0, AXES, 2 * AXES, 3 * AXES, 64  # numbers of a sample, by use
LONG_LOSS = OWN + 1  # status
RANDOM: dict[str, Any] = {"low": 0, "high": 2**31 - 1, "structural": SEED}


class Noise(Effect):
    """White noise of each sample, normal, independent from sample to sample and from axis to axis.

    Deviations are choices of ours, of the order of small commercial sensors.
    """

    explicit_only = True

    usbl = parameter(0.2, "m", "standard deviation of the position to the north and to the east", low=0.0)
    depth = parameter(0.01, "m", "standard deviation of the depth", low=0.0)
    dvl = parameter(0.01, "m/s", "standard deviation of surge, sway, heave", low=0.0)
    rate = parameter(2e-3, "rad/s", "standard deviation of the rates", low=0.0)
    attitude = parameter(5e-3, "rad", "standard deviation of the attitude, a small turn about each axis of the body", low=0.0)
    seed = integer(1, "number that selects one of many equally likely histories", **RANDOM)


class Bias(Effect):
    """A bias of each axis: normal at the start, then a random walk from sample to sample. Deviations are choices of ours."""

    explicit_only = True

    usbl = parameter(0.3, "m", "standard deviation of the position's bias at the start", low=0.0)
    depth = parameter(0.02, "m", "the same of the depth", low=0.0)
    dvl = parameter(5e-3, "m/s", "the same of surge, sway, heave", low=0.0)
    rate = parameter(1e-3, "rad/s", "the same of the rates", low=0.0)
    attitude = parameter(0.01, "rad", "the same of the attitude, about each axis of the body", low=0.0)
    usbl_walk = parameter(0.3, "m", "standard deviation of what the walk adds within an hour: position", low=0.0)
    depth_walk = parameter(0.02, "m", "the same of the depth", low=0.0)
    dvl_walk = parameter(5e-3, "m/s", "the same of surge, sway, heave", low=0.0)
    rate_walk = parameter(1e-3, "rad/s", "the same of the rates", low=0.0)
    attitude_walk = parameter(0.02, "rad", "the same of the attitude", low=0.0)
    seed = integer(1, "number that selects one of many equally likely histories", **RANDOM)


class Dropout(Effect):
    """Samples that get lost, in bursts: a sensor keeps its last value. The first sample of each arrives.

    Two states, a sample after the other (Gilbert, Bell System Technical Journal 39, 1960): a burst ends at a sample with 1 / length,
    and begins with share / (length (1 - share)).
    """

    explicit_only = True

    usbl = parameter(0.2, "1", "share of the samples of the position that get lost", low=0.0, high=0.99)
    depth = parameter(0.0, "1", "share of the samples of the depth", low=0.0, high=0.99)
    dvl = parameter(0.05, "1", "share of the samples of the velocity", low=0.0, high=0.99)
    imu = parameter(0.0, "1", "share of the samples of rates and attitude", low=0.0, high=0.99)
    usbl_length = parameter(3.0, "1", "mean number of samples of a burst: position", low=1.0)
    depth_length = parameter(1.0, "1", "the same of the depth", low=1.0)
    dvl_length = parameter(5.0, "1", "the same of the velocity", low=1.0)
    imu_length = parameter(1.0, "1", "the same of rates and attitude", low=1.0)
    seed = integer(1, "number that selects one of many equally likely histories", **RANDOM)

    usbl_lost = flag("1 while the last sample of the position is lost")
    depth_lost = flag("1 while the last sample of the depth is lost")
    dvl_lost = flag("1 while the last sample of the velocity is lost")
    imu_lost = flag("1 while the last sample of rates and attitude is lost")


class RovSensors(SampledComponent):
    """What a vehicle's sensors tell of its motion: samples of the truth, with errors where effects are on, held in between.

        measured = truth + bias + noise;  of the attitude  q exp(bias + noise),  a turn about axes of the body

    The IMU samples at the start and at whole multiples of `period`, the others at each n-th sample of it: position by USBL, depth by
    pressure, speed over ground by DVL at the vehicle's origin. Without effects a sample is the truth of its instant. Random numbers
    depend on the seed and the number of the sample alone. Left out: delays, lever arms, the acoustic geometry, accelerometers.
    """

    title = "Sensors of an underwater vehicle"
    system = "rov"
    default_step = 0.02
    default_stop = 10.0
    start_inputs = NAVIGATION

    noise = Noise
    bias = Bias
    dropout = Dropout

    period = parameter(0.02, "s", "time between samples of the IMU", low=1e-5)
    usbl_every = integer(
        50, "samples of the IMU from one of the position to the next", low=1, high=1_000_000, structural="a rate"
    )
    depth_every = integer(5, "samples of the IMU from one of the depth to the next", low=1, high=1_000_000, structural="a rate")
    dvl_every = integer(10, "samples of the IMU from one of the velocity to the next", low=1, high=1_000_000, structural="a rate")

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

    measured_position_north = output("m", "position to the north, as measured")
    measured_position_east = output("m", "position to the east, as measured")
    measured_depth = output("m", "depth, as measured")
    measured_quaternion_w = output("1", "attitude, as measured")
    measured_quaternion_x = output("1", "attitude, as measured")
    measured_quaternion_y = output("1", "attitude, as measured")
    measured_quaternion_z = output("1", "attitude, as measured")
    measured_surge = output("m/s", "velocity ahead, as measured")
    measured_sway = output("m/s", "velocity to starboard, as measured")
    measured_heave = output("m/s", "velocity down the body's axis, as measured")
    measured_roll_rate = output("rad/s", "rate of roll, as measured")
    measured_pitch_rate = output("rad/s", "rate of pitch, as measured")
    measured_yaw_rate = output("rad/s", "rate of yaw, as measured")

    ports = {"navigation": tuple(f"measured_{name}" for name in NAVIGATION)}
    port_members = {f"measured_{name}": name for name in NAVIGATION}

    refusals = {
        LONG_LOSS: Refusal(
            "dropout: a share of {refused[0]} in bursts of {refused[1]} samples",
            "at most length / (1 + length), where a burst begins after each sample",
            "Lengthen the bursts.",
        )
    }

    def states(self) -> int:
        """See the top of the file."""
        return BIASES + (AXES if "bias" in self.on else 0) + (4 if "dropout" in self.on else 0)

    def shapes(self) -> dict[str, Any]:
        """`refused`: (2,) numbers of a refusal."""
        return super().shapes() | {"refused": 2}


IN = RovSensors.input_places()


@kernel
def of_sensor(sensor, usbl, depth, dvl, imu):
    """That of four numbers which belongs to a sensor."""
    return usbl if sensor == USBL else depth if sensor == DEPTH else dvl if sensor == DVL else imu


@kernel
def of_axis(axis, usbl, depth, dvl, rate, attitude):
    """That of five numbers which belongs to an axis."""
    if axis < FIRST[DVL]:
        return usbl if axis < FIRST[DEPTH] else depth
    return dvl if axis < FIRST[IMU] else rate if axis < FIRST[IMU] + 3 else attitude


@kernel
def sensors_start(t, s, p, e):
    """No sample yet; bursts of losses are possible ones."""
    s.x[:] = 0.0
    if e.dropout is not None:
        d = e.dropout
        for sensor in range(4):
            share = of_sensor(sensor, d.usbl, d.depth, d.dvl, d.imu)
            length = of_sensor(sensor, d.usbl_length, d.depth_length, d.dvl_length, d.imu_length)
            if share > length * (1.0 - share):
                s.refused[0], s.refused[1] = share, length
                return LONG_LOSS
    return DONE


@kernel
def error(axis, number, x, e):
    """Error of an axis at a sample of the IMU's number, with the bias of the state."""
    total = 0.0
    if e.bias is not None:
        total += x[BIASES + axis]
    if e.noise is not None:
        n = e.noise
        deviation = of_axis(axis, n.usbl, n.depth, n.dvl, n.rate, n.attitude)
        total += deviation * normal_number(n.seed, CHANNELS * number + NOISE + axis)
    return total


@kernel
def walk(axis, number, time, x, bias):
    """The bias of an axis moves on to a sample; time: since the one before, s; 0 at the start."""
    if time == 0.0:
        deviation = of_axis(axis, bias.usbl, bias.depth, bias.dvl, bias.rate, bias.attitude)
        x[BIASES + axis] = deviation * normal_number(bias.seed, START + axis)
    else:
        deviation = of_axis(axis, bias.usbl_walk, bias.depth_walk, bias.dvl_walk, bias.rate_walk, bias.attitude_walk)
        x[BIASES + axis] += deviation * math.sqrt(time / HOUR) * normal_number(bias.seed, CHANNELS * number + WALK + axis)


@kernel
def measure(sensor, number, u, x, e):
    """The sample of a sensor from the inputs u, (13,), into the state."""
    if sensor == USBL:
        x[MEASURED] = u[IN.position_north] + error(0, number, x, e)
        x[MEASURED + 1] = u[IN.position_east] + error(1, number, x, e)
    elif sensor == DEPTH:
        x[MEASURED + 2] = u[IN.depth] + error(2, number, x, e)
    elif sensor == DVL:
        for i in range(3):
            x[MEASURED + 7 + i] = u[IN.surge + i] + error(3 + i, number, x, e)
    else:
        for i in range(3):
            x[MEASURED + 10 + i] = u[IN.roll_rate + i] + error(6 + i, number, x, e)
        w, i, j, k = u[IN.quaternion_w], u[IN.quaternion_x], u[IN.quaternion_y], u[IN.quaternion_z]
        a, b, c = 0.5 * error(9, number, x, e), 0.5 * error(10, number, x, e), 0.5 * error(11, number, x, e)
        size = math.sqrt(a * a + b * b + c * c)
        if size > 0.0:
            r, share = math.cos(size), math.sin(size) / size
            a, b, c = share * a, share * b, share * c
            w, i, j, k = (
                w * r - i * a - j * b - k * c,
                w * a + i * r + j * c - k * b,
                w * b - i * c + j * r + k * a,
                w * c + i * b - j * a + k * r,
            )
        x[MEASURED + 3], x[MEASURED + 4], x[MEASURED + 5], x[MEASURED + 6] = w, i, j, k


@kernel
def sensors_sample(t, u, s, p, e):
    """All sensors whose turn it is at time t, all of them at the start."""
    x, number = s.x, math.floor(t / p.period + 0.5)
    first = x[BEGUN] == 0.0
    x[BEGUN] = 1.0
    losses = BIASES
    if e.bias is not None:
        losses += AXES
    for sensor in range(4):
        every = of_sensor(sensor, p.usbl_every, p.depth_every, p.dvl_every, 1)
        if not first and number - every * math.floor(number / every) != 0.0:
            continue
        if e.bias is not None:
            for axis in range(FIRST[sensor], FIRST[sensor + 1] if sensor < IMU else AXES):
                walk(axis, number, 0.0 if first else every * p.period, x, e.bias)
        if e.dropout is not None and not first:
            d = e.dropout
            share = of_sensor(sensor, d.usbl, d.depth, d.dvl, d.imu)
            length = of_sensor(sensor, d.usbl_length, d.depth_length, d.dvl_length, d.imu_length)
            chance = uniform_number(d.seed, CHANNELS * number + LOSS + sensor)
            lost = x[losses + sensor] > 0.5
            x[losses + sensor] = 1.0 if chance < (1.0 - 1.0 / length if lost else share / (length * (1.0 - share))) else 0.0
            if x[losses + sensor] > 0.5:
                continue
        measure(sensor, number, u, x, e)


@kernel
def sensors_outputs(t, s, p, e):
    """The last samples, and which sensors have lost theirs."""
    x, y = s.x, s.y
    for i in range(13):
        y[i] = x[MEASURED + i]
    if e.dropout is not None:
        for sensor in range(4):
            y[e.dropout.y + sensor] = x[x.size - 4 + sensor]
    return DONE


RovSensors.kernels = sampled_kernels(__name__, sensors_start, sensors_sample, sensors_outputs)
