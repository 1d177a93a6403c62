"""`cosimo new component`: what it writes is whole, and keeps what it promises in a fresh folder."""

import os
import subprocess
import sys
from pathlib import Path

import cosimo
import pytest
from cosimo import component_class, load_scene
from cosimo.tests.commands import exit_code

ROOT = Path(cosimo.__file__).parents[1]


def new(*arguments: object) -> int:
    done = exit_code("new", "component", *map(str, arguments))
    return done


def test_the_files_are_a_component_and_its_scene(tmp_path, monkeypatch):
    assert new("SpringyMass", "-o", tmp_path) == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == [
        "README.md",
        "springy_mass.py",
        "springy_mass.toml",
        "test_springy_mass.py",
    ]
    monkeypatch.syspath_prepend(str(tmp_path))
    cls = component_class("springy_mass:SpringyMass")
    assert cls.title == "Springy mass"
    scene = load_scene(tmp_path / "springy_mass.toml")
    assert scene.units["springy_mass"].component == "springy_mass:SpringyMass"
    assert not [f.name for f in tmp_path.glob("*springy*") if "$" in f.read_text()]
    component = cls()
    component.initialize(0.0)
    assert component["displacement"] == 0.01


@pytest.mark.parametrize(
    ("name", "words"),
    [("springyMass", "starts with a capital letter"), ("Pantograph", "no component of the catalogue"), ("No-Name", "class name")],
)
def test_names_that_cannot_be(name, words, tmp_path, capsys):
    assert new(name, "-o", tmp_path) == 2
    assert words in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_nothing_is_overwritten(tmp_path, capsys):
    (tmp_path / "README.md").write_text("mine")
    assert new("SpringyMass", "-o", tmp_path) == 2
    assert "there already" in capsys.readouterr().err
    assert (tmp_path / "README.md").read_text() == "mine"


@pytest.mark.full
def test_the_tests_that_it_writes_pass_in_a_fresh_folder(tmp_path):
    assert new("FreshMass", "-o", tmp_path) == 0
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    done = subprocess.run(
        command,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)},
    )
    assert done.returncode == 0, done.stdout
    assert "8 passed" in done.stdout
    for command in ("stability component:fresh_mass:FreshMass", "accuracy component:fresh_mass:FreshMass --budget 1"):
        done = subprocess.run(
            [sys.executable, "-m", "cosimo.orchestrator.cli", *command.split(), "-o", "out"],
            cwd=tmp_path,
            env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": f"{ROOT}{os.pathsep}{tmp_path}"},
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
