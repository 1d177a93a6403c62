"""What sources import, kept on disk by their contents: to parse them took a tenth of the start of a process."""

from __future__ import annotations

import json
from pathlib import Path

from .closure import Imports, imports
from .store import digest_of, read_kept, write_kept

MOST = 4096  # sources; the oldest go


class ImportIndex:
    """`closure.imports` with a file; one that is missing or damaged is written anew. `file` None: nothing is kept."""

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
        write_kept(self._file, json.dumps(dict(list(whole.items())[-MOST:])).encode())


def _read(file: Path | None) -> dict[str, Imports]:
    """Import statements by the digest of the source."""
    content = read_kept(file) if file is not None else None
    if content is None:
        return {}
    return {
        key: tuple((level, module, tuple(names)) for level, module, names in statements)
        for key, statements in json.loads(content).items()
    }
