"""An hour of station keeping: hull, six thrusters, controller and current at a macro step of 20 ms, in process and as FMUs.

Run with `pytest -n 0 tests/benchmarks --write-page`. Recording is once a second, as for an hour one would; the first, short run compiles.
"""

import time

import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import load_scene

HOUR = 3600.0


@pytest.fixture(scope="module")
def scene():
    return load_scene("rov-station-keeping").with_changes({"record.interval": 1.0})


def speed(told, scene, stop: float, **options) -> float:
    """Simulated over real time of the stepping alone."""
    run(scene.with_changes({"stop_time": 1.0}), **options)
    start = time.perf_counter()
    result = run(scene.with_changes({"stop_time": stop}), **options)
    whole = time.perf_counter() - start
    assert result.outcome == "done", result.message
    stepping = result.info.timing.run
    label = f"underwater vehicle, an hour of station keeping, {'in process' if options else 'as nine FMUs'}"
    told("systems", label, s=whole, **{"× real time": stop / stepping})
    return stop / stepping


def test_an_hour_in_process(scene, told):
    assert speed(told, scene, HOUR, in_process=True) >= 100.0


def test_an_hour_as_fmus(scene, told):
    assert speed(told, scene, HOUR) >= 20.0
