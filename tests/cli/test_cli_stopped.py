"""A run that is stopped from outside: exit code, and what it keeps. It goes on from its checkpoint: see `test_checkpoint`."""

import json
import os
import subprocess
import sys
from time import monotonic, sleep

import pytest
from cosimo.orchestrator.interrupts import STOPPING

PATIENCE = 120.0  # s until a busy machine must have begun the run
pytestmark = pytest.mark.skipif(os.name == "nt", reason="there a process is ended, not sent a signal")


@pytest.mark.parametrize("number", STOPPING)
def test_a_run_that_is_stopped_keeps_rows_and_outcome_and_goes_on(number, tmp_path):
    settings = ("--stop", "1e5", "--in-process", "-o", str(tmp_path))
    command = (sys.executable, "-m", "cosimo.orchestrator.cli", "run", "mass-on-spring", *settings, "--checkpoint-every", "1")
    process = subprocess.Popen(
        command, env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, stderr=subprocess.PIPE, text=True, stdout=subprocess.DEVNULL
    )
    end = monotonic() + PATIENCE
    while not (tmp_path / "checkpoint").exists() and process.poll() is None and monotonic() < end:
        sleep(0.05)
    process.send_signal(number)
    try:
        _, errors = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
    assert process.returncode == 128 + number, errors
    info = json.loads((tmp_path / "run.json").read_text())
    assert (info["outcome"], info["signal"]) == ("stopped", number.name)
    assert f"stopped by {number.name} at t = " in errors
    assert "Traceback" not in errors
    rows = (tmp_path / "result.csv").read_text().splitlines()[1:]
    reached = info["timing"]["simulated"]
    assert 1.0 <= reached < 1e5
    assert float(rows[-1].split(",")[0]) == reached
    assert info["checkpoints"]["last"] == reached
