"""A signal at named moments of `cosimo run`: the exit code, the outcome and the rows that are kept. No moment depends on the clock."""

import json
import os
import signal
import subprocess
import sys

import pytest
from cosimo.orchestrator.interrupts import STOPPING

RAISING = """
import importlib, os, sys
module, name, call, number = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
owner = importlib.import_module(module)
*path, last = name.split(".")
for part in path:
    owner = getattr(owner, part)
real, calls = getattr(owner, last), 0
def sending(*args, **options):
    global calls
    calls += 1
    if calls == call:
        os.kill(os.getpid(), number)
    return real(*args, **options)
setattr(owner, last, sending)
from cosimo.orchestrator.cli import main
main(sys.argv[5:])
"""
# moment: module, function, before which of its calls, whether rows are kept
MOMENTS = {
    "start": ("cosimo.orchestrator.judgement.verification", "run_verified", 1, False),
    "FMUs": ("cosimo.orchestrator.run.run", "OpenScene", 1, False),
    "units": ("cosimo.orchestrator.opened.open_scene", "stepping_of", 1, False),
    "stepping": ("cosimo.orchestrator.run.instability", "InstabilityMonitor._judged", 3, True),
    "repetition": ("cosimo.orchestrator.run.run", "Run._start", 2, True),
    "report": ("cosimo.orchestrator.cli.run_parts", "write", 1, True),
}
# each moment with one signal, and in the complete run with the others
SENT = [
    pytest.param(moment, number, marks=() if k % len(STOPPING) == n else pytest.mark.full)
    for k, moment in enumerate(MOMENTS)
    for n, number in enumerate(STOPPING)
]
pytestmark = pytest.mark.skipif(os.name == "nt", reason="there a process is ended, not sent a signal")


@pytest.mark.parametrize(("moment", "number"), SENT)
def test_a_signal_ends_a_run_with_its_exit_code(moment, number, tmp_path):
    module, name, call, rows = MOMENTS[moment]
    settings = ("run", "mass-on-spring", "--stop", "0.2", "-o", str(tmp_path), *(() if moment == "FMUs" else ("--in-process",)))
    process = subprocess.run(
        [sys.executable, "-c", RAISING, module, name, str(call), str(int(number)), *settings],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL),
    )
    assert process.returncode == 128 + number, process.stderr
    assert "Traceback" not in process.stderr
    assert f"stopped by {number.name}" in process.stderr
    if rows:
        assert len((tmp_path / "result.csv").read_text().splitlines()) > 2
        info = json.loads((tmp_path / "run.json").read_text())
        assert info["outcome"] == ("done" if moment == "report" else "stopped")
