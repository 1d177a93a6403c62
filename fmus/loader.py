"""How an FMU finds its own code: the head of every generated slave script, and the place of the caches.

All FMUs made with pythonfmu share one interpreter, and a host may have its own copy of a package. So an FMU's code is one
package with a name of its own, bundle_<digest>, imported without `sys.path`, from a folder that stays the same. Machine code is
kept by the contents of the sources and shared between such packages.
"""

import atexit
import contextlib
import ctypes
import filecmp
import gc
import glob
import importlib
import importlib.util
import os
import shutil
import sys
import tempfile

from ..components.core.folders import cache_root, trusted


def same_sources(one, other):
    """Whether every source file below `one` is below `other`, too, byte for byte."""
    for folder, _, files in os.walk(one):
        for file in (f for f in files if f.endswith(".py")):
            copy = os.path.join(other, os.path.relpath(folder, one), file)
            if not os.path.isfile(copy) or not filecmp.cmp(os.path.join(folder, file), copy, shallow=False):
                return False
    return True


def stable_copy(source):
    """A copy of the folder `source` in the cache, made if it is missing or damaged; `source` itself where that fails."""
    target = os.path.join(cache_root(), "bundles", os.path.basename(source))
    try:
        if not same_sources(source, target):
            os.makedirs(os.path.dirname(target), exist_ok=True)
            with tempfile.TemporaryDirectory(dir=os.path.dirname(target), ignore_cleanup_errors=True) as fresh:
                shutil.copytree(source, os.path.join(fresh, "new"), ignore=shutil.ignore_patterns("__pycache__"))
                for folder, _, files in os.walk(os.path.join(fresh, "new")):  # a host may unpack for everybody to write
                    os.chmod(folder, 0o700)
                    for file in files:
                        os.chmod(os.path.join(folder, file), 0o600)
                if os.path.exists(target):
                    os.replace(target, os.path.join(fresh, "damaged"))
                os.replace(os.path.join(fresh, "new"), target)
    except OSError:  # not writable, or another process was quicker
        pass
    return target if private(target) and same_sources(source, target) else source


def private(target):
    """Whether nobody else may write there, or put another folder in its place: what lies in it, byte code too, is executed."""
    above = os.path.dirname(target)
    below = [os.path.join(folder, name) for folder, folders, files in os.walk(target) for name in (*folders, *files)]
    try:
        return all(trusted(os.stat(path)) for path in (os.path.dirname(above), above, target, *below))
    except OSError:
        return False


def load_package(folder):
    """Import the folder as a top-level package of its own name; at once if that has been done."""
    name = os.path.basename(folder)
    if name not in sys.modules:
        copy = stable_copy(folder)
        spec = importlib.util.spec_from_file_location(name, os.path.join(copy, "__init__.py"), submodule_search_locations=[copy])
        assert spec is not None
        assert spec.loader is not None
        module = sys.modules[name] = importlib.util.module_from_spec(spec)
        try:
            spec.loader.exec_module(module)
        except DAMAGED:
            drop_byte_code(copy)
            spec.loader.exec_module(module)
    return name


# what reading damaged byte code raises; the sources are known to be whole
DAMAGED = (EOFError, ValueError, TypeError, ImportError)


def drop_byte_code(copy):
    """Let a package be compiled anew from its sources."""
    for folder, _, _ in os.walk(copy):
        if os.path.basename(folder) == "__pycache__":
            shutil.rmtree(folder, ignore_errors=True)


def import_part(module, fmu):
    """A module of an FMU's package; the message of the `ImportError` says what the host's Python lacks, for the host's log."""
    try:
        try:
            return importlib.import_module(module)
        except DAMAGED:
            drop_byte_code(os.path.dirname(str(sys.modules[module.partition(".")[0]].__file__)))
            return importlib.import_module(module)
    except ModuleNotFoundError as error:
        missing = (error.name or str(error)).partition(".")[0]
        version = ".".join(map(str, sys.version_info[:2]))
        raise ImportError(
            f"{fmu} needs {missing}, which Python {version} of this host ({sys.prefix}) has not. "
            f"Install it there: python{version} -m pip install {missing}"
        ) from None


def leave_path(script):
    """Take back the entry of `sys.path` that pythonfmu makes at every instantiation; returns it, or nothing."""
    if sys.path and os.path.isfile(os.path.join(sys.path[0], script)):
        return sys.path.pop(0)
    return ""


def keep(namespace):
    """Give the namespace of the script one more reference: pythonfmu 0.7 releases one it does not own, each time."""
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(namespace))


def end_in_order(resources):
    """Let pythonfmu's library in this FMU drop its interpreter state before the process ends.

    On Linux its destructors run in the wrong order: the state is freed by one and released again by the next, into memory
    that may have another owner by then ("corrupted double-linked list", "free(): corrupted unsorted chunks" at exit).

    Objects that are left are not searched for cycles then: the last collection of the interpreter frees modules of SciPy and
    ends in a segmentation fault in the allocator (both bearings with SciPy, in a host in C with a preloaded libpython).
    """
    libraries = () if sys.platform == "win32" else glob.glob(os.path.join(resources, "..", "binaries", "*", "*.so"))
    for library in set(map(os.path.realpath, libraries)) - _ENDED:
        _ENDED.add(library)
        with contextlib.suppress(OSError, AttributeError):  # another version of pythonfmu's library
            atexit.register(ctypes.PyDLL(library).finalizePythonInterpreter)
            atexit.register(gc.freeze)


_ENDED: set[str] = set()
