"""Statistics of a contact force over a window of the track, with the settings they were made with."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ...harness.analysis.signals import ButterworthFilter, band, fraction_below, gaps, uniform, window

ARC = 5e-3  # s, shorter losses of contact are not counted as arcs (EN 50317, from memory)


@dataclass(frozen=True)
class ContactStatistics:
    """Numbers of one run; forces in N, lengths in m, losses in percent of time.

    All force statistics are of the filtered force, `loss_raw` excepted. `std` is the root of the mean square about the mean
    (divisor n). `std_0_5` and `std_5_20` are of the force in these bands (Hz), by filters of the same order and phase.
    """

    mean: float
    std: float
    statistical_max: float  # mean + 3 std
    statistical_min: float  # mean - 3 std
    max: float
    min: float
    std_0_5: float
    std_5_20: float
    loss_raw: float
    arcs: tuple[float, ...]  # s, losses of contact longer than `ARC`, of the unfiltered force
    loss_filtered: float
    height_range: float  # max - min of the contact point's height
    uplift: tuple[float, ...]  # greatest uplift at each support
    filter: ButterworthFilter
    window: tuple[float, float]
    rate: float  # Hz
    samples: int

    @property
    def max_uplift(self) -> float:
        """Greatest uplift at any of the supports, m; NaN when none was watched."""
        return max(self.uplift, default=float("nan"))

    @property
    def arcing(self) -> float:
        """Share of the time in losses of contact that count as arcs, percent (EN 50317's NQ for a steady speed)."""
        return 100.0 * sum(self.arcs) * self.rate / self.samples

    @property
    def settings(self) -> str:
        """One line that belongs under every table of these numbers."""
        a, b = self.window
        return f"window {a:g} to {b:g} m, {self.samples} samples at {self.rate:g} Hz, {self.filter}"


@dataclass(frozen=True)
class ContactRecord:
    """What the statistics are made of: time (n,) s, contact position (n,) m, force (n,) N, height (n,) m, uplifts (n,) m each,
    NaN where a support is not followed any more."""

    time: np.ndarray
    position: np.ndarray
    force: np.ndarray
    height: np.ndarray
    uplifts: tuple[np.ndarray, ...] = field(default=())

    def statistics(self, span: tuple[float, float], low_pass: ButterworthFilter | None = None) -> ContactStatistics:
        """Statistics over span[0] <= position < span[1]; filters see the whole record, so the window adds no edges.

        The uplift of a support is its maximum over the whole record: a support at the window's edge rises before and after.
        """
        low_pass = low_pass or ButterworthFilter()
        rate, _, (position, force, height) = uniform(self.time, self.position, self.force, self.height)
        cut = window(position, *span)
        filtered = low_pass.apply(force, rate)[cut]
        mean, std = float(filtered.mean()), float(filtered.std())
        return ContactStatistics(
            mean=mean,
            std=std,
            statistical_max=mean + 3.0 * std,
            statistical_min=mean - 3.0 * std,
            max=float(filtered.max()),
            min=float(filtered.min()),
            std_0_5=float(band(force, rate, 0.0, 5.0, low_pass)[cut].std()),
            std_5_20=float(band(force, rate, 5.0, 20.0, low_pass)[cut].std()),
            loss_raw=fraction_below(force[cut]),
            arcs=tuple(gaps(force[cut], rate, ARC).tolist()),
            loss_filtered=fraction_below(filtered),
            height_range=float(np.ptp(height[cut])),
            uplift=tuple(float(np.nanmax(u)) for u in self.uplifts if not np.isnan(u).all()),
            filter=low_pass,
            window=(float(span[0]), float(span[1])),
            rate=rate,
            samples=cut.stop - cut.start,
        )
