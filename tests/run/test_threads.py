"""Runs in threads of one process: the engines of LLVM, which have the machine code, are entered by one thread at a time."""

import subprocess
import sys

import pytest

PROGRAM = """
from concurrent.futures import ThreadPoolExecutor
import cosimo

def one(_):
    scene = cosimo.load_scene("mass-on-spring").with_changes({"stop_time": 0.02})
    return cosimo.run(scene, verify="no").columns["mass.base_x"].tolist()

with ThreadPoolExecutor(16) as pool:
    first, *others = pool.map(one, range(16))
assert all(o == first for o in others)
print("done")
"""


@pytest.mark.full
@pytest.mark.parametrize("attempt", range(3))  # without the lock, a third of the processes were ended by SIGSEGV
def test_sixteen_threads_start_at_once(attempt):
    run = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, timeout=120, check=False)
    assert (run.returncode, run.stdout.strip()) == (0, "done"), run.stderr[-2000:]
