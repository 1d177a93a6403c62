"""An hour of station keeping: hull, six thrusters, controller and current at a macro step of 20 ms, in process and as FMUs.

Run with `pytest -n 0 -s tests/benchmarks`. Recording is once a second, as for an hour one would; the first, short run compiles.
"""

import time

import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene

HOUR = 3600.0


@pytest.fixture(scope="module")
def scene():
    return load_scene("rov-station-keeping").with_changes({"record.interval": 1.0})


def speed(scene, stop: float, **options) -> float:
    """Simulated over real time of the stepping alone."""
    run(scene.with_changes({"stop_time": 1.0}), **options)
    start = time.perf_counter()
    result = run(scene.with_changes({"stop_time": stop}), **options)
    whole = time.perf_counter() - start
    assert result.outcome == "done", result.message
    stepping = result.info.timing.run
    print(f"\n{options or 'FMUs'}: {stepping:.2f} s, {whole:.2f} s with the start; {stop / stepping:.0f} times real time")
    return stop / stepping


def test_an_hour_in_process(scene):
    assert speed(scene, HOUR, in_process=True) >= 100.0


def test_an_hour_as_fmus(scene):
    assert speed(scene, HOUR) >= 20.0
