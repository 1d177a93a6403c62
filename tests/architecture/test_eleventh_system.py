"""Adding a system takes files of its name, a line in the catalogue, one in the list of systems and some in the documentation."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from cosimo.tests.architecture.eleventh_system import arguments, steps, write
from cosimo.tests.architecture.test_sources import shipped_files

ROOT = Path(__file__).resolve().parents[2]
OF_OTHERS = ("eleventh_system", "own_tree", "light_imports", "kinds_of_units", "abilities_of_units", "words", "one_core", "wheel")
# Not within itself, and not what the page's own texts decide: its files read no unit, build no engine and use no former name.
APART = (*(f"--ignore=tests/architecture/test_{name}.py" for name in OF_OTHERS), "-q", "-n", "0", "-p", "no:cacheprovider")


@pytest.fixture
def tree(tmp_path):
    """A copy of the project."""
    for path in shipped_files():
        copy = tmp_path / "cosimo" / path.relative_to(ROOT)
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(path.read_bytes())
    return tmp_path


def python(top, *arguments):
    """The process `python arguments` where `cosimo` is the copy."""
    return subprocess.run(
        [sys.executable, *arguments],
        capture_output=True,
        text=True,
        cwd=top / "cosimo",
        timeout=600,
        env={**os.environ, "PYTHONPATH": str(top), "PYTEST_ADDOPTS": " ".join(APART)},
    )


@pytest.mark.full
def test_the_page_from_top_to_bottom(tree):
    printed = {}
    for name, text in steps():
        if name:
            write(tree / "cosimo", name, text)
            continue
        done = python(tree, *arguments(text))
        assert done.returncode == 0, f"{text}\n{done.stdout[-5000:]}{done.stderr[-5000:]}"
        assert "Traceback" not in done.stderr
        printed[text] = done.stdout
    assert [text.split()[0] for text in printed] == ["cosimo"] * 4 + ["pytest"] * 3
    assert re.search(r"frequency .* 1\.3178 ± 0\.0001", printed["cosimo run duffing-free -o out/numbers"])
    assert all(re.search(r"\d passed", printed[text]) for text in printed if text.startswith("pytest"))
    out = tree / "cosimo" / "out" / "case"
    validated = json.loads((out / "validation.json").read_text(encoding="utf-8"))["cases"][0]
    assert (validated["outcome"], len(validated["rows"])) == ("passed", 2)
    assert all(row["error"] is not None for row in validated["rows"])
    assert "Orbit" in (out / "report.html").read_text(encoding="utf-8")
    listed = json.loads(python(tree, *arguments("cosimo list --json")).stdout)
    assert "DuffingOscillator" in {c["name"] for c in listed["components"]}
    assert "duffing-free" in {s["name"] for s in listed["scenes"]} & {c["name"] for c in listed["cases"]}


def test_a_line_of_a_list_stands_behind_whatever_is_last(tmp_path):
    name, texts = "orchestrator/systems/__init__.py", ('"a", "b")', '"a",\n    "b",\n)')
    for text in texts:
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"\nNAMES = ({text}\nOTHER = ()\n")
        write(tmp_path, name, "")
        names = {}
        exec(path.read_text(), names)
        assert (names["NAMES"], names["OTHER"]) == (("a", "b", "duffing"), ())
