"""Fronts: whose they are, where they are kept, what they advise, and that shipped ones belong to the shipped scenes."""

import json
import math
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator import code_digests
from cosimo.orchestrator.cli import choices, main
from cosimo.orchestrator.cli.choices import is_verified
from cosimo.orchestrator.code_digests import components_digest
from cosimo.orchestrator.harness.studies import fronts
from cosimo.orchestrator.harness.studies.accuracy import OWN, Accuracy, Point, accuracy
from cosimo.orchestrator.harness.studies.accuracy_table import read_points, write_points
from cosimo.orchestrator.harness.studies.fronts import choose, keep, known, scene_digest
from cosimo.orchestrator.harness.studies.quantities import distances, recording
from cosimo.orchestrator.judgement.verification import run as run_verified
from cosimo.orchestrator.scene.files import scene_files, shipped
from cosimo.orchestrator.systems import load_scene

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


@pytest.mark.parametrize(
    "changes", [{"master.step": 1e-3}, {"master.algorithm": "jacobi"}, {"title": "x"}, {"units.mass.parameters.substep": 1e-4}]
)
def test_a_front_is_that_of_the_physics(changes):
    assert scene_digest(SCENE.with_changes(changes)) == scene_digest(SCENE)


@pytest.mark.parametrize(
    "changes",
    [
        {"stop_time": 0.6},
        {"units.spring.parameters.stiffness": 101.0},
        {"study.quantities": ["mass.base_x, end"]},
        {"units.mass.effects": ["gravity"]},
        {"analysis.transient": 0.1},
    ],
)
def test_another_scene_has_another_front(changes):
    assert scene_digest(SCENE.with_changes(changes)) != scene_digest(SCENE)


def test_meshes_are_no_physics_where_they_are_named():
    named = SCENE.with_changes({"study.mesh": ["mass.length"]})
    assert scene_digest(named.with_changes({"units.mass.parameters.length": 2.0})) == scene_digest(named)


def test_a_kept_front_is_found_again(cache):
    assert known(SCENE) is None
    path = keep(SCENE, front())
    found = known(SCENE)
    assert str(path) in found.origin
    assert found.measured.own.error_with_finer == 0.01
    assert known(SCENE.with_changes({"stop_time": 0.6})) is None


def test_other_numbers_make_a_kept_front_stale(cache, monkeypatch):
    """What has changed them does not matter, and what changes none makes no front stale."""
    keep(SCENE, front())
    numbers = fronts.numbers_of(SCENE, {})
    monkeypatch.setattr(fronts, "numbers_of", lambda *_: {name: (1.0 + 3e-5) * x for name, x in numbers.items()})
    assert not known(SCENE).stale
    monkeypatch.setattr(fronts, "numbers_of", lambda *_: {name: (1.0 + 3e-4) * x for name, x in numbers.items()})
    assert "mass.base_x has an rms of" in known(SCENE).stale


def test_comments_and_docstrings_of_components_are_no_physics(monkeypatch):
    def digest(text):
        monkeypatch.setattr(code_digests, "sources", lambda module: {"x.py": text.encode()})
        return components_digest(SCENE)

    plain = digest("def f(x):\n    return 2.0 * x\n")
    assert digest('"""A module."""\n\n\ndef f(x):  # twice\n    """Twice."""\n    return 2.0 * x\n') == plain
    assert digest("def f(x):\n    return 2.5 * x\n") != plain


@pytest.fixture
def shipped_front(cache, tmp_path, monkeypatch):
    """Ships a front of the scene, with other marks where they are given."""

    def ship(scene, **marks):
        measured = fronts.marked(scene, front(("a", 1e-2, FAST, 0.02, 0.1), ("b", 1e-4, SLOW, 0.001, 0.05)))
        points = [replace(p, work={"calls": 100}) for p in measured.points]
        measured = replace(measured, points=tuple(points), marks={**measured.marks, **marks})
        write_points(measured, tmp_path / "shipped", "mass-on-spring.csv", times=False)
        tables = {"mass-on-spring": tmp_path / "shipped" / "mass-on-spring.csv"}
        monkeypatch.setattr(fronts, "shipped", lambda kind, ending: tables)

    return ship


def test_a_shipped_front_gets_its_times_here(shipped_front):
    """The setting with ten times the steps takes longer: of settings with the same counted work it is not chosen."""
    scene = SCENE.with_changes({"stop_time": 20.0})
    shipped_front(scene)
    measured = known(scene).measured
    assert all(math.isnan(p.seconds) for p in measured.points)
    chosen = choose(scene, measured, 0.05)
    assert chosen.series in (OWN, "a")
    assert 0.0 < chosen.seconds < 5.0
    assert "times measured here" in known(scene).origin
    assert choose(scene, measured, 0.002).series == "b"
    with pytest.raises(BadInput, match="the best setting measured has"):
        choose(scene, measured, 1e-5)


@pytest.mark.full
def test_a_shipped_front_with_other_numbers_is_stale_and_measured_anew(shipped_front, tmp_path, capsys):
    scene = tmp_path / "mass-on-spring.toml"
    text = scene_files()["mass-on-spring"].read_text(encoding="utf-8")
    scene.write_text(text.replace("stop_time = 20.0", "stop_time = 0.5"), encoding="utf-8")
    loaded = load_scene(scene)
    shipped_front(loaded, **{fronts.NUMBERS: '{"mass.base_x": 0.5, "spring.second_force_x": 1.0}'})
    assert "have changed since" in known(loaded).stale
    with pytest.raises(SystemExit) as exit_:
        main(["run", str(scene), "--accuracy", "5%", "--in-process"])
    assert exit_.value.code == 0
    captured = capsys.readouterr()
    assert "and had 0.5): measuring first" in captured.err
    assert "measured on this machine" in captured.out


def test_the_quickest_setting_that_holds_is_chosen():
    measured = front(("a", 1e-2, FAST, 0.02, 0.1), ("b", 2e-3, {}, 1e-3, 3.0), ("c", 1e-3, {}, 1e-4, 2.0))
    assert choose(SCENE, measured, 0.05).series == "a"
    assert choose(SCENE, measured, 0.01).series == OWN
    assert choose(SCENE, measured, 1e-3).series == "c"  # quicker than b and better


def test_more_than_was_measured_is_refused_with_what_there_is():
    with pytest.raises(BadInput, match=r"the best setting measured has 1 %"):
        choose(SCENE, front(), 1e-3)


def test_more_than_the_reference_knows_is_refused():
    with pytest.raises(BadInput, match="the reference's own error"):
        choose(SCENE, front(floor=1e-2), 1e-3)


def test_the_repetition_gives_the_errors_of_the_quantities():
    """At least those against a much finer run; at second order, half as much again at the most."""
    scene = recording(SCENE.with_changes(FAST))
    result = run_verified(scene, verify="full", in_process=True, distances=distances)
    fine = scene.with_changes({**SLOW, "units.mass.parameters.substep": 1e-4, "record.interval": 1e-2})
    true = distances(result, run_verified(fine, verify="no", in_process=True))
    for name, error in result.info["verification"]["quantities"]["steps"].items():
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
    result = SimpleNamespace(scene=SCENE, info={"verification": verification})
    assert is_verified(result, 0.01) == word.startswith("verified")
    assert word in capsys.readouterr().out.replace("\n", " ")


def test_options_are_refused_before_anything_is_measured(cache, capsys, monkeypatch):
    monkeypatch.setattr(fronts, "known", lambda scene: pytest.fail("measured"))
    for options in (["--verify", "often"], ["--limits", "no-such-table"], ["--native"], ["--checkpoint-every", "1"]):
        with pytest.raises(SystemExit) as exit_:
            main(["run", "mass-on-spring", "--in-process", "--accuracy", "1%", *options])
        assert exit_.value.code == 2


def test_the_command_runs_the_setting_and_says_so(cache, tmp_path, capsys):
    scene = tmp_path / "short.toml"
    text = scene_files()["mass-on-spring"].read_text(encoding="utf-8")
    scene.write_text(text.replace("stop_time = 20.0", "stop_time = 0.5"), encoding="utf-8")
    keep(load_scene(scene), front(("gauss-seidel, linear", 1e-2, FAST, 0.02, 0.1)))
    with pytest.raises(SystemExit) as exit_:
        main(["run", str(scene), "--accuracy", "5%", "--verify", "full", "--in-process", "-o", str(tmp_path / "out")])
    out = capsys.readouterr().out
    assert exit_.value.code == 0
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
    with pytest.raises(SystemExit) as exit_:
        main(["run", str(scene), "--accuracy", "0.1%", "--verify", "full", "--in-process"])
    assert exit_.value.code == 1
    assert "NOT verified" in capsys.readouterr().out


def test_nothing_known_is_measured_first(cache, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(choices, "accuracy", partial(accuracy, budget=1.0, repeats=2))
    scene = tmp_path / "short.toml"
    text = scene_files()["mass-on-spring"].read_text(encoding="utf-8")
    scene.write_text(text.replace("stop_time = 20.0", "stop_time = 0.5"), encoding="utf-8")
    for _ in range(2):
        with pytest.raises(SystemExit) as exit_:
            main(["run", str(scene), "--accuracy", "1%", "--in-process"])
        assert exit_.value.code == 0
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
        (["--verify", "whole", "--no-verify"], "one of them"),
    ],
)
def test_options_that_do_not_go_together(options, word, capsys):
    with pytest.raises(SystemExit) as exit_:
        main(["run", "mass-on-spring", "--in-process", *options])
    assert exit_.value.code == 2
    assert word in capsys.readouterr().err


@pytest.mark.parametrize("name", shipped("fronts", ".csv"))
def test_shipped_tables_are_those_of_the_scenes(name):
    """A scene whose physics or quantities change has to be measured again: accuracy.csv of cosimo accuracy NAME."""
    measured = read_points(shipped("fronts", ".csv")[name])
    scene = load_scene(name)
    assert measured.marks[fronts.SCENE] == scene_digest(scene)
    assert "numba" in measured.versions
    assert measured.own.outcome == "done"
    assert measured.own.size == scene.master.step


@pytest.mark.full
@pytest.mark.parametrize("name", shipped("fronts", ".csv"))
def test_no_shipped_table_is_stale(name):
    """Whatever has changed the scene's numbers: python -m cosimo.tests.benchmarks.fronts NAME measures it anew."""
    assert fronts.changed_number(load_scene(name), read_points(shipped("fronts", ".csv")[name])) == ""


@pytest.mark.parametrize("name", shipped("fronts", ".csv"))
def test_scenes_run_at_a_setting_on_their_front(name):
    """By counted work; a factor below 1.5 between neighbours turns with the quantity that is looked at.

    An error of a coarser setting that is the scene's only because finer ones count says nothing against the scene.
    """
    measured = read_points(shipped("fronts", ".csv")[name])
    own, floor = measured.own, measured.smallest_known
    for p in measured.points:
        if p.outcome == "done" and p.axis != "effect":
            calls = own.work["calls"] / p.work["calls"]
            error = max(own.error_with_finer, floor) / max(p.error_with_finer, floor)
            assert not (calls >= 1.0 and error > 1.5), f"{p.series} at {p.size:g} is more accurate"
            assert not (error > 1.0 and calls > 1.5), f"{p.series} at {p.size:g} is cheaper"
