"""Refusals of commands say each thing once: what came, what was expected, and the command or file that would do."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from cosimo.components.core.errors import counted, nearest, pick
from cosimo.orchestrator.systems.railway.line import refuse_pushing
from cosimo.tests.commands import exit_code

SUPPORTS = "position [m]; contact height [m]\n0;{0}\n50;{0}\n100;{0}\n150;{0}\n"


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("build Nonesuch", "a component (cosimo list components), or module:Class. The nearest of "),
        ("cache frob", "got 'frob', expected one of show, clear, prune\n"),
        ("compare folder folder", "got the folder 'folder' without run.json, expected a directory that a run has written. As by"),
        ("export folder -o x.csv", "got the folder 'folder' without run.json"),
        (
            "new line -- -x.toml supports.csv",
            "got '-x.toml', expected a name that no command takes for an option. As in ./-x.toml",
        ),
        (
            "new line x.toml deep.csv",
            "deep.csv, line 2, column 'contact height': got -5, expected a value in [-1, 20] m. Height of the contact wire above the rail",
        ),
        ("run rotor-run-up --preset left=6205 --preset left=rows.csv:6306", "got left twice, expected each unit once"),
        ("sweep mass-on-spring --plan plan.toml -o out", "plan.toml: vary.spring.stiffness: got 3.0, expected a list of values"),
    ],
)
def test_a_refusal_says_what_came_and_what_would_do(arguments, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    (tmp_path / "supports.csv").write_text(SUPPORTS.format(5.3))
    (tmp_path / "deep.csv").write_text(SUPPORTS.format(-5.0))
    (tmp_path / "plan.toml").write_text("[vary]\nspring.stiffness = 3.0\n")
    (tmp_path / "rows.csv").write_text("name;Z\n6306;8\n")
    assert exit_code(*arguments.split()) == 2
    assert said in capsys.readouterr().err


def test_names_stand_once_and_few_of_many():
    with pytest.raises(ValueError, match=r"expected one of ab, cd$"):
        pick("xyz", ("ab", "cd"), "here", "one of ab, cd")
    assert nearest("zzz", ["ab", "cd"]) == "There is ab, cd"
    many = [f"name {k}" for k in range(46)]
    assert nearest("Nonesuch", many).startswith("The nearest of 46 names are ")
    assert nearest("Nonesuch", many).count(",") == 2
    assert [counted(n, "support") for n in (0, 1, 2)] == ["0 supports", "1 support", "2 supports"]


@pytest.mark.parametrize("word", ["systems", "system"])
def test_systems_are_listed_by_what_they_have(word, capsys):
    assert exit_code("list", word, "--json") == 0
    systems = {e["name"]: e["title"] for e in json.loads(capsys.readouterr().out)["systems"]}
    assert {"railway", "bearings", "wrist"} <= systems.keys()
    assert systems["railway"].startswith("3 components, ")


def test_a_kind_is_listed_by_its_singular_too(capsys):
    assert exit_code("list", "component", "--json") == 0
    assert list(json.loads(capsys.readouterr().out)) == ["components"]


@pytest.mark.parametrize(
    ("lower", "said"), [((0, 0), "-3 N at 7 m"), ((0, 2), "-3 N at 7 m (contact wire 2)"), ((0, 4), "-3 N at 7 m (auxiliary)")]
)
def test_a_dropper_that_pushes_is_told_by_its_wire_where_there_are_two(lower, said):
    droppers = SimpleNamespace(position=np.array([5.0, 7.0]), lower=np.array(lower))
    form = SimpleNamespace(preload=np.array([40.0, -3.0]), layout=SimpleNamespace(droppers=droppers, contact_lanes=(0, 2)))
    with pytest.raises(ValueError, match="1 of 2 droppers with thrust at rest") as refusal:
        refuse_pushing(form, "line")
    assert said + ", expected tension in every dropper" in str(refusal.value)
