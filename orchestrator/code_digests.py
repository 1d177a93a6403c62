"""Digests of the code of components: what was measured with another one must be measured anew."""

from __future__ import annotations

import ast
import inspect
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from uuid import uuid4

from ..components.catalogue import CATALOGUE, component_class
from ..components.core.closure import closure, module_file
from ..components.core.kernel_sources import is_library
from ..components.core.store import digest_of
from .kept import Kept

PACKAGE = __name__.partition(".")[0]
_THIS_PROCESS = uuid4().hex  # code that may be another one in the next process


def code_digest(*components: str) -> str:
    """Of the code of components by their names; comments, docstrings and layout do not count."""
    return digest_of(*(part for name in components for part in _code_digests(name)))


def _code_digests(component: str) -> list[str]:
    if component in CATALOGUE:
        from ..fmus.build import sources  # most runs need no key

        return [_code_digest(content) for _, content in sorted(sources(CATALOGUE[component]).items())]
    try:
        return _own_digests(Path(inspect.getfile(component_class(component))))
    except (OSError, TypeError, ValueError, SyntaxError):  # a class of a notebook, which no source holds
        return [_THIS_PROCESS]


def function_digest(function: str) -> str:
    """Of the code of "module:name", which need not be loaded."""
    try:
        return digest_of(*_own_digests(_source_of(function.partition(":")[0]) or Path()))
    except (OSError, ValueError, SyntaxError):  # no source is found
        return _THIS_PROCESS


def _own_digests(file: Path) -> list[str]:
    """Of a user's source, and of all that it imports of the user's own and of components; for libraries their versions stand."""
    return sorted(_code_digest(path.read_bytes()) for path in closure(file.resolve(), _imported))


def _imported(module: str) -> Path | None:
    """The source of an imported module that counts."""
    top, *inner = module.split(".")
    if top == PACKAGE:
        return _source_of(module) if inner[:1] == ["components"] else None
    file = _source_of(module)
    return None if file is None or is_library(str(file)) else file


def _source_of(module: str) -> Path | None:
    """The source of a module, loaded or not: nothing is executed."""
    top, *inner = module.split(".")
    try:
        spec = find_spec(top)
    except (ImportError, ValueError):  # such as __main__
        return None
    folders = list((spec and spec.submodule_search_locations) or ())
    places = [str(Path(folder, *inner)) for folder in folders] or [str(spec and spec.origin).removesuffix(".py")]
    return next((Path(file) for place in places if (file := module_file(place)) is not None), None)


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
