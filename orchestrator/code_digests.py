"""Digests of the code of components: what was measured with another one must be measured anew."""

from __future__ import annotations

import ast
import inspect
from functools import cache
from pathlib import Path
from uuid import uuid4

from ..components.catalogue import CATALOGUE, component_class
from ..components.core.store import digest_of
from .kept import Kept

_THIS_PROCESS = uuid4().hex  # code that may be another one in the next process


def code_digest(*components: str) -> str:
    """Of the code of components by their names; comments, docstrings and layout do not count."""
    return digest_of(*(part for name in components for part in _code_digests(name)))


def _code_digests(component: str) -> list[str]:
    if component in CATALOGUE:
        from ..fmus.build import sources  # most runs need no key

        return [_code_digest(content) for _, content in sorted(sources(CATALOGUE[component]).items())]
    try:
        return [_code_digest(Path(inspect.getfile(component_class(component))).read_bytes())]
    except (OSError, TypeError):  # a class of a notebook, which no file holds
        return [_THIS_PROCESS]


@cache
def _code_digest(content: bytes) -> str:
    return Kept("code", digest_of(content)).once(lambda: digest_of(repr(_code(ast.parse(content)))))


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
