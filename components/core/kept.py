"""Files of the cache behind a digest of what is in them: one that is damaged counts as missing."""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from pathlib import Path
from uuid import uuid4

DIGEST = hashlib.sha256().digest_size  # bytes at the start of a file


def read_kept(file: Path) -> bytes | None:
    """What is in a file; None where it is missing or damaged."""
    with suppress(OSError):
        content = file.read_bytes()
        if hashlib.sha256(content[DIGEST:]).digest() == content[:DIGEST]:
            return content[DIGEST:]
    return None


def write_kept(file: Path, content: bytes) -> None:
    """Put a file in place as a whole; not done where nothing can be written."""
    part = file.with_name(f"{file.name}.tmp.{uuid4().hex[:16]}")
    with suppress(OSError):
        try:
            part.write_bytes(hashlib.sha256(content).digest() + content)
            os.replace(part, file)
        except OSError:
            part.unlink(missing_ok=True)
            raise
