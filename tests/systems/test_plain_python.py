"""Tests of the systems that the short run makes in plain Python (`interpreted`); the complete run compiles them."""

from __future__ import annotations

import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.plain_python import ROOT, passes_without_the_compiler

FILES = (ROOT / "tests" / "systems").glob("*/test_*.py")
FOLDERS = sorted({path.parent.name for path in FILES if "mark.interpreted" in path.read_text(encoding="utf-8")})


@pytest.mark.skipif(not COMPILED, reason="this is the session without the compiler")
@pytest.mark.parametrize("folder", FOLDERS)
def test_without_the_compiler(folder):
    passes_without_the_compiler(f"tests/systems/{folder}", "interpreted and not full")
