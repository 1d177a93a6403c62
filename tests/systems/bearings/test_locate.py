"""A defect located in a record: impacts that slip in noise, a simulated pit, and records that have none."""

from __future__ import annotations

import cosimo
import numpy as np
import pytest
from cosimo.components.bearings.ball_bearing import BallBearing
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.systems.bearings.locate import LEVEL, locate, main
from scipy.stats import binom

RATE, ROTATION = 20_000.0, 30.0  # samples and turns a second
FREQUENCIES = BallBearing((), {}, preset="JIS 6306", name="bearing").geometry.defect_frequencies(ROTATION)
TIME = np.arange(int(2.0 * RATE)) / RATE


def record(frequency, seed, size=1.0, slip=0.99):
    """Impacts on a resonance of 2.4 kHz, each at its time with 1 % of jitter; frequency 0: noise and the shaft alone."""
    rng, x = np.random.default_rng(seed), np.zeros(TIME.size)
    if frequency:
        at = np.cumsum(1.0 + 0.01 * rng.standard_normal(int(2.2 * frequency))) / (slip * frequency)
        np.add.at(x, (at[at < TIME[-1]] * RATE).astype(int), size)
    ringing = np.exp(-600.0 * TIME[:400]) * np.sin(2.0 * np.pi * 2400.0 * TIME[:400])
    shaft = (1.0 + 0.5 * np.cos(2.0 * np.pi * ROTATION * TIME)) * np.sin(2.0 * np.pi * 2000.0 * TIME)
    return np.convolve(x, ringing)[: TIME.size] + 0.3 * rng.standard_normal(TIME.size) + 0.1 * shaft


@pytest.mark.parametrize(("place", "multiple"), [("outer", 1.0), ("inner", 1.0), ("ball", 2.0)])
def test_impacts_are_located_though_they_slip(place, multiple):
    for seed in range(5):
        first = locate(TIME, record(multiple * FREQUENCIES[place], seed), FREQUENCIES, ROTATION)[0]
        assert first.place == place
        assert first.p < 1e-4
        assert first.frequency == pytest.approx(0.99 * multiple * FREQUENCIES[place], rel=5e-3)


def test_noise_and_an_unbalanced_shaft_have_no_defect():
    """As often as the level says, within 99.9 % of its binomial distribution."""
    named = [locate(TIME, record(0.0, seed), FREQUENCIES, ROTATION)[0].p < LEVEL for seed in range(100)]
    assert sum(named) <= binom.ppf(0.999, 100, LEVEL)


def test_the_pit_of_a_simulated_outer_race_is_found_from_a_file(tmp_path, capsys):
    run = cosimo.run("outer-ring-defect", verify="no")
    kept = run.time > 0.5
    rng, x = np.random.default_rng(0), run["bearing.acceleration_x"][kept]
    noisy = x + 0.2 * x.std() * rng.standard_normal(x.size)
    np.savetxt(
        tmp_path / "record.csv",
        np.column_stack([run.time[kept], noisy]),
        delimiter=",",
        header="time [s],acceleration [m/s2]",
        comments="",
    )
    main([str(tmp_path / "record.csv"), "--bearing", "JIS 6306", "--speed", "1800 rpm"])
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == "A defect: outer race (BPFO)."
    assert "expected    92.54 Hz" in lines[1]
    assert all(
        float(line.rpartition(" ")[2]) > LEVEL for line in lines[2:]
    )  # also of the ball, a multiple of which is the outer race's


def test_what_cannot_be_judged_is_refused(tmp_path, capsys):
    for time, said in ((TIME[:2000], "turns of the shaft"), (TIME * 20.0, "samples a second")):
        with pytest.raises(BadInput, match=said):
            locate(time, record(0.0, 1)[: time.size], FREQUENCIES, ROTATION)
    (tmp_path / "record.csv").write_text("time,acceleration\n0,1\n1,2\n")
    for speed, said in (("1800", "rpm"), ("1800 kg", "--speed")):
        with pytest.raises(SystemExit) as ended:
            main([str(tmp_path / "record.csv"), "--bearing", "JIS 6306", "--speed", speed])
        assert ended.value.code == 2
        assert said in capsys.readouterr().err
