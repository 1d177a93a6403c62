"""Fronts: whose they are, where they are kept, and what they advise."""

import json
import math
from dataclasses import replace
from types import SimpleNamespace

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.cli import choices
from cosimo.orchestrator.cli.choices import is_verified
from cosimo.orchestrator.harness.studies import fronts
from cosimo.orchestrator.harness.studies.accuracy import OWN, Accuracy, Point
from cosimo.orchestrator.harness.studies.fronts import choose, keep, kept, kept_front
from cosimo.orchestrator.harness.studies.quantities import distances, recording
from cosimo.orchestrator.judgement.verification import run_verified
from cosimo.orchestrator.run.run_record import RunRecord, VerificationRecord
from cosimo.orchestrator.scene.files import scene_files
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.commands import exit_code

SCENE = load_scene("mass-on-spring").with_changes({"stop_time": 0.5})
FAST = {"master.algorithm": "gauss-seidel", "master.extrapolation": 1, "master.step": 1e-2}
SLOW = {**FAST, "master.step": 1e-4}


def front(*points, floor=1e-6):
    made = [Point(OWN, "own", 5e-3, {}, "done", error=0.01, error_with_finer=0.01, seconds=1.0)]
    made += [
        Point(name, "coupling", size, changes, "done", error=error, error_with_finer=error, seconds=seconds)
        for name, size, changes, error, seconds in points
    ]
    return Accuracy("mass-on-spring", "", tuple(made), "by hand", "by hand", {"mass.base_x, time history": floor}, "here", "now")


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("COSIMO_CACHE", str(tmp_path / "cache"))


def test_a_kept_front_is_found_again(cache):
    assert kept(SCENE) is None
    measured = front(("a", 1e-2, FAST, 0.02, 0.1), ("b", 1e-4, SLOW, math.inf, math.nan))
    path = keep(SCENE, measured)
    assert repr(kept(SCENE).points) == repr(measured.points)  # NaN is no NaN's equal
    assert repr(kept(SCENE)) == repr(measured)
    assert kept(SCENE).agreement == measured.agreement
    assert path == kept_front(SCENE).file
    assert kept(SCENE.with_changes({"stop_time": 0.6})) is None
    path.write_text("[]", encoding="utf-8")
    assert kept(SCENE) is None


def test_without_a_time_the_least_counted_work_decides():
    points = (("a", 1e-2, FAST, 0.02, math.nan), ("b", 1e-4, SLOW, 0.001, math.nan))
    measured = front(*points)
    calls = {"a": 10, "b": 1000, OWN: 100}
    measured = replace(
        measured, points=tuple(replace(p, seconds=math.nan, work={"calls": calls[p.series]}) for p in measured.points)
    )
    assert choose(measured, 0.05).series == "a"
    assert choose(measured, 0.01).series == OWN
    assert choose(measured, 1e-3).series == "b"


def test_the_quickest_setting_that_holds_is_chosen():
    measured = front(("a", 1e-2, FAST, 0.02, 0.1), ("b", 2e-3, {}, 1e-3, 3.0), ("c", 1e-3, {}, 1e-4, 2.0))
    assert choose(measured, 0.05).series == "a"
    assert choose(measured, 0.01).series == OWN
    assert choose(measured, 1e-3).series == "c"  # quicker than b and better


def test_more_than_was_measured_is_refused_with_what_there_is():
    with pytest.raises(BadInput, match=r"the best setting measured has 1 %"):
        choose(front(), 1e-3)


def test_more_than_the_reference_knows_is_refused():
    with pytest.raises(BadInput, match="the reference's own error"):
        choose(front(floor=1e-2), 1e-3)


def test_the_repetition_gives_the_errors_of_the_quantities():
    """At least those against a much finer run; at second order, half as much again at the most."""
    scene = recording(SCENE.with_changes(FAST))
    result = run_verified(scene, verify="full", in_process=True, distances=distances)
    fine = scene.with_changes({**SLOW, "mass.substep": 1e-4, "record.interval": 1e-2})
    true = distances(result, run_verified(fine, verify="no", in_process=True))
    for name, error in result.info.verification.quantities["steps"].items():
        assert 0.95 * true[name] < error < 1.6 * true[name], name


@pytest.mark.parametrize(
    ("verification", "word"),
    [
        ({"done": False, "why": "too many rows"}, "NOT verified: too many rows"),
        ({"done": True, "quantities": {"steps": {"q": 0.001}}, "not_refined": {"b.mesh": "why"}}, "NOT verified: b.mesh could"),
        ({"done": True, "quantities": {"steps": {"q": 0.001}, "b.mesh": {"q": 0.02}}}, "NOT verified: 2 % is more than 1 %"),
        ({"done": True, "quantities": {"steps": {"q": None}}}, "NOT verified"),
        ({"done": True, "quantities": {"steps": {"q": 0.001}, "b.mesh": {"q": 0.01}}}, "verified: 1 % is within 1 %"),
    ],
)
def test_only_what_was_verified_is_called_so(verification, word, capsys):
    record = VerificationRecord(**{"why": "", **verification})
    result = SimpleNamespace(scene=SCENE, info=RunRecord(outcome="done", verification=record))
    assert is_verified(result, 0.01) == word.startswith("verified")
    assert word in capsys.readouterr().out.replace("\n", " ")


def test_options_are_refused_before_anything_is_measured(cache, capsys, monkeypatch):
    monkeypatch.setattr(fronts, "kept", lambda scene: pytest.fail("measured"))
    for options in (["--verify", "often"], ["--limits", "no-such-table"], ["--native"], ["--checkpoint-every", "1"]):
        exit_ = exit_code("run", "mass-on-spring", "--in-process", "--accuracy", "1%", *options)
        assert exit_ == 2


def test_the_command_runs_the_setting_and_says_so(cache, tmp_path, capsys):
    scene = tmp_path / "short.toml"
    text = scene_files()["mass-on-spring"].read_text(encoding="utf-8")
    scene.write_text(text.replace("stop_time = 20.0", "stop_time = 0.5"), encoding="utf-8")
    keep(load_scene(scene), front(("gauss-seidel, linear", 1e-2, FAST, 0.02, 0.1)))
    exit_ = exit_code("run", str(scene), "--accuracy", "5%", "--verify", "full", "--in-process", "-o", str(tmp_path / "out"))
    out = capsys.readouterr().out
    assert exit_ == 0
    assert "gauss-seidel, linear, 0.01" in out
    assert "verified" in out
    assert "NOT" not in out
    told = json.loads((tmp_path / "out" / "run.json").read_text(encoding="utf-8"))
    assert told["accuracy"]["changes"] == FAST
    assert told["accuracy"]["asked"] == 0.05
    assert "quickest" in told["accuracy"]["reason"]
    assert told["settings"]["step"] == 1e-2


def test_a_setting_that_does_not_hold_fails_the_check(cache, tmp_path, capsys):
    scene = tmp_path / "short.toml"
    text = scene_files()["mass-on-spring"].read_text(encoding="utf-8")
    scene.write_text(text.replace("stop_time = 20.0", "stop_time = 0.5"), encoding="utf-8")
    keep(load_scene(scene), front(("too good", 4e-2, {**FAST, "master.step": 4e-2}, 1e-4, 0.1)))
    exit_ = exit_code("run", str(scene), "--accuracy", "0.1%", "--verify", "full", "--in-process")
    assert exit_ == 1
    assert "NOT verified" in capsys.readouterr().out


def test_nothing_known_is_measured_first(cache, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(choices, "BUDGET", 1.0)
    scene = tmp_path / "short.toml"
    text = scene_files()["mass-on-spring"].read_text(encoding="utf-8")
    scene.write_text(text.replace("stop_time = 20.0", "stop_time = 0.5"), encoding="utf-8")
    for _ in range(2):
        assert exit_code("run", str(scene), "--accuracy", "1%", "--in-process") == 0
    captured = capsys.readouterr()
    assert captured.err.count("measuring first") == 1
    assert "measured on this machine" in captured.out


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--accuracy", "1%", "--step", "1e-3"], "--step"),
        (["--accuracy", "1%", "--algorithm", "jacobi"], "--algorithm"),
        (["--accuracy", "0%"], "share above 0 %"),
        (["--accuracy", "120%"], "at most 100 %"),
        (["--accuracy", "x"], "1% or 0.01"),
        (["--verify", "often"], "whole or full"),
        (["--verify", "whole", "--no-verify"], "exclude each other"),
    ],
)
def test_options_that_do_not_go_together(options, word, capsys):
    assert exit_code("run", "mass-on-spring", "--in-process", *options) == 2
    assert word in capsys.readouterr().err
