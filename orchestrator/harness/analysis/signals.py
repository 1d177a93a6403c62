"""Pure functions on sampled signals: filters, moments, bands, spectra, windows. Nothing here knows what the signal means."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from ....components.core.errors import BadInput

FINER = 20  # times the samples of an uneven record: most that it is resampled to
EDGE = (np.sqrt(2.0) - 1.0) ** 0.5  # (frequency ratio)^n at which two passes of an n-th order Butterworth lose 3 dB together


@dataclass(frozen=True)
class ButterworthFilter:
    """Butterworth filter, described as a whole: what is stated here is what the signal has gone through.

    cutoff: Hz, where the whole filter's gain is 1/sqrt(2) (-3 dB).
    order: of the whole filter; far beyond the cut-off the gain falls by `order` * 20 dB a decade.
    zero_phase: True, one pass of order/2 forward and one backward, with the cut-off of the single pass moved so that both
        together lose 3 dB at `cutoff` (the order must be even); False, one causal pass of the full order, which delays.
    kind: "lowpass" or "highpass".
    """

    cutoff: float = 20.0
    order: int = 6
    zero_phase: bool = True
    kind: str = "lowpass"

    def __post_init__(self) -> None:
        if self.kind not in ("lowpass", "highpass"):
            raise BadInput("filter", f"kind {self.kind!r}", "'lowpass' or 'highpass'")
        if self.order < 1 or (self.zero_phase and self.order % 2):
            raise BadInput("filter", f"order {self.order}", "a positive order, even for zero phase")
        if not self.cutoff > 0.0:
            raise BadInput("filter", f"cut-off {self.cutoff} Hz", "a positive frequency")

    def __str__(self) -> str:
        phase = "zero phase (forward and backward)" if self.zero_phase else "causal"
        kind = "low pass" if self.kind == "lowpass" else "high pass"
        return f"{self.cutoff:g} Hz Butterworth {kind}, order {self.order}, {phase}, -3 dB at {self.cutoff:g} Hz"

    def apply(self, x: np.ndarray, rate: float) -> np.ndarray:
        """The filtered signal, (n,), of `x` (n,) sampled at `rate` Hz.

        The causal pass starts as if the first sample had stood for ever; the zero-phase one extends both ends by odd
        reflection. So keep some periods of the cut-off between a window of interest and the ends of the signal.
        """
        from scipy.signal import sosfilt, sosfilt_zi, sosfiltfilt

        if not self.cutoff < 0.5 * rate:
            raise BadInput("filter", f"cut-off {self.cutoff:g} Hz at {rate:g} samples per second", f"less than {0.5 * rate:g} Hz")
        coefficients = sections(self, rate)
        if not self.zero_phase:
            return sosfilt(coefficients, x, zi=sosfilt_zi(coefficients) * x[0])[0]
        return sosfiltfilt(coefficients, x, padlen=min(x.size - 1, int(3 * rate / self.cutoff)))


@lru_cache(maxsize=64)  # a report and the errors of its numbers apply the same few filters many times
def sections(of: ButterworthFilter, rate: float) -> np.ndarray:
    """Second-order sections of a pass at a rate in Hz."""
    from scipy.signal import butter

    if not of.zero_phase:
        return butter(of.order, of.cutoff, of.kind, fs=rate, output="sos")
    n = of.order // 2
    # The bilinear transform warps frequencies by tan; shifting the cut-off on the warped axis is exact at any rate.
    warped = np.tan(np.pi * of.cutoff / rate) * EDGE ** (-1.0 / n if of.kind == "lowpass" else 1.0 / n)
    return butter(n, rate / np.pi * np.arctan(warped), of.kind, fs=rate, output="sos")


def uniform(time: np.ndarray, *signals: np.ndarray) -> tuple[float, np.ndarray, list[np.ndarray]]:
    """(rate in Hz, uniform time (n,), signals (n,)): as they are if the samples are evenly spaced, else interpolated linearly.

    An uneven record is resampled at its smallest spacing, so that nothing recorded is skipped, but to no more than `FINER`
    times its samples: a step that ends at an event may be a millionth of the others.
    """
    steps = np.diff(time)
    if time.size < 2 or not (steps > 0.0).all():
        raise BadInput("time", "fewer than two samples or a time that does not increase", "increasing times of a run")
    span = time[-1] - time[0]
    mean = span / steps.size
    if np.abs(steps - mean).max() <= 1e-6 * mean:
        return 1.0 / mean, time, list(signals)
    n = int(min(np.ceil(span / steps.min() * (1.0 - 1e-9)), FINER * steps.size))
    even = time[0] + span / n * np.arange(n + 1)
    return n / span, even, [np.interp(even, time, s) for s in signals]


def window(position: np.ndarray, start: float, end: float) -> slice:
    """The samples with start <= position < end, for a position (n,) that never decreases.

    Half open, so that neighbouring windows share no sample, and a whole number of spans is not weighted at both ends.
    """
    if not end > start:
        raise BadInput("window", f"from {start:g} to {end:g}", "an end after the start")
    first, last = np.searchsorted(position, (start, end))
    if last - first < 2 or position[0] > start or position[-1] < end - 2.0 * (position[-1] - position[-2]):
        raise BadInput(
            "window",
            f"from {start:g} to {end:g} where the run covers {position[0]:g} to {position[-1]:g}",
            "a window within the run",
            "Lengthen the run or move the window.",
        )
    return slice(int(first), int(last))


def fraction_below(x: np.ndarray, level: float = 0.0) -> float:
    """Share of the samples with x <= level, in percent."""
    return 100.0 * float(np.count_nonzero(x <= level)) / x.size


def gaps(x: np.ndarray, rate: float, longer_than: float = 0.0, level: float = 0.0) -> np.ndarray:
    """Lengths in s, (k,), of the uninterrupted stretches with x <= level that are longer than `longer_than` seconds."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], x <= level, [0]))))
    lengths = edges[1::2] - edges[::2]
    return lengths[lengths > longer_than * rate * (1.0 + 1e-9)] / rate


def band(x: np.ndarray, rate: float, low: float, high: float, like: ButterworthFilter) -> np.ndarray:
    """The part of x between `low` and `high` Hz, (n,), by filters of the order and phase of `like`; low 0 keeps the mean."""
    kept = ButterworthFilter(high, like.order, like.zero_phase).apply(x, rate)
    return kept if low == 0.0 else ButterworthFilter(low, like.order, like.zero_phase, "highpass").apply(kept, rate)


def hann(n: int) -> np.ndarray:
    """Weights (n,) of the periodic Hann window, sin(pi k / n)^2; 1 of a single sample."""
    return np.sin(np.pi / n * np.arange(n)) ** 2 if n > 1 else np.ones(n)


def amplitude_spectrum(x: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """(frequency in Hz, amplitude in units of x): single-sided, mean removed, Hann window.

    Scaled by the window's mean, so that a sine of amplitude A on a line of the spectrum reads A there.
    """
    weights = hann(x.size)
    amplitude = np.abs(np.fft.rfft((x - x.mean()) * weights)) * 2.0 / weights.sum()
    amplitude[0] *= 0.5
    if x.size % 2 == 0:
        amplitude[-1] *= 0.5
    return np.fft.rfftfreq(x.size, 1.0 / rate), amplitude


def welch_spectrum(
    x: np.ndarray, rate: float, samples: int, overlap: float, window: str, kind: str
) -> tuple[np.ndarray, np.ndarray]:
    """(frequency in Hz, spectrum), one-sided, of x (n,) sampled at `rate` Hz: mean over segments of so many samples, their means
    removed (Welch, IEEE Transactions on Audio and Electroacoustics 15 (1967) 70-73; SciPy's).

    kind: "power spectral density", units² / Hz, or "amplitude spectrum", in units: a sine of amplitude A on a line reads A there.
    """
    from scipy import signal as dsp

    density = kind == "power spectral density"
    f, p = dsp.welch(
        x, rate, window, samples, int(overlap * samples), detrend="constant", scaling="density" if density else "spectrum"
    )
    return f, p if density else np.sqrt(2.0 * p)


def amplitude_at(x: np.ndarray, rate: float, frequency: float) -> float:
    """Amplitude of the part of x (n,), sampled at `rate` Hz, that oscillates at `frequency` Hz; mean removed, Hann window.

    A sine at a distance of two spacings rate/n or more from `frequency` hardly counts.
    """
    if not 0.0 < frequency < 0.5 * rate:
        raise BadInput("amplitude", f"{frequency:g} Hz at {rate:g} samples per second", f"between 0 and {0.5 * rate:g} Hz")
    weights = hann(x.size)
    turning = np.exp(-2j * np.pi * frequency / rate * np.arange(x.size))
    return float(2.0 * abs(((x - x.mean()) * weights) @ turning) / weights.sum())


def accumulated(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Integral of values (n,) over time (n,) from its start on, (n,): trapezoids."""
    return np.concatenate(([0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(time))))
