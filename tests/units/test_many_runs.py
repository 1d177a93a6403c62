"""Thousands of runs in one process: memory, files, threads and folders do not grow; FMUs are extracted once."""

import gc
import itertools
import os
import shutil
import subprocess
import sys
import tempfile
from collections import OrderedDict
from pathlib import Path

import pytest
from cosimo.fmus.build import built
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units.folders import process_folder
from cosimo.tests.rest import at_rest
from cosimo.tests.units.exchange_fmu import exchange_fmu
from cosimo.tests.units.native import native_fmu

ROOT = Path(__file__).resolve().parents[3]
pytestmark = pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="asks /proc for memory and files")


def held() -> tuple[int, int, int, int]:
    """Open files, threads, temporary folders and entries of the import path."""
    gc.collect()
    folders = [*os.listdir(process_folder()), *os.listdir(tempfile.gettempdir())]  # in this order: the first may be made now
    return len(os.listdir("/proc/self/fd")), len(os.listdir("/proc/self/task")), len(folders), len(sys.path)


def memory() -> int:
    """Resident bytes."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def growth(scene, runs: int, warm: int, **how) -> float:
    """Bytes that each run leaves behind, and that nothing else stays.

    Memory comes from the system in large pieces, now and then; what a run forgets shows in every quarter of the runs.
    """
    for _ in range(warm):
        assert run(scene, **how).outcome == "done"
    before, resident = at_rest(held), [memory()]
    for _ in range(4):
        for _ in range(runs // 4):
            run(scene, **how)
        resident.append(memory())
    assert at_rest(held, before) == before
    return min(b - a for a, b in itertools.pairwise(resident)) / (runs // 4)


@pytest.fixture(autouse=True)
def counted_here(tmp_path, monkeypatch):
    """Temporary files of other processes do not count, and garbage is not sought in what earlier tests left: a second each time."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    gc.collect()
    gc.freeze()


@pytest.mark.full
@pytest.mark.parametrize("kind", ["FMI 2", "FMI 3", "model exchange"])
def test_hundreds_of_runs_of_a_native_fmu(kind):
    """A forgotten instance, state or integrator would be 200 bytes at least."""
    path = exchange_fmu() if kind == "model exchange" else native_fmu("bouncing_ball", int(kind[-1]))
    scene = read_scene({"stop_time": 0.2, "units": {"f": {"fmu": path}}, "master": {"step": 0.1}})
    assert growth(scene, 400, 100) < 200.0


@pytest.mark.full
def test_runs_of_an_fmu_made_with_pythonfmu():
    """pythonfmu itself loses some kilobytes an instance; a library that stayed loaded for each run would be 300."""
    scene = read_scene({"stop_time": 0.002, "units": {"p": {"fmu": str(built("Pantograph"))}}, "master": {"step": 1e-3}})
    assert growth(scene, 100, 20) < 8_000.0


@pytest.mark.full
@pytest.mark.parametrize(("parameters", "outcome"), [({"k": 0.0, "u": 1.0, "limit": 0.15}, "failed"), ({"end": 0.1}, "done")])
def test_runs_that_fail_or_end_early_leave_nothing_either(parameters, outcome):
    scene = read_scene(
        {"stop_time": 0.3, "units": {"f": {"fmu": exchange_fmu(), "parameters": parameters}}, "master": {"step": 0.1}}
    )
    run(scene)
    before = at_rest(held)
    for _ in range(20):
        assert run(scene).outcome == outcome
    assert at_rest(held, before) == before


def test_units_of_one_fmu_that_run_at_the_same_time_have_folders_of_their_own(tmp_path, monkeypatch):
    # Else, where there are too many, folders of other tests would go.
    monkeypatch.setattr("cosimo.orchestrator.units.folders._free", OrderedDict())
    copy = tmp_path / "copy.fmu"
    shutil.copy(exchange_fmu(), copy)
    unit = {"fmu": str(copy)}
    scene = read_scene({"stop_time": 0.1, "units": {"a": unit, "b": unit}, "master": {"step": 0.1}})
    before = held()[2]
    for _ in range(3):
        assert run(scene).outcome == "done"
        assert held()[2] == before + 2
    os.utime(copy, (0, 0))  # another file, as far as anyone can tell
    assert run(scene).outcome == "done"
    assert held()[2] == before + 4


def test_the_folders_are_gone_with_the_process(tmp_path):
    data = {"stop_time": 0.1, "units": {"f": {"fmu": exchange_fmu()}}, "master": {"step": 0.1}}
    code = (
        "from cosimo.orchestrator.run.run import run; from cosimo.orchestrator.scene.scene import read_scene\n"
        "import tempfile, os\n"
        f"scene = read_scene({data!r})\n"
        "print(run(scene).outcome, len(os.listdir(tempfile.gettempdir())))"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        cwd=ROOT,
        timeout=600,
        env={**os.environ, "TMPDIR": str(tmp_path)},
    )
    assert done.stdout == "done 1\n", done.stderr
    assert list(tmp_path.iterdir()) == []
