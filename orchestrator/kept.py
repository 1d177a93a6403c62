"""Results that were computed before, each in a file named by what it depends on: in the user's cache, or in a study's directory."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from ..components.core import store
from ..components.core.folders import cache_root
from .verified_file import packed, unpacked

T = TypeVar("T")


class Kept:
    """The place of one result. folder: of a study, or the name of a kind in the cache.  key: of `run.dependence.depends_on`."""

    def __init__(self, folder: str | Path, key: str):
        self.file = Path(cache_root(), folder) / key

    def read(self, record: type | None = None) -> Any:
        """What was written there; None where there is none, or it is damaged.

        Numbers, texts, arrays, lists and mappings; of a record, its dataclass, or that of the items of a list.
        """
        content = store.read_kept(self.file)
        return None if content is None else _restored(unpacked(content), record)

    def write(self, data: Any) -> None:
        """Keep plain data, arrays and dataclasses of them; where nothing can be written, it is computed again the next time."""
        with suppress(OSError):
            self.file.parent.mkdir(parents=True, exist_ok=True)
            store.write_kept(self.file, packed(data))

    def once(self, compute: Callable[[], T], record: type | None = None) -> T:
        """What is kept, or else `compute()`, which is kept."""
        with suppress(TypeError):  # a record of other fields
            if (kept := self.read()) is not None:
                return _restored(kept[0], record)
        value = compute()
        self.write([value])
        return value


def _restored(kept: Any, record: type | None) -> Any:
    if record is None or kept is None:
        return kept
    return [record(**one) for one in kept] if isinstance(kept, list) else record(**kept)
