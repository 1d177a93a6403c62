"""Numbers, texts and arrays as bytes (msgpack): saved states, messages of worker processes, what a study has computed so far.

Nothing in such bytes is ever executed, and nothing in them names a class. A digest before them shows damage of a file.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import msgpack
import numpy as np

from ..components.core.store import opened_trusted, replaced

MARK = b"cosimo data 1\n"  # at the start of a file
START = len(MARK) + hashlib.sha256().digest_size
ARRAY, TUPLE, LARGE = range(3)  # extension types: also a whole number of more than 64 bits


class DamagedFile(ValueError):
    """The digest of a file does not fit its content."""


def packed(data: Any) -> bytes:
    """Plain data and arrays as bytes, a dataclass as the mapping of its fields. Raises `TypeError` for any other object."""
    return msgpack.packb(data, default=_plain, strict_types=True)


def _plain(value: Any) -> Any:
    """What msgpack has no form for, in one that it has."""
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        return msgpack.ExtType(ARRAY, packed([value.dtype.str, [*value.shape], value.tobytes()]))
    if isinstance(value, np.generic):
        return value.item()
    if type(value) is int:
        return msgpack.ExtType(LARGE, str(value).encode())
    if isinstance(value, tuple):
        return msgpack.ExtType(TUPLE, packed([*value]))
    if is_dataclass(value) and not isinstance(value, type):
        return vars(value)
    if isinstance(value, Mapping):
        return dict(value)
    kinds: tuple[Any, ...] = str, int, float, list
    for kind in kinds:
        if isinstance(value, kind):  # of a class of its own
            return kind(value)
    raise TypeError(f"{type(value).__name__} {value!r} is neither number, text, array, list nor mapping")


def unpacked(content: Any) -> Any:
    """What `packed` was given; raises an exception of some kind for other bytes."""
    return msgpack.unpackb(content, ext_hook=_extended, strict_map_key=False)


def _extended(kind: int, content: bytes) -> Any:
    if kind == LARGE:
        return int(content)
    values = unpacked(content)
    if kind == TUPLE:
        return tuple(values)
    dtype, shape, cells = values
    return np.frombuffer(cells, dtype=dtype).reshape(shape).copy()


def write_verified(path: Path, content: Any) -> None:
    """Write plain data and arrays, see `packed`; the file appears as a whole or not at all.

    Others may not write it: `read_verified` takes no file that they could have written. Raises `OSError`, and `TypeError`.
    """
    with replaced(path, "wb", private=True) as file:
        file.write(verified_bytes(content))


def verified_bytes(content: Any) -> bytes:
    """Plain data and arrays as bytes, with a digest that shows damage."""
    data = packed(content)
    return MARK + hashlib.sha256(data).digest() + data


def read_verified(path: Path) -> Any:
    """What `write_verified` was given.

    Raises `OSError` for what cannot be read, `PermissionError` for what another user can have written, `ValueError` for what is none
    of its files, and for a damaged one `DamagedFile`.
    """
    with opened_trusted(path) as file:
        return verified_content(file.read())


def verified_content(content: bytes) -> Any:
    """What `verified_bytes` was given; raises `ValueError` for other bytes, and `DamagedFile` for damaged ones."""
    if not content.startswith(MARK):
        raise ValueError("no content with a digest")
    if hashlib.sha256(content[START:]).digest() != content[len(MARK) : START]:
        raise DamagedFile("its digest does not fit")
    try:
        return unpacked(memoryview(content)[START:])
    except Exception as error:  # from anywhere: somebody has made a digest for it
        raise ValueError(f"no data: {error}") from None
