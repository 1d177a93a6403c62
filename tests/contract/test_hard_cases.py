"""The declared hard cases of every component: each claim within its limit, each refusal in its words and sharp.

The catalogue runs in plain Python; tests/contract/test_plain_python.py starts the session for it. One pass over the components
without effects runs as machine code.
"""

import math

import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.hard_cases import Refused
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.harness.studies.hard_cases import declared, verdicts
from cosimo.tests.contract.configurations import in_plain_python
from cosimo.tests.short_run import ONE_A_SYSTEM

DECLARED = declared()
CASES = [(name, case) for name, cases in DECLARED.items() for case in cases]
FEWEST = 2
COMPILED_CASES = [
    (name, case) for name, case in CASES if name in ONE_A_SYSTEM and not case.effects and not isinstance(case.holds, Refused)
]


@pytest.mark.parametrize(("name", "case"), in_plain_python(CASES), ids=lambda v: v if isinstance(v, str) else v.name)
@pytest.mark.uncompiled
def test_hard_case(name, case):
    holds(name, case)


def holds(name, case):
    """Every claim of a case."""
    for verdict in verdicts(name, case):
        assert verdict.holds, f"{verdict.claim}: {verdict.reached:.3g} of {verdict.limit:.3g}. {verdict.message}"
        assert math.isnan(verdict.margin) or verdict.margin >= 1.0


@pytest.mark.full
@pytest.mark.skipif(not COMPILED, reason="no Numba, nothing to compile")
@pytest.mark.parametrize(("name", "case"), COMPILED_CASES, ids=lambda v: v if isinstance(v, str) else v.name)
def test_hard_case_as_machine_code(name, case):
    """Those that need no more than the kernels of the fewest effects, which other tests compile, too."""
    holds(name, case)


@pytest.mark.parametrize("name", CATALOGUE)
def test_every_component_has_its_cases(name):
    cases = DECLARED[name]
    assert len(cases) >= FEWEST
    assert len({case.name for case in cases}) == len(cases)
    assert any(not isinstance(case.holds, Refused) for case in cases)  # something that runs


@pytest.mark.parametrize(("name", "case"), CASES, ids=lambda v: v if isinstance(v, str) else v.name)
def test_what_a_case_names_exists(name, case):
    cls = component_class(name)
    accepted = case.holds.accepted if isinstance(case.holds, Refused) else {}
    assert {*case.parameters, *case.inputs, *accepted} <= cls.variables.keys()
    assert set(case.effects) <= cls.effects.keys()
    assert case.text.endswith(".")
    assert case.steps >= 1
    if isinstance(case.holds, Refused):
        assert case.holds.when in ("construction", "initialize", "step")
        assert case.holds.words
    else:
        assert case.holds
