"""Fits to spectra against closed forms that share no estimator with the code."""

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.analysis.signals import welch_spectrum
from cosimo.orchestrator.harness.many.fitting import fit
from cosimo.orchestrator.systems import read_scene

SCENE = {
    "stop_time": 2.0,
    "units": {"m": {"component": "cosimo.tests.support:Mass", "parameters": {"v0": 2.0}}},
    "master": {"step": 1e-2},
}
VARY = {"m.k": {"low": 300.0, "high": 500.0, "start": 380.0}, "m.c": {"low": 0.2, "high": 3.0, "start": 0.5}}


def decay_spectrum(k, c, v0=2.0, samples=201, step=1e-2):
    """(frequency, power spectral density) of x = v0/ω exp(-c t/2) sin ωt for 1 kg, ω² = k - c²/4, at n step: a geometric series.

    X(f) = sum over n of x_n exp(-2 π i f n step);  S = 2 step |X|² / N, one-sided, at multiples of 1 / (N step).
    """
    omega = np.sqrt(k - 0.25 * c * c)
    f = np.arange(1, samples // 2 + 1) / (samples * step)
    ratios = [np.exp((-0.5 * c + way * 1j * omega - 2j * np.pi * f) * step) for way in (1.0, -1.0)]
    first, second = ((1.0 - q**samples) / (1.0 - q) for q in ratios)
    return f, 2.0 * step / samples * np.abs(v0 / omega * (first - second) / 2j) ** 2


def measured(folder, k=400.0, c=1.0, noise=0.0, kind="power spectral density"):
    """A file of that spectrum, with relative noise, and its table in a plan."""
    f, s = decay_spectrum(k, c)
    values = s if kind == "power spectral density" else np.sqrt(2.0 * s / (201 * 1e-2))  # of one segment: A = sqrt(2 S df)
    values = values * np.exp(noise * np.random.default_rng(5).standard_normal(f.size))
    (folder / "s.csv").write_text("f,S\n" + "".join(f"{a!r},{b!r}\n" for a, b in zip(f.tolist(), values.tolist(), strict=True)))
    return {"signal": "m.x_out", "file": "s.csv", "frequency": "f", "column": "S", "window": "boxcar", "kind": kind}


@pytest.mark.first(1)
@pytest.mark.parametrize("kind", ["power spectral density", "amplitude spectrum"])
@pytest.mark.parametrize("logarithmic", [True, False])
def test_a_fit_finds_stiffness_and_damping_from_a_spectrum(tmp_path, kind, logarithmic):
    answer = fit(
        read_scene(SCENE),
        {"vary": VARY, "spectra": [measured(tmp_path, kind=kind) | {"logarithmic": logarithmic}]},
        folder=tmp_path,
    )
    np.testing.assert_allclose(answer.fit.values, [400.0, 1.0], rtol=1e-5)
    assert answer.charts[0].panels[0].logarithmic == logarithmic
    assert "Welch, the whole record, window boxcar" in answer.charts[0].text


def test_its_deviations_are_those_of_the_closed_form(tmp_path):
    """Covariance σ² (JᵀJ)⁻¹ with the derivatives of ln S by differences of the closed form."""
    settings = measured(tmp_path, noise=0.1) | {"noise": 0.1, "low": 1.0, "high": 20.0}
    answer = fit(read_scene(SCENE), {"vary": VARY, "spectra": [settings]}, folder=tmp_path)
    f = decay_spectrum(400.0, 1.0)[0]
    kept = (f >= 1.0) & (f <= 20.0)
    logs = [
        [np.log(decay_spectrum(400.0 + way * dk, 1.0 + way * dc)[1][kept]) for way in (1.0, -1.0)]
        for dk, dc in ((0.01, 0.0), (0.0, 1e-4))
    ]
    jacobian = np.stack([(up - down) / (2.0 * h) for (up, down), h in zip(logs, (0.01, 1e-4), strict=True)], axis=1)
    exact = 0.1 * np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))
    np.testing.assert_allclose(answer.fit.deviations, exact, rtol=0.05)
    assert (np.abs(answer.fit.values - [400.0, 1.0]) < 4.0 * exact).all()


def test_a_spectrum_does_not_tell_stiffness_from_mass(tmp_path):
    """The relative shape depends on their ratio; with the damping fixed, and the height free by the speed at the start."""
    vary = {"m.k": VARY["m.k"], "m.m": {"low": 0.8, "high": 1.3}, "m.v0": {"low": 1.0, "high": 3.0}}
    answer = fit(read_scene(SCENE), {"vary": vary, "spectra": [measured(tmp_path, c=0.0)]}, folder=tmp_path)
    assert any("told apart" in text or "do not identify" in text for text in answer.fit.messages)


def test_estimates_of_a_sine_and_of_noise():
    """A sine on a line reads its amplitude; densities add up to the variance (Parseval)."""
    t = np.arange(4000) / 1000.0
    f, a = welch_spectrum(1.0 + 3.0 * np.sin(2.0 * np.pi * 50.0 * t), 1000.0, 1000, 0.5, "hann", "amplitude spectrum")
    assert a[f == 50.0] == pytest.approx(3.0, rel=1e-12)
    x = np.random.default_rng(1).standard_normal(4000)
    f, s = welch_spectrum(x, 1000.0, 4000, 0.0, "boxcar", "power spectral density")
    assert s.sum() * f[1] == pytest.approx(x.var(), rel=1e-3)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"segment": 5.0}, "segments of 500 samples"),
        ({"low": 49.0}, "frequencies above 0"),
        ({"column": "P"}, "column 'P'"),
        ({"segment": 0.5}, "first line of segments"),
        ({"window": "han"}, "'hann'"),
        ({"file": "none.csv"}, "can be read"),
    ],
)
def test_bad_spectra_are_one_message(tmp_path, change, named):
    with pytest.raises(BadInput, match=named):
        fit(read_scene(SCENE), {"vary": VARY, "spectra": [measured(tmp_path) | change]}, folder=tmp_path)
