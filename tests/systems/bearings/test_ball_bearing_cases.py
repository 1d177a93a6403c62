"""The cases of the ball bearing: their rows hold, and would not if the model or the method were another."""

import numpy as np
import pytest
from cosimo.components.bearings.ball_bearing import BallBearing
from cosimo.orchestrator.harness.validation.case import Options, compare, outcome
from cosimo.orchestrator.harness.validation.reference import load_table
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems.bearings.cases import defect_frequencies, lyapunov_sum, varying_compliance

pytestmark = pytest.mark.full

IN_PROCESS = Options(in_process=True)


def test_lines_are_measured_not_assumed(monkeypatch):
    """Balls that slip by 1 % pass a pit 1 % more seldom, and the case finds the line there."""

    def slipping(bearing, t, initialize=BallBearing._initialize):
        status = initialize(bearing, t)
        bearing.arguments[0].constants.cage_ratio *= 0.99
        return status

    monkeypatch.setattr(BallBearing, "_initialize", slipping)
    seen = defect_frequencies.spectrum(run(defect_frequencies._scene("6205", "outer"), in_process=True))
    assert seen.line(3.55 * 29.95) / 29.95 == pytest.approx(0.99 * 3.5848, rel=1e-4)


def test_a_sound_bearing_has_the_line_of_the_outer_race_but_not_its_height():
    """The passing balls alone make it, so that its place says nothing of a pit: the row on its height does."""
    sound = defect_frequencies.spectrum(run(defect_frequencies._scene("6205", ""), in_process=True))
    assert sound.line(3.5848 * 29.95) / 29.95 == pytest.approx(3.5848, rel=1e-4)
    spectra = {("6205", "outer"): sound, ("6205", ""): sound}
    rows = [r for r in load_table("defect-frequencies").rows if r.measure == "6205.outer.contrast"]
    measured = {"6205.outer.contrast": defect_frequencies._contrast(spectra, "6205", "outer")}
    assert outcome(compare(tuple(rows), measured)) == "failed"


def test_clearance_brings_lines_that_a_periodic_motion_has_not():
    assert varying_compliance.off_lines(2e-6, 1000.0) < 0.01  # %
    assert varying_compliance.off_lines(30e-6, 1000.0) > 50.0


def test_another_damping_has_another_sum():
    """The sum follows c, so that the row's -2c/m is no constant of the method."""
    spectrum = lyapunov_sum.exponents(0.0, 400.0)
    assert spectrum.sum == pytest.approx(-40.0, rel=1e-4)
    assert np.all(np.diff(spectrum.exponents) <= 0.0)
