"""The motion of the water around a vehicle: a current, the same at every place and depth, and waves, which are not."""

from __future__ import annotations

import math

from ..core.component import Effect
from ..core.kernels import DONE, kernel
from ..core.stateless import StatelessComponent
from ..core.variables import output, parameter
from .waves import PLACE, Waves, WaveSpectrum, add_waves, wave_train

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
    start_inputs = ()
    default_step = 0.02
    default_stop = 60.0

    tide = Tide
    ramp = Ramp
    gust = Gust
    waves = Waves
    spectrum = WaveSpectrum

    speed = parameter(0.3, "m/s", "mean horizontal speed", low=0.0)
    direction = parameter(0.0, "rad", "where the mean current sets, from north over east")
    downwelling = parameter(0.0, "m/s", "mean vertical speed, positive downwards")

    velocity_north = output("m/s", "velocity to the north", feedthrough=PLACE)
    velocity_east = output("m/s", "velocity to the east", feedthrough=PLACE)
    velocity_down = output("m/s", "velocity downwards", feedthrough=PLACE)
    acceleration_north = output("m/s2", "acceleration to the north", nominal=0.1, feedthrough=PLACE)
    acceleration_east = output("m/s2", "acceleration to the east", nominal=0.1, feedthrough=PLACE)
    acceleration_down = output("m/s2", "acceleration downwards", nominal=0.1, feedthrough=PLACE)

    def _initialize(self, t: float) -> int:
        p, e = self._declared_arguments()
        if e.waves is not None:
            along = p.speed * math.cos(p.direction - e.waves.direction)
            e = e._replace(waves=wave_train(e.waves, e.spectrum, self.name, along))
        self.arguments = p, e
        return DONE

    def _outputs(self, t: float) -> None:
        water(t, self.u[0], self.y, *self.arguments)


@kernel
def water(t, u, y, p, e):
    """Velocity and acceleration at time t in y[:6], the surface's elevation behind them; u: (m,) inputs."""
    share, rate = 1.0, 0.0
    if e.ramp is not None:
        s = min(max((t - e.ramp.start_time) / e.ramp.duration, 0.0), 1.0)
        share, rate = s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) / e.ramp.duration
    north, east = p.speed * math.cos(p.direction), p.speed * math.sin(p.direction)
    y[0], y[1], y[2] = share * north, share * east, share * p.downwelling
    y[3], y[4], y[5] = rate * north, rate * east, rate * p.downwelling
    if e.tide is not None:
        w = TURN / e.tide.period
        add(y, e.tide.direction, e.tide.amplitude * math.sin(w * t + e.tide.phase),
            w * e.tide.amplitude * math.cos(w * t + e.tide.phase))
    if e.gust is not None:
        s = min(max((t - e.gust.start_time) / e.gust.duration, 0.0), 1.0)
        w = TURN / e.gust.duration
        add(y, e.gust.direction, 0.5 * e.gust.amplitude * (1.0 - math.cos(TURN * s)),
            0.5 * w * e.gust.amplitude * math.sin(TURN * s))
    if e.waves is not None:
        add_waves(t, u, y, e.waves)


@kernel
def add(y, direction, speed, acceleration):
    """Add a horizontal part that sets in a direction to the velocity and the acceleration in y, (6,)."""
    north, east = math.cos(direction), math.sin(direction)
    y[0] += speed * north
    y[1] += speed * east
    y[3] += acceleration * north
    y[4] += acceleration * east
