"""No component of the catalogue needs special treatment to be measured alone."""

import json
import os
import subprocess
import sys

import pytest
from cosimo.components.catalogue import CATALOGUE

pytestmark = pytest.mark.full


def test_components_and_scipy_agree_over_a_few_steps():
    """In a process without compilation, which for all components would take minutes."""
    done = subprocess.run(
        [sys.executable, "-m", "cosimo.tests.harness.studies.plain_components"],
        capture_output=True,
        text=True,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert set(found) == set(CATALOGUE)
    solved = {name: value for name, value in found.items() if value is not None}
    assert len(solved) > 8
    assert {name: value for name, value in solved.items() if not value < 1e-3} == {}
