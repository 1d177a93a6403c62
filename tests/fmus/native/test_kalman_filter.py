"""The filter of docs/derivatives.md: FMPy alone, and the exact directional derivatives of a native FMU."""

import os
import re
import sys
from pathlib import Path

import numpy as np
import pytest

PAGE = Path(__file__).resolve().parents[3] / "docs" / "derivatives.md"
pytest.importorskip("ziglang")
pytestmark = pytest.mark.full


@pytest.fixture
def example(tmp_path, monkeypatch):
    """The page's code, in a folder of its own; it calls `cosimo` by name, which is this environment's."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"])))
    (code,) = (block for block in re.findall(r"^```python\n(.*?)^```$", PAGE.read_text(), re.M | re.S) if "FMU2Slave" in block)
    return code


def test_it_finds_angle_and_rate_within_its_own_deviations(example):
    names = {}
    exec(example, names)
    error = names["x"] - [names["true"][-1], 6.0]
    assert np.all(np.abs(error) < 2.0 * np.sqrt(np.diag(names["P"])))
    assert np.all(np.sqrt(np.diag(names["P"])) < [0.02, 0.1])


def test_without_the_derivative_it_does_not(example):
    names = {}
    exec(example.replace("H = np.array([slope, 0.0])", "H = np.array([1.0, 0.0])"), names)
    assert np.abs(names["x"] - [names["true"][-1], 6.0])[0] > 0.1
