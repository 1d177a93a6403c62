"""Machine code of components on disk, so that another process, and other parameter values, compile nothing.

It is found by a digest of all that it follows from: the layout of the block, the kernels that they reach with what
these enclose, the import closures of their sources, and the versions of what compiles. The kernels alone do not depend on the
layout, and are kept by themselves (`kernel_cache`): the master of another scene, or a component with another mesh, is only linked.
"""

from __future__ import annotations

import inspect
import sys
import types
import zlib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from ...components.core import store
from ...components.core.kernel_sources import private_folder, sources_digest
from ..versions import version

VERSIONS = ("cosimo", "numpy", "numba", "llvmlite")


class _Unknown(Exception):
    """Something enclosed in a kernel of which there is no digest."""


def digest_of(
    identity: Iterable[Any], reached: Callable[[Any], Mapping[str, Any]], kernels: Iterable[Any], component: type
) -> str | None:
    """Digest of what machine code follows from; None where part of it is known to this process only.

    identity: texts and kernels. reached: the kernels that a function names. kernels: all functions that become part of the code.
    """
    known: dict[int, str] = {}

    def described(value: Any) -> str:
        if value is None or isinstance(value, bool | int | float | str):
            return repr(value)
        if isinstance(value, tuple):
            return f"({', '.join(map(described, value))})"
        if isinstance(value, type):
            return f"{value.__module__}.{value.__qualname__} {getattr(value, '_fields', '')}"
        function = getattr(value, "py_func", value)
        if not isinstance(function, types.FunctionType):
            raise _Unknown(type(value).__name__)
        if id(function) not in known:
            known[id(function)] = f"{function.__module__}.{function.__qualname__}"  # where it calls itself
            cells = tuple(cell.cell_contents for cell in function.__closure__ or ())
            parts = (known[id(function)], described(cells), *(n + described(k) for n, k in sorted(reached(function).items())))
            known[id(function)] = store.digest_of(*parts)
        return known[id(function)]

    functions = [getattr(k, "py_func", k) for k in kernels]
    try:
        parts = [described(part) for part in identity]
        parts += sorted(map(described, functions))
        files = {inspect.getfile(cls) for cls in component.__mro__[:-1]} | {f.__code__.co_filename for f in functions}
        parts.append(sources_digest(*sorted({__file__, *files})))
    except (_Unknown, OSError, TypeError, SyntaxError, ValueError):  # all but the first: no file, as in an interactive session
        return None
    parts += [sys.version, *(f"{name} {version(name)}" for name in VERSIONS)]
    return store.digest_of(*parts)


def _file(digest: str) -> Path | None:
    folder = private_folder("native")
    return None if folder is None else folder / f"{digest}.ll"


def load(digest: str) -> str | None:
    """The code of a digest; None where it is missing or damaged."""
    file = _file(digest)
    content = None if file is None else store.read_kept(file)
    return None if content is None else zlib.decompress(content).decode()


def save(digest: str, text: str) -> None:
    """Keep code by its digest; not done where nothing can be written."""
    if (file := _file(digest)) is not None:
        store.write_kept(file, zlib.compress(text.encode(), 1))
