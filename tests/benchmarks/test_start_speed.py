"""How long a user waits before anything happens: `import cosimo` and `cosimo --help`, beside a bare interpreter."""

from __future__ import annotations

import subprocess
import sys
from time import perf_counter

import pytest

pytestmark = pytest.mark.benchmark


def seconds(*arguments: str) -> float:
    """The shortest of ten runs of a new process, in s."""
    times = []
    for _ in range(10):
        begin = perf_counter()
        subprocess.run([sys.executable, *arguments], capture_output=True, check=True)
        times.append(perf_counter() - begin)
    return min(times)


@pytest.mark.parametrize(("arguments", "limit"), [
    (("-c", "import cosimo"), 0.1), (("-m", "cosimo.orchestrator.cli", "--help"), 0.3),
])
def test_start(arguments, limit):
    bare = seconds("-c", "pass")
    whole = seconds(*arguments)
    print(f"\n{' '.join(arguments)}: {whole:.3f} s, of which {bare:.3f} s are the interpreter")
    assert whole - bare < limit
