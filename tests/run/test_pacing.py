"""Steps at the pace of the clock: with a clock of the test's own, and a real run."""

from itertools import pairwise

import numpy as np
import pytest
from cosimo.orchestrator.harness.summary import pacing_rows
from cosimo.orchestrator.run import pacing
from cosimo.orchestrator.run.pacing import Pacing
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene


class Clock:
    """Time that passes only when it is told to."""

    def __init__(self, monkeypatch):
        self.now, self.waits = 100.0, []
        monkeypatch.setattr(pacing, "perf_counter", lambda: self.now)
        monkeypatch.setattr(pacing, "sleep", self.sleep)

    def sleep(self, seconds: float) -> None:
        """Wake 0.01 ms too late, as systems do."""
        self.waits.append(seconds)
        self.now += seconds + 1e-5


def test_early_steps_wait_and_late_ones_catch_up(monkeypatch):
    clock, paced = Clock(monkeypatch), Pacing()
    durations = [0.5, 3e-3, 2e-4, 4e-4, 2.5e-3, 2e-4, 2e-4, 2e-4]  # s: the first two are the start and the step that loads
    for i, duration in enumerate(durations):
        clock.now += duration
        paced(i, i * 1e-3)
    report = paced.report()
    assert report.steps == 6
    assert report.duration["100 %"] == pytest.approx(2.5e-3)
    # due at 1, 2, 3 ... ms behind the first step: the long one ends 1.51 ms late, those behind it 0.71 late, then early
    assert report.late == 2
    assert report.lateness["100 %"] == pytest.approx(1.51e-3)
    assert sum(report.lateness_counts) == 2
    assert sum(report.duration_counts) == 6
    assert clock.waits == pytest.approx([8e-4, 5.9e-4, 9e-5, 7.9e-4], abs=1e-9)
    assert report.waking["100 %"] == pytest.approx(1e-5)


def test_a_run_of_no_step_has_no_report():
    paced = Pacing()
    paced(0, 0.0)
    assert paced.report() is None


def test_a_paced_run_is_never_ahead_of_the_clock_and_bit_identical():
    scene = load_scene("lumped-catenary").with_changes({"stop_time": 0.05})
    free, paced = run(scene, in_process=True), run(scene, in_process=True, real_time=True)
    for name, values in free.columns.items():
        assert np.array_equal(values, paced[name]), name
    assert paced.info.timing.run >= 0.048  # all steps but the first
    assert paced.info.real_time.steps == 49
    assert free.info.real_time is None
    names = [row.name for row in pacing_rows(paced.info.real_time)]
    assert names[:2] == ["real_time.steps", "real_time.late"]
    assert not pacing_rows(free.info.real_time)
    medians = [paced.info.real_time.duration[p] for p in ("50 %", "90 %", "99 %", "100 %")]
    assert all(a <= b for a, b in pairwise(medians))
