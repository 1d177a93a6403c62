"""The window of moving wires, and how wide it has to be: waves that its edges let out must not be missed when they come back.

    echo = A exp(-g T),   T = 2 L c / (c² - v²),   g = (alpha + beta w²) / 2,   w = N 2 pi v / span

L: length to the edge; v: speed of the contact; c: of waves on the quicker wire; T: time in which a wave goes out to the edge and
comes back to a contact that moves on; g: its Rayleigh damping at N times the frequency at which supports pass. A and N are
computed: the 20 Hz-filtered force in windows of 60 to 700 m against the whole line, on the reference model of EN 50318:2002 over
30 spans at 144, 200 and 250 km/h (N = 4.4 to 5.3, A = 0.2), and on lines of AC and DC benchmarks with a tenth of the damping,
where dispersion and scattering at droppers act as well and the formula is on the safe side (A = 0.3 to 0.5).
"""

from __future__ import annotations

import math
import warnings

import numpy as np

from ..core.kernels import kernel
from .contact import element_at
from .wires import LINE, row_length

AHEAD, BEHIND, WANTED, COST_AHEAD, COST_BEHIND = range(5)  # of `window`: lengths in use and wanted, m, and their `echo`
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


@kernel
def open_window(alpha, beta, mesh, window, given):
    """Lengths of the window that moves, where they are not given; given: of `MovingWindow`."""
    wave, span, whole = 0.0, 0.0, mesh.position[mesh.position.size - 1]
    for j in range(mesh.impedance.size):
        if mesh.impedance[j] > 0.0:
            wave = max(wave, mesh.tension[j] / mesh.impedance[j])
    for k in range(mesh.support.size - 1):
        span = max(span, mesh.position[mesh.support[k + 1]] - mesh.position[mesh.support[k]])
    wanted = width(wave, span, alpha, beta, given.speed)
    window[WANTED] = wanted
    window[AHEAD] = given.ahead if given.ahead > 0.0 else min(wanted, whole)
    window[BEHIND] = given.behind if given.behind > 0.0 else min(wanted, whole)
    window[COST_AHEAD] = echo(window[AHEAD], wave, span, alpha, beta, given.speed)
    window[COST_BEHIND] = echo(window[BEHIND], wave, span, alpha, beta, given.speed)


@kernel
def move_window(front, rear, x, mesh, window):
    """First and last moving node for the contact points at `front` and `rear`; nodes left behind go to equilibrium.

    x: its last two elements hold the window of the step before.  window: its lengths, m.
    """
    n, N, W = mesh.position.size, mesh.mass.size, mesh.bending_gradient.size
    before = int(x[x.size - 2])
    lo = max(element_at(max(rear - window[BEHIND], 0.0), mesh), max(before, 1))
    hi = min(element_at(min(front + window[AHEAD], mesh.position[n - 1]), mesh) + 1, n - 2)
    if lo > 1:
        lo = max(lo - lo % LINE, max(before, 1))  # rows are swept from the beginning of a line of the cache
    for part in range(3):
        for j in range(W * max(before, 1), W * lo):
            x[part * row_length(N) + j] = 0.0
    x[x.size - 2], x[x.size - 1] = lo, hi
    return lo, hi


def warn_of_narrow_window(name: str, ahead: float, behind: float, window: np.ndarray, whole: float) -> None:
    """Warn where a length that is given is too short; name: of the component.  whole: length of the line, m."""
    wanted = float(window[WANTED])
    for side, given, cost in (("ahead", ahead, window[COST_AHEAD]), ("behind", behind, window[COST_BEHIND])):
        if 0.0 < given < min(wanted, whole):
            takes = "the whole line" if wanted >= whole else f"{wanted:.0f} m"
            warnings.warn(
                f"{name}: moving_window.{side} = {given:g} m may cost {100.0 * cost:.2g} % of the contact force: "
                f"{100.0 * ENOUGH:g} % takes {takes}; 0 is as much as it takes",
                stacklevel=3,
            )
