"""How wide a window of moving wires has to be: waves that its edges let out must not be missed when they would come back.

    echo = A exp(-g T),   T = 2 L c / (c² - v²),   g = (alpha + beta w²) / 2,   w = N 2 pi v / span

L: length to the edge; v: speed of the contact; c: of waves on the quicker wire; T: time in which a wave goes out to the edge and
comes back to a contact that moves on; g: its Rayleigh damping at N times the frequency at which supports pass. A and N are
computed: the 20 Hz-filtered force in windows of 60 to 700 m against the whole line, on the reference model of EN 50318:2002 over
30 spans at 144, 200 and 250 km/h (N = 4.4 to 5.3, A = 0.2), and on lines of AC and DC benchmarks with a tenth of the damping,
where dispersion and scattering at droppers act as well and the formula is on the safe side (A = 0.3 to 0.5).
"""

from __future__ import annotations

import math

from ..core.kernels import kernel

ENOUGH = 0.005  # error of the filtered contact force (rms) over its standard deviation
STRENGTH = 0.5  # A
HARMONIC = 4.4  # N


@kernel
def echo(length, wave, span, alpha, beta, speed):
    """Error of the contact force that an edge at a length (m) makes, as share of its deviation.

    wave: speed of waves, m/s; span: m; alpha, beta: 1/s, s; speed: of the contact, m/s.
    """
    if speed >= wave:
        return 0.0  # no wave runs ahead of the contact, and none from behind reaches it
    back = 2.0 * length * wave / (wave**2 - speed**2)
    return STRENGTH * math.exp(-wave_damping(span, alpha, beta, speed) * back)


@kernel
def width(wave, span, alpha, beta, speed):
    """Length to an edge, m, for an echo of `ENOUGH`, a span at least; infinite without damping. Arguments as of `echo`."""
    if speed >= wave:
        return span
    rate = wave_damping(span, alpha, beta, speed)
    if rate == 0.0:
        return math.inf
    return max(math.log(STRENGTH / ENOUGH) / rate * (wave**2 - speed**2) / (2.0 * wave), span)


@kernel
def wave_damping(span, alpha, beta, speed):
    """Rayleigh damping at the frequency at which an echo counts, 1/s."""
    return 0.5 * (alpha + beta * (HARMONIC * 2.0 * math.pi * speed / span) ** 2)
