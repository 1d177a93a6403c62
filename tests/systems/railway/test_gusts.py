"""Gusts on the wires: the field's spectrum and coherence, the applied load, and the wires' answer against closed forms."""

from itertools import pairwise

import numpy as np
import pytest
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.gusts import von_karman
from cosimo.tests.support import initialized
from scipy.integrate import quad

LENGTH, TENSION, MASS, ALPHA = 60.0, 20e3, 1.35, 1.0
AIR = 0.5 * 1.225 * 15.0 * 0.0145 * 1.0  # N.s/m2, rho U d (C_L' + C_D) / 2 with the defaults
ALONE = {
    "spans": 1,
    "span_length": LENGTH,
    "droppers": 1,
    "dropper_position[1]": 30.0,
    "dropper_stiffness": 1.0,
    "damping.alpha": ALPHA,
    "damping.beta": 0.0,
    "gusts.messenger_diameter": 0.0,
    "first_watched_support": 0,
}
SMALL = {"spans": 1, "element": 6.0}


def blown(effects=(), position=23.0, **values) -> Catenary:
    """A catenary in the wind, at rest, without contact force; values by the gusts' names, others with their own."""
    return initialized(
        Catenary(("gusts", *effects), {(n if n in Catenary.variables else f"gusts.{n}"): v for n, v in values.items()}),
        {"contact_position": position, "contact_force": 0.0},
    )


def waves(g):
    """Amplitude, m/s, frequency, 1/s, wave number, 1/m, and phase of the vertical field, without what straight lines take off."""
    interval, distance, _ = g.grid
    carried = np.sinc(g.omega / 2.0 / np.pi * interval) ** 2 * np.sinc(g.wave[0] * distance / 2.0 / np.pi) ** 2
    return g.amplitude[0] * carried, g.omega, g.wave[0], g.phase[0]


def many_winds(seeds, **values):
    """The fields of some seeds, on one mesh."""
    catenary = blown(**SMALL, **values)
    for seed in range(seeds):
        catenary.set("gusts.seed", seed)
        catenary.initialize(0.0)
        yield waves(catenary.arguments[0].gusts)


def shapes(modes, wave):
    """Integral of sin(j pi x / L) exp(i k x) over the wire, (modes, n) m."""
    j = np.arange(1, modes + 1)[:, None] * np.pi / LENGTH
    return j * (1.0 - np.cos(j * LENGTH) * np.exp(1j * wave * LENGTH)) / (j**2 - wave**2)


def receptance(modes, omega):
    """Displacement of mode j over its generalised force at a frequency, (modes, n) m/N."""
    j = np.arange(1, modes + 1)[:, None] * np.pi / LENGTH
    return 2.0 / LENGTH / (TENSION * j**2 - MASS * omega**2 + 1j * omega * (ALPHA * MASS + AIR))


@pytest.mark.interpreted
@pytest.mark.parametrize(("lateral", "length"), [(False, 100.0), (True, 2.5)])
def test_spectra_hold_the_variance(lateral, length):
    def of_logarithm(z):
        return np.exp(z) * von_karman(np.exp(z), 1.3, length, 15.0, lateral)

    assert quad(of_logarithm, -25.0, 25.0, limit=500)[0] == pytest.approx(1.3**2, rel=1e-3)


@pytest.mark.interpreted
def test_spectra_are_those_of_isotropic_turbulence():
    """S_w = (S_u - n dS_u/dn) / 2 with L_w = L_u / 2."""
    n = np.geomspace(1e-3, 10.0, 50)
    u, above, below = (von_karman(f * n, 1.0, 100.0, 15.0, False) for f in (1.0, 1.0 + 1e-5, 1.0 - 1e-5))
    np.testing.assert_allclose(von_karman(n, 1.0, 50.0, 15.0, True), 0.5 * (u - (above - below) / 2e-5), rtol=1e-6)


@pytest.mark.interpreted
def test_energy_of_the_waves_is_that_of_the_spectrum_in_every_band():
    """Less the share of the waves shorter than the shortest, 1 - 2/pi atan(k_max U / (C n))."""
    amplitude, omega, wave, _ = next(many_winds(1, components=400))
    assert np.abs(wave).max() <= 2.0 * np.pi / 12.0

    def density(z):
        n = np.exp(z)
        return n * von_karman(n, 0.09 * 15.0, 2.5, 15.0, True) * 2.0 / np.pi * np.arctan(2.0 * np.pi / 12.0 * 15.0 / (10.0 * n))

    edges = np.geomspace(0.02, 5.0, 9)
    for low, high in pairwise(edges):
        inside = (omega / 2.0 / np.pi >= low) & (omega / 2.0 / np.pi < high)
        assert 0.5 * np.sum(amplitude[inside] ** 2) == pytest.approx(quad(density, np.log(low), np.log(high))[0], rel=0.02)


@pytest.mark.full
def test_coherence_fades_along_the_line():
    """Mean of cos(k x) over many waves of about one frequency: exp(-C n x / U), within three standard deviations."""
    cosines = {x: [] for x in (1.0, 3.0, 8.0)}
    for amplitude, _, wave, _ in many_winds(20, lowest=0.999, highest=1.001, shortest=0.5):
        for x, found in cosines.items():
            found.append(np.sum(amplitude**2 * np.cos(wave * x)) / np.sum(amplitude**2))
    for x, found in cosines.items():
        assert np.mean(found) == pytest.approx(np.exp(-10.0 * x / 15.0), abs=3.0 * np.std(found) / np.sqrt(20) + 0.015)


@pytest.mark.full
def test_answer_of_a_wire_over_many_winds_is_that_of_the_spectrum():
    """Variance of the first modes: |H|² S times the double integral of both shapes and the coherence exp(-C n |x - y| / U)."""
    x = (np.arange(150) + 0.5) * LENGTH / 150
    n = np.geomspace(0.02, 5.0, 100)
    H = np.abs(receptance(3, 2.0 * np.pi * n)) ** 2
    found = []
    for amplitude, omega, wave, _ in many_winds(40, shortest=2.0):
        answer = receptance(3, omega) * shapes(3, wave) * AIR * amplitude
        found.append(0.5 * np.sum(np.abs(answer) ** 2, axis=1))
    for mode in (1, 2, 3):
        shape = np.sin(mode * np.pi * x / LENGTH)
        double = np.array([shape @ np.exp(-10.0 * f / 15.0 * np.abs(x[:, None] - x)) @ shape for f in n]) * (x[1] - x[0]) ** 2
        spectrum = H[mode - 1] * AIR**2 * von_karman(n, 0.09 * 15.0, 2.5, 15.0, True) * double
        expected = np.sum(0.5 * (spectrum[1:] + spectrum[:-1]) * np.diff(n))
        mean, deviation = np.mean(found, axis=0)[mode - 1], np.std(found, axis=0)[mode - 1]
        assert mean == pytest.approx(expected, abs=3.0 * deviation / np.sqrt(len(found)) + 0.02 * expected)


@pytest.mark.known_answers(Catenary="gusts")
@pytest.mark.full
@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_a_single_wire_answers_as_its_modes_do(method):
    """Every wave's steady answer in closed form, over 8 s once the start has decayed by exp(-13)."""
    catenary = blown(("damping",), element=0.5, substep=2e-3, method=method, highest=3.0, **ALONE)
    amplitude, omega, wave, phase = waves(catenary.arguments[0].gusts)
    t = 2e-3 * np.arange(1, 16001)
    height = np.zeros(t.size)
    for i in range(t.size):
        catenary.step(2e-3 * i, 2e-3)
        height[i] = catenary["wire_height"]
    modes = np.sin(np.arange(1, 41) * np.pi * 23.0 / LENGTH)
    answer = AIR * amplitude * np.exp(1j * phase) * (modes @ (receptance(40, omega) * shapes(40, wave)))
    late = t > 24.0
    expected = np.real(np.exp(1j * np.outer(t[late], omega)) @ answer)
    assert np.std(height[late] - expected) < 0.01 * np.std(expected)


@pytest.mark.full
def test_applied_load_has_the_spectrum():
    """Of a run of 400 s: variance in each band, and the time series itself, that of the waves at the place."""
    catenary = blown(
        element=6.0,
        substep=1e-2,
        method="implicit",
        position=30.0,
        **{n: v for n, v in ALONE.items() if not n.startswith("damping")},
    )
    amplitude, omega, wave, phase = waves(catenary.arguments[0].gusts)
    t = 1e-2 * np.arange(1, 40001)
    load = np.zeros(t.size)
    for i in range(t.size):
        catenary.step(1e-2 * i, 1e-2)
        load[i] = catenary["gusts.load"]
    angle = np.outer(t[:4000], omega) + wave * 30.0 + phase
    assert np.std(load[:4000] - AIR * np.cos(angle) @ amplitude) < 0.05 * load.std()  # corners at samples and stations
    power = 2.0 * np.abs(np.fft.rfft(load * np.hanning(t.size))) ** 2 / np.sum(np.hanning(t.size) ** 2) / t.size
    n = np.fft.rfftfreq(t.size, 1e-2)

    def density(f):
        share = 2.0 / np.pi * np.arctan(2.0 * np.pi / 12.0 * 15.0 / (10.0 * f))
        return AIR**2 * von_karman(f, 0.09 * 15.0, 2.5, 15.0, True) * share

    for low, high in ((0.3, 1.0), (1.0, 2.0), (2.0, 4.0)):
        found = power[(n >= low) & (n < high)].sum()
        assert found == pytest.approx(quad(density, low, high)[0], rel=0.05)


@pytest.mark.interpreted
def test_a_constant_wind_lifts_the_wire_as_a_parabola():
    """One wire: f x (L - x) / 2T. On rigid droppers both wires carry it together. And so it stays."""
    lift = 0.5 * 1.225 * 0.0145 * 0.2 * 25.0**2
    wind = {"speed": 25.0, "lift_coefficient": 0.2, "intensity": 0.0, "vertical_intensity": 0.0}
    still = wind | {"lift_coefficient": 1e-12}
    alone = {n: v for n, v in ALONE.items() if not n.startswith("damping")}
    for line, tension, x in ((alone, TENSION, 30.0), ({"spans": 1, "dropper_stiffness": 1e9}, TENSION + 16e3, 23.5)):
        up, down = (blown(**values, **line, element=1.0, components=10, position=x) for values in (wind, still))
        expected = lift * x * (60.0 - x) / (2.0 * tension)
        assert up["wire_height"] - down["wire_height"] == pytest.approx(expected, rel=1.2e-3)
        assert not np.any(up.x[: up.mesh.mass.size])
    for i in range(20):
        up.step(1e-3 * i, 1e-3)
    assert np.abs(up.x[: up.mesh.mass.size]).max() < 1e-12
    assert up["gusts.load"] == 0.0


@pytest.mark.interpreted
def test_the_window_meets_the_same_wind():
    """Loads at a contact point that moves, and jumps ahead, do not depend on what of the line moves."""
    some = {"moving_window.behind": 15.0}
    whole, part = (
        blown(effects, spans=4, element=3.0, components=10, position=70.0, lift_coefficient=0.1, **values)
        for effects, values in (((), {}), (("moving_window",), some))
    )
    for i in range(40):
        x = 70.0 + 1.0 * i if i < 30 else 205.0
        for catenary in (whole, part):
            catenary.set("contact_position", x)
            catenary.step(1e-3 * i, 1e-3)
        assert part["gusts.load"] == pytest.approx(whole["gusts.load"], abs=1e-12)
        assert whole["gusts.load"] != 0.0


@pytest.mark.interpreted
def test_a_step_repeats_to_the_bit_and_seeds_tell_winds_apart():
    one, same, other = (blown(spans=1, element=5.0, components=10, seed=seed) for seed in (1, 1, 2))
    for i in range(40):  # two samples and more
        state = one.save()
        one.step(1e-3 * i, 1e-3)
        first = one.save()
        one.restore(state)
        one.step(1e-3 * i, 1e-3)
        assert one.save() == first
        same.step(1e-3 * i, 1e-3)
        other.step(1e-3 * i, 1e-3)
    assert same.save() == first
    assert abs(other["gusts.load"] - one["gusts.load"]) > 1e-3
