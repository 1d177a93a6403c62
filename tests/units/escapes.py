"""Ways out of a worker process, tried by a unit: each has an output, which is 1 where the attempt succeeds.

The test leaves in `TARGET` what there is to reach: a victim process, files, sockets, memory and keys of its own. Nothing here
needs the rights of an administrator. Numbers of system calls are those of x86-64.
"""

from __future__ import annotations

import ctypes
import fcntl
import json
import mmap
import os
import resource
import signal
import socket
import struct
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from cosimo.components.core.component import Component
from cosimo.components.core.kernels import DONE
from cosimo.components.core.variables import input_, output

TARGET = Path(__file__).with_name("outside") / "target.json"
MARKERS = {"child": "3001.5", "daemon": "3002.5"}  # s that those sleep who shall outlive the run: they are known by this number
GB, CONT = 1 << 30, int(signal.SIGCONT)
LIBC = ctypes.CDLL(None, use_errno=True)
LIBC.syscall.restype = ctypes.c_long


def call(number: int, *arguments: Any) -> int:
    """A system call, with integers as long as registers; raises `OSError`."""
    result = LIBC.syscall(number, *(ctypes.c_long(a) if isinstance(a, int) else a for a in arguments))
    if result < 0:
        raise OSError(ctypes.get_errno(), "refused")
    return result


def _siginfo() -> bytes:
    return struct.pack("iii", CONT, 0, -1).ljust(128, b"\0")  # SI_QUEUE


def _owned_pipe(t: dict) -> None:
    fcntl.fcntl(os.pipe()[0], fcntl.F_SETOWN, t["victim"])


def _vector(address: int) -> bytes:
    return struct.pack("QQ", address, 8)


def _vm(number: int, t: dict) -> None:
    local, own = ctypes.create_string_buffer(8), ctypes.create_string_buffer(16)
    own.raw = _vector(ctypes.addressof(local))
    call(number, t["victim"], own, 1, ctypes.create_string_buffer(_vector(t["address"])), 1, 0)


def _perf(t: dict) -> None:
    attributes = struct.pack("IIQ", 1, 128, 1).ljust(40, b"\0") + struct.pack("Q", 1 << 5 | 1 << 6)  # software clock, user only
    call(298, ctypes.create_string_buffer(attributes.ljust(128, b"\0")), t["victim"], -1, -1, 0)


def _namespace(t: dict) -> None:
    call(272, 0x10020000)  # unshare: user and mount


def _mount(t: dict) -> None:
    with suppress(OSError):
        _namespace(t)
    call(165, b"none", str(Path(t["file"]).parent).encode(), b"tmpfs", 0, None)


def _connect(kind: int, address: Any) -> None:
    with socket.socket(kind) as one:
        one.connect(address)


def _message_queue(t: dict) -> None:
    call(240, t["queue"].encode(), 2, 0, None)


def _terminal(t: dict) -> None:
    fcntl.ioctl(os.open("/dev/tty", os.O_RDWR), 0x5412, b"x")  # TIOCSTI


def _privileges(t: dict) -> None:
    if LIBC.prctl(39, 0, 0, 0, 0):  # PR_GET_NO_NEW_PRIVS: programs with the rights of others do not get them
        raise PermissionError


def _secret(t: dict) -> None:
    os.environ["COSIMO_TEST_SECRET"]


def _sleeper(kind: str) -> None:
    if not os.fork():
        if kind == "daemon":
            os.setsid()
        if not os.fork():
            os.execvp("sleep", ["sleep", MARKERS[kind]])
        os._exit(0)


def _processes(t: dict) -> None:
    children = []
    try:
        for _ in range(100):
            if not (child := os.fork()):
                time.sleep(60.0)
                os._exit(0)
            children.append(child)
    finally:
        for child in children:
            os.kill(child, signal.SIGKILL)


def _memory(size: int) -> mmap.mmap:
    """Memory that is reserved, and not filled."""
    return mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | 0x4000)  # MAP_NORESERVE


def _memory_of_three(t: dict) -> None:
    read, write = os.pipe()
    for _ in range(3):
        if not os.fork():
            with suppress(OSError):
                kept = _memory(2 * GB)
                os.write(write, b"x")
                time.sleep(1.0)
                kept.close()
            os._exit(0)
    os.close(write)
    if len(os.read(read, 1) + os.read(read, 1) + os.read(read, 1)) < 3:
        raise MemoryError


def _memory_file(size: int) -> None:
    os.ftruncate(os.memfd_create("x"), size)


def _large_files(folder: Path, size: int, count: int) -> None:
    paths = [folder / f"cosimo-large-{k}" for k in range(count)]
    try:
        for path in paths:
            with open(path, "wb") as file:
                os.posix_fallocate(file.fileno(), 0, size)
    finally:
        for path in paths:
            path.unlink(missing_ok=True)


def _many_files(t: dict) -> None:
    with open("/dev/null") as file:
        for _ in range(1000):
            os.dup(file.fileno())


def _read_mail(path: str) -> None:
    with open(path, "rb") as file:
        file.read(1)


def _key(t: dict) -> None:
    call(250, 11, t["key"], ctypes.create_string_buffer(8), 8)  # KEYCTL_READ


def _new_key(t: dict) -> None:
    if call(250, 0, -3, 0) == t["keyring"]:  # its session's keyring is that of the run
        return
    raise PermissionError


def _home(t: dict) -> None:
    path = Path(t["home"]) / "cosimo-written-by-a-unit"
    path.write_text("x")
    path.unlink()


def _see_home(t: dict) -> None:
    if sorted(os.listdir(t["home"])) != t["in home"]:  # folders on the way to what may be read
        raise PermissionError


def _pidfd(t: dict) -> int:
    return call(434, t["victim"], 0)


WAYS: dict[str, Callable[[dict], Any]] = {
    "kill": lambda t: os.kill(t["victim"], CONT),
    "kill_run": lambda t: os.kill(t["run"], CONT),
    "killpg": lambda t: os.killpg(t["victim"], CONT),
    "tgkill": lambda t: call(234, t["victim"], t["victim"], CONT),
    "tkill": lambda t: call(200, t["victim"], CONT),
    "rt_sigqueueinfo": lambda t: call(129, t["victim"], CONT, _siginfo()),
    "rt_tgsigqueueinfo": lambda t: call(297, t["victim"], t["victim"], CONT, _siginfo()),
    "pidfd_send_signal": lambda t: call(424, _pidfd(t), CONT, None, 0),
    "signal_by_setown": _owned_pipe,
    "prlimit": lambda t: resource.prlimit(t["victim"], resource.RLIMIT_CORE, (0, 0)),
    "setpriority": lambda t: os.setpriority(os.PRIO_PROCESS, t["victim"], 5),
    "ioprio_set": lambda t: call(251, 1, t["victim"], 3 << 13),
    "affinity": lambda t: os.sched_setaffinity(t["victim"], {0}),
    "scheduler": lambda t: os.sched_setscheduler(t["victim"], os.SCHED_BATCH, os.sched_param(0)),
    "ptrace": lambda t: call(101, 0x4206, t["victim"], None, None),
    "process_vm_readv": lambda t: _vm(310, t),
    "process_vm_writev": lambda t: _vm(311, t),
    "memory_of_another": lambda t: _read_mail(f"/proc/{t['victim']}/auxv"),
    "memory_of_run": lambda t: os.open(f"/proc/{t['run']}/mem", os.O_RDWR),
    "environment_of_another": lambda t: _read_mail(f"/proc/{t['victim']}/environ"),
    "root_of_another": lambda t: os.listdir(f"/proc/{t['victim']}/root"),
    "files_of_another": lambda t: call(438, _pidfd(t), 0, 0),
    "compare_processes": lambda t: call(312, os.getpid(), t["victim"], 1, 0, 0),
    "watch_process": _perf,
    "oom_of_another": lambda t: Path(f"/proc/{t['victim']}/oom_score_adj").write_text("1000"),
    "see_processes": lambda t: os.stat(f"/proc/{t['victim']}"),
    "write": lambda t: Path(t["file"]).write_text("y"),
    "append_by_proc": lambda t: os.open(f"/proc/self/root{t['file']}", os.O_APPEND | os.O_WRONLY),
    "truncate": lambda t: os.truncate(t["file"], 0),
    "chmod": lambda t: os.chmod(t["file"], 0o600),
    "chown": lambda t: os.chown(t["file"], os.getuid(), os.getgid()),
    "utimensat": lambda t: os.utime(t["file"], (1, 1)),
    "setxattr": lambda t: os.setxattr(t["file"], "user.x", b"y"),
    "link": lambda t: os.link(t["file"], t["file"] + "-link"),
    "symlink": lambda t: os.symlink("x", t["file"] + "-symlink"),
    "mkdir": lambda t: os.mkdir(t["file"] + "-folder"),
    "mkfifo": lambda t: os.mkfifo(t["file"] + "-fifo"),
    "rename": lambda t: os.rename(t["file"] + "-2", t["file"] + "-3"),
    "unlink": lambda t: os.unlink(t["file"] + "-4"),
    "read_file": lambda t: _read_mail(t["secret"]),
    "read_home": _see_home,
    "write_home": _home,
    "sysctl": lambda t: os.open("/proc/sys/kernel/core_pattern", os.O_WRONLY),
    "secret_of_environment": _secret,
    "user_namespace": _namespace,
    "mount": _mount,
    "tcp": lambda t: _connect(socket.AF_INET, ("127.0.0.1", t["port"])),
    "abstract_socket": lambda t: _connect(socket.AF_UNIX, "\0" + t["queue"]),
    "hidden_socket": lambda t: _connect(socket.AF_UNIX, t["socket"]),
    "socket_it_may_read": lambda t: _connect(socket.AF_UNIX, str(Path(t["file"]).with_name("socket"))),
    "shared_memory": lambda t: call(30, t["segment"], None, 0),
    "posix_memory": lambda t: _read_mail("/dev/shm/" + t["queue"]),
    "semaphores": lambda t: call(66, t["semaphore"], 0, 12, 0),
    "message_queue": _message_queue,
    "key": _key,
    "keyring": _new_key,
    "type_into_terminal": _terminal,
    "gain_privileges": _privileges,
    "child_stays": lambda t: _sleeper("child"),
    "daemon_stays": lambda t: _sleeper("daemon"),
    "100_processes": _processes,
    "1000_files": _many_files,
    "6_GB": lambda t: _memory(6 * GB),
    "6_GB_of_three": _memory_of_three,
    "6_GB_memfd": lambda t: _memory_file(6 * GB),
    "6_GB_memfds": lambda t: [_memory_file(GB) for _ in range(6)],
    "large_file": lambda t: _large_files(Path(os.environ["TMPDIR"]), 5 * GB // 4, 1),
    "disk": lambda t: _large_files(Path(os.environ["TMPDIR"]), GB // 4, 5),
    "shared_disk": lambda t: _large_files(Path("/dev/shm"), GB // 8, 1),
}


def tried(way: Callable[[dict], Any], target: dict) -> float:
    """1 where an attempt succeeds, which a child makes."""
    if not (child := os.fork()):
        try:
            way(target)
        except BaseException:
            os._exit(0)
        os._exit(1)
    end = time.monotonic() + 20.0
    while time.monotonic() < end:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return float(os.waitstatus_to_exitcode(status) == 1)
        time.sleep(1e-3)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return 0.0


class Attempts(Component):
    """Tries all ways in its first step."""

    driven = input_(0.0, "1", "any number")

    def _initialize(self, t: float) -> int:
        self.x = np.zeros(len(WAYS))
        return DONE

    def _step(self, t: float, h: float) -> int:
        if t == 0.0:
            target = json.loads(TARGET.read_text())
            self.x[:] = [tried(way, target) for way in WAYS.values()]
        self.refresh()
        return DONE

    def _outputs(self, t: float) -> None:
        self.y[:] = self.x


Escapes = type("Escapes", (Attempts,), {f"way_{n}": output("1", f"1: {n} worked") for n in WAYS} | {"__module__": __name__})
