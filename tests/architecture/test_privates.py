"""A name with an underscore is its module's own, or that of a class and those that inherit from it."""

from __future__ import annotations

import ast

import pytest
from cosimo.tests.architecture.test_imports import PACKAGES, ROOT, dotted, modules

CLEAN = ("orchestrator/derivatives", "orchestrator/estimation", "orchestrator/judgement")
LEFT = 20  # uses in other folders, and of names that other packages have, too
OF_NAMED_TUPLES = {"_fields", "_replace", "_asdict", "_make"}


def bound(source: str) -> set[str]:
    """Private names that a source binds itself: functions, classes, variables, and attributes of `self`."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and of_self(node):
            names.add(node.attr)
    return {name for name in names if name.startswith("_") and not name.endswith("_")} - OF_NAMED_TUPLES


def used(source: str) -> list[str]:
    """Private names that a source imports, or reads from something other than itself, and does not bind itself."""
    found, own = [], bound(source)
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom):
            found += [(alias.name, alias.name) for alias in node.names]
        elif isinstance(node, ast.Attribute) and not of_self(node):
            found.append((node.attr, ast.unparse(node)))
    return [text for name, text in found if name in PRIVATE and name not in own]


def of_self(node: ast.Attribute) -> bool:
    return ast.unparse(node.value) in ("self", "cls", "super()")


SOURCES = {path: path.read_text(encoding="utf-8") for package in PACKAGES for path in modules(package)}
PRIVATE = set().union(*map(bound, SOURCES.values()))  # of the project: other packages have their own
USES = {path: names for path, source in SOURCES.items() if (names := used(source))}


def test_uses_of_privates_are_seen(monkeypatch):
    uses = "return o._f + self._b + o._replace()"
    source = (
        f"from .a import _b, c\nclass D:\n    def __init__(self, e):\n        self._f = e._g\n    def h(self, o):\n        {uses}"
    )
    monkeypatch.setattr(f"{__name__}.PRIVATE", {"_b", "_f", "_g"})
    assert bound(source) == {"_f"}
    assert used(source) == ["_b", "e._g"]


@pytest.mark.parametrize("folder", CLEAN)
def test_no_module_uses_the_privates_of_another(folder):
    assert {dotted(path): names for path, names in USES.items() if path.is_relative_to(ROOT / folder)} == {}


def test_uses_of_privates_get_fewer():
    """A lower number is written here as soon as it is reached."""
    assert sum(map(len, USES.values())) == LEFT, {dotted(path): names for path, names in USES.items()}
