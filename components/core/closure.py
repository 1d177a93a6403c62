"""The import closure of a source file: what its machine code, or an FMU that carries it, depends on.

Imports are read from the source, those inside functions too; nothing is executed. `ImportIndex` keeps them on disk.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from .store import digest_of, read_kept, write_kept

if TYPE_CHECKING:
    import ast

INDEXED_SOURCES = 4096  # in the file of an `ImportIndex`; the oldest go

Imports = tuple[tuple[int, str, tuple[str, ...]], ...]


@lru_cache(maxsize=1024)
def imports(source: bytes) -> Imports:
    """(level, module, names) of every import statement; level 0: absolute, with no names for `import module`."""
    import ast

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


def closure(
    file: Path, absolute: Callable[[str], Path | None] = lambda name: None, imports: Callable[[bytes], Imports] = imports
) -> dict[Path, bytes]:
    """The file and all that it imports, contents by path.

    `absolute` gives the file of a module that is imported by its full name, or None for one that does not belong to it;
    `imports` the import statements of a source, for a caller that has kept them.
    """
    contents: dict[str, bytes] = {}
    pending = [str(file)]
    while pending:
        path = pending.pop()
        if path in contents:
            continue
        with open(path, "rb") as source:
            contents[path] = source.read()
        for level, module, names in imports(contents[path]):
            if level:
                base = path
                for _ in range(level):
                    base = os.path.dirname(base)
                base = os.path.join(base, *filter(None, module.split(".")))
                wanted = [base, *(os.path.join(base, name) for name in names)]
                pending += [there for place in wanted if (there := _module_file(place)) is not None]
            else:
                pending += [str(f) for name in (module, *(f"{module}.{n}" for n in names)) if (f := absolute(name)) is not None]
    return {Path(path): source for path, source in contents.items()}


def _module_file(place: str) -> str | None:
    """The file of the module or package at a place; None where there is neither."""
    file = os.path.join(place, "__init__.py") if os.path.isdir(place) else place + ".py"
    return file if os.path.isfile(file) else None


class ImportIndex:
    """`imports` with a file, because to parse the sources took a tenth of the start of a process.

    A file that is missing or damaged is written anew. `file` None: nothing is kept.
    """

    def __init__(self, file: Path | None):
        self._file = file
        self._known = _read(file)
        self._new: dict[str, Imports] = {}

    def imports(self, source: bytes) -> Imports:
        """The import statements of a source."""
        digest = digest_of(source)
        statements = self._known.get(digest)
        if statements is None:
            statements = self._known[digest] = self._new[digest] = imports(source)
        return statements

    def save(self) -> None:
        """Write what is new, beside what other processes have written meanwhile; not done where nothing can be written."""
        if self._file is None or not self._new:
            return
        whole = {**_read(self._file), **self._new}
        self._new = {}
        write_kept(self._file, json.dumps(dict(list(whole.items())[-INDEXED_SOURCES:])).encode())


def _read(file: Path | None) -> dict[str, Imports]:
    """Import statements by the digest of the source."""
    content = read_kept(file) if file is not None else None
    if content is None:
        return {}
    return {
        key: tuple((level, module, tuple(names)) for level, module, names in statements)
        for key, statements in json.loads(content).items()
    }
