"""Options of `cosimo run`, and what it shows without running."""

import json
from pathlib import Path

import pytest
from cosimo.components.core.kernels import COMPILED
from cosimo.orchestrator.judgement import dry_run
from cosimo.tests.commands import exit_code
from pythonfmu.builder import FmuBuilder

FMUS = Path(__file__).parent / "fmus"
SCENE = """
title = "a mass on a spring"
stop_time = 2.0
connections = ["spring.force -> mass.force", "mass.x_out -> spring.position", "mass.v_out -> spring.velocity",
               "mass.x_out -> probe.length"]
[units]
mass = { component = "cosimo.tests.support:Mass" }
spring = { component = "cosimo.tests.support:SpringDamper", parameters = { d = 2.0 } }
probe = { component = "cosimo.tests.support:Probe" }
[master]
algorithm = "jacobi"
step = 1e-2
[[faults]]
kind = "freeze"
signal = "probe.length"
begin = 0.5
"""
PANTOGRAPH = """
stop_time = 0.1
[units.p]
component = "Pantograph"
effects = ["contact_loss"]
[master]
step = 1e-3
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "spring.toml"
    path.write_text(SCENE)
    return path


@pytest.fixture
def pantograph(tmp_path):
    path = tmp_path / "pantograph.toml"
    path.write_text(PANTOGRAPH)
    return path


def test_help_shows_examples(capsys):
    assert exit_code("run", "--help") == 0
    shown = " ".join(capsys.readouterr().out.split())
    options = "--set --effects --algorithm --step --stop --record --resume --checkpoint-every --dry-run"
    assert [option for option in options.split() if option not in shown] == []
    assert shown.count("cosimo run scene.toml") >= 3


def test_record_and_algorithm_and_step(scene, tmp_path):
    out = tmp_path / "out"
    assert (
        exit_code(
            "run",
            scene,
            "--in-process",
            "-o",
            out,
            "--record",
            "mass.x_out,probe.profile[2]",
            "--record",
            "spring.force",
            "--algorithm",
            "gauss-seidel",
            "--step",
            "2e-2",
        )
        == 0
    )
    info = json.loads((out / "run.json").read_text())
    assert (info["settings"]["algorithm"], info["settings"]["step"]) == ("gauss-seidel", 0.02)
    assert info["counters"]["master"]["steps"] == 100
    header = (out / "result.csv").read_text().splitlines()[0]
    assert header == '"time","mass.x_out","probe.profile[2]","spring.force"'


def test_effects_are_switched_on_beside_those_of_the_scene(pantograph, tmp_path):
    assert exit_code("run", pantograph, "--in-process", "-o", tmp_path / "out", "--effects", "p.bump_stops,p.lower_frame") == 0
    on = json.loads((tmp_path / "out" / "run.json").read_text())["effects"]["p"]["on"]
    assert set(on) == {"contact_loss", "bump_stops", "lower_frame"}


@pytest.mark.parametrize(
    ("option", "value", "named"),
    [
        ("--effects", "p.bump_stop", "'bump_stops'"),
        ("--effects", "q.bump_stops", "unit 'q'"),
        ("--effects", "p", "unit.effect"),
        ("--effects", "p.contact_loss", "not on already"),
        ("--effects", "p.bump_stops,p.bump_stops", "not on already"),
        ("--effects", "p.bump_stops,", "separated by commas"),
        ("--record", "p.contact_forc", "'contact_force'"),
        ("--record", "", "separated by commas"),
        ("--checkpoint-every", "0.05", "an output directory"),
        ("--algorithm", "iterativ", "'iterative'"),
    ],
)
def test_bad_options(pantograph, option, value, named, capsys):
    assert exit_code("run", pantograph, "--in-process", option, value) == 2
    out, err = capsys.readouterr()
    assert named in err
    assert (out, err.count("\n")) == ("", 1)


def test_in_process_is_refused_where_it_would_have_no_effect(tmp_path, capsys):
    fmu = FmuBuilder.build_FMU(FMUS / "msd.py", dest=tmp_path)
    scene = tmp_path / "fmus.toml"
    scene.write_text(f'stop_time = 1.0\nunits.m.fmu = "{Path(fmu).name}"\nmaster.step = 0.1\n')
    assert exit_code("run", scene, "--in-process") == 2
    assert "--in-process: no effect with a scene of FMUs only" in capsys.readouterr().err


def test_dry_run_shows_the_settled_scene_and_its_limit(scene, capsys):
    assert exit_code("run", scene, "--in-process", "--dry-run") == 0
    out, err = capsys.readouterr()
    for shown in ("spring.force", "freeze", "1000", "mass, spring", "200 macro"):  # m to mm: 1000
        assert shown in out
    assert "stability of the coupling: not examined: " in out  # the units are in plain Python
    assert err == ""


@pytest.mark.skipif(not COMPILED, reason="derivatives are those of machine code")
def test_dry_run_tells_the_limit_and_warns_of_a_step_that_is_too_long(capsys):
    """A fifth of critical damping, linear inputs: 1.2131689/ω."""
    assert exit_code("run", "mass-on-spring", "--in-process", "--dry-run") == 0
    assert "longest stable macro step: 0.1213 s" in capsys.readouterr().out
    assert exit_code("run", "mass-on-spring", "--in-process", "--step", "0.13", "--dry-run") == 0
    assert "the coupling is stable up to 0.121 s" in capsys.readouterr().err


def test_dry_run_says_for_what_it_knows_no_limit(tmp_path, capsys):
    for name in ("msd", "ctrl"):
        FmuBuilder.build_FMU(FMUS / f"{name}.py", dest=tmp_path)
    mass, control = tmp_path / "Msd.fmu", tmp_path / "Ctrl.fmu"
    (tmp_path / "circle.toml").write_text(
        f'stop_time = 0.1\nconnections = ["m.x -> c.x", "c.force -> m.f"]\nunits.m.fmu = "{mass}"\n'
        f'units.c.fmu = "{control}"\nmaster.step = 1e-2\n'
    )
    assert exit_code("run", tmp_path / "circle.toml", "--dry-run") == 0
    assert "left out: the stability of the coupling" in capsys.readouterr().out


def test_dry_run_draws_the_scene_where_it_has_a_directory(scene, tmp_path, capsys):
    assert exit_code("run", scene, "--dry-run", "-o", tmp_path / "new") == 0
    assert [p.name for p in (tmp_path / "new").iterdir()] == ["scene.svg"]
    assert (tmp_path / "new" / "scene.svg").read_text().startswith("<svg ")


@pytest.mark.parametrize("option", [("--native",), ("--checkpoint-every", "1"), ("--resume", "file")])
def test_options_without_effect_on_a_dry_run_are_refused(scene, option, capsys):
    assert exit_code("run", scene, "--dry-run", *option) == 2
    assert "no effect" in capsys.readouterr().err


def test_dry_run_of_a_scene_that_cannot_start(tmp_path, capsys):
    path = tmp_path / "failing.toml"
    path.write_text(
        'stop_time = 1.0\nmaster = { step = 0.1 }\n[units.p]\ncomponent = "cosimo.tests.support:Probe"\n'
        "parameters = { fail_at = 0.15 }\n"
    )
    assert exit_code("run", path, "--dry-run") == 3
    assert "p failed at t = 0.1 s" in capsys.readouterr().err


def test_units_with_dots_in_their_names_are_changed(tmp_path):
    path = tmp_path / "dotted.toml"
    path.write_text(
        'stop_time = 1.0\nmaster = { step = 0.1 }\n[units."sub.p"]\ncomponent = "cosimo.tests.support:Probe"\n'
        "parameters = { length = 1.0 }\n"
    )
    assert exit_code("run", path, "-o", tmp_path / "out", "--set", "sub.p.length=3", "--record", "sub.p.profile[1]") == 0
    assert (tmp_path / "out" / "result.csv").read_text().splitlines()[-1] == "1.0,3.0"


def test_a_run_goes_on_from_its_checkpoint_to_the_same_bits(scene, tmp_path, capsys):
    whole, part = tmp_path / "whole", tmp_path / "part"
    assert exit_code("run", scene, "--in-process", "-o", whole) == 0
    assert exit_code("run", scene, "--in-process", "-o", part, "--checkpoint-every", "0.7") == 0
    again = tmp_path / "again"
    assert exit_code("run", scene, "--in-process", "-o", again, "--resume", part / "checkpoint") == 0
    first = (whole / "result.csv").read_text()
    assert first == (part / "result.csv").read_text() == (again / "result.csv").read_text()
    capsys.readouterr()
    assert exit_code("run", scene, "--in-process", "--step", "2e-2", "--resume", part / "checkpoint") == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert exit_code("run", scene, "--in-process", "--resume", tmp_path / "none") == 2
    assert exit_code("run", scene, "--in-process", "--resume", scene) == 2


def test_a_module_that_is_not_found_says_where_its_folder_belongs(tmp_path, capsys):
    (tmp_path / "scene.toml").write_text('stop_time = 1.0\n[units.a]\ncomponent = "no_such_parts:Body"\n[master]\nstep = 0.1\n')
    assert exit_code("run", str(tmp_path / "scene.toml")) == 2
    assert "PYTHONPATH" in capsys.readouterr().err


def test_the_numbers_of_a_run_are_printed_and_written(tmp_path, capsys):
    """The energy of an undamped double pendulum: the row on the terminal is the one of the file."""
    assert exit_code("run", "double-pendulum", "--in-process", "--stop", "0.2", "-o", tmp_path / "out") == 0
    numbers = json.loads((tmp_path / "out" / "summary.json").read_text(encoding="utf-8"))
    drift = numbers["chain.energy_change"]
    assert 0.0 <= drift["value"] < 1e-6
    assert drift["unit"] == "1"
    run = json.loads((tmp_path / "out" / "run.json").read_text(encoding="utf-8"))
    assert {key: numbers[key] for key in ("outcome", "warnings")} == {key: run[key] for key in ("outcome", "warnings")}
    printed = capsys.readouterr().out
    assert "chain.energy_change" in printed
    assert "summary.json" in printed


def test_a_dry_run_of_a_long_run_answers_at_once(capsys, monkeypatch):
    """Internal steps of 1 ns: the first part alone would take minutes."""
    monkeypatch.setattr(dry_run, "run_verified", lambda *_, **__: pytest.fail("it ran"))
    assert exit_code("run", "mass-on-spring", "--in-process", "--set", "mass.substep=1e-9", "--dry-run") == 0
    assert "no trial run of the first" in capsys.readouterr().out


def test_record_of_an_effect_that_the_command_switches_on(tmp_path):
    short = ("--in-process", "--no-verify", "--stop", 0.002)
    switched = ("--effects", "left.friction", "--record", "left.friction.power")
    assert exit_code("run", "rotor-run-up", *short, *switched, "-o", tmp_path) == 0
    assert "left.friction.power" in (tmp_path / "result.csv").read_text(encoding="utf-8").partition("\n")[0]
