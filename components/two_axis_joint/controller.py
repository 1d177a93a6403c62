"""Pointing with a gimbal: a sampled PID controller for each axis, and a scan of both as its set point."""

from __future__ import annotations

import math

from ..core.component import Effect
from ..core.kernels import DONE, kernel
from ..core.sampled import SampledComponent, integrated, sampled_kernels
from ..core.stateless import nothing
from ..core.variables import input_, output, parameter

TURN = 2.0 * math.pi
VOLTAGES, INTEGRALS, ERRORS = 1, 3, 5  # of the state: behind the number of the next sample a pair of each
STATES = 7


class Scan(Effect):
    """The set point swings about the constant one in each axis: amplitude · sin(2π frequency t + phase)."""

    explicit_only = True

    outer_amplitude = parameter(0.5, "rad", "amplitude of the outer axis")
    inner_amplitude = parameter(0.3, "rad", "amplitude of the inner axis")
    outer_frequency = parameter(0.5, "Hz", "frequency of the outer axis", low=0.0)
    inner_frequency = parameter(1.0, "Hz", "frequency of the inner axis", low=0.0)
    outer_phase = parameter(0.0, "rad", "phase of the outer axis")
    inner_phase = parameter(0.0, "rad", "phase of the inner axis")


class GimbalController(SampledComponent):
    """PID controller of the two angles of a gimbal, sampled, its voltages held in between.

        V = K_p (set - angle) + K_d (set' - rate) + I,    I' = K_i (set - angle) + (V_limited - V) / T

    What the limit keeps back of the voltage flows back into the integral within the time T, so that it does not wind up.
    Samples are taken at whole multiples of the period and at the start; at a sample's instant the voltages are its own.
    Gains are a choice of ours, for about 20 rad/s with the default gimbal and motors.
    """

    title = "Controller of a gimbal"
    system = "two_axis_joint"
    default_step = 2e-3
    default_stop = 5.0
    start_inputs = ("outer_angle", "inner_angle", "outer_rate", "inner_rate")  # sampled at the start

    scan = Scan

    period = parameter(2e-3, "s", "time between samples", low=1e-6)
    set_outer_angle = parameter(0.0, "rad", "set point of the outer axis", tunable=True)
    set_inner_angle = parameter(0.0, "rad", "set point of the inner axis", tunable=True)
    outer_gain = parameter(640.0, "V/rad", "voltage per error of the outer angle", low=0.0, nominal=100.0, tunable=True)
    inner_gain = parameter(400.0, "V/rad", "voltage per error of the inner angle", low=0.0, nominal=100.0, tunable=True)
    outer_rate_gain = parameter(64.0, "V.s/rad", "voltage per error of the outer rate", low=0.0, nominal=10.0, tunable=True)
    inner_rate_gain = parameter(40.0, "V.s/rad", "voltage per error of the inner rate", low=0.0, nominal=10.0, tunable=True)
    outer_integral_gain = parameter(
        640.0, "V/rad/s", "voltage per error of the outer angle and time", low=0.0, nominal=100.0, tunable=True
    )
    inner_integral_gain = parameter(
        400.0, "V/rad/s", "voltage per error of the inner angle and time", low=0.0, nominal=100.0, tunable=True
    )
    voltage_limit = parameter(24.0, "V", "largest voltage that is asked for", low=1e-9, nominal=10.0, tunable=True)
    unwinding_time = parameter(0.1, "s", "time in which the integrals give up what the limit keeps back", low=1e-6, tunable=True)

    outer_angle = input_(0.0, "rad", "angle of the outer axis")
    inner_angle = input_(0.0, "rad", "angle of the inner axis")
    outer_rate = input_(0.0, "rad/s", "rate of the outer axis")
    inner_rate = input_(0.0, "rad/s", "rate of the inner axis")

    outer_voltage = output("V", "voltage for the motor of the outer axis", nominal=10.0)
    inner_voltage = output("V", "voltage for the motor of the inner axis", nominal=10.0)
    outer_error = output("rad", "set point less angle of the outer axis at the last sample", nominal=0.1)
    inner_error = output("rad", "set point less angle of the inner axis at the last sample", nominal=0.1)

    def states(self) -> int:
        """The number of the next sample, voltages, integrals, errors."""
        return STATES


IN = GimbalController.input_places()
OUT = GimbalController.output_places()


@kernel
def axis_sample(i, error, rate_error, gain, rate_gain, integral_gain, x, p):
    """One sample of one axis, 0 outer, 1 inner: voltage, integral and error in x."""
    wanted = gain * error + rate_gain * rate_error + x[INTEGRALS + i]
    voltage = min(max(wanted, -p.voltage_limit), p.voltage_limit)
    x[VOLTAGES + i], x[ERRORS + i] = voltage, error
    x[INTEGRALS + i] = integrated(x[INTEGRALS + i], integral_gain, error, (voltage - wanted) / p.unwinding_time, p.period)


@kernel
def control_sample(t, u, s, p, e):
    """One sample of both axes at time t with the inputs u."""
    outer, inner, outer_rate, inner_rate = p.set_outer_angle, p.set_inner_angle, 0.0, 0.0
    if e.scan is not None:
        w, v = TURN * e.scan.outer_frequency, TURN * e.scan.inner_frequency
        outer += e.scan.outer_amplitude * math.sin(w * t + e.scan.outer_phase)
        inner += e.scan.inner_amplitude * math.sin(v * t + e.scan.inner_phase)
        outer_rate = e.scan.outer_amplitude * w * math.cos(w * t + e.scan.outer_phase)
        inner_rate = e.scan.inner_amplitude * v * math.cos(v * t + e.scan.inner_phase)
    axis_sample(
        0,
        outer - u[IN.outer_angle],
        outer_rate - u[IN.outer_rate],
        p.outer_gain,
        p.outer_rate_gain,
        p.outer_integral_gain,
        s.x,
        p,
    )
    axis_sample(
        1,
        inner - u[IN.inner_angle],
        inner_rate - u[IN.inner_rate],
        p.inner_gain,
        p.inner_rate_gain,
        p.inner_integral_gain,
        s.x,
        p,
    )


@kernel
def control_outputs(t, s, p, e):
    """Voltages and errors of the last sample."""
    x, y = s.x, s.y
    y[OUT.outer_voltage], y[OUT.inner_voltage], y[OUT.outer_error], y[OUT.inner_error] = (
        x[VOLTAGES],
        x[VOLTAGES + 1],
        x[ERRORS],
        x[ERRORS + 1],
    )
    return DONE


GimbalController.kernels = sampled_kernels(__name__, start=nothing, sample=control_sample, outputs=control_outputs)
