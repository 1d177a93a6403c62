"""What a shell completes, and that it does so without importing components."""

from __future__ import annotations

import subprocess
import sys
from types import SimpleNamespace

import pytest
from cosimo.components.catalogue import CATALOGUE
from cosimo.orchestrator.cli import completion
from cosimo.orchestrator.scene.scene import scene_files
from cosimo.tests.architecture.test_light_imports import HEAVY


@pytest.fixture
def names(tmp_path, monkeypatch):
    monkeypatch.setenv("COSIMO_CACHE", str(tmp_path))
    return completion.catalogue()


def context(scene="", args=()):
    return SimpleNamespace(params={"scene": scene or None}, args=list(args))


def test_names_of_everything(names):
    assert set(names["components"]) == set(CATALOGUE)
    assert set(names["scenes"]) == set(scene_files())
    assert completion.components("Pan") == ["Pantograph"]
    assert "en50318-2002" in completion.scenes("en50")
    assert completion.kinds_and_systems("ro") == ["rotor", "rov"]


def test_parameters_effects_and_presets_of_a_scene(names, tmp_path):
    assert completion.parameters(context("en50318-2002"), "pantograph.bump") == [
        "pantograph.bump_stops.stiffness=", "pantograph.bump_stops.travel="]
    assert completion.effects(context(args=["--in-process", "en50318-2002"]), "pantograph.bu") == ["pantograph.bump_stops"]
    assert completion.presets(context("en50318-2002"), "pantograph=DSA2") == ["pantograph=DSA250"]
    assert completion.presets(context("Pantograph"), "DSA2") == ["DSA250"]
    own = tmp_path / "own.toml"
    own.write_text('units.p.component = "Pantograph"\n')
    assert "p.speed=" in completion.parameters(context(str(own)), "p.")
    assert completion.parameters(context(str(tmp_path / "missing.toml")), "p") == []


def test_scene_files_are_offered(names, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").touch()
    (tmp_path / "notes.txt").touch()
    (tmp_path / "mill").mkdir()
    assert completion.scenes("mi") == ["mill/", "mine.toml"]


def test_a_kept_catalogue_imports_no_component(names):
    code = ("import sys\nfrom cosimo.orchestrator.cli import completion\nassert completion.components('Pan') == ['Pantograph']\n"
            "print(*{m.split('.')[0] for m in sys.modules})")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert set(done.stdout.split()) & HEAVY == set()


def test_damage_of_the_kept_catalogue_heals(names, tmp_path):
    (kept,) = (tmp_path / "completion").glob("*.json")
    kept.write_text("{")
    assert completion.catalogue() == names
    assert len(list((tmp_path / "completion").iterdir())) == 1
