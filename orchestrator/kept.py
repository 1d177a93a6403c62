"""What was measured once, on this machine: kept in the user's cache, and measured anew with another version of cosimo."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

from ..components.core import store
from ..components.core.folders import cache_root
from ..fmus.versions import version


class Kept:
    """The place of one measurement. kind: folder of the cache.  key: all that it depends on beside the version of cosimo."""

    def __init__(self, kind: str, *key: str):
        self.file = Path(cache_root()) / kind / store.digest_of(version("cosimo"), *key)

    def read(self) -> Any:
        """The plain data that was written there; None where there is none, or it is damaged."""
        content = store.read_kept(self.file)
        return None if content is None else json.loads(content)

    def write(self, data: Any) -> None:
        """Keep plain data; where nothing can be written, it is measured again the next time."""
        with suppress(OSError):
            self.file.parent.mkdir(parents=True, exist_ok=True)
            store.write_kept(self.file, json.dumps(data).encode())
