"""Water under waves: linear (Airy) waves on a current over a level bottom, a regular one or the components of a spectrum.

    elevation  a cos(q),    q = k s - w t + phase,    (w - k U)² = r² = g k tanh(k h)
    along the wave  u = a r C cos(q),    C = cosh k(h - z) / sinh k h
    downwards       v = -a r S sin(q),   S = sinh k(h - z) / sinh k h
    acceleration    Du/Dt = du/dt + (V . grad) u,   V: velocity of the water, current and waves together

s: distance along the direction of travel; z: depth below still water; h: depth of the bottom; w: frequency at a fixed place, as
the period is; U: mean current along the waves, uniform over the depth. Above still water and below the bottom the value at still
water and at the bottom holds. The acceleration is that of the water that is at the place: what moves with the water drifts as a
particle does (Stokes drift, a² k r cosh 2k(h - z) / 2 sinh² k h) and feels the mean force of waves that grow to the surface.
Left out: the second harmonic of the velocity, 3/4 k a cosh 2k(h - z) / (sinh³ k h cosh k(h - z)) of the first one, nothing in
deep water; the mean flow back that a closed basin asks for, as large as the drift over the depth; and that tide, gust and ramp,
which carry the water along, change the length of the waves.
Sources: Dean and Dalrymple, Water Wave Mechanics; Peregrine, "Interaction of water waves and currents" (Adv. Appl. Mech. 16,
1976) for the frequency; Auton, Hunt and Prud'homme, "The force exerted on a body in inviscid unsteady non-uniform rotational
flow" (J. Fluid Mech. 197, 1988) for the acceleration (recalled).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..core.component import Effect
from ..core.errors import BadInput
from ..core.kernels import kernel, kernel_tuple
from ..core.variables import input_, integer, output, parameter

GRAVITY = 9.80665  # m/s²
TURN = 2.0 * math.pi
STEEPEST = 0.142  # height over length at which a wave breaks in deep water (Miche 1944; recalled)
LOWEST, HIGHEST = 0.4, 6.0  # ends of a spectrum over its peak frequency: all but 0.1 % of the energy lies between
BLOCKED = 0.01  # of a sea's energy that a current may block: what is left out of it at most
PLACE = ("waves.position_north", "waves.position_east", "waves.depth")


class Waves(Effect):
    """Orbital velocity and acceleration of a long-crested linear wave on the current, at a place that moves, as a vehicle's."""

    explicit_only = True

    height = parameter(0.5, "m", "height from trough to crest; with `spectrum` the significant height", low=0.0)
    period = parameter(4.0, "s", "period at a fixed place; with `spectrum` that of the peak", low=0.1, high=1e3)
    direction = parameter(0.0, "rad", "where the waves travel to, from north over east")
    phase = parameter(0.0, "rad", "phase at time 0 at the origin, 0: a crest; with `spectrum` it adds to each component's")
    water_depth = parameter(10.0, "m", "depth of the bottom", low=1e-2, high=1e5)

    position_north = input_(0.0, "m", "place to the north")
    position_east = input_(0.0, "m", "place to the east")
    depth = input_(5.0, "m", "depth of the place below still water")

    elevation = output("m", "elevation of the surface above the place", feedthrough=PLACE[:2])


class WaveSpectrum(Effect):
    """An irregular long-crested sea: components with random phases under a JONSWAP spectrum, the same for the same seed.

    Each component lies at random within its own band of frequencies and has the band's whole energy: the sea does not repeat.
    Peakedness 1 is the spectrum of Pierson and Moskowitz, 3.3 the mean of the North Sea.
    """

    requires = ("waves",)
    explicit_only = True

    peakedness = parameter(3.3, "1", "peak over that of Pierson and Moskowitz", low=1.0, high=20.0)
    components = integer(200, "number of components", low=1, high=5000)
    seed = integer(1, "of the random phases and frequencies", low=0, high=2**31 - 1)


@kernel_tuple
class WaveTrain(NamedTuple):
    """Waves for the kernels; arrays (n,), one element a component. u, y: positions of the first input and output."""

    u: int
    y: int
    amplitude: np.ndarray  # m
    frequency: np.ndarray  # rad/s, at a fixed place
    intrinsic: np.ndarray  # rad/s, seen by one who drifts with the current
    number: np.ndarray  # 1/m
    phase: np.ndarray
    north: float  # direction of travel
    east: float
    water_depth: float


def wave_number(frequency: np.ndarray, water_depth: float, current: float = 0.0) -> np.ndarray:
    """k of (w - k U)² = g k tanh(k h), 1/m, by Newton's method; frequency w in rad/s at a fixed place, current U along the wave.

    NaN where an opposing current blocks the wave: no wave of that frequency carries its energy against it.
    """
    w = np.asarray(frequency, dtype=float)
    deep = w**2 / GRAVITY * water_depth  # k h in deep water
    x = deep / np.sqrt(np.tanh(deep))  # within 5 % at any depth
    for _ in range(8):
        t = np.tanh(x)
        x = x - (x * t - deep) / (t + x * (1.0 - t * t))
    k = x / water_depth
    if current == 0.0:
        return k
    blocked = np.zeros(w.shape, dtype=bool)
    for _ in range(200):  # r + k U - w is concave: from the left of its zero, or where U > 0 after one step, none goes beyond it
        r, group = _intrinsic(k, water_depth)
        blocked |= group + current <= 0.0
        k = np.where(blocked, k, k - (r + k * current - w) / np.where(blocked, 1.0, group + current))
    r, _ = _intrinsic(k, water_depth)
    return np.where(blocked | (np.abs(r + k * current - w) > 1e-9 * w), np.nan, k)


def _intrinsic(number: np.ndarray, water_depth: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequency, rad/s, and group velocity, m/s, of waves on water at rest."""
    kh = number * water_depth
    r = np.sqrt(GRAVITY * number * np.tanh(kh))
    return r, 0.5 * r / number * (1.0 + 2.0 * kh / np.sinh(np.minimum(2.0 * kh, 700.0)))


def jonswap(frequency: np.ndarray, height: float, period: float, peakedness: float) -> np.ndarray:
    """Spectral density of the elevation, m² s, over the frequency in Hz, of a significant height in m and a peak period in s.

    S = (1 - 0.287 ln G) 5/16 H² f_p⁴ f⁻⁵ exp(-5/4 (f_p/f)⁴) G^exp(-(f - f_p)² / (2 s² f_p²)),  s = 0.07 below f_p, 0.09 above
    Source: Hasselmann et al. 1973; the factor, which keeps the significant height, as usual in the field (recalled).
    """
    f, peak = np.asarray(frequency, dtype=float), 1.0 / period
    width = np.where(f <= peak, 0.07, 0.09)
    exponent = np.exp(-((f - peak) ** 2) / (2.0 * width**2 * peak**2))
    scale = (1.0 - 0.287 * math.log(peakedness)) * 5.0 / 16.0 * height**2 * peak**4
    return scale * f**-5 * np.exp(-1.25 * (peak / f) ** 4) * peakedness**exponent


def wave_train(waves, spectrum, where: str, current: float = 0.0) -> WaveTrain:
    """Components of the effects' values; `spectrum` None: one regular wave. current: m/s, along the waves.

    Components of a spectrum that the current blocks are left out. `BadInput` for waves that would have broken, and where more
    than `BLOCKED` of the energy is blocked.
    """
    (number,) = wave_number(np.array([TURN / waves.period]), waves.water_depth, current)
    if math.isnan(number):
        raise BadInput(f"{where}: waves", f"a period of {waves.period:g} s against a current of {-current:.3g} m/s",
                       "waves that travel faster than the current", "The current blocks these waves: lengthen the period.")
    limit = STEEPEST * TURN / number * math.tanh(number * waves.water_depth)
    if waves.height > limit:
        raise BadInput(f"{where}: waves", f"a height of {waves.height:g} m at a period of {waves.period:g} s",
                       f"at most {limit:.3g} m", "Higher waves break at this period and depth: lower the height.")
    amplitude, frequency, phase = np.array([0.5 * waves.height]), np.array([TURN / waves.period]), np.array([waves.phase])
    if spectrum is not None:
        random = np.random.default_rng(int(spectrum.seed))
        edges = np.linspace(LOWEST, HIGHEST, int(spectrum.components) + 1) / waves.period
        fine = np.linspace(edges[:-1], edges[1:], 65)  # 64 intervals of Simpson's rule a band
        density = jonswap(fine, waves.height, waves.period, spectrum.peakedness)
        weights = np.array([1.0, *[4.0, 2.0] * 31, 4.0, 1.0])[:, None] / 3.0
        energy = (weights * density).sum(axis=0) * (edges[1] - edges[0]) / 64.0
        amplitude = np.sqrt(2.0 * energy)
        frequency = TURN * (edges[:-1] + (edges[1:] - edges[:-1]) * random.random(energy.size))
        phase = TURN * random.random(energy.size) + waves.phase
    k = wave_number(frequency, waves.water_depth, current)
    if (blocked := np.isnan(k)).any():
        share = float((amplitude[blocked] ** 2).sum() / (amplitude**2).sum())
        if share > BLOCKED:
            raise BadInput(f"{where}: spectrum", f"a sea of which a current of {-current:.3g} m/s blocks {100.0 * share:.2g} %",
                           f"at most {100.0 * BLOCKED:g} % of its energy", "Lengthen the period, or slow the current down.")
        amplitude, frequency, phase, k = amplitude[~blocked], frequency[~blocked], phase[~blocked], k[~blocked]
    return WaveTrain(waves.u, waves.y, amplitude, frequency, frequency - k * current, k, phase,
                     math.cos(waves.direction), math.sin(waves.direction), waves.water_depth)


@kernel
def add_waves(t, u, y, waves):
    """Add waves to the velocity and acceleration of the water in y[:6] (north, east, down), which hold the current.

    The surface's elevation follows; u: (m,) inputs.
    """
    north, east, depth = u[waves.u], u[waves.u + 1], u[waves.u + 2]
    along = waves.north * north + waves.east * east
    h = waves.water_depth
    z = min(max(depth, 0.0), h)
    speed = sink = rate = sink_rate = elevation = 0.0
    stretch = shear = 0.0  # du/ds = -dv/dz, du/dz = dv/ds
    for i in range(waves.amplitude.size):
        k, w, r = waves.number[i], waves.frequency[i], waves.intrinsic[i]
        angle = k * along - w * t + waves.phase[i]
        c, s = math.cos(angle), math.sin(angle)
        # cosh and sinh of k (h - z) over sinh of k h, in a form that does not overflow
        near, far, whole = math.exp(-k * z), math.exp(-k * (2.0 * h - z)), 1.0 - math.exp(-2.0 * k * h)
        a = waves.amplitude[i]
        level, steep = a * r * (near + far) / whole, a * r * (near - far) / whole
        speed += level * c
        sink -= steep * s
        rate += w * level * s
        sink_rate += w * steep * c
        stretch -= k * level * s
        shear -= k * steep * c
        elevation += a * c
    flow = waves.north * y[0] + waves.east * y[1] + speed
    fall = y[2] + sink
    rate += flow * stretch + fall * shear
    sink_rate += flow * shear - fall * stretch
    y[0] += waves.north * speed
    y[1] += waves.east * speed
    y[2] += sink
    y[3] += waves.north * rate
    y[4] += waves.east * rate
    y[5] += sink_rate
    y[waves.y] = elevation
