"""Every effect has a case of known size: the table of them is complete, and the tests it names exist and use the effect."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import pytest
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.tests.contract.known_answers import known

ROOT = Path(__file__).resolve().parents[2]
NAMED = [(component, effect, test) for component, tests in known().items() for effect, test in tests.items()]


@cache
def named_in(file: str) -> frozenset[str]:
    """Names of the tests that a file defines."""
    tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    return frozenset(n.name for n in tree.body if isinstance(n, ast.FunctionDef) and n.name.startswith("test_"))


def test_every_effect_of_every_component_is_in_the_table():
    assert {c: set(tests) for c, tests in known().items()} == {c: set(component_class(c).effects) for c in CATALOGUE}


@pytest.mark.parametrize(("component", "effect", "test"), NAMED)
def test_the_test_exists_and_its_file_uses_the_effect(component, effect, test):
    file, _, name = test.partition("::")
    assert name in named_in(file), f"{component}.{effect}"
    text = (ROOT / file).read_text(encoding="utf-8")
    ring = effect.partition("_")[2]  # such as f"{ring}_defect"
    assert effect in text or f"}}_{ring}" in text, f"{component}.{effect}"
