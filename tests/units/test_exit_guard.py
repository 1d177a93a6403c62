"""A unit that ends the process of its run: code 3, a message, and what was computed until then."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.scene.scene import read_scene
from cosimo.orchestrator.units.exit_guard import ExitGuard
from cosimo.tests.units.native import native_fmu

ROOT = Path(__file__).parents[3]
SCENE = """stop_time = 1.0
[units.f]
fmu = {fmu!r}
parameters = {{ exit_at = {at} }}
[master]
step = 0.1
"""


def ended(tmp_path: Path, fmi: int, at: float) -> tuple[subprocess.CompletedProcess, Path]:
    (tmp_path / "scene.toml").write_text(SCENE.format(fmu=native_fmu("moody", fmi), at=at))
    done = subprocess.run(
        [sys.executable, "-m", "cosimo.orchestrator.cli", "run", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "out")],
        capture_output=True,
        text=True,
        cwd=ROOT,
        timeout=600,
    )
    return done, tmp_path / "out"


@pytest.mark.parametrize("fmi", [2, 3])
def test_exit_inside_a_unit_is_a_failed_run_with_its_result(fmi, tmp_path):
    done, out = ended(tmp_path, fmi, 0.55)
    assert done.returncode == 3, done.stderr
    assert "unit f has ended this process from inside" in done.stderr
    info = json.loads((out / "run.json").read_text())
    assert info["outcome"] == "failed"
    assert "has ended this process" in info["message"]
    table = np.genfromtxt(out / "result.csv", delimiter=",", names=True)
    assert 0.0 < table["time"][-1] <= 0.5 + 1e-9  # compiled steps hand over their rows in batches
    np.testing.assert_allclose(table["fnow"], table["time"], rtol=1e-15)
    if fmi == 3:
        assert len(table) == 6


def test_a_run_without_such_a_unit_ends_as_ever(tmp_path):
    done, _ = ended(tmp_path, 3, 1e9)
    assert done.returncode == 0, done.stderr


def test_a_guard_that_was_left_does_nothing():
    """The registration is taken out again: neither many guards nor the end of the process call anything."""
    code = (
        "from cosimo.orchestrator.units.exit_guard import ExitGuard\n"
        "for _ in range(100):\n    with ExitGuard(['u'], print): pass\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, timeout=600)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    with ExitGuard([]):
        pass


def test_a_component_that_calls_sys_exit_fails_the_run():
    scene = read_scene(
        {
            "stop_time": 1.0,
            "master": {"step": 0.1},
            "units": {"a": {"component": "cosimo.tests.units.troubled:Troubled", "parameters": {"trouble": "sys exit"}}},
        }
    )
    result = run(scene, in_process=True)
    assert (result.outcome, result.message) == ("failed", "a unit has called sys.exit(0)")
    assert result.time[-1] == pytest.approx(0.2)
