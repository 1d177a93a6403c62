"""The sandbox of `isolation = "restricted"`: a worker process under bubblewrap, with limits of memory, processes and files.

Bubblewrap gives the worker namespaces of its own for processes, network, files, IPC and users, and drops all privileges. The
kernel ends every process of the sandbox with the first one. What the sandbox promises is what tests/units/test_sandbox.py shows.

Sources: man pages bwrap(1) of bubblewrap 0.8, setrlimit(2) and proc(5) of Linux.
"""

from __future__ import annotations

import ctypes
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from pathlib import Path

from ...components.core.errors import BadInput, visible
from ...components.core.folders import cache_root
from .folders import process_folder

ANSWER = 60.0  # s that an answer may take where the scene gives no limit
TEMPORARY, SHARED = 1 << 30, 64 << 20  # bytes of all files in /tmp, and in /dev/shm
LIMITS = {"AS": 4 << 30, "FSIZE": 1 << 30, "NOFILE": 256, "NPROC": 64, "CORE": 0}  # bytes, files, processes; see setrlimit(2)
KEYCTL, JOIN_SESSION_KEYRING = {"x86_64": 250, "aarch64": 219}, 1  # see keyctl(2)
INSTALL = (
    "Install bubblewrap: apt install bubblewrap, dnf install bubblewrap, or pacman -S bubblewrap. "
    'Without it isolation = "process" contains crashes, time and memory.'
)
# what a library may need to know; all else of the environment, such as keys and passwords of services, stays outside
PASSED_ON = ("PATH", "LD_LIBRARY_PATH", "LANG", "LC_ALL", "TZ", "NUMBA_CACHE_DIR", "NUMBA_DISABLE_JIT")
SYSTEM = ("/usr", "/bin", "/sbin", "/lib", "/lib32", "/lib64", "/nix/store")
SYSTEM_FILES = tuple(f"/etc/{name}" for name in ("ld.so.cache", "ld.so.conf", "ld.so.conf.d", "alternatives", "localtime"))
NAMESPACES = ("user", "pid", "net", "mnt", "ipc", "uts")  # in /proc/self/ns, see namespaces(7)
OWN_FOLDERS = ("/tmp", "/dev/shm")  # of the sandbox
OWN = ("user", "processes", "network", "files", "IPC", "host name")  # namespaces


# executed in the sandbox before any foreign code is: prints what is not as the sandbox promises, and that it has been there
PROOF = """
import os, sys
home, probe, *ours = sys.argv[1:]
open_to = [kind for kind, link in (one.split("=", 1) for one in ours) if os.readlink("/proc/self/ns/" + kind) == link]
try:
    os.close(os.open("/.cosimo", os.O_CREAT | os.O_WRONLY))
    os.unlink("/.cosimo")
    open_to.append("the folder /")
except OSError:
    pass
if home and os.access(home, os.W_OK):
    open_to.append("the home folder")
if probe and os.path.exists(probe):
    open_to.append("the run's temporary files")
print("proved", ", ".join(open_to))
"""
PROOF_TIME = 60.0  # s


def sandboxed(where: str, fmu: str) -> list[str]:
    """The start of a command line that runs the rest of it in the sandbox, in which an FMU, or else Python's path, can be read.

    Raises `BadInput` where bubblewrap is missing, cannot start or keeps nothing in.
    """
    program = shutil.which("bwrap")
    if program is None:
        raise BadInput(where, "'restricted' without the program bwrap", "bubblewrap on Linux", INSTALL)
    start = _command(program, fmu)
    if fault := _fault(program, tuple(_command(program, ""))):
        raise BadInput(where, f"'restricted' with {program}, which {fault}", "bubblewrap 0.8 or newer on Linux", INSTALL)
    return start


def _command(program: str, fmu: str) -> list[str]:
    options = (
        "--unshare-all --unshare-user --disable-userns --cap-drop ALL --die-with-parent --new-session --proc /proc --dev /dev"
    )
    temporary = f"--size {SHARED} --tmpfs /dev/shm --size {TEMPORARY} --tmpfs /tmp"
    places = [option for place in sorted(set(_readable(fmu))) for option in ("--ro-bind-try", place, place)]
    closing = "--remount-ro /proc --remount-ro /dev --remount-ro / --chdir /tmp --"
    return [program, *options.split(), *temporary.split(), *places, *closing.split()]


@lru_cache(maxsize=16)
def _fault(program: str, start: tuple[str, ...]) -> str:
    """What is wrong with a sandbox, "" where it holds: whatever program is called bwrap is tried before it is trusted."""
    kinds = [f"{kind}={os.readlink(f'/proc/self/ns/{kind}')}" for kind in NAMESPACES]
    home = str(Path.home())
    with tempfile.TemporaryDirectory(dir=process_folder()) as probe:
        seen = any(Path(probe).is_relative_to(place) for place in _readable(""))
        command = [*start, sys.executable, "-I", "-S", "-c", PROOF, "" if home in OWN_FOLDERS else home, "" if seen else probe]
        try:
            done = subprocess.run([*command, *kinds], capture_output=True, text=True, env=environment(), timeout=PROOF_TIME)
        except (OSError, subprocess.TimeoutExpired) as error:
            return f"does not answer ({type(error).__name__})"
    if done.returncode or not done.stdout.startswith("proved"):
        last = (done.stderr.strip().splitlines() or [f"it ends with code {done.returncode}"])[-1]
        return f"cannot start: {visible(last[:200])}"
    open_to = done.stdout.removeprefix("proved").strip()
    return f"keeps nothing in: the unit would have {visible(open_to)} of the system" if open_to else ""


def _readable(fmu: str) -> Iterator[str]:
    """Files and folders that the worker may read: the system's libraries, Python, this package, its cache, the foreign code.

    Of Python's path all but what holds the user's home, for a class of a module; the installed packages alone for an FMU.
    """
    yield from (*SYSTEM, *SYSTEM_FILES, sys.prefix, sys.base_prefix, str(Path(__file__).parents[2]), cache_root())
    yield from filter(os.path.isabs, os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep))
    if numba := os.environ.get("NUMBA_CACHE_DIR"):
        yield os.path.abspath(numba)
    for entry in map(os.path.abspath, sys.path):
        if Path(entry).name in ("site-packages", "dist-packages") if fmu else not Path.home().is_relative_to(entry):
            yield entry
    if fmu:
        yield os.path.abspath(fmu)


def environment() -> dict[str, str]:
    """What a worker in the sandbox may know of the environment; its home is the folder of temporary files."""
    passed_on = {name: os.environ[name] for name in PASSED_ON if name in os.environ}
    threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}  # each thread reserves memory
    return passed_on | threads | {"HOME": "/tmp", "COSIMO_CACHE": cache_root()}


def limit_resources(restricted: bool) -> None:
    """Limit this process before foreign code is loaded: to the machine's memory, or to `LIMITS`; raises `OSError`, `ValueError`.

    The memory of a worker that is not restricted is limited as far as the system can do that.
    """
    try:
        import resource
    except ImportError:  # Windows
        return
    if restricted:
        for kind, limit in LIMITS.items():
            resource.setrlimit(getattr(resource, f"RLIMIT_{kind}"), (limit, limit))
        if number := KEYCTL.get(platform.machine()):
            ctypes.CDLL(None).syscall(number, JOIN_SESSION_KEYRING, None)  # a new one, without the user's keys
        return
    with suppress(OSError, ValueError, AttributeError):  # macOS has other names and refuses some
        memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
        resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))
    with suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("1000")  # the kernel ends the worker, not the run, where memory is short


def walls() -> list[str]:
    """What stands around a worker that has started in the sandbox, as run.json lists it; nothing of this comes from the worker."""
    limits = [f"{kind} {limit}" for kind, limit in LIMITS.items()]
    return [f"bubblewrap: own {', '.join(OWN)}", f"/tmp {TEMPORARY}, /dev/shm {SHARED}", f"rlimits: {', '.join(limits)}"]
