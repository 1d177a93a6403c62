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
flow" (J. Fluid Mech. 197, 1988) for the acceleration (from memory).
"""

from __future__ import annotations

import math

import numpy as np

from ..core.component import Effect
from ..core.contract import Refusal
from ..core.kernels import DONE, OWN, kernel
from ..core.variables import SEED, input_, integer, output, parameter

GRAVITY = 9.80665  # m/s²
TURN = 2.0 * math.pi
STEEPEST = 0.142  # height over length at which a wave breaks in deep water (Miche 1944; from memory)
LOWEST, HIGHEST = 0.4, 6.0  # ends of a spectrum over its peak frequency: all but 0.1 % of the energy lies between
BLOCKED = 0.01  # largest share of a sea's energy that may be left out, as a current blocks it
# rows of the components of a sea: m, rad/s at a fixed place, rad/s seen by one who drifts with the current, 1/m, rad
AMPLITUDE, FREQUENCY, INTRINSIC, NUMBER, PHASE = range(5)
ROWS = 5
WAVES_BLOCKED, BROKEN, SEA_BLOCKED = OWN + 1, OWN + 2, OWN + 3
REFUSALS = {
    WAVES_BLOCKED: Refusal(
        "waves: a period of {waves.period} s against a current of {refused[0]} m/s",
        "waves that travel faster than the current",
        "The current blocks these waves: lengthen the period.",
    ),
    BROKEN: Refusal(
        "waves: a height of {waves.height} m at a period of {waves.period} s",
        "at most {refused[1]} m",
        "Higher waves break at this period and depth: lower the height.",
    ),
    SEA_BLOCKED: Refusal(
        "spectrum: a sea of which a current of {refused[0]} m/s blocks {refused[1]} %",
        f"at most {100.0 * BLOCKED:g} % of its energy",
        "Lengthen the period, or slow the current down.",
    ),
}
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
    components = integer(200, "number of components", low=1, high=5000, mesh="random")
    seed = integer(1, "of the random phases and frequencies", low=0, high=2**31 - 1, structural=SEED)


@kernel
def wave_number(frequency, water_depth, current):
    """k of (w - k U)² = g k tanh(k h), 1/m, by Newton's method; frequency w in rad/s at a fixed place, current U along the wave.

    NaN where an opposing current blocks the wave: no wave of that frequency carries its energy against it.
    """
    w = frequency
    deep = w * w / GRAVITY * water_depth  # k h in deep water
    x = deep / math.sqrt(math.tanh(deep))  # within 5 % at any depth
    for _ in range(8):
        t = math.tanh(x)
        x = x - (x * t - deep) / (t + x * (1.0 - t * t))
    k = x / water_depth
    if current == 0.0:
        return k
    for _ in range(200):  # r + k U - w is concave: from the left of its zero, or where U > 0 after one step, none goes beyond it
        r, group = intrinsic(k, water_depth)
        if group + current <= 0.0:
            return math.nan
        before = k
        k = k - (r + k * current - w) / (group + current)
        if k == before:
            break
    r, _ = intrinsic(k, water_depth)
    return math.nan if abs(r + k * current - w) > 1e-9 * w else k


@kernel
def intrinsic(number, water_depth):
    """Frequency, rad/s, and group velocity, m/s, of a wave on water at rest."""
    kh = number * water_depth
    r = math.sqrt(GRAVITY * number * math.tanh(kh))
    return r, 0.5 * r / number * (1.0 + 2.0 * kh / math.sinh(min(2.0 * kh, 700.0)))


@kernel
def jonswap(frequency, height, period, peakedness):
    """Spectral density of the elevation, m² s, over the frequency in Hz, of a significant height in m and a peak period in s.

    S = (1 - 0.287 ln G) 5/16 H² f_p⁴ f⁻⁵ exp(-5/4 (f_p/f)⁴) G^exp(-(f - f_p)² / (2 s² f_p²)),  s = 0.07 below f_p, 0.09 above
    Source: Hasselmann et al. 1973; the factor, which keeps the significant height, as usual in the field (from memory).
    """
    f, peak = frequency, 1.0 / period
    width = 0.07 if f <= peak else 0.09
    exponent = math.exp(-((f - peak) ** 2) / (2.0 * width**2 * peak**2))
    scale = (1.0 - 0.287 * math.log(peakedness)) * 5.0 / 16.0 * height**2 * peak**4
    return scale * f**-5.0 * math.exp(-1.25 * (peak / f) ** 4) * peakedness**exponent


def chances(components: int, seed: int) -> np.ndarray:
    """Places of the components within their bands, and their phases over a turn, (2, n), of a seed."""
    random = np.random.default_rng(seed)
    return np.stack([random.random(components), random.random(components)])


@kernel
def band_edge(i, n, period):
    """Lower edge of band i of n, Hz."""
    return (HIGHEST if i == n else i * ((HIGHEST - LOWEST) / n) + LOWEST) / period


@kernel
def band_energy(low, high, waves, spectrum):
    """Energy of the spectrum between two frequencies in Hz, m²: Simpson's rule with 64 intervals."""
    total, step = 0.0, (high - low) / 64
    for j in range(65):
        weight = 1.0 if j == 0 or j == 64 else 4.0 if j % 2 == 1 else 2.0
        f = high if j == 64 else j * step + low
        total += weight / 3.0 * jonswap(f, waves.height, waves.period, spectrum.peakedness)
    return total


@kernel
def start_waves(current, sea, count, refused, chance, waves, spectrum):
    """The components of a sea, or one regular wave where there is no spectrum, on a current along them in m/s.

    Components of a spectrum that the current blocks are left out. Returns a status: refused are waves that would have broken,
    and a sea of which the current blocks more than `BLOCKED` of the energy.
    """
    number = wave_number(TURN / waves.period, waves.water_depth, current)
    refused[0] = -current
    if math.isnan(number):
        return WAVES_BLOCKED
    refused[1] = STEEPEST * TURN / number * math.tanh(number * waves.water_depth)
    if waves.height > refused[1]:
        return BROKEN
    if spectrum is None:
        sea[AMPLITUDE, 0], sea[FREQUENCY, 0], sea[PHASE, 0] = 0.5 * waves.height, TURN / waves.period, waves.phase
        sea[NUMBER, 0], sea[INTRINSIC, 0] = number, TURN / waves.period - number * current
        count[0] = 1
        return DONE
    n, taken, whole, blocked = sea.shape[1], 0, 0.0, 0.0
    first = band_edge(1, n, waves.period) - band_edge(0, n, waves.period)
    for i in range(n):
        low, high = band_edge(i, n, waves.period), band_edge(i + 1, n, waves.period)
        amplitude = math.sqrt(2.0 * (band_energy(low, high, waves, spectrum) * first / 64.0))
        frequency = TURN * (low + (high - low) * chance[0, i])
        number = wave_number(frequency, waves.water_depth, current)
        whole += amplitude * amplitude
        if math.isnan(number):
            blocked += amplitude * amplitude
            continue
        sea[AMPLITUDE, taken], sea[FREQUENCY, taken], sea[NUMBER, taken] = amplitude, frequency, number
        sea[INTRINSIC, taken], sea[PHASE, taken] = frequency - number * current, TURN * chance[1, i] + waves.phase
        taken += 1
    count[0] = taken
    refused[1] = 100.0 * blocked / whole if whole > 0.0 else 0.0
    return SEA_BLOCKED if refused[1] > 100.0 * BLOCKED else DONE


@kernel
def add_waves(t, u, y, sea, count, waves):
    """Add waves to the velocity and acceleration of the water in y[:6] (north, east, down), which hold the current.

    The surface's elevation follows; u: (m,) inputs.
    """
    north, east = math.cos(waves.direction), math.sin(waves.direction)
    along = north * u[waves.u] + east * u[waves.u + 1]
    h = waves.water_depth
    z = min(max(u[waves.u + 2], 0.0), h)
    speed = sink = rate = sink_rate = elevation = 0.0
    stretch = shear = 0.0  # du/ds = -dv/dz, du/dz = dv/ds
    for i in range(count[0]):
        k, w, r = sea[NUMBER, i], sea[FREQUENCY, i], sea[INTRINSIC, i]
        angle = k * along - w * t + sea[PHASE, i]
        c, s = math.cos(angle), math.sin(angle)
        # cosh and sinh of k (h - z) over sinh of k h, in a form that does not overflow
        near, far, whole = math.exp(-k * z), math.exp(-k * (2.0 * h - z)), 1.0 - math.exp(-2.0 * k * h)
        a = sea[AMPLITUDE, i]
        level, steep = a * r * (near + far) / whole, a * r * (near - far) / whole
        speed += level * c
        sink -= steep * s
        rate += w * level * s
        sink_rate += w * steep * c
        stretch -= k * level * s
        shear -= k * steep * c
        elevation += a * c
    flow = north * y[0] + east * y[1] + speed
    fall = y[2] + sink
    rate += flow * stretch + fall * shear
    sink_rate += flow * shear - fall * stretch
    y[0] += north * speed
    y[1] += east * speed
    y[2] += sink
    y[3] += north * rate
    y[4] += east * rate
    y[5] += sink_rate
    y[waves.y] = elevation
