"""Spectra and followed orders of signals put together from known lines."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.analysis.signals import amplitude_spectrum
from cosimo.orchestrator.harness.analysis.spectra import (
    Family,
    envelope,
    envelope_spectrum,
    follow,
    peak,
    resonance_band,
    turns_steadily,
    waterfall,
)

RATE = 5000.0
TIME = np.arange(20_000) / RATE  # 4 s, bins of 0.25 Hz


@pytest.mark.parametrize("offset", [0.0, 0.1, 0.25, 0.4, 0.5])
def test_peak_of_a_sine_between_bins_is_found_with_its_height(offset):
    f = 100.0 + offset * 0.25
    at, height = peak(*amplitude_spectrum(3.0 + 2.5 * np.sin(2 * np.pi * f * TIME + 0.3), RATE), 100.0, 1.0)
    # The formula is exact for a lone line; the mirror at -f, 800 bins away, leaks 800^-3 of the height and moves it as much.
    assert at == pytest.approx(f, abs=1e-6)
    assert height == pytest.approx(2.5, rel=1e-6)


def test_peak_is_looked_for_only_where_told():
    spectrum = amplitude_spectrum(np.sin(2 * np.pi * 50 * TIME) + 0.1 * np.sin(2 * np.pi * 60 * TIME), RATE)
    assert peak(*spectrum, 60.0, 2.0)[1] == pytest.approx(0.1, rel=1e-6)  # Hann leaks nothing at whole bins
    with pytest.raises(BadInput, match=r"0\.25 Hz"):
        peak(*spectrum, 60.1, 0.01)


def test_envelope_of_a_modulated_carrier_is_its_modulation():
    modulation = 1.0 + 0.5 * np.cos(2 * np.pi * 30 * TIME)
    x = modulation * np.cos(2 * np.pi * 1000 * TIME) + 4.0 * np.sin(2 * np.pi * 20 * TIME)
    middle = slice(2000, -2000)
    # At 1000 Hz the filters lose 0.414 (0.528^6 + 0.447^6) = 1.2 % (warped frequency ratios); 20 Hz falls to (20 / 500)^6.
    assert envelope(x, RATE, 500.0, 1500.0)[middle] == pytest.approx(modulation[middle], rel=0.015)
    at, height = peak(*envelope_spectrum(x, RATE, 500.0, 1500.0), 30.0, 5.0)
    assert at == pytest.approx(30.0, abs=1e-3)  # ends of the envelope are not whole periods of a sine
    assert height == pytest.approx(0.5, rel=0.015)
    with pytest.raises(BadInput, match="rising"):
        envelope(x, RATE, 500.0, 2600.0)


def test_impacts_on_a_resonance_show_in_the_envelope_and_not_below():
    """A hit every 1 / 37 s rings at 1200 Hz: no line at 37 Hz in the spectrum worth the name, the first one in the envelope."""
    x = np.zeros_like(TIME)
    for start in np.arange(0.0, 4.0, 1 / 37.0):
        ringing = start <= TIME
        x[ringing] += np.exp(-400 * (TIME[ringing] - start)) * np.sin(2 * np.pi * 1200 * (TIME[ringing] - start))
    f, a = envelope_spectrum(x, RATE, 800.0, 1600.0)
    assert f[np.argmax(a)] == pytest.approx(37.0, abs=0.25)  # a bin
    plain = peak(*amplitude_spectrum(x, RATE), 37.0, 1.0)[1]
    assert a.max() > 10 * plain
    noisy = x + np.random.default_rng(2).normal(0.0, 0.3, x.size) + 5.0 * np.sin(2 * np.pi * 20 * TIME)
    low, high = resonance_band(noisy, RATE, 150.0, 2250.0)
    assert low < 1200.0 < high < 2250.0


def test_families_name_harmonics_and_sidebands():
    lines = Family("inner race", 100.0, 2, spacing=30.0, sidebands=1).lines(1000.0)
    assert [(line.frequency, line.order, line.side) for line in lines] == [
        (70.0, 1, -1), (100.0, 1, 0), (130.0, 1, 1), (170.0, 2, -1), (200.0, 2, 0), (230.0, 2, 1),
    ]  # fmt: skip
    assert [line.text for line in lines[:2]] == ["1× − 1 side", ""]
    assert len(Family("shaft", 100.0, 20).lines(450.0)) == 4
    assert Family("low", 10.0, 1, spacing=15.0, sidebands=1).lines(100.0)[0].frequency == 10.0  # nothing below zero


def test_order_of_a_steady_turning_is_found_with_amplitude_and_lag():
    angle = 2 * np.pi * 13.7 * TIME
    x = 4.0 + 2.0 * np.cos(angle - 0.6) + 0.7 * np.cos(2 * angle + 1.0)
    one, two = follow(TIME, angle % (2 * np.pi), x), follow(TIME, angle % (2 * np.pi), x, 2.0)
    linear = (2 * np.pi / 365) ** 2 / 8 * 5  # linear interpolation of 365 samples a turn, both orders with their curvature
    assert one.amplitude == pytest.approx(2.0, abs=linear)
    assert one.lag == pytest.approx(0.6, abs=linear)
    assert two.component == pytest.approx(0.7 * np.exp(1.0j), abs=2 * linear)
    assert one.speed == pytest.approx(2 * np.pi * 13.7, rel=1e-9)  # rounding of the interpolation


def test_run_up_through_a_resonance_is_followed_by_angle():
    """Slow enough to be quasi-steady: the response at each speed is that of the oscillator at that speed."""
    t = np.arange(0.0, 40.0, 1e-3)
    speed = 20.0 + 4.0 * t
    angle = 20.0 * t + 2.0 * t**2
    r = speed / 100.0
    response = r**2 / (1 - r**2 + 2j * 0.1 * r)
    x = (response * np.exp(1j * angle)).real
    track = follow(t, angle, x, turns=2)
    exact = np.interp(track.speed, speed, np.abs(response))
    assert track.speed[[0, -1]] == pytest.approx([np.sqrt(400 + 8 * 2 * np.pi), 180], abs=0.3)  # a turn from either end
    # Over 2 turns, 0.13 s, the speed changes by 0.5 rad/s: the half width of the resonance is 10 rad/s. 2 %: its curvature there.
    assert track.amplitude == pytest.approx(exact, rel=0.02)
    assert np.interp(100.0, track.speed, track.lag) == pytest.approx(np.pi / 2, abs=0.03)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_forward_and_backward_whirl_are_told_apart(sense):
    """Forward is with the rotation; a lag in time is one whichever way the rotor turns."""
    angle = sense * 2 * np.pi * 11.0 * TIME
    z = 3.0 * np.exp(1j * (angle - sense * 0.4)) + 1.0 * np.exp(-1j * angle)
    forward = follow(TIME, angle, z)
    assert forward.amplitude == pytest.approx(3.0, abs=1e-3)  # linear interpolation, 450 samples a turn
    assert forward.lag == pytest.approx(0.4, abs=1e-3)
    assert follow(TIME, angle, z, -1.0).amplitude == pytest.approx(1.0, abs=1e-3)
    assert follow(TIME, angle, z.real - 1.0 * np.cos(angle)).lag == pytest.approx(0.4, abs=1e-3)


def test_steady_turning_is_told_from_standing_and_turning_back():
    assert turns_steadily((5.0 * TIME) % (2 * np.pi))
    assert turns_steadily((-5.0 * TIME) % (2 * np.pi))
    assert not turns_steadily(np.zeros_like(TIME))
    assert not turns_steadily(np.sin(TIME) + 0.5)
    assert not turns_steadily((2.0 * np.arange(100)) % (2 * np.pi))  # 3 samples a turn


def test_waterfall_shows_a_rising_frequency():
    t = np.arange(0.0, 10.0, 1 / 1000.0)
    at, f, a = waterfall(np.sin(2 * np.pi * (20 * t + 4 * t**2)), 1000.0, 0.5, 12)
    assert f[np.argmax(a, axis=1)] == pytest.approx(20 + 8 * at, abs=2.0)  # a bin, 2 Hz
    assert at[[0, -1]] == pytest.approx([0.25, 9.75], abs=1e-3)
