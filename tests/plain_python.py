"""Tests in a process without the compiler, as a host without Numba would run the equations.

Numba takes seconds over each combination of effects. Many short runs take plain Python less than the compiler.
"""

import os
import subprocess
import sys
from pathlib import Path

from cosimo.components.railway import mesh

ROOT = Path(__file__).resolve().parents[1]


def passes_without_the_compiler(files: str, marks: str) -> None:
    """Run the tests of these files and folders (separated by blanks) that `marks` selects, in plain Python; all must pass."""
    command = [sys.executable, "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", "-m", marks, *files.split()]
    done = subprocess.run(
        command,
        cwd=ROOT,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
    )
    assert done.returncode == 0, done.stdout[-20000:]
    assert " passed" in done.stdout


def keep_compliance_tables() -> None:
    """Compute the table of each wire once in this process: nine tenths of what a small catenary takes to initialize."""
    compute, kept = mesh.compliance_table, {}

    def compliance_table(wire, table):
        """As `compute`, which gives the same numbers for the same wire."""
        key = (*wire, table.size)
        if key not in kept:
            compute(wire, table)
            kept[key] = table.copy()
        table[:] = kept[key]

    mesh.compliance_table = compliance_table
