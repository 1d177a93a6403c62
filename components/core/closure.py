"""The import closure of a source file: what its machine code, or an FMU that carries it, depends on.

Imports are read from the source, those inside functions too; nothing is executed. `SourceIndex` keeps them on disk.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from pathlib import Path
from time import time_ns
from typing import TYPE_CHECKING, Any

from .store import cache_folder, digest_of, read_kept, write_kept

if TYPE_CHECKING:
    import ast

INDEXED_SOURCES = 4096  # in the file of a `SourceIndex`; the oldest go
SETTLED = 2_000_000_000  # ns after a change from which on another one has another time

Imports = tuple[tuple[int, str, tuple[str, ...]], ...]
Imported = dict[tuple[str, str], tuple[list[str], list[str]]]  # by path and digest: files imported by place, modules by full name


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
    file: Path, absolute: Callable[[str], Path | None] = lambda name: None, seen: Imported | None = None
) -> dict[Path, str]:
    """The file and all that it imports: digests of the contents by path.

    `absolute` gives the file of a module that is imported by its full name, or None for one that does not belong to it. `seen` is
    what former calls have found of contents; given, the imports of these are not looked for again.
    """
    digests: dict[str, str] = {}
    pending, index, seen = [str(file)], sources(), {} if seen is None else seen
    while pending:
        path = pending.pop()
        if path in digests:
            continue
        digests[path], statements = index.read(path)
        if (known := (path, digests[path])) not in seen:
            names = [n for level, module, some in statements if not level for n in _full(module, some)]
            seen[known] = _beside(path, statements), names
        beside, names = seen[known]
        pending += [*beside, *(str(there) for name in names if (there := absolute(name)) is not None)]
    index.save()
    return {Path(path): digest for path, digest in digests.items()}


def _beside(path: str, statements: Imports) -> list[str]:
    """The files of what a source imports by its own place."""
    files = list[str]()
    for level, module, names in statements:
        base = path
        for _ in range(level):
            base = os.path.dirname(base)
        base = os.path.join(base, *filter(None, module.split(".")))
        wanted = [base, *(os.path.join(base, name) for name in names)] if level else []
        files += [there for place in wanted if (there := module_file(place)) is not None]
    return files


def _full(module: str, names: tuple[str, ...]) -> list[str]:
    """The modules that an import by its full name may mean."""
    return [module, *(f"{module}.{name}" for name in names)]


def module_file(place: str) -> str | None:
    """The file of the module or package at a place; None where there is neither."""
    file = os.path.join(place, "__init__.py") if os.path.isdir(place) else place + ".py"
    return file if os.path.isfile(file) else None


class SourceIndex:
    """What sources import, and the digests of files, kept on disk: nothing of a file is read that is as it was.

    To read and to parse the sources took a tenth of the start of a process. A file is as it was where its size, its times of change
    and its number on the disk are; one that was changed just now may change once more within the same instant, and is not kept.
    An index that is missing or damaged is written anew. `file` None: nothing is kept.
    """

    def __init__(self, file: Path | None):
        self._file = file
        self._imports, self._files = _read(file)
        self._new: tuple[dict[str, Any], dict[str, Any]] = {}, {}

    def read(self, path: str) -> tuple[str, Imports]:
        """The digest of a file's content, and the import statements in it. Raises `OSError`."""
        status = os.stat(path)
        seen = [status.st_size, status.st_mtime_ns, status.st_ctime_ns, status.st_ino]
        known = self._files.get(path)
        if known is not None and known[0] == seen and known[1] in self._imports:
            return known[1], self._imports[known[1]]
        with open(path, "rb") as source:
            content = source.read()
        statements, digest = self.imports(content), digest_of(content)
        if time_ns() - max(seen[1:3]) > SETTLED:
            self._files[path] = self._new[1][path] = [seen, digest]
        return digest, statements

    def imports(self, source: bytes) -> Imports:
        """The import statements of a source."""
        digest = digest_of(source)
        statements = self._imports.get(digest)
        if statements is None:
            statements = self._imports[digest] = self._new[0][digest] = imports(source)
        return statements

    def save(self) -> None:
        """Write what is new, beside what other processes have written meanwhile; not done where nothing can be written."""
        if self._file is None or not any(self._new):
            return
        whole = [list((old | new).items())[-INDEXED_SOURCES:] for old, new in zip(_read(self._file), self._new, strict=True)]
        self._new = {}, {}
        write_kept(self._file, json.dumps(whole).encode())


@lru_cache(maxsize=1)
def sources() -> SourceIndex:
    """The index of this user."""
    folder = cache_folder("kernels")
    return SourceIndex(None if folder is None else folder / "sources.json")


def _read(file: Path | None) -> tuple[dict[str, Imports], dict[str, Any]]:
    """Import statements by the digest of the source, and of files what was seen of them and their digests."""
    content = read_kept(file) if file is not None else None
    if content is None:
        return {}, {}
    statements, files = map(dict, json.loads(content))
    return {key: tuple((level, module, tuple(names)) for level, module, names in some) for key, some in statements.items()}, files
