"""The import closure of a source file: what its machine code, or an FMU that carries it, depends on.

Imports are read from the source, those inside functions too; nothing is executed.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from pathlib import Path


@lru_cache(maxsize=1024)
def imports(source: bytes) -> tuple[tuple[int, str, tuple[str, ...]], ...]:
    """(level, module, names) of every import statement; level 0: absolute, with no names for `import module`."""
    result: list[tuple[int, str, tuple[str, ...]]] = []
    for node in _statements(ast.parse(source).body):
        if isinstance(node, ast.Import):
            result += [(0, alias.name, ()) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            result.append((node.level, node.module or "", tuple(alias.name for alias in node.names)))
    return tuple(result)


def _statements(nodes: Iterable[ast.AST]) -> Iterator[ast.AST]:
    """Statements and those inside them, without the expressions in them: `ast.walk` takes ten times as long."""
    for node in nodes:
        yield node
        for field in ("body", "orelse", "finalbody", "handlers", "cases"):
            yield from _statements(getattr(node, field, ()))


def closure(file: Path, absolute: Callable[[str], Path | None] = lambda name: None) -> dict[Path, bytes]:
    """The file and all that it imports, contents by path.

    `absolute` gives the file of a module that is imported by its full name, or None for one that does not belong to it.
    """
    contents: dict[Path, bytes] = {}
    pending = [file]
    while pending:
        path = pending.pop()
        if path in contents:
            continue
        contents[path] = path.read_bytes()
        for level, module, names in imports(contents[path]):
            if level:
                base = path.parents[level - 1].joinpath(*filter(None, module.split(".")))
                wanted = [base, *(base / name for name in names)]
                pending += [f for place in wanted if (f := _module_file(place)) is not None]
            else:
                pending += [f for name in (module, *(f"{module}.{n}" for n in names)) if (f := absolute(name)) is not None]
    return contents


def _module_file(place: Path) -> Path | None:
    """The file of the module or package at a place; None where there is neither."""
    file = place / "__init__.py" if place.is_dir() else place.with_name(place.name + ".py")
    return file if file.is_file() else None
