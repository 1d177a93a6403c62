"""cosimo effects and cosimo run --effects auto: files, what they say, what they keep, what they refuse."""

import json

import pytest
from cosimo.components.core import store
from cosimo.orchestrator.harness.studies.full_model import effects_on
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.verified_file import unpacked
from cosimo.tests.commands import exit_code

SCENE = """
stop_time = 1.0
[units]
part = { component = "cosimo.tests.harness.studies.parts:Parts", effects = ["medium", "small"] }
[master]
step = 0.01
[study]
quantities = ["part.total, end"]
"""


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("COSIMO_CACHE", str(tmp_path / "cache"))


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "parts.toml"
    path.write_text(SCENE, encoding="utf-8")
    return path


def test_a_scene_and_what_is_written(scene, tmp_path, capsys):
    small = tmp_path / "small.toml"
    assert exit_code("effects", scene, "--tolerance", "1%", "-o", tmp_path / "out", "--write", small) == 0
    out = capsys.readouterr().out
    assert "part.big" in out
    assert "smallest set: error 0.977 %" in out  # 0.015 of 1.535
    for name in ("effects.csv", "report.html"):
        assert (tmp_path / "out" / name).is_file()
    assert effects_on(load_scene(small)) == {"part": ("big", "medium")}
    text = small.read_text(encoding="utf-8")
    assert text.startswith("# Of the scene parts: the effects whose absence shows by more than 1 %;")
    assert "# without part.small: error without it 0.521 %" in text
    assert exit_code("run", small, "--in-process", "-o", tmp_path / "run") == 0


def test_as_json(scene, tmp_path, capsys):
    assert exit_code("effects", scene, "--tolerance", "0.3", "--with", "part.load", "-o", tmp_path / "out", "--json") == 0
    told = json.loads(capsys.readouterr().out)
    # 0.5 of 1.735 alone would be within 30 %, but not beside all that is smaller
    assert {e["effect"] for e in told["effects"] if e["chosen"]} == {"big"}
    assert told["chosen"]["error"] == pytest.approx(0.235 / 1.735)
    assert told["tolerance"] == 0.3


def test_a_run_with_what_the_scene_calls_for(scene, tmp_path, capsys):
    assert exit_code("run", scene, "--in-process", "--effects", "auto", "--tolerance", "1%", "-o", tmp_path / "run") == 0
    captured = capsys.readouterr()
    assert "effects within 1 %: part.big, part.medium; error 0.977 %" in captured.out
    assert "measured now" in captured.err
    info = json.loads((tmp_path / "run" / "run.json").read_text(encoding="utf-8"))
    listed = info["effects"]["part"]
    assert set(listed["on"]) == {"big", "medium"}
    assert listed["on"]["big"] == "error without it 33.6 %, more than 1 %"  # 0.515 of 1.535
    assert listed["off"]["load"] == "only where a scene asks for it"
    assert listed["off"]["small"].startswith("error without it 0.521 %")
    why = info["selection"]["effects"]["part.medium"]
    assert why["on"]
    assert why["actual"] == pytest.approx(0.02 / 1.535)
    assert info["scene"]["units"]["part"]["effects"] == ["big", "medium"]

    assert exit_code("run", scene, "--in-process", "--effects", "auto", "--tolerance", "1%") == 0  # known by now
    assert "as kept in" in capsys.readouterr().err


def test_another_scene_or_tolerance_is_measured_anew(scene, capsys):
    for more in (["--tolerance", "1%"], ["--tolerance", "2%"], ["--tolerance", "1%", "--set", "part.small.size=0.001"]):
        assert exit_code("run", scene, "--in-process", "--effects", "auto", *more) == 0
        assert "measured now" in capsys.readouterr().err


def test_what_was_kept_and_is_damaged_is_measured_anew(scene, tmp_path, capsys):
    assert exit_code("run", scene, "--in-process", "--effects", "auto") == 0
    (kept,) = (tmp_path / "cache" / "effects").iterdir()
    whole = store.read_kept(kept)
    kept.write_text("[]", encoding="utf-8")
    capsys.readouterr()
    assert exit_code("run", scene, "--in-process", "--effects", "auto") == 0
    assert "measured now" in capsys.readouterr().err
    assert unpacked(store.read_kept(kept))["on"] == unpacked(whole)["on"]


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["effects", "no-such-scene"], "shipped scene"),
        (["effects", "SCENE", "--tolerance", "0"], "above 0 %"),
        (["effects", "SCENE", "--write", "x.ssp"], ".toml"),
        (["effects", "SCENE", "--with", "part.lode"], "load"),
        (["run", "SCENE", "--tolerance", "1%"], "--effects auto"),
        (["run", "SCENE", "--effects", "auto,part.big"], "auto alone"),
        (["run", "SCENE", "--effects", "auto", "--tolerance", "1 kg"], "above 0 %"),
    ],
)
def test_bad_input(arguments, word, scene, tmp_path, capsys):
    output = ["-o", tmp_path / "out"] if arguments[0] == "effects" else []
    assert exit_code(*(scene if a == "SCENE" else a for a in arguments), *output) == 2
    assert word in capsys.readouterr().err
