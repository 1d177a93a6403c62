"""Spectra of machines that turn: envelopes, families of lines, components that follow the rotation."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ....components.core.errors import BadInput
from .signals import ButterworthFilter, amplitude_spectrum, band, hann

TURN = 2.0 * np.pi
HELD = 64  # samples a turn on which a signal is followed; far above any order that is asked for


def envelope(x: np.ndarray, rate: float, low: float, high: float) -> np.ndarray:
    """Amplitude (n,) of the oscillation of x between `low` and `high` Hz: modulus of the analytic signal of that band."""
    if not 0.0 < low < high < 0.5 * rate:
        actual = f"{low:g} to {high:g} Hz at {rate:g} samples per second"
        raise BadInput("band of the envelope", actual, f"two rising frequencies between 0 and {0.5 * rate:g} Hz")
    from scipy.signal import hilbert

    return np.abs(hilbert(band(x, rate, low, high, ButterworthFilter())))


def envelope_spectrum(x: np.ndarray, rate: float, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """(frequency in Hz, amplitude in units of x) of the envelope in a band: shows what repeats an excitation of a resonance."""
    return amplitude_spectrum(envelope(x, rate, low, high), rate)


def resonance_band(x: np.ndarray, rate: float, lowest: float, highest: float) -> tuple[float, float]:
    """Band in Hz, within two bounds, in which the signal is most impulsive: the highest kurtosis of |analytic signal|.

    Tried are the whole range and its halves, thirds, quarters, sixths and eighths: a coarse form of the kurtogram of Antoni,
    Mechanical Systems and Signal Processing 20 (2006) 282-307 and 21 (2007) 108-124.
    """
    if not 0.0 < lowest < highest < 0.5 * rate:
        actual = f"{lowest:g} to {highest:g} Hz at {rate:g} samples per second"
        raise BadInput("bounds of the envelope's band", actual, f"two rising frequencies between 0 and {0.5 * rate:g} Hz")
    spectrum = np.fft.fft(x - x.mean())
    f = np.fft.fftfreq(x.size, 1.0 / rate)
    candidates = []
    for parts in (1, 2, 3, 4, 6, 8):
        edges = np.linspace(lowest, highest, parts + 1)
        for low, high in pairwise(edges):
            power = np.abs(np.fft.ifft(np.where((f >= low) & (f < high), spectrum, 0.0))) ** 2
            mean = power.mean()
            candidates.append((float((power**2).mean() / mean**2) if mean > 0.0 else 0.0, float(low), float(high)))
    return max(candidates)[1:]


@dataclass(frozen=True)
class Line:
    """A frequency at which something is expected: `order` times the family's, `side` sidebands away."""

    frequency: float
    order: int
    side: int = 0

    @property
    def text(self) -> str:
        """ "2×", "1× + 2 side"; the fundamental alone is empty."""
        text = f"{self.order}×" if self.order > 1 or self.side else ""
        if self.side:
            text += f" {'+' if self.side > 0 else '−'} {abs(self.side)} side"
        return text


@dataclass(frozen=True)
class Family:
    """Lines of one cause: the first `harmonics` multiples of `frequency` (Hz), each with sidebands `spacing` Hz apart."""

    name: str
    frequency: float
    harmonics: int = 3
    spacing: float = 0.0
    sidebands: int = 0

    def lines(self, highest: float) -> list[Line]:
        """The lines above zero and below `highest` Hz, those of the fundamental first."""
        lines = [
            Line(k * self.frequency + m * self.spacing, k, m)
            for k in range(1, self.harmonics + 1)
            for m in range(-self.sidebands, self.sidebands + 1)
        ]
        return [line for line in lines if 0.0 < line.frequency < highest]


def peak(frequency: np.ndarray, amplitude: np.ndarray, near: float, within: float) -> tuple[float, float]:
    """(frequency in Hz, amplitude) of the highest line of an amplitude spectrum at most `within` Hz from `near`.

    Between the bins by the shape of the Hann window, exact for a lone sine: with r the greater neighbour over the highest
    bin, the sine lies d = (2 r - 1) / (r + 1) bins towards it, and is pi d (1 - d^2) / sin(pi d) times as high.
    """
    step = frequency[1]
    first, last = (int(k) for k in np.searchsorted(frequency, (near - within, near + within)))
    if first >= last:
        raise BadInput("spectrum", f"no line within {within:g} Hz of {near:g} Hz", f"more than the bins' spacing, {step:g} Hz")
    k = first + int(np.argmax(amplitude[first:last]))
    if not 0 < k < amplitude.size - 1 or amplitude[k] == 0.0:
        return float(frequency[k]), float(amplitude[k])
    side = 1 if amplitude[k + 1] >= amplitude[k - 1] else -1
    r = amplitude[k + side] / amplitude[k]
    d = np.clip((2.0 * r - 1.0) / (r + 1.0), 0.0, 0.5)  # beyond: not a sine's shape
    return float(frequency[k] + side * d * step), float(amplitude[k] * (1.0 - d * d) / np.sinc(d))


@dataclass(frozen=True)
class Track:
    """A component that follows the rotation. component (k,): A exp(-i phi) of A cos(order * angle - phi).

    The angle counts the way the rotor turns, backwards, too: a lag is one in time, and forward is with the rotation.
    """

    time: np.ndarray  # (k,) s
    speed: np.ndarray  # (k,) rad/s
    component: np.ndarray

    @property
    def amplitude(self) -> np.ndarray:
        """(k,), in units of the signal."""
        return np.abs(self.component)

    @property
    def lag(self) -> np.ndarray:
        """Phase lag in time behind the rotation, whichever way it goes, (k,) rad, without jumps."""
        return -np.unwrap(np.angle(self.component))


def unwrapped(angle: np.ndarray) -> np.ndarray:
    """An angle (n,) rad that was recorded within one turn, without its jumps; refused where its direction is ambiguous."""
    steps = np.abs((np.diff(angle) + np.pi) % TURN - np.pi)
    if steps.size and steps.max() > 0.9 * np.pi:
        actual = f"{np.degrees(steps.max()):.0f}° between two samples"
        raise BadInput("angle", actual, "less than half a turn", "Record more often.")
    return np.unwrap(angle)


def turns_steadily(angle: np.ndarray) -> bool:
    """Whether a recorded angle always turns the same way, and was recorded often enough to tell: sections and orders need it."""
    steps = (np.diff(angle) + np.pi) % TURN - np.pi
    return bool(steps.size) and bool((steps > 0.0).all() or (steps < 0.0).all()) and float(np.abs(steps).max()) < 0.5 * np.pi


def follow(time: np.ndarray, angle: np.ndarray, x: np.ndarray, order: float = 1.0, turns: int = 4) -> Track:
    """The component of x (n,) at `order` times the rotation, over windows of `turns` turns that lie a turn apart.

    Resampled over the angle, Hann window: of a steady signal, all whole orders but the neighbours within 2 / turns are
    rejected to rounding, the mean among them. A complex x + i y gives the whirl with the rotation (order -1: against it); of a
    rotor that turns backwards it is seen in the mirror, x - i y, in which it turns forwards.
    """
    theta = unwrapped(angle)
    if theta[-1] < theta[0]:
        theta, x = -theta, x.conj()
    whole = int((theta[-1] - theta[0]) / TURN)
    if turns < 2 or whole < turns or not (np.diff(theta) > 0.0).all():
        raise BadInput("order tracking", f"windows of {turns} turns of {whole}, or a turning back", "two or more, one direction")
    n = turns * HELD
    even = theta[0] + TURN / HELD * np.arange(whole * HELD)
    t, real = np.interp(even, theta, time), np.interp(even, theta, x.real)
    held = real + 1j * np.interp(even, theta, x.imag) if np.iscomplexobj(x) else 2.0 * real
    turned = held * np.exp(-1j * order * even)
    weights = hann(n)
    starts = np.arange(0, even.size - n + 1, HELD)
    component = np.array([weights @ turned[k : k + n] for k in starts]) / weights.sum()
    middle = starts + n // 2
    speed = np.gradient(even, t)[middle] if even.size > n else np.array([TURN * turns / (t[-1] - t[0])])
    return Track(t[middle], speed, component)


def waterfall(x: np.ndarray, rate: float, duration: float, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(times (k,) s of the windows' middles from the first sample, frequency (m,) Hz, amplitudes (k, m)).

    `count` windows of `duration` s spread evenly over the signal, each a single-sided amplitude spectrum. (SciPy's short-time
    transform moves by a whole number of samples, pads the ends, and leaves the amplitudes to the caller.)
    """
    n = round(duration * rate)
    if not 8 <= n <= x.size or count < 2:
        actual = f"{count} windows of {n} samples in {x.size}"
        raise BadInput("waterfall", actual, "two windows or more of at least 8 samples, no longer than the signal")
    starts = np.linspace(0, x.size - n, count).round().astype(int)
    spectra = [amplitude_spectrum(x[k : k + n], rate) for k in starts]
    return (starts + 0.5 * n) / rate, spectra[0][0], np.array([a for _, a in spectra])
