"""The page of the Python interface: types and meanings of parameters, and examples that run."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs" / "site"))
python_pages = pytest.importorskip("python_pages")


def test_every_function_has_its_types_and_what_it_returns():
    page = python_pages.page()
    assert "| `jobs` | `int | None` |".replace("| None", r"\| None") in page
    assert "**options" not in page
    assert "pydantic" not in page.lower()
    assert "FieldInfo" not in page
    assert "Returns `Result`." in page


@pytest.mark.full
@pytest.mark.parametrize("name", python_pages.EXAMPLES)
def test_an_example_runs(name, tmp_path):
    path = os.pathsep.join(p or os.curdir for p in sys.path)
    done = subprocess.run(
        [sys.executable, "-c", python_pages.example(name)],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
