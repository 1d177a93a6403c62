"""Tests of the systems that the short run makes in plain Python (`interpreted`); the complete run compiles them."""

from __future__ import annotations

import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.systems import NAMES
from cosimo.tests.plain_python import ROOT, passes_without_the_compiler

FOLDERS = ("drives", *NAMES)


@pytest.mark.skipif(not COMPILED, reason="this is the session without the compiler")
@pytest.mark.parametrize("folder", FOLDERS)
def test_without_the_compiler(folder):
    passes_without_the_compiler(f"tests/systems/{folder}", "interpreted and not full")


def test_no_folder_is_left_out():
    assert {path.name for path in (ROOT / "tests" / "systems").iterdir() if list(path.glob("test_*.py"))} == set(FOLDERS)
