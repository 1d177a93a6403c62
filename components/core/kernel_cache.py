"""Machine code on disk, kept by the contents of the sources that it was compiled from.

Numba's own cache looks at the file of a function, or at its time, and not at the files of the functions that are inlined into it:
an edit there goes unnoticed. Here the key is a digest of the import closure, so that touching a file costs nothing, an edit
recompiles what depends on it and nothing else, and a copy of the sources elsewhere finds the same machine code.

Each FMU made from Python has its sources in a package with a name of its own. Machine code of those with the same sources, and of
the components of cosimo itself, is shared. Its symbols keep the name of the package that compiled it: where two such packages are
in one process, symbols of one name are the same code. What belongs to a package by name is looked up in the one that loads.
"""

from __future__ import annotations

import io
import pickle
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from uuid import uuid4

from numba.core import environment
from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache, _CacheLocator
from numba.core.runtime.nrt import rtsys

from .compiler import OPTIONS, KernelDispatcher, callable_from_python
from .kernel_library import ADDRESS, KERNELS, PYTHON
from .kernel_sources import BUNDLE, packages, private_root, sources_digest
from .store import private, read_kept, write_kept

_PROCESS = uuid4().hex[:8]


class _Locator(_CacheLocator):
    """Tells Numba the folder and the freshness of a kernel."""

    def __init__(self, folder: Path, stamp: str):
        self._folder, self._stamp = folder, stamp

    def get_cache_path(self) -> str:
        return str(self._folder)

    def get_source_stamp(self) -> str:
        return self._stamp

    def get_disambiguator(self) -> str:
        return "kernel"


def own_module(module: str, package: str) -> str:
    """The module of components in a package in the place of that in another one."""
    first, dot, rest = module.partition(".")
    return f"{package}{dot}{rest}" if BUNDLE.fullmatch(first) and rest.startswith("components.") else module


class _Reader(pickle.Unpickler):
    """Reads what an FMU's package or another with the same sources has written; `package` is the one that reads."""

    def __init__(self, content: bytes, package: str):
        super().__init__(io.BytesIO(content))
        self._package = package

    def find_class(self, module, name):
        named = super().find_class(own_module(module, self._package), name)
        return self._environment if named is environment._rebuild_env else named

    def _environment(self, module, constants, name):
        return environment._rebuild_env(own_module(module, self._package), constants, name)


class _Files(IndexDataCacheFile):
    """Index and machine code of a kernel, each behind its digest; a damaged file counts as missing, and is written anew.

    Both are pickles, and one of them is machine code: nothing is looked at before the digest fits.

    Numba counts the files of a kernel. Processes that compile it for different arguments at once arrive at the same number, and
    the index of one then leads to the code of the other: here each process gives its files names of its own.
    """

    def __init__(self, cache_path: str, filename_base: str, source_stamp: str, package: str):
        super().__init__(cache_path, filename_base, source_stamp)
        self._package = package
        self._data_name_pattern = f"{filename_base}.{{number:d}}-{_PROCESS}.nbc"

    def _load_index(self):
        try:
            version, stamp, overloads = self._read(self._index_path)
        except Exception:  # missing, damaged, or of another version of this class
            return {}
        return overloads if (version, stamp) == (self._version, self._source_stamp) else {}

    def _save_index(self, overloads):
        self._write(self._index_path, (self._version, self._source_stamp, overloads))

    def _load_data(self, name):
        data = self._read(self._data_path(name))
        if self._package:
            data[1].modname = own_module(data[1].modname, self._package)
        return data

    def _save_data(self, name, data):
        self._write(self._data_path(name), data)

    def _read(self, path):
        content = read_kept(Path(path))
        if content is None:
            raise FileNotFoundError(path)
        return _Reader(content, self._package).load() if self._package else pickle.loads(content)

    def _write(self, path, data):
        write_kept(Path(path), self._dump(data))

    def load(self, key):
        for place in (key, (key, self._package)) if self._package else (key,):
            with suppress(Exception):
                if (data := super().load(place)) is not None:
                    return data
        return None

    def save(self, key, data):
        _, _, (code, _) = data[0]
        if self._package and f"{self._package}.".encode() in code:  # it makes objects of the package's classes
            key = key, self._package
        with suppress(OSError):  # a full disk: the machine code is at hand, the next process compiles again
            super().save(key, data)


@lru_cache(maxsize=1)
def load_array_functions() -> None:
    """Load what Numba knows of arrays, without SciPy's BLAS, for which it looks there: a seventh of the start of a process.

    A kernel that multiplies matrices has it loaded when it is compiled, and when it is called.
    """
    from numba.np import linalg

    if "numba.np.arraymath" in sys.modules or find_spec("scipy") is None or not hasattr(linalg, "ensure_blas"):
        return
    ensure = linalg.ensure_blas
    linalg.ensure_blas = lambda: None
    try:
        from numba.np import arraymath
    finally:
        linalg.ensure_blas = ensure
    arraymath.ensure_blas = ensure


SERVE = {PYTHON: (PYTHON,), ADDRESS: (ADDRESS, PYTHON, KERNELS), KERNELS: (KERNELS, ADDRESS, PYTHON)}  # who asks -> kinds of code


class KernelCache(FunctionCache):
    """The cache of one kernel; nothing is read before it is needed. files: sources that decide on the machine code.

    wanted: who asks for the code. Machine code that Python may call, or that has an address, serves kernels as well.
    """

    wanted = PYTHON

    def __init__(self, function, files: tuple[str, ...]):
        self._py_func, self._name, self._files = function, repr(function), files
        self._opened: FunctionCache | NullCache | None = None

    def _open(self):
        if self._opened is None:
            self._opened = NullCache()
            with suppress(OSError, SyntaxError, ValueError):  # a function of no file, as one of an interactive session
                if (root := private_root()) is not None:
                    self._opened = _OpenCache(self._py_func, root, sources_digest(*self._files))
        return self._opened

    @property
    def cache_path(self):
        return self._open().cache_path

    def load_overload(self, sig, target_context):
        cache = self._open()
        overload = None
        for cache.kind in SERVE[self.wanted]:
            overload = overload or cache.load_overload(sig, target_context)
        if overload is None:  # it will be compiled
            load_array_functions()
        return overload

    def save_overload(self, sig, data):
        cache = self._open()
        cache.kind = PYTHON if callable_from_python(data) else ADDRESS if data.library.finalized else KERNELS
        if (cache.kind, self.wanted) == (KERNELS, ADDRESS):
            return  # there will be machine code
        with suppress(OSError):
            cache.save_overload(sig, data)

    def enable(self):
        self._open().enable()

    def disable(self):
        self._open().disable()

    def flush(self):
        self._open().flush()


class _OpenCache(FunctionCache):
    """Numba's cache with the files above."""

    kind = PYTHON

    def __init__(self, function, root: Path, digest: str):
        self._py_func, self._name = function, repr(function)
        module = f"{function.__module__}"
        own, neutral = packages(module)
        package = root / neutral
        folder = package / f"{module.partition('.')[2] or 'module'}-{digest[:16]}"
        if not (private(package) and private(folder)):
            raise PermissionError(f"others may write {folder}")
        self._impl = object.__new__(self._impl_class)
        self._impl._lineno = function.__code__.co_firstlineno
        self._impl._locator = _Locator(folder, digest)
        name = function.__qualname__.replace(own, neutral)  # of one that is bound, it has the package in it
        self._impl._filename_base = self._impl.get_filename_base(name, getattr(sys, "abiflags", ""))
        self._cache_path = str(folder)
        self._cache_file = _Files(self._cache_path, self._impl.filename_base, digest, own if neutral != own else "")
        self.enable()

    def _index_key(self, sig, codegen):
        return self.kind, *super()._index_key(sig, codegen)

    def load_overload(self, sig, target_context):
        """The machine code for a signature, or None.

        It runs with Numba's runtime alone. Numba's own method first loads all that it can translate, which only a compilation
        needs and does itself: a fifth of the start of a process that compiles nothing.
        """
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)
        return None


def dispatcher_of(function: Callable[..., Any], files: tuple[str, ...], inline: bool) -> KernelDispatcher:
    """The compiler of a function. files: as of `KernelCache`.  inline: its instructions stand wherever a kernel calls it."""
    options = {"nopython": True, "boundscheck": None, **OPTIONS} | ({"forceinline": True} if inline else {})
    dispatcher = KernelDispatcher(function, targetoptions=options, pipeline_class=options.pop("pipeline_class"))
    dispatcher._cache = KernelCache(function, files)
    return dispatcher
