"""Tests that the short run makes in plain Python (`interpreted`), beside the contract."""

from pathlib import Path

import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.plain_python import ROOT, passes_without_the_compiler

FILES = [
    str(path.relative_to(ROOT))
    for path in ROOT.glob("tests/**/test_*.py")
    if path.parent.name != "contract" and path != Path(__file__) and "mark.interpreted" in path.read_text(encoding="utf-8")
]


@pytest.mark.skipif(not COMPILED, reason="this is the session without the compiler")
def test_without_the_compiler():
    """In one process: each would import the same libraries."""
    passes_without_the_compiler(" ".join(sorted(FILES)), "interpreted and not full")
