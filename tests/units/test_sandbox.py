"""Foreign code in the sandbox of bubblewrap: which ways out hold, what a run says where there is no sandbox."""

from __future__ import annotations

import ctypes
import json
import os
import platform
import re
import shutil
import signal
import socket
import subprocess
from contextlib import ExitStack
from pathlib import Path

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.fmus.build import built
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.tests.commands import exit_code
from cosimo.tests.rest import at_rest
from cosimo.tests.scene_runs import finished
from cosimo.tests.units import escapes
from cosimo.tests.units.exchange_fmu import exchange_fmu

ROOT = Path(__file__).resolve().parents[2]


def refusal() -> str:
    """Why bubblewrap cannot start here; empty where it can."""
    if not shutil.which("bwrap"):
        return "bubblewrap is not installed"
    command = "bwrap --ro-bind / / --unshare-all --unshare-user --disable-userns --proc /proc true"
    started = subprocess.run(command.split(), capture_output=True, text=True)
    return "" if started.returncode == 0 else started.stderr


needs_bubblewrap = pytest.mark.skipif(bool(refusal()), reason=refusal())
# what gets out all the same; of a worker process without a sandbox what does not
OPEN = {
    "socket_it_may_read": "a socket file in a folder that the unit may read is as good as its own",
    "6_GB_of_three": "the limit of memory is one of each process, and there may be 64",
    "6_GB_memfds": "files in memory have a limit each, not together",
}
HELD_WITHOUT = {"child_stays", "type_into_terminal"}
ONLY_FOR_USERS = {"100_processes"}  # Linux does not count the processes of an administrator
# what the settings of a system may forbid to every process, or allow to an administrator alone
BY_SETTINGS = {
    "sysctl",
    "ptrace",
    "process_vm_readv",
    "process_vm_writev",
    "memory_of_run",
    "files_of_another",
    "memory_of_another",
}
BY_SETTINGS |= {"root_of_another", "compare_processes", "watch_process", "environment_of_another", "user_namespace", "mount"}


@pytest.fixture
def target(tmp_path, monkeypatch):
    """What the unit shall not reach; the file beside it may be read in the sandbox."""
    libc, folder, name = ctypes.CDLL(None), escapes.TARGET.parent, f"cosimo-test-{os.getpid()}"
    monkeypatch.setenv("COSIMO_TEST_SECRET", "a password")
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    folder.mkdir()
    for end in ("", "-2", "-4"):
        (folder / f"file{end}").write_text("x")
    (tmp_path / "secret").write_text("x")
    with ExitStack() as stack:
        stack.callback(shutil.rmtree, folder)
        victim = stack.enter_context(subprocess.Popen(["sleep", "600"], start_new_session=True))
        stack.callback(victim.kill)
        addresses = ("127.0.0.1", 0), "\0" + name, str(tmp_path / "socket"), str(folder / "socket")
        for address in addresses:
            kind = socket.AF_INET if isinstance(address, tuple) else socket.AF_UNIX
            server = stack.enter_context(socket.socket(kind))
            server.bind(os.path.relpath(address) if address[0] == "/" else address)
            server.listen()
            if kind == socket.AF_INET:
                port = server.getsockname()[1]
        segment, semaphore = libc.shmget(0, 4096, 0o1600), libc.semget(0, 1, 0o1600)
        stack.callback(libc.shmctl, segment, 0, None)
        stack.callback(libc.semctl, semaphore, 0, 0, None)
        shared = Path("/dev/shm", name)
        shared.write_text("x")
        stack.callback(shared.unlink)
        libc.syscall(240, name.encode(), os.O_CREAT | os.O_RDWR, 0o600, None)
        stack.callback(libc.syscall, 241, name.encode())
        key = libc.syscall(248, b"user", name.encode(), b"x", 1, -3)
        stack.callback(libc.syscall, 250, 9, key, -3)
        stack_of_victim = re.search(r"^([0-9a-f]+)-.*\[stack\]", Path(f"/proc/{victim.pid}/maps").read_text(), re.MULTILINE)
        reachable = {
            "victim": victim.pid,
            "run": os.getpid(),
            "address": int(stack_of_victim[1], 16),
            "file": str(folder / "file"),
            "secret": str(tmp_path / "secret"),
            "home": str(Path.home()),
            "in home": sorted(os.listdir(Path.home())),
            "port": port,
            "socket": str(tmp_path / "socket"),
            "queue": name,
            "segment": segment,
            "semaphore": semaphore,
            "key": key,
            "keyring": libc.syscall(250, 0, -3, 0),
        }
        escapes.TARGET.write_text(json.dumps(reachable))
        yield


def sleepers(seconds: str) -> list[int]:
    """Processes that sleep so long."""
    those = []
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if path.read_bytes().split(b"\0")[:2] == [b"sleep", seconds.encode()]:
                those.append(int(path.parent.name))
        except OSError:
            pass
    return those


@needs_bubblewrap
@pytest.mark.skipif(platform.machine() != "x86_64", reason="numbers of system calls are those of x86-64")
@pytest.mark.parametrize("isolation", ["restricted", "process"])
def test_which_ways_out_hold(isolation, target):
    unit = {"component": "cosimo.tests.units.escapes:Escapes", "isolation": isolation}
    result = finished(read_scene({"stop_time": 0.2, "units": {"u": unit}, "master": {"step": 0.1}}))
    out = {name for name in escapes.WAYS if result[f"u.way_{name}"][-1]}
    for kind, seconds in escapes.MARKERS.items():
        if not at_rest(lambda seconds=seconds: sleepers(seconds)):
            out -= {f"{kind}_stays"}
        for process in sleepers(seconds):
            os.kill(process, signal.SIGKILL)
    assert bool(result.info.units["u"].walls) == (isolation == "restricted")
    if isolation == "restricted":
        assert sorted(out - (ONLY_FOR_USERS if os.geteuid() == 0 else set())) == sorted(OPEN)
    else:
        assert sorted(out | BY_SETTINGS) == sorted(escapes.WAYS.keys() - HELD_WITHOUT)


def test_the_documentation_states_the_count():
    text = " ".join((ROOT / "docs" / "foreign-files.md").read_text().split())
    of = len(escapes.WAYS)
    assert (
        f"The sandbox blocks {of - len(OPEN)} of {of} escape attempts; a plain worker process blocks {len(HELD_WITHOUT)}," in text
    )
    for name in OPEN:
        assert f"`{name}`" in text


def test_without_bubblewrap_a_run_says_how_to_install_it(tmp_path, capsys, monkeypatch):
    path = tmp_path / "foreign.toml"
    path.write_text('units.m.component = "cosimo.tests.support:Mass"\nmaster.step = 0.01\nstop_time = 0.1\n')
    monkeypatch.setenv("PATH", str(tmp_path))
    end = exit_code("run", str(path), "--isolate", "-o", str(tmp_path / "out"))
    assert end == 2
    assert "apt install bubblewrap" in capsys.readouterr().err


@needs_bubblewrap
def test_the_option_is_for_foreign_code(tmp_path, capsys):
    end = exit_code("run", "mass-on-spring", "--isolate", "--dry-run")
    assert end == 2
    assert "all of whose units are components of the catalogue" in capsys.readouterr().err
    with pytest.raises(BadInput, match="an FMU or module:Class"):
        read_scene(
            {"stop_time": 1.0, "master": {"step": 0.1}, "units": {"p": {"component": "Pantograph", "isolation": "restricted"}}}
        )
    path = tmp_path / "foreign.toml"
    path.write_text(
        'units.m.component = "cosimo.tests.support:Mass"\nunits.m.time_limit = 30.0\nmaster.step = 0.01\nstop_time = 0.1\n'
    )
    assert exit_code("run", str(path), "--isolate", "-o", str(tmp_path / "out")) == 0
    info = json.loads((tmp_path / "out" / "run.json").read_text())
    assert info["scene"]["units"]["m"]["isolation"] == "restricted"
    assert info["scene"]["title"] == ""


@needs_bubblewrap
@pytest.mark.parametrize(
    "maker", [exchange_fmu, pytest.param(lambda: str(built("Pantograph")), marks=pytest.mark.full)], ids=["compiled", "pythonfmu"]
)
def test_fmus_in_the_sandbox(maker):
    """They are unpacked, loaded and stepped there; an FMU of pythonfmu brings an interpreter with it."""
    scene = {"stop_time": 0.02, "units": {"u": {"fmu": maker()}}, "master": {"step": 1e-3}}
    plain = run(read_scene(scene))
    walled = run(read_scene({**scene, "units": {"u": {**scene["units"]["u"], "isolation": "restricted"}}}))
    assert (plain.outcome, walled.outcome) == ("done", "done"), walled.message
    assert all(plain[name].tobytes() == walled[name].tobytes() for name in plain.columns)
