"""Foreign code behind walls: what it tries there, and what a run's record says of them."""

from __future__ import annotations

import json
import os
import pickle
import sys
from pathlib import Path

import numpy as np
import pytest
from cosimo.components.core.errors import BadInput, StepFailed
from cosimo.fmus.build import built
from cosimo.orchestrator.cli import main
from cosimo.orchestrator.run import run
from cosimo.orchestrator.systems import read_scene
from cosimo.orchestrator.units.walls import clean_environment, read_answer
from cosimo.tests.support import two_masses
from cosimo.tests.units.exchange_fmu import exchange_fmu

linux = pytest.mark.skipif(sys.platform != "linux", reason="walls of Linux")


def curious(isolation: str, kind: str = "Curious") -> dict:
    unit = {"component": f"cosimo.tests.units.troubled:{kind}", "isolation": isolation}
    return {"stop_time": 0.2, "units": {"u": unit}, "master": {"step": 0.1}}


@linux
@pytest.mark.parametrize("isolation", ["process", "restricted"])
def test_what_a_unit_can_do_behind_walls(isolation, tmp_path, monkeypatch):
    monkeypatch.setenv("COSIMO_TEST_SECRET", "a password")
    result = run(read_scene(curious(isolation)), output=tmp_path)
    assert result.outcome == "done", result.message
    target = Path(__file__).parent / "written-by-a-unit"
    walled = isolation == "restricted"
    walls = result.info["units"]["u"].get("walls", [])
    written = target.exists()
    target.unlink(missing_ok=True)
    assert result["u.own"][-1] == 1.0
    assert result["u.secret"][-1] == (not walled)
    assert bool(walls) == walled
    stand = " ".join(walls)
    assert result["u.memory"][-1] == ("memory" not in stand)
    if walled and "landlock" in stand:
        assert not written
    if walled and ("seccomp" in stand):
        assert result["u.network"][-1] == 0.0
        assert result["u.kills"][-1] == 0.0
    if not walled:
        assert written
        assert result["u.network"][-1] == result["u.kills"][-1] == 1.0


def test_an_object_that_a_unit_forges_is_not_brought_to_life():
    result = run(read_scene(curious("restricted", "Forger")))
    assert result.outcome == "failed"
    assert "something else than answers came from its worker process" in result.message


def test_answers_hold_data_only():
    for value in ([1.0, "text", None, {"a": (1, b"x")}], (StepFailed, ("u", 0.5, "reason")), (BadInput, ("a", "b", "c"))):
        assert read_answer(pickle.dumps(value)) == value
    array = np.arange(6.0).reshape(2, 3)
    assert read_answer(pickle.dumps(array)).tolist() == array.tolist()
    assert read_answer(pickle.dumps(np.float64(2.5))) == 2.5
    for value in (os.system, Path("x"), json.loads, type):
        with pytest.raises(pickle.UnpicklingError, match="no part of an answer"):
            read_answer(pickle.dumps(value))


def test_the_environment_of_a_walled_worker(monkeypatch):
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", "x")
    environment = clean_environment("/there")
    assert environment["HOME"] == "/there"
    assert "PATH" in environment
    assert not [name for name in environment if "SECRET" in name or "TOKEN" in name]


def test_the_same_bits_behind_walls():
    scene = two_masses("jacobi", 5e-3, 1)
    plain = run(read_scene(scene))
    walled = run(read_scene({**scene, "units": {n: {**u, "isolation": "restricted"} for n, u in scene["units"].items()}}))
    assert walled.outcome == "done", walled.message
    assert all(plain[name].tobytes() == walled[name].tobytes() for name in plain.columns)


def test_the_option_is_for_foreign_code(tmp_path, capsys):
    with pytest.raises(SystemExit) as end:
        main(["run", "mass-on-spring", "--isolate", "--dry-run"])
    assert end.value.code == 2
    assert "all of whose units are components of the catalogue" in capsys.readouterr().err
    with pytest.raises(BadInput, match="an FMU or module:Class"):
        read_scene(
            {"stop_time": 1.0, "master": {"step": 0.1}, "units": {"p": {"component": "Pantograph", "isolation": "restricted"}}}
        )
    path = tmp_path / "foreign.toml"
    path.write_text('units.m.component = "cosimo.tests.support:Mass"\nmaster.step = 0.01\nstop_time = 0.1\n')
    with pytest.raises(SystemExit) as end:
        main(["run", str(path), "--isolate", "-o", str(tmp_path / "out")])
    assert not end.value.code
    info = json.loads((tmp_path / "out" / "run.json").read_text())
    assert info["scene"]["units"]["m"]["isolation"] == "restricted"
    assert info["scene"]["title"] == ""


@pytest.mark.parametrize(
    "maker", [exchange_fmu, pytest.param(lambda: str(built("Pantograph")), marks=pytest.mark.full)], ids=["compiled", "pythonfmu"]
)
def test_fmus_behind_walls(maker):
    """They are unpacked, loaded and stepped there; an FMU of pythonfmu brings an interpreter with it."""
    scene = {"stop_time": 0.02, "units": {"u": {"fmu": maker()}}, "master": {"step": 1e-3}}
    plain = run(read_scene(scene))
    walled = run(read_scene({**scene, "units": {"u": {**scene["units"]["u"], "isolation": "restricted"}}}))
    assert (plain.outcome, walled.outcome) == ("done", "done"), walled.message
    assert all(plain[name].tobytes() == walled[name].tobytes() for name in plain.columns)
