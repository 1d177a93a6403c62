"""The contract without the compiler: every configuration of every component."""

from __future__ import annotations

import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.plain_python import passes_without_the_compiler

SHORT = (  # what the complete run leaves to the short one, or makes again with all configurations
    "tests/contract/test_declaration.py",
    "tests/contract/test_effect_sizes.py",
    "tests/contract/test_steps.py",
    "tests/contract/test_hard_case_catalogue.py",
    "tests/contract/test_effects_absent.py",
)
REST = (
    "tests/contract/test_steps.py",
    "tests/contract/test_effect_strength.py",
    "tests/contract/test_effects_free.py",
    "tests/fmus/test_fmu_run.py",
    "tests/run/test_run.py",
    "tests/harness/studies/test_effects.py",
    "tests/harness/studies/test_selection.py",
)
pytestmark = pytest.mark.skipif(not COMPILED, reason="this is the session without the compiler")


def test_without_the_compiler():
    passes_without_the_compiler(" ".join(SHORT), "not full")


@pytest.mark.full
@pytest.mark.parametrize("file", REST)
def test_the_rest_without_the_compiler(file):
    passes_without_the_compiler(file, "full" if file in SHORT else "full or not full")
