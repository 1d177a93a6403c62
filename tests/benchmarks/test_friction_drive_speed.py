"""The drive as FMUs, two motors, wheels with sleeve and controller at 1 ms, against real time."""

from __future__ import annotations

import time

import pytest

from orchestrator.run import run
from orchestrator.scene import load_scene

pytestmark = pytest.mark.benchmark

LEAST = 10.0  # times faster than real time
REPEATS = 5


@pytest.mark.parametrize("in_process", [False, True])
def test_the_drive_runs_ten_times_faster_than_real_time(in_process):
    """The step in both axes with exact friction everywhere; the time of the whole call, less that of a run of one step."""
    scene = load_scene("friction-drive-step")
    short = scene.with_changes({"stop_time": scene.master.step})
    run(short, in_process=in_process)

    def seconds(one) -> float:
        begin = time.perf_counter()
        result = run(one, in_process=in_process)
        assert result.outcome == "done", result.message
        return time.perf_counter() - begin

    start = min(seconds(short) for _ in range(REPEATS))
    whole = min(seconds(scene) for _ in range(REPEATS))
    ratio = scene.stop_time / (whole - start)
    print(f"  {'in process' if in_process else 'as FMUs'}: {scene.stop_time:g} s in {whole - start:.3f} s, "
          f"{ratio:.0f} times real time; start {start:.2f} s")  # fmt: skip
    assert ratio >= LEAST
