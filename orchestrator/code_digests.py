"""Digests of the code of components: what was measured with another one must be measured anew."""

from __future__ import annotations

import ast
import inspect
from functools import cache
from pathlib import Path

from ..components.catalogue import CATALOGUE, component_class
from ..components.core.store import digest_of
from ..fmus.build import sources
from .kept import Kept
from .scene.scene import Scene


def components_digest(scene: Scene) -> str:
    """Of the code of the scene's components; comments, docstrings and layout do not count."""
    parts = [part for name, unit in sorted(scene.units.items()) for part in _code_digests(unit.component, name)]
    return short_digest(" ".join(parts).encode())


def component_digest(name: str) -> str:
    """The same of one component."""
    return short_digest(" ".join(_code_digests(name, name)).encode())


def _code_digests(component: str, unit: str) -> list[str]:
    if component in CATALOGUE:
        return [_code_digest(content) for _, content in sorted(sources(CATALOGUE[component]).items())]
    return [_code_digest(Path(inspect.getfile(component_class(component, unit))).read_bytes())] if component else []


@cache
def _code_digest(content: bytes) -> str:
    place = Kept("code", digest_of(content))
    digest: str | None = place.read()
    if digest is None:
        place.write(digest := short_digest(repr(_code(ast.parse(content))).encode()))
    return digest


def _code(node: object) -> object:
    """A syntax tree as nested tuples, the same for all versions of Python that have the same fields: empty ones are left out."""
    if isinstance(node, list):
        return [_code(item) for item in node]
    if not isinstance(node, ast.AST):
        return node
    fields = {name: value for name, value in ast.iter_fields(node) if value not in (None, [])}
    if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node, clean=False) is not None:
        fields["body"] = node.body[1:]
    return type(node).__name__, [(name, _code(value)) for name, value in fields.items()]


def short_digest(*parts: bytes) -> str:
    """Sixteen hexadecimal digits."""
    return digest_of(*parts)[:16]
