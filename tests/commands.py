"""Commands as tests give them: within this process by their exit code, or as processes of their own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from cosimo.orchestrator.cli import main

ROOT = Path(__file__).resolve().parents[1]


def exit_code(*arguments: object) -> int:
    """The exit code of `cosimo arguments`, in this process."""
    with pytest.raises(SystemExit) as end:
        main([str(a) for a in arguments])
    return end.value.code or 0


def python(source: str, *arguments: object, folder: Path = ROOT, code: int = 0, **environment: str) -> str:
    """What a new process prints that executes a source in a folder; it must end with the exit code."""
    done = subprocess.run(
        [sys.executable, "-c", source, *map(str, arguments)],
        capture_output=True,
        text=True,
        cwd=folder,
        timeout=1800,
        env={**os.environ, **environment},
    )
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout
