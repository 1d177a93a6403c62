"""Adding a system takes files in folders of its name, a line in the catalogue and one in the list of systems; nothing else."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from cosimo.tests.architecture.eleventh_system import FILES, LISTS
from cosimo.tests.architecture.test_sources import shipped_files

ROOT = Path(__file__).resolve().parents[2]
TESTS = [
    "tests/systems/duffing",
    "tests/contract/test_declaration.py",
    "tests/contract/test_known_answers.py",
    "tests/contract/test_steps.py",
    "tests/contract/test_effect_strength.py",
    "tests/contract/test_hard_case_catalogue.py",
    "tests/architecture/test_catalogues.py",
    "tests/architecture/test_imports.py",
    "tests/architecture/test_rooms.py",
    "tests/architecture/test_sources.py",
]


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of the project with the system added, and the environment in which `cosimo` is that copy."""
    top = tmp_path_factory.mktemp("eleventh")
    for path in shipped_files():
        copy = top / "cosimo" / path.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(path.read_bytes())
    for name, text in FILES.items():
        path = top / "cosimo" / name
        assert not path.exists()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    for name, (before, after) in LISTS.items():
        text = (top / "cosimo" / name).read_text(encoding="utf-8")
        assert before in text
        (top / "cosimo" / name).write_text(text.replace(before, after), encoding="utf-8")
    return top


def python(top, *arguments, **environment):
    """What `python arguments` prints where `cosimo` is the copy."""
    done = subprocess.run(
        [sys.executable, *arguments],
        capture_output=True,
        text=True,
        cwd=top / "cosimo",
        timeout=600,
        env={**os.environ, "PYTHONPATH": str(top), "COSIMO_CACHE": str(top / "cache"), **environment},
    )
    assert done.returncode == 0, done.stdout[-5000:] + done.stderr[-5000:]
    return done.stdout


@pytest.mark.full
def test_scene_case_figure_and_fmu_of_the_new_system(tree):
    listed = json.loads(python(tree, "-m", "cosimo.orchestrator.cli", "list", "--json"))
    assert "DuffingOscillator" in {c["name"] for c in listed["components"]}
    assert "duffing-free" in {s["name"] for s in listed["scenes"]} & {c["name"] for c in listed["cases"]}
    validated = json.loads(
        python(tree, "-m", "cosimo.orchestrator.cli", "validate", "duffing-free", "--json", "-o", str(tree / "out"))
    )
    assert validated["cases"][0]["outcome"] == "passed"  # through the FMU, built on demand
    page = (tree / "out" / "report.html").read_text(encoding="utf-8")
    assert "Orbit" in page


@pytest.mark.full
def test_contract_and_architecture_of_the_new_system(tree):
    printed = python(
        tree,
        "-m",
        "pytest",
        "-q",
        "-n",
        "0",
        "-p",
        "no:cacheprovider",
        "-m",
        "full or not full",
        "-k",
        "DuffingOscillator or duffing or architecture",
        *TESTS,
        NUMBA_DISABLE_JIT="1",
    )
    assert " passed" in printed
