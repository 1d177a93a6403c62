"""The command line: what it prints for people and for programs, and its exit codes."""

import json
from importlib.metadata import version

import pytest
from cosimo import BadInput, load_scene
from cosimo.components.catalogue import CATALOGUE
from cosimo.orchestrator.cli.common import change, scene_of, with_presets
from cosimo.orchestrator.cli.options import parameters_of, preset_of
from cosimo.tests.commands import exit_code

SCENE = """
title = "pantograph under a rigid wire"
stop_time = 0.1
[units.pantograph]
component = "Pantograph"
[master]
step = 1e-3
"""
FAILING = """
stop_time = 1.0
[units.p]
component = "cosimo.tests.support:Probe"
parameters = { fail_at = 0.45 }
[master]
step = 0.1
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "rigid.toml"
    path.write_text(SCENE)
    return path


@pytest.mark.parametrize("command", ["list", "build", "check", "run", "validate"])
def test_help_shows_an_example(command, capsys):
    assert exit_code(command, "--help") == 0
    assert f"Example: cosimo {command}" in " ".join(capsys.readouterr().out.split())


def test_list_for_programs(capsys):
    assert exit_code("list", "--json") == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found) == {"components", "fmus", "scenes", "cases"}
    assert {c["name"] for c in found["components"]} == set(CATALOGUE)
    pantograph = next(c for c in found["components"] if c["name"] == "Pantograph")
    assert pantograph["system"] == "railway"
    assert "contact_loss" in pantograph["effects"]
    assert {"name", "causality", "unit"} <= pantograph["variables"][0].keys()
    for entries in found.values():
        assert all(e["name"] and e["title"] for e in entries)


def test_list_of_one_kind(capsys):
    assert exit_code("list", "components") == 0
    assert "Pantograph" in capsys.readouterr().out
    assert exit_code("list", "componets") == 2
    assert "Did you mean 'components'" in capsys.readouterr().err


def test_list_of_a_system_and_of_a_word(capsys):
    assert exit_code("list", "rotor", "--json") == 0
    rotor = json.loads(capsys.readouterr().out)
    assert {c["name"] for c in rotor["components"]} == {"JeffcottRotor", "BeamRotor"}
    assert {e["system"] for entries in rotor.values() for e in entries} == {"rotor"}
    assert exit_code("list", "Stiction", "--json") == 0
    assert [e["name"] for e in json.loads(capsys.readouterr().out)["scenes"]] == ["joint-stiction"]
    assert exit_code("list", "stictoin") == 2
    assert "Did you mean 'joint-stiction'" in capsys.readouterr().err


def test_list_without_a_word_fits_a_screen_and_has_every_name(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "160")
    assert exit_code("list") == 0
    out = capsys.readouterr().out
    assert len(out.splitlines()) <= 50
    assert set(CATALOGUE) <= set(out.split())


def test_version(capsys):
    assert exit_code("--version") == 0
    assert capsys.readouterr().out == f"cosimo {version('cosimo')}\n"


def test_arrays_and_presets_of_a_run(tmp_path, capsys):
    assert exit_code("run", "en50318-2002", "--dry-run", "--preset", "pantograph=DSA381") == 2
    assert "Did you mean 'DSA380'" in capsys.readouterr().err
    scene = load_scene("en50318-2002")
    changed = scene.with_changes(
        {
            **with_presets(scene, ["pantograph=DSA380"]),
            **dict([change(scene, "catenary.dropper_position=[5, 11.5]"), change(scene, "catenary.dropper_position[1]=6")]),
        }
    )
    assert changed.units["pantograph"].preset == "DSA380"
    droppers = {n: v for n, v in changed.units["catenary"].parameters.items() if n.startswith("dropper_position")}
    assert droppers == {"dropper_position[1]": 6, "dropper_position[2]": 11.5}
    assert parameters_of(["position=[0.1, 0.2]", "mass=2"]) == {"position[1]": 0.1, "position[2]": 0.2, "mass": 2.0}
    with pytest.raises(BadInput, match="an array of numbers"):
        change(scene, "catenary.dropper_position=[5, ")


def test_run_writes_its_results(scene, tmp_path, capsys):
    assert (
        exit_code(
            "run",
            str(scene),
            "--in-process",
            "-o",
            str(tmp_path / "out"),
            "--set",
            "pantograph.static_force=90",
            "--step",
            "2e-3",
            "--stop",
            "0.05",
        )
        == 0
    )
    assert "pantograph.contact_force" in capsys.readouterr().out
    info = json.loads((tmp_path / "out" / "run.json").read_text())
    assert info["units"]["pantograph"]["parameters"]["static_force"] == 90.0
    assert (info["outcome"], info["counters"]["master"]["steps"]) == ("done", 25)
    rows = (tmp_path / "out" / "result.csv").read_text().splitlines()
    assert rows[0].startswith('"time","pantograph.contact_force"')
    assert len(rows) == 1 + 26
    assert float(rows[-1].split(",")[0]) == 0.05


@pytest.mark.parametrize(
    ("option", "value", "named"),
    [
        ("--set", "pantograph.sped=1", "'speed'"),
        ("--set", "pantograph.speed", "unit.parameter=value"),
        ("--set", "pantograf.speed=1", "'pantograph'"),
        ("--step", "0", "master.step"),
        ("--stop", "-1", "stop_time"),
        ("--algorithm", "newton", "'jacobi'"),
    ],
)
def test_bad_options_of_run(scene, option, value, named, capsys):
    assert exit_code("run", str(scene), "--in-process", option, value) == 2
    out, err = capsys.readouterr()
    assert named in err
    assert out == ""
    assert err.count("\n") == 1


def test_an_output_place_that_is_a_file(scene, capsys):
    assert exit_code("run", str(scene), "--in-process", "-o", str(scene)) == 2
    assert "output directory" in capsys.readouterr().err


def test_a_failed_run_keeps_its_partial_result(tmp_path, capsys):
    (tmp_path / "failing.toml").write_text(FAILING)
    assert exit_code("run", str(tmp_path / "failing.toml"), "-o", str(tmp_path / "out")) == 3
    assert "p failed at t = 0.4 s" in capsys.readouterr().err
    assert len((tmp_path / "out" / "result.csv").read_text().splitlines()) == 1 + 5
    assert json.loads((tmp_path / "out" / "run.json").read_text())["outcome"] == "failed"


def test_build_then_check(tmp_path, capsys):
    assert exit_code("build", "Pantograph", "-o", str(tmp_path)) == 0
    fmu = tmp_path / "Pantograph.fmu"
    assert capsys.readouterr().out.split() == [str(fmu)]
    assert exit_code("check", str(fmu), "--execute", "--json") == 0
    findings = json.loads(capsys.readouterr().out)["findings"]
    assert findings
    assert all(f["ok"] for f in findings)
    fmu.write_bytes(b"no zip file")
    assert exit_code("check", str(fmu)) == 1
    assert exit_code("check", str(tmp_path / "none.fmu")) == 2
    assert exit_code("build", "Pantograf", "-o", str(tmp_path)) == 2


def test_unknown_case(capsys):
    assert exit_code("validate", "en50318-2003") == 2
    assert "en50318-2002" in capsys.readouterr().err


def test_places_that_cannot_be_written_are_one_message(scene, tmp_path, capsys):
    """A file where a folder should be, a folder where a file should be; of a sweep before its runs."""
    (tmp_path / "file").write_text("")
    (tmp_path / "out" / "report.html").mkdir(parents=True)
    taken = str(tmp_path / "file")
    sweep = ["sweep", str(scene), "--over", "pantograph.static_force=1:2:2"]
    for command in (
        ["build", "Pantograph", "-o", taken],
        [*sweep, "-o", taken],
        ["run", str(scene), "--in-process", "--stop", "0.05", "-o", str(tmp_path / "out")],
    ):
        assert exit_code(*command) == 2
        message = capsys.readouterr().err
        assert message.startswith("cosimo: ")
        assert message.count("\n") == 1
        assert "expected a place that can be" in message


def test_presets_of_a_scene_and_of_a_component_alone():
    scene = scene_of("en50318-2002", ["pantograph.head_mass=7"], ["pantograph=DSA380"], {"stop_time": 1.0})
    assert (scene.units["pantograph"].preset, scene.units["pantograph"].parameters["head_mass"]) == ("DSA380", 7)
    assert "DSA380" in scene.title
    assert preset_of(["DSA380"]) == "DSA380"
    assert preset_of(None) == ""
    for texts in (["pantograph=DSA380"], ["DSA250", "DSA380"]):
        with pytest.raises(BadInput, match="one preset of a component alone"):
            preset_of(texts)


@pytest.mark.parametrize(
    "arguments",
    [
        ("accuracy", "SCENE", "-o", "x"),
        ("stability", "SCENE", "-o", "x"),
        ("effects", "SCENE", "-o", "x"),
        ("show", "SCENE"),
        ("ssp", "SCENE", "-o", "x.ssp"),
        ("sweep", "SCENE", "--over", "pantograph.speed=50:60:2", "-o", "x"),
        ("run", "SCENE"),
        ("build", "--native", "--scene", "SCENE", "-o", "x"),
        ("accuracy", "component:Pantograph", "-o", "x"),
        ("show", "Pantograph"),
    ],
)
def test_every_command_of_scenes_and_components_takes_presets(arguments, tmp_path, monkeypatch, capsys):
    """A wrong name is refused with the nearest one, before anything runs."""
    monkeypatch.chdir(tmp_path)
    given = [a.replace("SCENE", "en50318-2002") for a in arguments]
    preset = "pantograph=DSA381" if "en50318-2002" in given else "DSA381"
    assert exit_code(*given, "--preset", preset) == 2
    assert "Did you mean 'DSA380'" in capsys.readouterr().err
