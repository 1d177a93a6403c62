"""Numbers, texts and arrays in a file with a digest that shows damage: checkpoints, and what a study has computed so far.

Nothing in such a file is ever executed, and nothing in it names a class.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import is_dataclass
from io import BytesIO
from pathlib import Path
from typing import IO, Any
from zipfile import ZIP_STORED, ZipFile

import numpy as np

from ..components.core.store import opened_trusted, replaced


class DamagedFile(ValueError):
    """The digest of a file does not fit its content."""


def write_verified(path: Path, content: Any) -> None:
    """Write plain data and arrays, a dataclass as the mapping of its fields; the file appears as a whole or not at all.

    Others may not write it: `read_verified` takes no file that they could have written. Raises `OSError`, and `TypeError` for any
    other object.
    """
    with replaced(path, "wb", private=True) as file:
        file.write(verified_bytes(content))


def verified_bytes(content: Any) -> bytes:
    """Plain data and arrays as bytes, with a digest that shows damage."""
    arrays: dict[str, np.ndarray] = {}
    arrays["text"] = np.frombuffer(json.dumps(_plain(content, arrays)).encode(), dtype=np.uint8)
    arrays["digest"] = np.frombuffer(content_digest(arrays), dtype=np.uint8)
    file = BytesIO()
    np.savez(file, **arrays)  # type: ignore[arg-type]
    return file.getvalue()


def read_verified(path: Path) -> Any:
    """What `write_verified` was given.

    Raises `OSError` for what cannot be read, `PermissionError` for what another user can have written, `ValueError` for what is none
    of its files, and for a damaged one `DamagedFile`.
    """
    with opened_trusted(path) as file:
        return _verified(file, str(path))


def verified_content(content: bytes) -> Any:
    """What `verified_bytes` was given; raises `ValueError` for other bytes, and `DamagedFile` for damaged ones."""
    return _verified(BytesIO(content), "what was given")


def _verified(file: IO[bytes], what: str) -> Any:
    try:
        arrays = _read_arrays(file)
    except OSError:
        raise
    except Exception:  # from anywhere: what NumPy and zipfile raise for damaged files is of many kinds
        arrays = {}
    if not {"text", "digest"} <= arrays.keys():
        raise ValueError(f"{what} holds no content with a digest")
    if arrays.pop("digest").tobytes() != content_digest(arrays):
        raise DamagedFile(what)
    return _arrayed(json.loads(arrays["text"].tobytes()), arrays)


def _read_arrays(content: IO[bytes]) -> dict[str, np.ndarray]:
    """The arrays of a file; of one that is compressed none, because cosimo compresses nothing and a small one may be huge."""
    with ZipFile(content) as archive:
        if any(member.compress_type != ZIP_STORED for member in archive.infolist()):
            return {}
    content.seek(0)
    with np.load(content, allow_pickle=False) as file:
        arrays = dict(file)  # a member that is no array comes as bytes
    return arrays if all(isinstance(array, np.ndarray) for array in arrays.values()) else {}


def content_digest(arrays: Mapping[str, np.ndarray]) -> bytes:
    """SHA-256 over names, types, shapes and bytes of arrays."""
    whole = hashlib.sha256()
    for name, array in sorted(arrays.items()):
        whole.update(repr((name, array.dtype.str, array.shape)).encode() + array.tobytes())
    return whole.digest()


# -- numbers and texts as they are, arrays and bytes beside the text, tuples and mappings as tagged mappings ------------------
def _plain(value: Any, arrays: dict[str, np.ndarray]) -> Any:
    if is_dataclass(value) and not isinstance(value, type):
        value = vars(value)
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, bytes | np.ndarray):
        name = f"array{len(arrays)}"
        arrays[name] = value if isinstance(value, np.ndarray) else np.frombuffer(value, dtype=np.uint8)
        return {"bytes" if isinstance(value, bytes) else "array": name}
    if isinstance(value, list):
        return [_plain(item, arrays) for item in value]
    if isinstance(value, tuple):
        return {"tuple": [_plain(item, arrays) for item in value]}
    if isinstance(value, Mapping):
        return {"mapping": [[_plain(key, arrays), _plain(item, arrays)] for key, item in value.items()]}
    raise TypeError(f"{type(value).__name__} {value!r} is neither number, text, array, list nor mapping")


def _arrayed(data: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    """What `_plain` was given."""
    if isinstance(data, list):
        return [_arrayed(item, arrays) for item in data]
    if not isinstance(data, dict):
        return data
    ((kind, content),) = data.items()
    if kind in ("array", "bytes"):
        return arrays[content] if kind == "array" else arrays[content].tobytes()
    if kind == "tuple":
        return tuple(_arrayed(item, arrays) for item in content)
    return {_arrayed(key, arrays): _arrayed(item, arrays) for key, item in content}
