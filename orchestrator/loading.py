"""What files from anywhere may ask for, and one net for all that goes wrong while they are read."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import PurePosixPath
from typing import Any
from zipfile import ZipFile

from ..components.core.errors import BadInput

MOST_TOML = 1 << 24  # bytes of a scene file
MOST_XML = 1 << 26  # bytes of an FMU's model description
MOST_VARIABLES = 100_000  # of an FMU; 300 000 take 0.9 GB and a minute
MOST_ELEMENTS = 1_000_000  # of all arrays of an FMU
MOST_REFERENCE = 2**32 - 1  # fmi2ValueReference and fmi3ValueReference are unsigned and have 32 bits
MOST_MEMBERS = 100_000  # files in an archive
MOST_UNPACKED = 1 << 33  # bytes of an archive's files
MOST_INSIDE = 1 << 28  # bytes of an FMU inside of an .ssp file, which is read as a whole
RATIO, RATIO_FROM = 200, 1 << 28  # deflate packs text 5 to 20 times; more than this, from this many bytes on, is made to do harm
MOST_FILES = 1000  # scene files that a scene is made of
DEEPEST = 100  # tables and lists inside one another

log = logging.getLogger("cosimo")


@contextmanager
def loading(where: str, expected: str = "a file that can be read") -> Iterator[None]:
    """All that goes wrong inside becomes one `BadInput` with the place; the traceback goes to the log "cosimo"."""
    try:
        yield
    except BadInput:
        raise
    except RecursionError:
        raise BadInput(where, "a content nested too deeply", f"at most {DEEPEST} levels") from None
    except MemoryError:
        raise BadInput(where, "a content that the memory does not hold", expected) from None
    except Exception as error:  # of zlib, zipfile, lxml, Unicode, numbers ...: what libraries raise for damage is of many kinds
        log.debug("reading %s", where, exc_info=True)
        raise BadInput(where, f"a content that cannot be read ({type(error).__name__}: {error})", expected) from None


def check_values(data: Any, where: str) -> None:
    """Raises `BadInput` for tables and lists nested deeper than `DEEPEST`, and for integers that no variable can hold."""
    level = [data]
    for _ in range(DEEPEST):
        inside = [inner for item in level for inner in (item.values() if isinstance(item, Mapping) else item)]
        if wide := next((v for v in inside if isinstance(v, int) and not -(2**64) < v < 2**64), None):
            raise BadInput(where, f"an integer of {wide.bit_length()} bits", "at most 64 bits", "Write large numbers as 1e30.")
        level = [inner for inner in inside if isinstance(inner, Mapping | list | tuple)]
        if not level:
            return
    raise BadInput(where, f"tables and lists nested more than {DEEPEST} deep", f"at most {DEEPEST} levels")


def check_archive(archive: ZipFile, where: str) -> int:
    """Bytes that an archive unpacks to, by its directory; `BadInput` for one that is made to fill disk or memory."""
    members = archive.infolist()
    size, packed = sum(m.file_size for m in members), sum(m.compress_size for m in members)
    folders = {str(parent) for m in members for parent in PurePosixPath(m.filename + "x" * m.is_dir()).parents}
    if both := [m.filename for m in members if not m.is_dir() and str(PurePosixPath(m.filename)) in folders]:
        raise BadInput(where, f"an archive in which {both[0]!r} is a file and a folder", "one of the two")
    if len(members) > MOST_MEMBERS:
        raise BadInput(where, f"an archive of {len(members)} files", f"at most {MOST_MEMBERS}")
    if size > MOST_UNPACKED:
        raise BadInput(where, f"an archive that unpacks to {size} bytes", f"at most {MOST_UNPACKED}")
    if size > RATIO_FROM and size > RATIO * packed:
        raise BadInput(where, f"an archive that unpacks from {packed} to {size} bytes", f"at most {RATIO} times as many")
    return size
