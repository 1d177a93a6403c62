"""cosimo accuracy: files, what it prints, what it refuses."""

import json

import pytest
from cosimo.tests.commands import exit_code


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("COSIMO_CACHE", str(tmp_path / "cache"))


def test_a_scene(tmp_path, capsys):
    assert exit_code("accuracy", "mass-on-spring", "--stop", 0.2, "--budget", 1, "-o", tmp_path / "out") == 0
    out = capsys.readouterr().out
    assert "DOP853" in out
    assert (tmp_path / "out" / "accuracy.csv").is_file()
    assert (tmp_path / "out" / "report.html").is_file()
    assert len(list((tmp_path / "cache" / "fronts").iterdir())) == 1


@pytest.mark.full
def test_a_component_alone_as_json(tmp_path, capsys):
    given = ("--set", "stiffness=2e5", "--stop", 0.2, "--budget", 2, "-o", tmp_path, "--json")
    assert exit_code("accuracy", "component:JeffcottRotor", *given) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["name"] == "component:JeffcottRotor"
    assert told["fronts"]["calls"]
    assert told["outcomes"]["done"] > 0


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["no-such-scene"], "shipped scene"),
        (["component:BallBering"], "BallBearing"),
        (["component:Wind"], "integrated"),
        (["mass-on-spring", "--budget", "0"], "more than 0 s"),
        (["mass-on-spring", "--effects", "x"], "no effect for a scene"),
        (["component:PlanarLink", "--set", "mass"], "parameter=value"),
        (["component:PlanarLink", "--effects", "gravitty"], "gravity"),
    ],
)
def test_bad_input(arguments, word, tmp_path, capsys):
    assert exit_code("accuracy", *arguments, "-o", tmp_path) == 2
    assert word in capsys.readouterr().err
