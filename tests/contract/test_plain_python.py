"""What runs without the compiler only: the contract, the study of effects, every component and scene as FMUs."""

from pathlib import Path

import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.tests.plain_python import ROOT, passes_without_the_compiler

FMUS = "tests/fmus/test_fmu_run.py"
SCENES = "tests/run/test_run.py::test_shipped_scenes_run_alike_as_fmus_and_in_process"
SHORT = (
    "tests/contract/test_declaration.py",
    "tests/contract/test_effect_sizes.py",
    "tests/contract/test_steps.py",
    "tests/contract/test_hard_cases.py",
    "tests/contract/test_effects_absent.py",
    "tests/contract/test_effects_read.py",
    "tests/contract/test_ranges.py",
    "tests/contract/test_refusals.py",
    "tests/harness/studies/test_effects.py",
    "tests/harness/studies/test_selection.py",
    SCENES,
)
REST = (  # what the complete run adds, marked `full`
    "tests/contract/test_steps.py",
    "tests/contract/test_effect_strength.py",
    "tests/contract/test_effects_free.py",
    f"{FMUS}::test_the_fmu_is_the_component_to_the_last_bit",
    f"{FMUS}::test_what_is_off_reads_its_start_value_and_takes_writes",
    SCENES,
)
pytestmark = pytest.mark.skipif(not COMPILED, reason="this is the session without the compiler")


def test_without_the_compiler():
    passes_without_the_compiler(" ".join(SHORT), "not full")


@pytest.mark.full
def test_the_rest_without_the_compiler():
    passes_without_the_compiler(" ".join(REST), "full")


def test_no_test_for_plain_python_is_left_out():
    started = " ".join((*SHORT, *REST))
    files = [
        path
        for path in (ROOT / "tests").rglob("test_*.py")
        if path != Path(__file__) and "in_plain_python(" in path.read_text(encoding="utf-8")
    ]
    assert len(files) > 5
    assert [path.name for path in files if path.relative_to(ROOT).as_posix() not in started] == []
