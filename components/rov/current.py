"""The motion of the water around a vehicle: a current, the same at every place and depth, and waves, which are not."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..core.component import Effect
from ..core.kernels import DONE, kernel
from ..core.stateless import StatelessComponent, stateless_kernels
from ..core.variables import output, parameter
from .waves import PLACE, REFUSALS, ROWS, Waves, WaveSpectrum, add_waves, chances, start_waves

TURN = 2.0 * math.pi


class Tide(Effect):
    """A sinusoidal part: amplitude * sin(2 pi t / period + phase) along its own direction. 6.2 h is half a day of the moon."""

    explicit_only = True

    amplitude = parameter(0.2, "m/s", "amplitude of the sinusoidal part")
    period = parameter(44714.0, "s", "period", low=1e-3)
    phase = parameter(0.0, "rad", "phase at time 0")
    direction = parameter(0.0, "rad", "where it sets at its positive peak, from north over east")


class Ramp(Effect):
    """The mean current grows from 0 as 3 s² - 2 s³ in the share s of a duration, without a jump of its acceleration."""

    explicit_only = True

    start_time = parameter(0.0, "s", "time at which it begins to grow")
    duration = parameter(10.0, "s", "time it takes", low=1e-3)


class Gust(Effect):
    """A single gust, amplitude (1 - cos(2 pi s)) / 2 in the share s of its duration."""

    explicit_only = True

    amplitude = parameter(0.2, "m/s", "highest speed of the gust")
    start_time = parameter(10.0, "s", "time at which it begins")
    duration = parameter(5.0, "s", "time it takes", low=1e-3)
    direction = parameter(0.0, "rad", "where it sets, from north over east")


class WaterCurrent(StatelessComponent):
    """Velocity and acceleration of the water in north, east and down; a function of time and, with `waves`, of the place.

    A vehicle needs the acceleration, too, which pulls at its added mass: with `waves` that of the water at the place, which is
    not the one at a fixed place. Without effects it is 0.
    """

    title = "Current of the water"
    system = "rov"
    default_step = 0.02
    default_stop = 60.0
    refusals = REFUSALS

    tide = Tide
    ramp = Ramp
    gust = Gust
    waves = Waves
    spectrum = WaveSpectrum

    speed = parameter(0.3, "m/s", "mean horizontal speed", low=0.0)
    direction = parameter(0.0, "rad", "where the mean current sets, from north over east")
    downwelling = parameter(0.0, "m/s", "mean vertical speed, positive downwards", tunable=True)

    velocity_north = output("m/s", "velocity to the north", feedthrough=PLACE)
    velocity_east = output("m/s", "velocity to the east", feedthrough=PLACE)
    velocity_down = output("m/s", "velocity downwards", feedthrough=PLACE)
    acceleration_north = output("m/s2", "acceleration to the north", nominal=0.1, feedthrough=PLACE)
    acceleration_east = output("m/s2", "acceleration to the east", nominal=0.1, feedthrough=PLACE)
    acceleration_down = output("m/s2", "acceleration downwards", nominal=0.1, feedthrough=PLACE)

    def shapes(self) -> dict[str, Any]:
        """What the waves consist of.

        `sea`: (5, n) amplitude in m, frequency at a fixed place and seen by one who drifts with the current in rad/s, wave number
        in 1/m, phase in rad.  `taken`: (1,) of components that the current lets through.  `chance`: (2, n) of the seed.
        `refused`: (2,) numbers of a refusal.
        """
        sea: dict[str, Any] = {"sea": None, "taken": None, "chance": None, "refused": None}
        if "waves" in self.on:
            sea |= {"sea": (ROWS, 1), "taken": np.zeros(1, dtype=np.int64), "refused": 2}
        if "spectrum" in self.on:
            n = self.get("spectrum.components")
            sea |= {"sea": (ROWS, n), "chance": chances(n, self.get("spectrum.seed"))}
        return sea


OUT = WaterCurrent.output_places()


@kernel
def water_start(t, s, p, e):
    """The components of the waves on the mean current."""
    if e.waves is not None:
        along = p.speed * math.cos(p.direction - e.waves.direction)
        return start_waves(along, s.sea, s.taken, s.refused, s.chance, e.waves, e.spectrum)
    return DONE


@kernel
def water(t, s, p, e):
    """Velocity and acceleration at time t, and the surface's elevation."""
    y = s.y
    share, rate = 1.0, 0.0
    if e.ramp is not None:
        r = min(max((t - e.ramp.start_time) / e.ramp.duration, 0.0), 1.0)
        share, rate = r * r * (3.0 - 2.0 * r), 6.0 * r * (1.0 - r) / e.ramp.duration
    north, east = p.speed * math.cos(p.direction), p.speed * math.sin(p.direction)
    y[OUT.velocity_north], y[OUT.velocity_east], y[OUT.velocity_down] = share * north, share * east, share * p.downwelling
    y[OUT.acceleration_north], y[OUT.acceleration_east], y[OUT.acceleration_down] = (
        rate * north,
        rate * east,
        rate * p.downwelling,
    )
    if e.tide is not None:
        w = TURN / e.tide.period
        add(
            y,
            e.tide.direction,
            e.tide.amplitude * math.sin(w * t + e.tide.phase),
            w * e.tide.amplitude * math.cos(w * t + e.tide.phase),
        )
    if e.gust is not None:
        r = min(max((t - e.gust.start_time) / e.gust.duration, 0.0), 1.0)
        w = TURN / e.gust.duration
        add(
            y,
            e.gust.direction,
            0.5 * e.gust.amplitude * (1.0 - math.cos(TURN * r)),
            0.5 * w * e.gust.amplitude * math.sin(TURN * r),
        )
    if e.waves is not None:
        add_waves(t, s.u[0], y, s.sea, s.taken, e.waves)
    return DONE


@kernel
def add(y, direction, speed, acceleration):
    """Add a horizontal part that sets in a direction to the velocity and the acceleration in y, (6,)."""
    north, east = math.cos(direction), math.sin(direction)
    y[OUT.velocity_north] += speed * north
    y[OUT.velocity_east] += speed * east
    y[OUT.acceleration_north] += acceleration * north
    y[OUT.acceleration_east] += acceleration * east


WaterCurrent.kernels = stateless_kernels(__name__, water, water_start)
