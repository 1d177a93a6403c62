"""Walls around foreign code in a worker process: limits, no network, files to be read only.

Each is put up where the system offers it, and a run's record says which of them stand. Linux: rlimits, a network namespace,
libseccomp where it is installed, landlock from kernel 5.13 on. Elsewhere: the limits of POSIX, as far as the system keeps them.

Sources: man pages setrlimit(2), prctl(2), unshare(2), seccomp_rule_add(3) and landlock(7) of Linux; numbers of landlock's system
calls and rights from include/uapi/linux/landlock.h of Linux 6.
"""

from __future__ import annotations

import ctypes
import os
import pickle
import platform
import struct
import sys
from collections.abc import Mapping
from ctypes.util import find_library
from io import BytesIO
from typing import Any

from ...components.core.errors import BadInput, StepFailed
from .interface import SimulationEnded

MEMORY, FILES, FILE_SIZE = 4 << 30, 256, 1 << 30  # bytes of address space, open files, bytes of a file
ANSWER = 60.0  # s that an answer may take where the scene gives no limit
# what a library may need to know; all else of the environment, such as keys and passwords of services, stays outside
PASSED_ON = (
    "PATH",
    "LD_LIBRARY_PATH",
    "SYSTEMROOT",
    "LANG",
    "LC_ALL",
    "TZ",
    "COSIMO_CACHE",
    "XDG_CACHE_HOME",
    "NUMBA_CACHE_DIR",
    "NUMBA_DISABLE_JIT",
)
NO_NEW_PRIVS, NEW_USER, NEW_NET = 38, 0x10000000, 0x40000000
ALLOW, REFUSE = 0x7FFF0000, 0x00050000 | 1  # SCMP_ACT_ALLOW, SCMP_ACT_ERRNO(EPERM)
REFUSED = (
    "socket",
    "socketpair",
    "connect",
    "ptrace",
    "process_vm_readv",
    "process_vm_writev",
    "kill",
    "pidfd_send_signal",
    "pidfd_getfd",
    "mount",
    "umount2",
    "unshare",
    "setns",
    "bpf",
    "keyctl",
    "add_key",
    "io_uring_setup",
    "userfaultfd",
)
CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446
EXECUTE, WRITE, READ, READ_DIRECTORY, ALL = 1 << 0, 1 << 1, 1 << 2, 1 << 3, (1 << 13) - 1  # rights of landlock's ABI 1
TRUNCATE = 1 << 14  # from ABI 3 on, with REFER, 1 << 13, of ABI 2


def clean_environment(folder: str) -> dict[str, str]:
    """What a walled worker may know of the environment; its home is its own folder."""
    kept = {name: os.environ[name] for name in PASSED_ON if name in os.environ}
    return kept | {"HOME": folder, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}  # each thread reserves memory


def put_up(folder: str) -> list[str]:
    """Put up all walls that this system offers; `folder` stays writable. Returns the names of those that stand."""
    walls = _limits()
    if sys.platform != "linux":
        return walls
    libc = ctypes.CDLL(None, use_errno=True)
    library = find_library("seccomp")  # it writes a temporary file
    if libc.prctl(NO_NEW_PRIVS, 1, 0, 0, 0) == 0:
        walls.append("no new privileges")
    if libc.unshare(NEW_USER | NEW_NET) == 0:
        walls.append("network namespace")
    if library and _seccomp(ctypes.CDLL(library)):
        walls.append("system calls (seccomp)")
    if _landlock(libc, folder):
        walls.append("read-only files (landlock)")
    return walls


def _limits() -> list[str]:
    try:
        import resource
    except ImportError:  # Windows
        return []
    walls = []
    for name, kind, limit in (
        ("memory", "RLIMIT_AS", MEMORY),
        ("open files", "RLIMIT_NOFILE", FILES),
        ("size of files", "RLIMIT_FSIZE", FILE_SIZE),
        ("core", "RLIMIT_CORE", 0),
    ):
        try:
            resource.setrlimit(getattr(resource, kind), (limit, limit))
            walls.append(f"{name} {limit}" if limit else "no core files")
        except (OSError, ValueError, AttributeError):  # macOS refuses some
            pass
    return walls


def _seccomp(library: Any) -> bool:
    """Let the system calls in `REFUSED` fail with EPERM; one that the library does not know is passed by."""
    library.seccomp_init.restype = ctypes.c_void_p
    library.seccomp_init.argtypes = (ctypes.c_uint32,)
    for name, arguments in (
        ("seccomp_load", (ctypes.c_void_p,)),
        ("seccomp_release", (ctypes.c_void_p,)),
        ("seccomp_rule_add_array", (ctypes.c_void_p, ctypes.c_uint32, ctypes.c_int, ctypes.c_uint, ctypes.c_void_p)),
    ):
        getattr(library, name).argtypes = arguments
    context = library.seccomp_init(ALLOW)
    if not context:
        return False
    for name in REFUSED:
        number = library.seccomp_syscall_resolve_name(name.encode())
        if number >= 0:
            library.seccomp_rule_add_array(context, REFUSE, number, 0, None)
    stands = library.seccomp_load(context) == 0
    library.seccomp_release(context)
    return stands


def _landlock(libc: Any, folder: str) -> bool:
    """Files can be read and executed everywhere, and written in `folder` alone."""
    if platform.machine() not in ("x86_64", "aarch64"):  # whose numbers of system calls are those above
        return False
    abi = libc.syscall(CREATE_RULESET, None, ctypes.c_size_t(0), 1)
    if abi < 1:
        return False
    handled = ALL | (1 << 13 if abi >= 2 else 0) | (TRUNCATE if abi >= 3 else 0)
    attributes = struct.pack("=Q", handled)
    ruleset = libc.syscall(CREATE_RULESET, attributes, ctypes.c_size_t(len(attributes)), 0)
    if ruleset < 0:
        return False
    stands = True
    for place, rights in (("/", EXECUTE | READ | READ_DIRECTORY), (folder, handled), (os.devnull, READ | WRITE)):
        handle = os.open(place, os.O_PATH | os.O_CLOEXEC)
        rule = struct.pack("=Qi", rights, handle)
        stands = libc.syscall(ADD_RULE, ruleset, 1, rule, 0) == 0 and stands
        os.close(handle)
    stands = stands and libc.syscall(RESTRICT_SELF, ruleset, 0) == 0
    os.close(ruleset)
    return stands


class _Answers(pickle.Unpickler):
    """Reads plain data, arrays and the exceptions of this package, and imports nothing else: the other end may be hostile."""

    def find_class(self, module: str, name: str) -> Any:
        known = {kind.__name__: kind for kind in (BadInput, StepFailed, SimulationEnded)}
        if module == "builtins" and name in ("set", "frozenset", "complex", "bytearray", "slice", "range"):
            return super().find_class(module, name)
        if name in known and module == known[name].__module__:
            return known[name]
        if module.startswith("numpy") and name in ("ndarray", "dtype", "_reconstruct", "scalar", "_frombuffer"):
            return super().find_class(module, name)
        raise pickle.UnpicklingError(f"{module}.{name} is no part of an answer")


def read_answer(content: Any) -> Any:
    """An object that a worker has sent; raises `UnpicklingError` for what no answer holds."""
    return _Answers(BytesIO(content)).load()


def walls_of(units: Mapping[str, Any]) -> dict[str, list[str]]:
    """Names of the walls around units, by the name of the unit."""
    return {name: walls for name, unit in units.items() if (walls := getattr(unit, "walls", None))}
