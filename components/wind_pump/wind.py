"""Wind as an environment unit: a mean speed, and effects that vary it."""

from __future__ import annotations

import math
from typing import Any

from ..core.component import Effect
from ..core.contract import KernelComponent, Kernels, Refusal
from ..core.kernels import DONE, OWN, kernel
from ..core.random_numbers import normal_number
from ..core.variables import SEED, integer, output, parameter

DAY = 86400.0  # s
FOREVER = 1e12  # s
GUSTS_OVERLAP, BACK_BEFORE_START, STILL_AIR = OWN + 1, OWN + 2, OWN + 3


class Ramp(Effect):
    """The mean changes at a constant rate to an end speed, stays there, and goes back as slowly if a time is given for it."""

    explicit_only = True

    end_speed = parameter(8.0, "m/s", "speed at the end of the ramp", low=0.0, high=100.0)
    rate = parameter(0.05, "m/s2", "magnitude of the rate of change", low=0.0)
    start_time = parameter(0.0, "s", "time at which the speed begins to change")
    return_time = parameter(FOREVER, "s", "time at which it begins to go back to the mean; the start is never")


class Daily(Effect):
    """Course of the day: the mean times 1 + amplitude cos(2 pi (t - strongest) / 24 h)."""

    explicit_only = True

    amplitude = parameter(0.3, "1", "amplitude over the mean; a choice of ours", low=0.0, high=1.0)
    strongest = parameter(54000.0, "s", "time of the day at which the wind is strongest; 15 h, a choice of ours")


class Turbulence(Effect):
    """Longitudinal turbulence with Dryden's spectrum: at a fixed place a process of first order, correlation exp(-U tau / L).

    Sampled exactly at a fixed interval and linear in between, so that neither macro step nor a repeated step shows; the
    deviation is intensity times the mean of the instant, and U, which fades it, the mean speed. The numbers depend on the
    seed and the sample alone.
    """

    explicit_only = True

    intensity = parameter(0.15, "1", "standard deviation over the mean speed", low=0.0, high=1.0)
    length = parameter(150.0, "m", "length scale L; order of magnitude near the ground, from memory", low=1e-3)
    interval = parameter(0.5, "s", "time between samples", low=1e-3)
    seed = integer(1, "number that selects one of many equally likely winds", low=0, high=2**31 - 1, structural=SEED)


class Gusts(Effect):
    """One gust, or one every period: a rise as (1 - cos)/2, a stay, and the same way down. A rise of 0 s is a step."""

    explicit_only = True

    amplitude = parameter(7.0, "m/s", "speed added at the height of the gust")
    start_time = parameter(10.0, "s", "time at which the first gust begins")
    rise = parameter(2.0, "s", "time of rise, and of fall", low=0.0)
    stay = parameter(10.0, "s", "time at full height", low=0.0)
    period = parameter(FOREVER, "s", "time from gust to gust; the start is a single one", low=1e-3)


class Wind(KernelComponent):
    """Wind speed over time: ((mean, or ramp) * daily) * (1 + turbulence) + gusts, and never below 0.

    Only turbulence has a state. Source of its spectrum: H. L. Dryden's, in the form of MIL-F-8785C,
    S(W) = sigma² 2 L / pi / (1 + (L W)²) over the wave number W; from memory.
    """

    title = "Wind with ramp, gusts, turbulence and the course of a day"
    system = "wind_pump"
    start_inputs = ()
    counters = ("steps",)
    default_step = 0.1
    default_stop = 60.0

    ramp = Ramp
    daily = Daily
    turbulence = Turbulence
    gusts = Gusts

    mean_speed = parameter(5.0, "m/s", "mean wind speed", low=0.0, high=100.0)

    speed = output("m/s", "wind speed", nominal=5.0)

    refusals = {
        GUSTS_OVERLAP: Refusal(
            "gusts.period = {gusts.period} s",
            "at least {gust[0]} s, the duration of a gust",
            "Lengthen the period, or shorten rise or stay.",
        ),
        BACK_BEFORE_START: Refusal(
            "ramp.return_time = {ramp.return_time} s", "at least the ramp's start, {ramp.start_time} s", "Move one of them."
        ),
        STILL_AIR: Refusal(
            "effect 'turbulence' with mean_speed = 0 m/s",
            "a mean speed that carries it along",
            "Raise mean_speed, or leave the effect off.",
        ),
    }

    def shapes(self) -> dict[str, Any]:
        """`x`: sample, turbulence at it and at the next.  `gust`: duration of a gust, s."""
        return {"x": 3 if "turbulence" in self.on else 0, "gust": 1}


OUT = Wind.output_places()


@kernel
def wind_initialize(t, s, p, e):
    """Turbulence at the samples around the start."""
    if e.gusts is not None:
        s.gust[0] = 2.0 * e.gusts.rise + e.gusts.stay
        if e.gusts.period < s.gust[0]:
            return GUSTS_OVERLAP
    if e.ramp is not None and e.ramp.return_time < e.ramp.start_time:
        return BACK_BEFORE_START
    if e.turbulence is not None:
        if p.mean_speed == 0.0:
            return STILL_AIR
        s.x[0] = math.floor(t / e.turbulence.interval)
        s.x[1] = normal_number(e.turbulence.seed, s.x[0])
        s.x[2] = after(s.x[1], s.x[0] + 1.0, p, e.turbulence)
    return DONE


@kernel
def after(value, sample, p, turbulence):
    """Turbulence of unit variance at a sample from that at the sample before."""
    kept = math.exp(-p.mean_speed * turbulence.interval / turbulence.length)
    return kept * value + math.sqrt(1.0 - kept * kept) * normal_number(turbulence.seed, sample)


@kernel
def advance(t, x, p, e):
    """Moves x = (sample, turbulence at it, turbulence at the next) on until t lies between the two."""
    if e.turbulence is not None:
        while t >= (x[0] + 1.0) * e.turbulence.interval:
            x[0] += 1.0
            x[1] = x[2]
            x[2] = after(x[1], x[0] + 1.0, p, e.turbulence)


@kernel
def gust_share(s, rise, stay):
    """Height of a gust, 0 to 1, at the time s after its begin."""
    if s < 0.0 or s >= 2.0 * rise + stay:
        return 0.0
    if s < rise:
        return 0.5 * (1.0 - math.cos(math.pi * s / rise))
    if s > rise + stay:
        return 0.5 * (1.0 + math.cos(math.pi * (s - rise - stay) / rise))
    return 1.0


@kernel
def wind_outputs(t, s, p, e):
    """Wind speed at time t, m/s."""
    x = s.x
    speed = p.mean_speed
    if e.ramp is not None:
        change = e.ramp.end_speed - speed
        gained = min(e.ramp.rate * max(min(t, e.ramp.return_time) - e.ramp.start_time, 0.0), abs(change))
        gained = max(gained - e.ramp.rate * max(t - e.ramp.return_time, 0.0), 0.0)
        speed += math.copysign(gained, change)
    if e.daily is not None:
        speed *= 1.0 + e.daily.amplitude * math.cos(2.0 * math.pi / DAY * (t - e.daily.strongest))
    if e.turbulence is not None:
        share = t / e.turbulence.interval - x[0]
        speed *= 1.0 + e.turbulence.intensity * (x[1] + share * (x[2] - x[1]))
    if e.gusts is not None:
        since = t - e.gusts.start_time
        if since > 0.0:
            since %= e.gusts.period
        speed += e.gusts.amplitude * gust_share(since, e.gusts.rise, e.gusts.stay)
    s.y[OUT.speed] = max(speed, 0.0)
    return DONE


@kernel
def wind_step(t, h, s, p, e):
    """The turbulence moves on."""
    s.counts[0] += 1
    advance(t + h, s.x, p, e)
    return wind_outputs(t + h, s, p, e)


Wind.kernels = Kernels(wind_initialize, wind_step, wind_outputs)
