"""Signals with answers known beforehand."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.analysis.signals import (
    ButterworthFilter,
    amplitude_spectrum,
    band,
    fraction_below,
    gaps,
    uniform,
    window,
)
from cosimo.orchestrator.systems.railway.contact import ContactRecord

RATE = 1000.0
TIME = np.arange(20_000) / RATE
MIDDLE = slice(5_000, 15_000)  # 10 s: whole periods of every frequency used here, 5 s away from the ends' transients
TRANSIENT = 1e-6  # what a 20 Hz filter's transient leaves after 5 s is far below; covers the rounding of the recursion too


def sine(frequency, amplitude=1.0):
    return amplitude * np.sin(2 * np.pi * frequency * TIME)


def gain(low_pass, frequency):
    return np.sqrt(2.0) * low_pass.apply(sine(frequency), RATE)[MIDDLE].std()


@pytest.mark.parametrize("zero_phase", [True, False])
@pytest.mark.parametrize("order", [2, 4, 6, 8])
@pytest.mark.parametrize("kind", ["lowpass", "highpass"])
def test_gain_at_the_cutoff_is_3_db_for_the_whole_filter(order, zero_phase, kind):
    assert gain(ButterworthFilter(20.0, order, zero_phase, kind), 20.0) == pytest.approx(np.sqrt(0.5), abs=TRANSIENT)


def test_order_is_that_of_the_whole_filter():
    # Bilinear transform: the analogue Butterworth on the axis tan(pi f / rate), here for a causal pass of order 6.
    ratio = np.tan(np.pi * 40.0 / RATE) / np.tan(np.pi * 20.0 / RATE)
    assert gain(ButterworthFilter(20.0, 6, False), 40.0) == pytest.approx((1 + ratio**12) ** -0.5, abs=TRANSIENT)
    # Two passes of order 3: gain 1 / (1 + (sqrt(2) - 1) ratio^6), the same asymptote up to the factor sqrt(2) - 1.
    assert gain(ButterworthFilter(20.0, 6, True), 40.0) == pytest.approx(1 / (1 + (np.sqrt(2) - 1) * ratio**6), abs=TRANSIENT)


def test_zero_phase_does_not_shift_and_causal_delays_by_the_phase_of_butterworth():
    x = sine(10.0)
    for low_pass, phase in ((ButterworthFilter(20.0, 6, True), 0.0), (ButterworthFilter(20.0, 2, False), None)):
        y = low_pass.apply(x, RATE)[MIDDLE]
        measured = np.angle(np.sum(y * np.exp(-2j * np.pi * 10.0 * TIME[MIDDLE])) * 1j)
        if phase is None:  # second order: phase of 1 / (1 + sqrt(2) s + s²) on the warped axis
            s = 1j * np.tan(np.pi * 10.0 / RATE) / np.tan(np.pi * 20.0 / RATE)
            phase = np.angle(1 / (1 + np.sqrt(2) * s + s**2))
        assert measured == pytest.approx(phase, abs=1e-5)  # rad; transient over amplitude


def test_constant_passes_unchanged_from_the_first_sample():
    level = np.full(2000, 120.0)
    for zero_phase in (True, False):
        assert ButterworthFilter(20.0, 6, zero_phase).apply(level, RATE) == pytest.approx(level, abs=1e-9)  # rounding


def test_two_tones_fall_into_their_bands():
    x = 100.0 + sine(1.0, 30.0) + sine(10.0, 12.0) + sine(80.0, 50.0)
    like = ButterworthFilter()
    assert band(x, RATE, 0.0, 5.0, like)[MIDDLE].std() == pytest.approx(30.0 / np.sqrt(2), rel=3e-2)  # 10 Hz leaks 1/(1+.414*64)
    # 10 Hz is an octave from both edges and loses a factor 1 + (sqrt(2) - 1) / 64 in each; 1e-3: warping of the two octaves
    assert band(x, RATE, 5.0, 20.0, like)[MIDDLE].std() == pytest.approx(12.0 / np.sqrt(2) / (1 + 0.4142 / 64) ** 2, rel=1e-3)
    assert like.apply(x, RATE)[MIDDLE].std() == pytest.approx(np.hypot(30.0, 12.0) / np.sqrt(2), rel=1e-2)


@pytest.mark.parametrize("samples", [1000, 1001])
def test_spectrum_reads_the_amplitude(samples):
    rate = float(samples)  # one second: lines at whole Hz
    t = np.arange(samples) / rate
    frequency, amplitude = amplitude_spectrum(7.0 + 3.0 * np.sin(2 * np.pi * 5 * t) + 0.5 * np.cos(2 * np.pi * 40 * t), rate)
    assert (frequency[5], frequency[40]) == pytest.approx((5.0, 40.0))
    assert (amplitude[5], amplitude[40]) == pytest.approx((3.0, 0.5), abs=1e-9)  # rounding: whole periods, Hann line exact
    assert amplitude[0] == pytest.approx(0.0, abs=1e-9)


def test_ends_of_the_spectrum_are_scaled_once():
    """The window shows half of a line beside it, the constant one, too; at half of the rate there is one line for two."""
    k = np.arange(64)
    assert amplitude_spectrum(3.0 * np.cos(2.0 * np.pi * k / 64), RATE)[1][:4] == pytest.approx([1.5, 3.0, 1.5, 0.0], abs=1e-12)
    assert amplitude_spectrum(3.0 * (-1.0) ** k, RATE)[1][-1] == pytest.approx(3.0, rel=1e-12)


def test_fraction_below_of_a_known_duty():
    x = np.where(np.arange(1000) % 10 < 3, 0.0, 50.0)
    assert fraction_below(x) == pytest.approx(30.0, abs=1e-12)


def test_short_gaps_are_not_counted():
    x = np.full(1000, 50.0)
    x[:5], x[100:106], x[500:503], x[980:] = 0.0, 0.0, -1.0, 0.0
    assert gaps(x, RATE, 0.005) == pytest.approx([0.006, 0.020])  # 5 ms is not longer than 5 ms
    assert gaps(x, RATE) == pytest.approx([0.005, 0.006, 0.003, 0.020])
    assert gaps(np.full(10, 50.0), RATE, 0.005).size == 0


def test_window_is_half_open_and_must_lie_in_the_run():
    position = np.arange(0.0, 100.0, 0.5)
    cut = window(position, 10.0, 20.0)
    assert (position[cut][0], position[cut][-1]) == (10.0, 19.5)
    with pytest.raises(BadInput, match="within the run"):
        window(position, 90.0, 140.0)
    with pytest.raises(BadInput, match="after the start"):
        window(position, 20.0, 10.0)


def test_uneven_samples_are_interpolated_at_the_smallest_spacing():
    time = np.array([0.0, 0.1, 0.2, 0.25, 0.4])
    rate, even, (x,) = uniform(time, 3.0 * time)
    assert rate == pytest.approx(20.0)
    assert x == pytest.approx(3.0 * even)
    assert uniform(TIME, TIME)[1] is TIME
    with pytest.raises(BadInput, match="increase"):
        uniform(np.array([0.0, 1.0, 1.0]), np.zeros(3))


def test_contact_statistics_of_a_known_signal():
    speed = 50.0
    force = 120.0 + sine(1.0, 30.0) + sine(100.0, 500.0)
    uplift = 0.05 * np.exp(-((TIME - 8.0) ** 2))
    record = ContactRecord(TIME, speed * TIME, force, 0.02 * np.sin(2 * np.pi * TIME), (uplift, 0.5 * uplift))
    s = record.statistics((300.0, 700.0))
    assert s.mean == pytest.approx(120.0, abs=1e-3)  # whole periods
    assert s.std == pytest.approx(30.0 / np.sqrt(2), rel=1e-4)  # 100 Hz is damped to 500 / (1 + .414 * 5^6) = 0.08 N
    assert s.statistical_max - s.mean == pytest.approx(3.0 * s.std)
    assert s.mean - s.statistical_min == pytest.approx(3.0 * s.std)
    assert (s.max, s.min) == pytest.approx((150.0, 90.0), abs=0.2)
    assert s.std_0_5 == pytest.approx(s.std, rel=1e-3)
    assert s.std_5_20 < 0.01 * s.std
    assert s.loss_raw > 30.0  # the 100 Hz part is below zero for much of its period
    assert s.loss_filtered == 0.0
    assert s.arcs == ()  # no half-period of 100 Hz is longer than 5 ms
    assert s.height_range == pytest.approx(0.04, rel=1e-3)
    assert s.max_uplift == pytest.approx(0.05)
    assert s.samples == 8000
    assert "300 to 700 m" in s.settings
    assert "zero phase" in s.settings


def test_arcs_are_counted_with_their_durations():
    """Three losses of 3, 6 and 20 ms within the window of 8 s: two arcs, 0.325 % of the time; one outside does not count."""
    force = np.full(TIME.size, 100.0)
    for begin, lasts in ((7.0, 0.003), (8.0, 0.006), (9.0, 0.020), (1.0, 0.1)):
        force[(begin - 1e-9 <= TIME) & (begin + lasts - 1e-9 > TIME)] = 0.0
    s = ContactRecord(TIME, 50.0 * TIME, force, np.zeros(TIME.size)).statistics((300.0, 700.0))
    assert s.arcs == pytest.approx((0.006, 0.020))
    assert s.arcing == pytest.approx(100.0 * 0.026 / 8.0)
    assert s.loss_raw == pytest.approx(100.0 * 0.029 / 8.0)
