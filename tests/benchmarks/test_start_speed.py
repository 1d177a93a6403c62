"""How long a user waits before anything happens: the first command, with nothing compiled, and those after it.

CPU times of whole processes with their children. Measure where the package has byte code: without it, each start compiles sources.
"""

import os
import subprocess
import sys
from time import perf_counter

import pytest

pytestmark = pytest.mark.skipif(not hasattr(os, "wait4"), reason="the system does not tell what a process took")
COMMANDS = {  # CPU time that is aimed at, s
    "--help": 0.2,
    "list": 0.2,
    "show Pantograph": 0.5,
    "run rov-station-keeping --in-process --no-verify --stop 0.1": 0.4,
    "run gimbal-scan --in-process --no-verify --stop 0.1": 0.4,
    "run en50318-2002 --in-process --no-verify --stop 0.1": 0.4,
}


def spent(*arguments, folder, **surroundings):
    """CPU time and time by the clock of a new process of Python, with its children, s."""
    begin = perf_counter()
    process = subprocess.Popen(
        [sys.executable, *arguments], stdout=subprocess.DEVNULL, cwd=folder, env={**os.environ, **surroundings}
    )
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0, arguments
    return used.ru_utime + used.ru_stime, perf_counter() - begin


def command(text, folder, **surroundings):
    return spent("-m", "cosimo.orchestrator.cli", *text.split(), folder=folder, **surroundings)


@pytest.mark.parametrize(("text", "aim"), COMMANDS.items(), ids=COMMANDS)
def test_a_warm_start(text, aim, tmp_path, told):
    """The least of six, behind two that compile and write: at most twelve bare starts with NumPy, however busy the machine is."""
    times, bare = [], []
    for _ in range(8):
        bare.append(spent("-c", "import numpy", folder=tmp_path)[0])
        times.append(command(text, tmp_path)[0])
    seconds = min(times[2:])
    told.target(f"`cosimo {text}`", seconds, aim, "s of CPU")
    assert seconds < 12.0 * min(bare)


def test_the_first_command(tmp_path, told):
    """`cosimo validate en50318-2002` with empty caches, once."""
    used, clock = command("validate en50318-2002", tmp_path, COSIMO_CACHE=str(tmp_path / "cache"))
    told.target("`cosimo validate en50318-2002`, empty caches", clock, 16.0, "s by the clock")
    told.target("the same", used, 24.0, "s of CPU")
    again, _ = command("validate en50318-2002", tmp_path, COSIMO_CACHE=str(tmp_path / "cache"))
    assert again < 0.5 * used
