"""The part of the line that moves: its front follows the motion, its rear is a length behind the last contact point.

Front: nodes rest at the equilibrium of the start, fixed there, until one of the last nodes before them moves more than a threshold,
a share of the largest motion of a catenary; then `STRIP` nodes more move. A wave is not quicker than a node in a step. The 20
Hz-filtered force changes in proportion to the threshold: 1e-4 of 0.07 m and 0.6 m/s changes it by 0.002 % of its deviation in 5 s
over ten spans, by 0.009 % in 20 s over sixty, of EN 50318:2002. Behind nothing comes to rest within a run: there a length is given, or
follows from what waves that the edge lets out must not be missed for when they come back:

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
from .wires import LINE, contacts_at, first_at_or_after, row_length, state_rows

# of `window`: share of the motion, 0 where all moves; length behind, m, infinite where all moves, and that given, 0: from damping and
# speed; speed of waves, m/s; longest span, m; nodes for which it was found which droppers, supports and clamps move: first and end
THRESHOLD, BEHIND, GIVEN, WAVE, SPAN, FIRST, LAST, FOUND = range(8)
WINDOW = FOUND + 6
LARGEST, FASTEST_NODE = (
    0.07,
    0.6,
)  # m, m/s: the largest motion, of which the threshold is a share; EN 50318:2002 has 0.068 and 0.6
STRIP = 16  # nodes by which the front moves on
SEEN = 4  # nodes at the front that are looked at
ENOUGH = 0.005  # error of the filtered contact force (rms) over its standard deviation
STRENGTH = 0.5  # A
HARMONIC = 4.4  # N
USUAL_SPEED = 250.0 / 3.6  # m/s, for which a length that is given is judged before a run


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
def open_window(threshold, mesh, window, given):
    """Threshold and rear of the part that moves; given: of `MovingWindow`, or None."""
    wave, span = 0.0, 0.0
    for j in range(mesh.impedance.size):
        if mesh.impedance[j] > 0.0:
            wave = max(wave, mesh.tension[j] / mesh.impedance[j])
    for k in range(mesh.support.size - 1):
        span = max(span, mesh.position[mesh.support[k + 1]] - mesh.position[mesh.support[k]])
    window[THRESHOLD], window[WAVE], window[SPAN], window[FIRST] = threshold, wave, span, -1.0
    window[BEHIND], window[GIVEN] = math.inf, math.inf
    if given is not None:
        window[GIVEN] = given.behind
        if given.behind > 0.0:
            window[BEHIND] = given.behind


@kernel
def follow_speed(x, points, mesh, window, alpha, beta):
    """The length behind that is not given, for the slowest contact point; x: state."""
    if window[GIVEN] == 0.0:
        slowest = math.inf
        for k in range(points.shape[0]):
            slowest = min(slowest, abs(x[contacts_at(mesh.mass.size) + 2 * k + 1]))
        window[BEHIND] = width(window[WAVE], window[SPAN], alpha, beta, slowest)


@kernel
def quiet(first, end, x, threshold, mesh):
    """Whether the nodes first to end - 1 move less than the threshold."""
    q, w, _ = state_rows(x, mesh.mass.size)
    W = mesh.bending_gradient.size
    moving = False
    for j in range(W * first, W * end):
        moving = moving or abs(q[j]) > threshold * LARGEST or abs(w[j]) > threshold * FASTEST_NODE
    return not moving


@kernel
def begin_front(front, x, mesh, window):
    """All moves, but what the equilibrium moves by less than the threshold, ahead of the contact point at `front`, m."""
    hi, least = mesh.position.size - 2, element_at(front, mesh) + STRIP
    while window[THRESHOLD] > 0.0 and hi - STRIP > least and quiet(hi - STRIP, hi + 1, x, window[THRESHOLD], mesh):
        hi -= STRIP
    x[x.size - 2], x[x.size - 1] = 1.0, hi


@kernel
def move_window(front, rear, x, mesh, window):
    """First and last moving node for the contact points at `front` and `rear`; nodes left behind go to equilibrium.

    x: its last two elements hold those of the step before.  window: see above.
    """
    n, N, W = mesh.position.size, mesh.mass.size, mesh.bending_gradient.size
    before, hi = int(x[x.size - 2]), int(x[x.size - 1])
    if hi < n - 2:
        least = min(element_at(front, mesh) + STRIP, n - 2)
        while hi < least:
            hi = min(hi + STRIP, n - 2)
        if hi < n - 2 and not quiet(hi - SEEN, hi + 1, x, window[THRESHOLD], mesh):
            hi = min(hi + STRIP, n - 2)
    lo = before
    if rear > window[BEHIND]:
        lo = max(element_at(rear - window[BEHIND], mesh), before)
        lo = max(lo - lo % LINE, before)  # rows are swept from the beginning of a line of the cache
        for part in range(3):
            for j in range(W * before, W * lo):
                x[part * row_length(N) + j] = 0.0
    x[x.size - 2], x[x.size - 1] = lo, hi
    if window[FIRST] != lo or window[LAST] != hi:
        window[FIRST], window[LAST] = lo, hi
        window[FOUND], window[FOUND + 1] = first_at_or_after(mesh.dropper, lo), first_at_or_after(mesh.dropper, hi + 1)
        window[FOUND + 2] = max(first_at_or_after(mesh.support, lo), 1)
        window[FOUND + 3] = min(first_at_or_after(mesh.support, hi + 1), mesh.support.size - 1)
        window[FOUND + 4] = first_at_or_after(mesh.clamped, W * lo)
        window[FOUND + 5] = first_at_or_after(mesh.clamped, W * hi + W)
    return lo, hi


def warn_of_narrow_window(name: str, behind: float, alpha: float, beta: float, window: np.ndarray, whole: float) -> None:
    """Warn where a length that is given is too short; name: of the component.  whole: length of the line, m."""
    line = float(window[WAVE]), float(window[SPAN]), alpha, beta, USUAL_SPEED
    wanted = width(*line)
    if 0.0 < behind < min(wanted, whole):
        takes = "the whole line" if wanted >= whole else f"{wanted:.0f} m"
        warnings.warn(
            f"{name}: moving_window.behind = {behind:g} m may cost {100.0 * echo(behind, *line):.2g} % of the contact force at "
            f"250 km/h: {100.0 * ENOUGH:g} % takes {takes}; 0 is as much as it takes",
            stacklevel=3,
        )
