"""What sources import, kept on disk by their contents: to parse them took a tenth of the start of a process."""

from __future__ import annotations

import hashlib
import json
import os
from contextlib import suppress
from pathlib import Path
from uuid import uuid4

from .closure import Imports, imports

DIGEST = hashlib.sha256().digest_size  # bytes at the start of the file
MOST = 4096  # sources; the oldest go


class ImportIndex:
    """`closure.imports` with a file; one that is missing or damaged is written anew. `file` None: nothing is kept."""

    def __init__(self, file: Path | None):
        self._file = file
        self._known = _read(file)
        self._new: dict[str, Imports] = {}

    def imports(self, source: bytes) -> Imports:
        """The import statements of a source."""
        digest = hashlib.sha256(source).hexdigest()
        found = self._known.get(digest)
        if found is None:
            found = self._known[digest] = self._new[digest] = imports(source)
        return found

    def save(self) -> None:
        """Write what is new, beside what other processes have written meanwhile; not done where nothing can be written."""
        if self._file is None or not self._new:
            return
        whole = {**_read(self._file), **self._new}
        kept = dict(list(whole.items())[-MOST:])
        self._new = {}
        content = json.dumps(kept).encode()
        part = self._file.with_name(f"{self._file.name}.tmp.{uuid4().hex[:16]}")
        with suppress(OSError):
            try:
                part.write_bytes(hashlib.sha256(content).digest() + content)
                os.replace(part, self._file)
            except OSError:
                part.unlink(missing_ok=True)
                raise


def _read(file: Path | None) -> dict[str, Imports]:
    """Import statements by the digest of the source; nothing is looked at before the file's digest fits."""
    with suppress(OSError, ValueError):
        if file is not None:
            content = file.read_bytes()
            if hashlib.sha256(content[DIGEST:]).digest() == content[:DIGEST]:
                return {key: tuple((level, module, tuple(names)) for level, module, names in found)
                        for key, found in json.loads(content[DIGEST:]).items()}
    return {}
