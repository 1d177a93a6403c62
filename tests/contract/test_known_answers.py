"""Every effect has a test that compares it with a known answer: closed form, balance, published number, another solver.

The marker `known_answers` of a test says so: `@pytest.mark.known_answers(Component="effect", Other=("effect", "another"))`.
"""

import ast
from pathlib import Path

import pytest
from cosimo.components.catalogue import CATALOGUE, component_class

TESTS = Path(__file__).parents[1]


def marked() -> list[tuple[str, str, Path]]:
    """(component, effect, file) of every marker."""
    found = []
    texts = {path: path.read_text(encoding="utf-8") for path in TESTS.glob("*/**/test_*.py") if path != Path(__file__)}
    for path, text in texts.items():
        for test in ast.parse(text).body if "mark.known_answers(" in text else ():
            for mark in getattr(test, "decorator_list", ()):
                if isinstance(mark, ast.Call) and ast.unparse(mark.func) == "pytest.mark.known_answers":
                    given = [(word.arg, ast.literal_eval(word.value)) for word in mark.keywords]
                    found += [(str(name), e, path) for name, on in given for e in ((on,) if isinstance(on, str) else on)]
    return found


MARKED = marked()


def test_every_effect_of_every_component_has_a_known_answer():
    has = {name: {effect for component, effect, _ in MARKED if component == name} for name in CATALOGUE}
    assert has == {name: set(component_class(name).effects) for name in CATALOGUE}
    assert {component for component, *_ in MARKED} <= CATALOGUE.keys()


@pytest.mark.parametrize(("component", "effect", "path"), MARKED)
def test_the_file_uses_the_effect(component, effect, path):
    """In another place than the marker."""
    text = path.read_text(encoding="utf-8")
    ring = effect.partition("_")[2]  # such as f"{ring}_defect"
    marks = sum(effect == e for _, e, other in MARKED if other == path)
    assert text.count(effect) > marks or f"}}_{ring}" in text, f"{component}.{effect}"
