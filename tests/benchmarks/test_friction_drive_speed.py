"""The friction drive at a macro step of 1 ms against real time: motors, wheels with sleeve, controller, in process and as FMUs.

Run with `pytest -n 0 -s tests/benchmarks`. Friction of shafts, contacts and seal is exact. Recording is every 10 ms and there is no
energy account, as for a long run; the first, short runs compile.
"""

import time

import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene

LEAST = 10.0  # times faster than real time
END = 20.0  # s
REPEATS = 3


@pytest.mark.parametrize("options", [{"in_process": True}, {}], ids=["in process", "FMUs"])
def test_the_drive_runs_ten_times_faster_than_real_time(options):
    scene = load_scene("friction-drive-step").with_changes({"record.interval": 0.01, "master.bonds": (), "stop_time": END})
    run(scene.with_changes({"stop_time": 0.2}), **options)
    wall, used = [], []
    for _ in range(REPEATS):
        begin = time.process_time()
        result = run(scene, **options)
        used.append(time.process_time() - begin)
        assert result.outcome == "done", result.message
        wall.append(result.info.timing.run)
    print(f"\n{options or 'FMUs'}: {min(wall):.2f} s for {END:g} s, {END / min(wall):.0f} times real time; "
          f"CPU time with the start {min(used):.2f} s")  # fmt: skip
    assert END / min(wall) >= LEAST
