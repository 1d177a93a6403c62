"""A name with an underscore is its module's own, or that of a class and those that inherit from it."""

from __future__ import annotations

import ast
import functools

import pytest
from cosimo.tests.architecture.test_imports import PACKAGES, ROOT, dotted, modules

CLEAN = ("orchestrator/derivatives", "orchestrator/estimation", "orchestrator/judgement")
LEFT = 20  # uses in other folders, and of names that other packages have, too
OF_NAMED_TUPLES = {"_fields", "_replace", "_asdict", "_make"}


def bound(tree: ast.Module) -> set[str]:
    """Private names that a source binds itself: functions, classes, variables, and attributes of `self`."""
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and of_self(node):
            names.add(node.attr)
    return {name for name in names if name.startswith("_") and not name.endswith("_")} - OF_NAMED_TUPLES


def used(tree: ast.Module, private: set[str]) -> list[str]:
    """Those of the private names that a source imports, or reads from something other than itself, and does not bind itself."""
    found, wanted = [], private - bound(tree)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            found += [alias.name for alias in node.names if alias.name in wanted]
        elif isinstance(node, ast.Attribute) and node.attr in wanted and not of_self(node):
            found.append(ast.unparse(node))
    return found


def of_self(node: ast.Attribute) -> bool:
    return ast.unparse(node.value) in ("self", "cls", "super()")


@functools.cache
def uses() -> dict:
    """Path -> texts of uses, of the modules that have some. Asked for by tests: each worker of xdist imports this module."""
    trees = {path: ast.parse(path.read_text(encoding="utf-8")) for package in PACKAGES for path in modules(package)}
    private = set().union(*map(bound, trees.values()))  # of the project: other packages have their own
    return {path: names for path, tree in trees.items() if (names := used(tree, private))}


def test_uses_of_privates_are_seen():
    last = "return o._f + self._b + o._replace()"
    tree = ast.parse(
        f"from .a import _b, c\nclass D:\n    def __init__(self, e):\n        self._f = e._g\n    def h(self, o):\n        {last}"
    )
    assert bound(tree) == {"_f"}
    assert used(tree, {"_b", "_f", "_g"}) == ["_b", "e._g"]


@pytest.mark.parametrize("folder", CLEAN)
def test_no_module_uses_the_privates_of_another(folder):
    assert {dotted(path): names for path, names in uses().items() if path.is_relative_to(ROOT / folder)} == {}


def test_uses_of_privates_get_fewer():
    """A lower number is written here as soon as it is reached."""
    assert sum(map(len, uses().values())) == LEFT, {dotted(path): names for path, names in uses().items()}
