"""A name with an underscore is its module's own, or that of a class and those that inherit from it."""

from __future__ import annotations

import ast
import functools

import pytest
from cosimo.tests.architecture.test_imports import PACKAGES, ROOT, dotted, modules

CLEAN = ("orchestrator/derivatives", "orchestrator/estimation", "orchestrator/judgement")
LEFT = 20  # uses in other folders, and of names that other packages have, too
OF_NAMED_TUPLES = {"_fields", "_replace", "_asdict", "_make"}


def names_of(source: str) -> tuple[set[str], list[tuple[str, str]]]:
    """Private names of a source: those that it binds, and (name, text) of those that it takes from something other than itself.

    Bound are functions, classes, variables, and attributes of `self`. In one walk: the tree has hundreds of thousands of nodes.
    """
    own: set[str] = set()
    taken = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            own.add(node.name)
        elif isinstance(node, ast.Name):
            if isinstance(node.ctx, ast.Store):
                own.add(node.id)
        elif isinstance(node, ast.Attribute):
            if node.attr.startswith("_"):
                of_self = ast.unparse(node.value) in ("self", "cls", "super()")
                if of_self and isinstance(node.ctx, ast.Store):
                    own.add(node.attr)
                elif not of_self:
                    taken.append((node.attr, ast.unparse(node)))
        elif isinstance(node, ast.ImportFrom):
            taken += [(alias.name, alias.name) for alias in node.names]
    return {name for name in own if name.startswith("_") and not name.endswith("_")} - OF_NAMED_TUPLES, taken


@functools.cache
def uses() -> dict:
    """Path -> texts of uses, of the modules that have some. Asked for by tests: each worker of xdist imports this module."""
    found = {path: names_of(path.read_text(encoding="utf-8")) for package in PACKAGES for path in modules(package)}
    private = set().union(*(own for own, _ in found.values()))  # of the project: other packages have their own
    return {path: texts for path, (own, taken) in found.items() if (texts := used(own, taken, private))}


def used(own: set[str], taken: list[tuple[str, str]], private: set[str]) -> list[str]:
    """Texts of what a source takes of the private names and does not bind itself."""
    return [text for name, text in taken if name in private and name not in own]


def test_uses_of_privates_are_seen():
    last = "return o._f + self._b + o._replace()"
    own, taken = names_of(
        f"from .a import _b, c\nclass D:\n    def __init__(self, e):\n        self._f = e._g\n    def h(self, o):\n        {last}"
    )
    assert own == {"_f"}
    assert used(own, taken, {"_b", "_f", "_g"}) == ["_b", "e._g"]


@pytest.mark.parametrize("folder", CLEAN)
def test_no_module_uses_the_privates_of_another(folder):
    assert {dotted(path): names for path, names in uses().items() if path.is_relative_to(ROOT / folder)} == {}


def test_uses_of_privates_get_fewer():
    """A lower number is written here as soon as it is reached."""
    assert sum(map(len, uses().values())) == LEFT, {dotted(path): names for path, names in uses().items()}
