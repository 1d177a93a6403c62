"""What is printed can be seen: control characters of foreign texts as text, in any encoding; what cannot be a file is refused."""

import errno
import os
import socket
import subprocess
import sys

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator import cli
from cosimo.orchestrator.cli.common import fail, print_table, shown_output, warn
from cosimo.tests.commands import exit_code

ESCAPE = "\x1b]0;owned\x07\u202e[red]title[/red]"
SHOWN = r"\x1b]0;owned\x07\u202e[red]title[/red]"
FOREIGN = "a warning\ncosimo: done\n  log: x"


WAYS = {
    "a line": lambda: print(ESCAPE),
    "a title": lambda: print_table(ESCAPE, ("a",), [("b" * 60,)]),
    "a header": lambda: print_table("", (ESCAPE,), [("b",)]),
    "a cell": lambda: print_table("", ("a",), [(ESCAPE,)]),
    "a warning": lambda: warn([ESCAPE]),
    "a message": lambda: fail(ESCAPE),
}


@pytest.mark.parametrize("way", WAYS)
def test_foreign_text_is_visible_wherever_it_is_printed(way, capsys):
    with shown_output():
        WAYS[way]()
    shown = "".join(capsys.readouterr())
    assert SHOWN in shown
    assert "\x1b" not in shown


@pytest.mark.parametrize("way", [lambda: warn([FOREIGN]), lambda: fail(FOREIGN)], ids=["warning", "message"])
def test_no_line_of_foreign_text_begins_as_a_message_does(way, capsys):
    way()
    lines = capsys.readouterr().err.splitlines()
    assert [line for line in lines if line.startswith("cosimo:")] == lines[:1]
    assert lines[1:] == ["  cosimo: done", "  log: x"]


def test_a_title_of_a_scene_is_text(tmp_path, capsys):
    path = tmp_path / "s.toml"
    title = '"\\u001b]0;owned\\u0007[red]title[/red]"'
    path.write_text(f'title = {title}\nstop_time = 0.1\nmaster.step = 0.01\nunits.m.component = "cosimo.tests.support:Mass"\n')
    for command in (("show", path), ("run", path, "--in-process")):
        assert exit_code(*command) == 0
        out = capsys.readouterr().out
        assert r"\x1b]0;owned\x07[red]title[/red]" in out
        assert "\x1b" not in out


@pytest.mark.skipif(os.name == "nt", reason="pipes of POSIX")
@pytest.mark.parametrize("command", [("run",), ("show",), ("check",), ("railway", "fit-pantograph")])
def test_a_pipe_a_device_or_a_socket_is_refused_at_once(command, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.toml")
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind("socket.fmu")
        for place in ("pipe.toml", "socket.fmu", "/dev/zero"):
            assert exit_code(*command, place) == 2
            assert (
                capsys.readouterr().err == f"cosimo: {place!r}: got a pipe, a device or a socket, expected a file or a folder\n"
            )


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EACCES])
def test_a_full_disk_is_no_bad_input_whatever_the_message_says(number, monkeypatch):
    def unpack(arguments):
        try:
            raise OSError(number, os.strerror(number))
        except OSError as error:
            raise BadInput("units.u", f"it cannot be unpacked: {error}", "a sound FMU file") from None

    monkeypatch.setattr(cli, "app", unpack)
    assert exit_code() == (2 if number == errno.EACCES else 3)


@pytest.mark.skipif(os.name == "nt", reason="names that are no UTF-8")
def test_any_encoding_and_any_name(tmp_path):
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "LC_ALL": "C"}
    command = [
        os.fsencode(sys.executable),
        b"-m",
        b"cosimo.orchestrator.cli",
        b"show",
        os.fsencode(tmp_path) + b"/n\xff\xc3\xb6.toml",
    ]
    done = subprocess.run(command, env=environment, capture_output=True)
    assert done.returncode == 2, done.stderr
    assert b"Traceback" not in done.stderr
