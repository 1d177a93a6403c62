"""The friction drive at a macro step of 1 ms against real time: motors, wheels with sleeve, controller, in process and as FMUs.

Run with `pytest -n 0 tests/benchmarks --write-page`.
Friction of shafts, contacts and seal is exact. Recording is every 10 ms and there is no
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
def test_the_drive_runs_ten_times_faster_than_real_time(options, told):
    scene = load_scene("friction-drive-step").with_changes({"record.interval": 0.01, "master.bonds": (), "stop_time": END})
    run(scene.with_changes({"stop_time": 0.2}), **options)
    wall, used = [], []
    for _ in range(REPEATS):
        begin = time.process_time()
        result = run(scene, **options)
        used.append(time.process_time() - begin)
        assert result.outcome == "done", result.message
        wall.append(result.info.timing.run)
    told("systems", f"friction drive, 20 s, 1 ms, {'in process' if options else 'as FMUs'}",
         s=min(used), **{"× real time": END / min(wall)})  # fmt: skip
    assert END / min(wall) >= LEAST
