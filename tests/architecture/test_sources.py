"""Sizes, docstrings, and what must not stand in any file of the tree."""

from __future__ import annotations

import ast
import re
import subprocess
import warnings
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOFT, HARD, HARD_TESTS = 400, 500, 600  # lines of a file
SOURCES = sorted(p for package in ("components", "fmus", "orchestrator", "tests") for p in (ROOT / package).rglob("*.py"))
# Spelled in pieces, because this file is searched, too.
NOWHERE = ("/wo" + "rk/", "/ro" + "ot/", "/ho" + "me/", "sha" + "red/", "hel" + "per-")


def shipped_files() -> list[Path]:
    """Tracked files and new ones that are not ignored; in a tree without git, all files outside caches and builds."""
    command = ["git", "-C", str(ROOT), "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    try:
        listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        found = [ROOT / name for name in listed.split("\0") if name]
    except (OSError, subprocess.CalledProcessError):
        folders = [ROOT / name for name in ("components", "docs", "fmus", "orchestrator", "tests", ".ci", ".github")]
        found = [*ROOT.iterdir(), *(p for f in folders for p in f.rglob("*") if "__pycache__" not in p.parts)]
    return [path for path in found if path.is_file()]


def test_no_file_is_too_long():
    lengths = {str(p.relative_to(ROOT)): len(p.read_text().splitlines()) for p in SOURCES}
    long = {name: n for name, n in lengths.items() if n > SOFT}
    if long:
        warnings.warn(f"above {SOFT} lines: {long}", stacklevel=1)
    assert {name: n for name, n in long.items() if n > (HARD_TESTS if name.startswith("tests") else HARD)} == {}


def test_no_place_of_one_machine_is_named_anywhere():
    found = []
    assert len(shipped_files()) > len(SOURCES)
    for path in shipped_files():
        text = path.read_bytes().decode("utf-8", errors="replace")
        found += [f"{path.relative_to(ROOT)}: {word}" for word in NOWHERE if word in text]
    assert found == []


def undocumented(path: Path) -> list[str]:
    """Public functions and classes of a module without a docstring, and the module itself.

    Methods are left out: most keep a contract that is written once, at the base or the protocol.
    """
    tree = ast.parse(path.read_text())
    found = [] if ast.get_docstring(tree) or not tree.body else ["the module"]
    named = (node for node in tree.body if isinstance(node, ast.FunctionDef | ast.ClassDef))
    return found + [node.name for node in named if not node.name.startswith("_") and not ast.get_docstring(node)]


# What reads a clock: to show or to keep a time, to pace, or for a limit that a user gives; what is repeated of a run does not depend on it.
READS_CLOCKS = {
    "components/core": {"closure"},  # the age of a file that may have changed a moment ago
    "orchestrator": {"cache", "output"},
    "orchestrator/run": {"pacing", "progress", "recording", "run", "run_info"},
    "orchestrator/cli": {"show_parts"},
    "orchestrator/engine/stepping": {"loop"},
    "orchestrator/harness/many": {"execute", "store"},
    "orchestrator/harness/studies": {"component_accuracy", "reference", "trial"},
    "orchestrator/judgement": {"advice", "verification"},
    "orchestrator/systems/rov": {"twin"},  # whose vehicle is in real time
    "orchestrator/units": {"channel", "fmi2", "folders", "process"},
}


def test_only_what_shows_paces_or_limits_reads_a_clock():
    clocks = re.compile(r"^\s*(from time import|import time\b)", re.MULTILINE)
    product = [p for p in SOURCES if p.relative_to(ROOT).parts[0] != "tests"]
    found = {p.relative_to(ROOT).with_suffix("").as_posix() for p in product if clocks.search(p.read_text())}
    assert found == {f"{folder}/{name}" for folder, names in READS_CLOCKS.items() for name in names}


@pytest.mark.parametrize("package", ["components", "fmus", "orchestrator"])
def test_everything_public_has_a_docstring(package):
    without = {
        str(p.relative_to(ROOT)): names for p in SOURCES if package == p.relative_to(ROOT).parts[0] if (names := undocumented(p))
    }
    assert without == {}
