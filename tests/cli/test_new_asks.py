"""`cosimo new` on a terminal: questions in words, wrong answers asked again, and the arguments for scripts."""

import os
import shlex
import subprocess
import sys

import pytest
from cosimo.orchestrator.cli import asked
from cosimo.orchestrator.cli.asked import QUESTIONS, arguments_of
from cosimo.tests.commands import exit_code

SUPPORTS = "position [m]\n" + "\n".join(str(50 * k) for k in range(11)) + "\n"


@pytest.fixture
def answering(monkeypatch, tmp_path):
    """A function that answers the next questions; they come to an end where no answer is left."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "supports.csv").write_text(SUPPORTS)
    left: list[str] = []

    def answer(prompt: str) -> str:
        print(prompt)
        if not left:
            raise EOFError
        return left.pop(0)

    monkeypatch.setattr("builtins.input", answer)
    monkeypatch.setattr(asked, "on_terminal", lambda: True)
    return lambda *answers: left.extend(answers)


def test_a_line_a_scene_and_a_case_are_asked_for(answering, tmp_path, capsys):
    answering("line", "", "supports.csv", "22", "kN", "", "18,5 kN", "18.5 kN", "", "")
    assert exit_code("new") == 0
    shown = capsys.readouterr().out
    assert "22 kN or N [kN]" in shown
    assert "Write 18.5, with a decimal point" in shown
    answering(
        "", "house", "", "supports.csv", "my-line.toml", "", "160", "m/h", "km/h", "1", "en5036", "en50367", "Line 7", "", "", ""
    )
    assert exit_code("new", "scene") == 0
    shown = capsys.readouterr().out
    assert "160 km/h or m/s" in shown
    assert "got a CSV table, expected the table of a line" in shown
    assert "Did you mean 'en50367'?" in shown
    assert "How many" in shown
    assert "Distance" not in shown
    answering("", "my-scene.toml", "120, 160 km/h", "", "", "Run 7", "", "A. Author", "")
    assert exit_code("new", "case") == 0
    commands = [line for line in capsys.readouterr().out.splitlines() if line.startswith("Without questions: ")]
    written = (tmp_path / "my-case.toml").read_bytes()
    (tmp_path / "my-case.toml").unlink()
    assert exit_code(*shlex.split(commands[0].partition("cosimo ")[2])) == 0  # the same answers as options
    assert (tmp_path / "my-case.toml").read_bytes() == written
    assert 'title = "Line 7"' in (tmp_path / "my-scene.toml").read_text()
    assert '[document]\ntitle = "Run 7"\nauthor = "A. Author"' in written.decode()


@pytest.mark.parametrize(
    ("kind", "answers", "arguments"),
    [
        ("scene", ["a.toml", "copy", "overlap", "", "", "", "", ""], ["a.toml", "--from", "overlap"]),
        ("scene", ["a.toml", "components", "Catenary Pantograph", *[""] * 5], ["a.toml", "Catenary", "Pantograph"]),
        ("case", ["a.toml", "overlap", *[""] * 6], ["a.toml", "overlap", "--limits", "en50367"]),
        ("table", ["", "mass-on-sprin", "mass-on-spring"], ["my-table.toml", "mass-on-spring"]),
        ("component", ["", "Pendulum"], ["Pendulum"]),
        ("vehicle", ["a.csv", "a.toml", "supports.csv"], ["a.toml", "supports.csv"]),
    ],
)
def test_answers_become_arguments(answering, kind, answers, arguments):
    answering(*answers)
    assert arguments_of(kind, QUESTIONS[kind]) == arguments


def test_without_further_answers_nothing_is_written(answering, tmp_path, capsys):
    answering("scene", "a.toml")
    assert exit_code("new") == 2
    assert "no further answers" in capsys.readouterr().err
    assert not (tmp_path / "a.toml").exists()


def test_scripts_are_not_asked(capsys):
    assert exit_code("new") == 2
    assert "Commands:" in "".join(capsys.readouterr())


@pytest.mark.skipif(os.name == "nt", reason="pseudo-terminals of POSIX")
def test_a_person_at_a_terminal_is_asked(tmp_path):
    import pty

    outer, inner = pty.openpty()
    command = [sys.executable, "-m", "cosimo.orchestrator.cli", "new", "component"]
    with subprocess.Popen(command, cwd=tmp_path, stdin=inner, stdout=inner, stderr=inner) as process:
        os.close(inner)
        os.write(outer, b"MassOnWire\n")
        shown = b""
        while b"README.md says" not in shown:
            shown += os.read(outer, 4096)
        assert process.wait(30) == 0
    os.close(outer)
    assert b"Name of the class" in shown
    assert b"Without questions: cosimo new component MassOnWire" in shown
    assert (tmp_path / "mass_on_wire.py").exists()
