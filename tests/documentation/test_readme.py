"""What the README shows works as it stands: its commands in their order, its Python, its scenes.

The lines that install and the one that starts this suite are left to .ci/run, which runs exactly them.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from cosimo.orchestrator.run import run
from cosimo.orchestrator.systems import load_scene

ROOT = Path(__file__).resolve().parents[2]
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", (ROOT / "README.md").read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)
BY_CI = ("pip install .", 'pip install -e ".[test]"', "pytest")


def blocks(language: str) -> list[str]:
    """The README's code blocks in a language, in their order."""
    return [text for name, text in BLOCKS if name == language]


def commands() -> list[str]:
    """The lines of the bash blocks, without remarks behind "  #"; a line that ends in a backslash goes on in the next."""
    text = "".join(blocks("bash")).replace("\\\n", " ")
    return [line for raw in text.splitlines() if (line := re.sub(r"(^|\s\s)#.*", "", raw).strip())]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """One working directory for all commands: later ones use what earlier ones have written."""
    return tmp_path_factory.mktemp("readme")


def shell(command: list[str] | str, folder: Path) -> subprocess.CompletedProcess[str]:
    """The command as a reader runs it, with this environment's programs and this tree's packages."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    environment = {**os.environ, "PATH": path}
    return subprocess.run(command, shell=isinstance(command, str), cwd=folder, env=environment, capture_output=True, text=True,
                          timeout=300)


def test_the_readme_shows_commands_python_and_a_scene():
    assert sum(c.startswith("cosimo ") for c in commands()) >= 5
    assert blocks("python")
    assert any("[master]" in text for text in blocks("toml"))
    assert set(BY_CI) <= set(commands())
    assert commands().index(BY_CI[0]) == 0  # and the first command behind it is the one that .ci/run tries as a user
    assert commands()[1] in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


@pytest.mark.parametrize("command", [c for c in commands() if c not in BY_CI])
def test_commands(command, folder):
    done = shell(command, folder)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    for option in re.findall(r"(?:-o|--output|--output-file) (\S+)", command):
        assert (folder / option).exists()


@pytest.mark.parametrize("source", blocks("python"))
def test_python(source, folder):
    done = shell([sys.executable, "-c", source], folder)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("text", [t for t in blocks("toml") if "[master]" in t])
def test_scenes(text, tmp_path):
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    scene = load_scene(tmp_path / "scene.toml")
    assert run(scene.with_changes({"stop_time": 0.1}), in_process=True).outcome == "done"
