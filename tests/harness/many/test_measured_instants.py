"""Fits to curves sampled seldom, unevenly, in part: the run is evaluated where the measurement is, and samples are counted."""

from types import SimpleNamespace

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.harness.analysis.least_squares import fit as least_squares
from cosimo.orchestrator.harness.many.fitting import fit
from cosimo.orchestrator.harness.validation.curves import compare_curve
from cosimo.orchestrator.run.instants import at_instants
from cosimo.orchestrator.scene.measured import Measured
from cosimo.orchestrator.settings.case import CurveSettings
from cosimo.orchestrator.systems import read_scene

C, K, STOP = 2.5, 100.0, 3.0  # N.s/m, N/m of 1 kg; s
ROWS = np.linspace(0.0, STOP, 601)
CURVE = {"signal": "m.x_out", "file": "measured.csv", "time": "t", "column": "x"}
SCENE = {
    "stop_time": STOP,
    "units": {"m": {"component": "cosimo.tests.support:Mass", "parameters": {"k": K, "c": C, "v0": 1.0}}},
    "master": {"step": 5e-3},
}
DENSITIES = (301, 151, 76, 38)


def decay(t, c=C, v0=1.0):
    """x = v0/ω exp(-c t/2) sin ωt, ω² = K - c²/4: the closed form of 1 kg that starts with v0."""
    omega = np.sqrt(K - 0.25 * c * c)
    return v0 / omega * np.exp(-0.5 * c * t) * np.sin(omega * t)


class Run:
    """What a comparison reads of a run."""

    measures = {"m.x_out": "m"}

    def __init__(self, time, transient=0.0, **signals):
        self.time, self.signals = time, {f"m.{name}": values for name, values in signals.items()}
        self.scene = SimpleNamespace(
            analysis=SimpleNamespace(transient=transient), counts_from=transient, coupling=SimpleNamespace(interfaces={})
        )

    def __getitem__(self, name):
        return self.signals[name]


def comparison(t, x, run, **settings):
    return compare_curve(CurveSettings(**CURVE, source="s", **settings), Measured(t, x), run)


def fitted(t, x, **settings):
    """(damping, deviation) by the fit's own comparison and least squares, from rows of the closed form."""

    def residuals(p):
        one = comparison(t, x, Run(ROWS, x_out=decay(ROWS, p[0])), **settings)
        return one.simulated - one.measured

    answer = least_squares(residuals, {"c": 2.0}, {"c": (0.5, 8.0)})
    return answer.values[0], answer.deviations[0]


@pytest.mark.parametrize("samples", DENSITIES)
def test_a_fit_is_unbiased_and_its_deviation_is_right_at_any_density(samples):
    """200 seeds: (fit - truth)/deviation is of mean 0 and deviation 1, and each is what its own noise makes of it to first order."""
    t = np.linspace(0.0, STOP, samples)
    noise = np.random.default_rng(samples + 5).standard_normal((200, samples))
    found = np.array([fitted(t, decay(t) + 1e-3 * n) for n in noise])
    off = (found[:, 0] - C) / found[:, 1]
    assert abs(off.mean()) < 0.15
    assert off.std() == pytest.approx(1.0, abs=0.1)
    by_c = (decay(t, C + 1e-4) - decay(t, C - 1e-4)) / 2e-4
    assert abs((off - noise @ by_c / np.sqrt(by_c @ by_c)).mean()) < 0.02
    assert fitted(t, decay(t))[0] == pytest.approx(C, rel=1e-6)


@pytest.mark.parametrize(
    ("cut", "settings"),
    [
        (lambda t: t, {"shift": 0.0}),
        (lambda t: t[np.random.default_rng(1).random(t.size) < 0.4], {}),  # uneven
        (lambda t: t[(t < 0.7) | (t > 1.3)], {}),  # a gap
        (lambda t: t[t < 1.0], {}),  # covers a part of the run
        (lambda t: t, {"cutoff": 12.0}),
        (lambda t: t[(t < 0.7) | (t > 1.3)], {"cutoff": 12.0}),
        (lambda t: t + 0.0017, {}),  # between the rows, and one beyond the end
    ],
)
def test_without_noise_the_truth_comes_back(cut, settings):
    t = cut(np.linspace(0.0, STOP, 151))
    assert fitted(t, decay(t), **settings)[0] == pytest.approx(C, rel=2e-6)


def test_over_a_position_and_what_is_not_compared_is_counted():
    """A position that accelerates; samples outside, in the transient and without a number are counted apart."""
    x = np.linspace(-0.4, 6.0, 65)
    run = Run(ROWS, 0.5, x_out=decay(ROWS), position=ROWS + 0.2 * ROWS**2)
    at = 2.5 * (np.sqrt(1.0 + 0.8 * x.clip(0.0)) - 1.0)  # s + 0.2 s² = x
    measured = Measured(x, decay(at), empty=3)
    curve = CurveSettings(signal="m.x_out", file="measured.csv", over="m.position", source="s")
    one = compare_curve(curve, measured, run)
    np.testing.assert_allclose(one.simulated, one.measured, atol=1e-7)
    np.testing.assert_allclose(one.time, at[(x >= 0.0) & (x <= 4.8 + 1e-9) & (at >= 0.5)], atol=1e-9)
    assert list(one.left_out.values()) == [3, 16, 6]
    assert one.counted.startswith(f"{one.time.size} of 68 samples of measured.csv are compared: 3 without a number, 16 outside")


def test_a_filter_shows_no_run_at_frequencies_that_a_sparse_measurement_cannot_have():
    """60 Hz in the run, measured behind an anti-aliasing filter at 50 samples a second: it is not 10 Hz."""
    t = np.linspace(0.0, STOP, 3001)
    at = np.linspace(0.0, STOP, 151)
    one = comparison(at, decay(at), Run(t, x_out=decay(t) + 0.05 * np.sin(2.0 * np.pi * 60.0 * t)), cutoff=12.0)
    assert one.numbers["difference"][1] < 2e-4


def test_values_between_rows_are_of_fourth_order_and_stay_beside_a_jump_within_its_cell():
    at = np.random.default_rng(2).uniform(0.0, 3.0, 400)
    worst = []
    for rows in (61, 121, 241):
        t = np.linspace(0.0, 3.0, rows)
        worst.append(np.abs(at_instants(at, t, np.sin(4.0 * t)) - np.sin(4.0 * at)).max())
    assert np.all(np.log2(np.array(worst[:-1]) / worst[1:]) > 3.7)
    t = np.sort(np.append(np.random.default_rng(3).uniform(0.0, 3.0, 80), [0.0, 3.0, 1.5, 1.5 + 1e-9]))  # a step to an event
    jump = np.where(t > 1.5, 1.0, 0.0)
    assert np.array_equal(at_instants(at, t, jump), np.where(at > 1.5 + 1e-9, 1.0, 0.0))
    assert np.array_equal(at_instants(t, t, np.cos(t)), np.cos(t))
    kink = np.abs(t - 1.5)
    assert np.abs(at_instants(at, t, kink) - np.abs(at - 1.5)).max() < 1e-9
    broken = np.where(t > 2.0, np.nan, t)
    assert np.allclose(at_instants(at, t, broken)[at < t[t <= 2.0].max()], at[at < t[t <= 2.0].max()])


@pytest.mark.parametrize("samples", DENSITIES)
def test_the_command_gives_the_truth_back_at_any_density(samples, tmp_path):
    """From the file to fit.csv; an empty cell and samples behind the run's end are said, a coarse record is said."""
    t = np.linspace(0.0, STOP, samples)
    write(tmp_path, [*(f"{a:.9f},{b:.12g}" for a, b in zip(t, decay(t), strict=True)), f"{STOP + 0.1},0.0", f"{STOP + 0.2},"])
    settings = {"vary": {"m.c": {"low": 0.5, "high": 8.0, "start": 2.0}}, "curves": [CURVE]}
    answer = fit(read_scene(SCENE), settings, folder=tmp_path)
    assert answer.fit.values[0] == pytest.approx(C, rel=1e-5)
    assert answer.fit.residuals.size == samples
    assert any("1 without a number, 1 outside of the run" in text for text in answer.fit.messages)
    coarse = read_scene(SCENE | {"record": {"interval": 0.05}})
    noisy = settings | {"curves": [CURVE | {"noise": 1e-4}]}
    assert any("reduce record.interval" in text for text in fit(coarse, noisy, folder=tmp_path).fit.messages)
    assert not any("record.interval" in text for text in fit(read_scene(SCENE), noisy, folder=tmp_path).fit.messages)


def write(folder, lines):
    (folder / "measured.csv").write_text("t,x\n" + "\n".join(lines) + "\n", encoding="utf-8")


def test_faults_of_a_file_are_told_with_line_and_column(tmp_path, capsys):
    settings = {"vary": {"m.c": {"low": 0.5, "high": 8.0, "start": 2.0}}, "curves": [CURVE]}
    good = [f"{0.1 * k:.1f},0" for k in range(12)]
    for lines, named in (
        ([*good[:9], "", "0.85,0", "0.8,0"], r"measured.csv, line 13.*does not rise: 0.8 behind 0.85 of line 12"),
        ([*good, "1.1,0"], r"measured.csv, line 14.*1.1 behind 1.1"),
        ([*good, "1.2,x"], r"measured.csv, line 14, column 'x'"),
        ([*good, "nought,1"], r"measured.csv, line 14, column 't'"),
        ([*good, "1.2,inf"], r"not finite"),
        ([f"{k}," for k in range(12)], "0 lines of numbers"),
    ):
        write(tmp_path, lines)
        with pytest.raises(BadInput, match=named):
            fit(read_scene(SCENE), settings, folder=tmp_path)
