"""Questions about nodes of a syntax tree, and statements that nothing needs."""

from __future__ import annotations

import ast
from collections.abc import Collection
from typing import Any

PURE = ("abs", "float", "int", "len", "max", "min")  # calls that may go with a value that nothing reads


def is_name(node: Any, names: Collection[str]) -> bool:
    """Whether a node is one of some names."""
    return isinstance(node, ast.Name) and node.id in names


def load(name: str) -> ast.Name:
    """A name that is read."""
    return ast.Name(name, ast.Load())


def is_declared_arguments(node: Any) -> bool:
    """Whether a node is a call of `self._declared_arguments`."""
    function = getattr(node, "func", None)
    return isinstance(function, ast.Attribute) and function.attr == "_declared_arguments" and is_self(function.value)


def is_self(node: Any) -> bool:
    """Whether a node is `self` or `type(self)`."""
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "type" and len(node.args) == 1:
        return is_self(node.args[0])
    return isinstance(node, ast.Name) and node.id == "self"


def drop_unread(body: list[Any]) -> None:
    """Remove assignments to names that nothing reads any more, such as the parts of a message."""
    while True:
        module = ast.Module(body, [])
        read = {n.id for n in ast.walk(module) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}
        if not _drop(body, read):
            return


def _drop(body: list[Any], read: set[str]) -> bool:
    changed = False
    for node in list(body):
        for field in ("body", "orelse"):
            changed |= _drop(getattr(node, field, None) or [], read)
        if isinstance(node, ast.Assign) and all(isinstance(t, ast.Name) and t.id not in read for t in node.targets):
            calls = [n for n in ast.walk(node.value) if isinstance(n, ast.Call)]
            if all(isinstance(c.func, ast.Name) and c.func.id in PURE for c in calls):
                body.remove(node)
                changed = True
    if changed and not body:
        body.append(ast.Pass())
    return changed


def text_of(node: Any) -> str:
    """The words of a raised message, with "..." for its values."""
    parts, first = [], 1 if is_name(getattr(node, "func", None), ("BadInput",)) else 2  # what is known at build of who says it
    for argument in node.args[first:] if isinstance(node, ast.Call) else []:
        for n in argument.values if isinstance(argument, ast.JoinedStr) else [argument]:
            parts.append(str(n.value) if isinstance(n, ast.Constant) else "...")
        parts.append(". ")
    return "".join(parts).strip(" .") or "failed"
