"""The tests test their own tree, whatever package is installed."""

from __future__ import annotations

import os
import subprocess
import sys

from cosimo.tests.architecture.test_sources import ROOT


def test_tests_that_would_test_another_package_stop_at_once(tmp_path):
    (tmp_path / "cosimo").mkdir()
    (tmp_path / "cosimo" / "__init__.py").touch()
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-n", "0", "--collect-only", "tests/architecture/test_own_tree.py"],
        capture_output=True,
        text=True,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    )
    assert done.returncode != 0
    assert f"would test {(tmp_path / 'cosimo').resolve()}" in done.stderr
    assert f"pip install -e . in {ROOT}" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_tree_that_is_reached_by_a_link_is_its_own(tmp_path):
    (tmp_path / "cosimo").symlink_to(ROOT, target_is_directory=True)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-n", "0", "--collect-only", "-q", "tests/architecture/test_own_tree.py"],
        capture_output=True,
        text=True,
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    )
    assert done.returncode == 0, done.stderr
