"""The wheel holds every file that the package needs at run time, and nothing else."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from importlib.metadata import version
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = (".py", ".toml", ".csv", ".html", ".css", ".js", ".c", ".h")
PARTS = ("components", "fmus", "orchestrator")


@pytest.mark.full
@pytest.mark.skipif(int(version("setuptools").partition(".")[0]) < 77, reason="needs setuptools 77; the extra test has it")
def test_content_of_the_wheel(tmp_path):
    """Built from a copy, so that no folder `build` of earlier builds gets in; setuptools is one of the test requirements."""
    source = tmp_path / "source"
    source.mkdir()
    for name in ("__init__.py", "py.typed", "pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    for part in (*PARTS, "tests", "docs"):
        shutil.copytree(ROOT / part, source / part, ignore=shutil.ignore_patterns("__pycache__"))
    done = subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation", "-w", tmp_path, source],
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        packed = {name for name in archive.namelist() if ".dist-info/" not in name}

    needed = {
        f"cosimo/{path.relative_to(ROOT).as_posix()}"
        for part in PARTS
        for path in (ROOT / part).rglob("*")
        if path.suffix in SHIPPED and "__pycache__" not in path.parts
    }
    assert len(needed) > 300
    assert packed == needed | {"cosimo/__init__.py", "cosimo/py.typed", "cosimo/LICENSE"}
