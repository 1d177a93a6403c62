"""What a user at a terminal meets: grouped help, whole names, a closed pipe, a fault in a kernel of their own, nothing left behind."""

import errno
import os
import signal
import subprocess
import sys
import time

import pytest
from cosimo.orchestrator.cli.common import GROUPS, app, first_sentence, print_table
from cosimo.tests.commands import exit_code
from typer.main import get_command

MODULE = """
from cosimo import DONE, OdeComponent, kernel, ode_kernels, output, parameter

class Spring(OdeComponent):
    stiffness = parameter(1.0, "N/m", "stiffness")
    substep = parameter(1e-3, "s", "longest internal step")
    displacement = output("m", "displacement")

    def states(self):
        return 1

@kernel
def start(t, s, p, e):
    s.x[0] = 1.0
    return DONE

@kernel
def derivatives(t, x, u, dx, s, p, e):
    dx[0] = -p.stifness * x[0]

@kernel
def outputs(t, s, p, e):
    s.y[0] = s.x[0]
    return DONE

Spring.kernels = ode_kernels(__name__, start=start, derivatives=derivatives, outputs=outputs)
"""
SCENE = 'stop_time = 0.1\n[units]\none = { component = "misspelt_spring:Spring" }\n[master]\nstep = 0.05\n'


def started(*arguments, **more):
    """The command in a process of its own."""
    program = [sys.executable, "-c", "from cosimo.orchestrator.cli import main; main()", *arguments]
    return subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more)


def test_every_command_is_in_a_group_with_a_whole_sentence(capsys):
    exit_code("--help")
    text = " ".join(capsys.readouterr().out.split())
    commands = get_command(app).commands
    assert {name for names in GROUPS.values() for name in names} >= {*commands}
    assert "Others:" not in text
    for command in commands.values():
        assert first_sentence(command.help) in text
        assert first_sentence(command.help).endswith(".")


@pytest.mark.parametrize("width", ["40", "60", "200"])
def test_names_are_never_cut(width, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", width)
    monkeypatch.setattr("cosimo.orchestrator.cli.common.output_width", lambda: int(width))
    name = "dropper_slackening.a_rather_long_name[12]"
    print_table("", ("name", "text"), [(name, "what it is, in several words that do not fit"), ("short", 1.0)])
    shown = capsys.readouterr().out
    assert "…" not in shown
    assert name in "".join(c for c in shown if c not in "│┃ \n").replace("whatitis,", "") or int(width) < 2 * len(name)


def test_numbers_and_words_stay_whole_beside_a_long_name(monkeypatch, capsys):
    monkeypatch.setattr("cosimo.orchestrator.cli.common.output_width", lambda: 80)
    rows = [("iterative, quadratic, substeps x 4, and more", "0.0025", "0.00846 %", "0.00247 s", "56000", "time, work", "")]
    print_table("", ("setting", "size", "error", "CPU time", "calls", "on the front of", ""), rows)
    shown = capsys.readouterr().out
    assert max(map(len, shown.splitlines())) <= 80
    cells = {cell.strip() for line in shown.splitlines() for cell in line.split("│")}
    assert cells >= {"0.0025", "0.00846 %", "0.00247 s", "56000"}
    words = {word for cell in cells for word in cell.split()}
    assert words >= {"iterative,", "quadratic,", "substeps", "time,", "work"}


def test_columns_that_no_row_fills_are_left_out(capsys):
    print_table("", ("name", ""), [("a", "")])
    assert "│ a    │\n" in capsys.readouterr().out


def test_a_closed_pipe_ends_a_command_quietly():
    process = started("list", "--json")
    assert process.stdout.readline()
    process.stdout.close()
    assert process.wait(60) == 128 + signal.SIGPIPE
    assert process.stderr.read() == ""


def test_a_fault_in_a_kernel_is_one_message_and_leaves_nothing(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path])
    (tmp_path / "misspelt_spring.py").write_text(MODULE)
    (tmp_path / "scene.toml").write_text(SCENE)
    assert exit_code("run", str(tmp_path / "scene.toml"), "--in-process", "-o", str(tmp_path / "out")) == 2
    message = capsys.readouterr().err
    assert len(message.splitlines()) == 1
    assert "misspelt_spring.py:19: Numba cannot compile this kernel: Unknown attribute 'stifness'" in message
    assert "Did you mean 'stiffness'" in message
    assert not (tmp_path / "out").exists()


@pytest.mark.full
@pytest.mark.skipif(os.name == "nt", reason="POSIX signals")
@pytest.mark.parametrize("after", [1.0, 1.6, 2.2])
def test_an_interrupt_is_answered_before_a_run_starts_and_in_runs_of_a_study(after, tmp_path):
    process = started("validate", "en50318-2002", "--in-process", "-o", str(tmp_path / "out"))
    time.sleep(after)
    process.send_signal(signal.SIGINT)
    assert process.wait(60) == 130
    assert "stopped by SIGINT" in process.stderr.read()


def test_open_wants_a_report(tmp_path, capsys, monkeypatch):
    (tmp_path / "report.html").write_text("<p>")
    opened = []
    monkeypatch.setattr("webbrowser.open", lambda address: opened.append(address) or True)
    exit_code("open", tmp_path)
    assert opened == [(tmp_path / "report.html").as_uri()]
    assert exit_code("open", str(tmp_path / "nothing")) == 2
    assert "report.html" in capsys.readouterr().err


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT])
def test_a_full_disk_is_no_bad_input(number, tmp_path, monkeypatch, capsys):
    """Exit code 3, wherever the disk is full: here where a directory is reserved, and in the drawing of a scene."""

    def full(*_args, **_keywords):
        raise OSError(number, os.strerror(number))

    for place in ("Path.mkdir", "Path.write_text"):
        with monkeypatch.context() as patch:
            patch.setattr(f"pathlib.{place}", full)
            end = exit_code("new", "component", "Foo", "-o", str(tmp_path / "out"))
        assert end == 3
        assert os.strerror(number) in capsys.readouterr().err


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such names")
def test_an_output_whose_name_is_no_text_is_one_message(tmp_path, capsys):
    assert exit_code("run", "mass-on-spring", "--in-process", "-o", os.fsdecode(bytes(tmp_path) + b"/b\xffad")) == 2
    assert "expected a name in UTF-8" in capsys.readouterr().err
