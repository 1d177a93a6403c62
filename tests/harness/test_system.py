"""A system whose folder has a part of what a system may have, and a list that names one that is not there."""

import re

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator import systems
from cosimo.orchestrator.harness import report
from cosimo.orchestrator.harness.system import System
from cosimo.orchestrator.harness.validation.shipped import shipped_cases


def test_a_folder_without_modules_has_no_cases_figures_summary_or_motion(tmp_path, monkeypatch):
    bare = System("bare", "Bare", "cosimo.components.core")  # a package that has none of them
    monkeypatch.setitem(systems.SYSTEMS, "bare", bare)
    monkeypatch.setitem(systems.KNOWN_SYSTEMS.models, "bare", bare.keys)
    units = {"b": {"component": "JeffcottRotor", "parameters": {"start_speed": 10.0}}}
    result = systems.run(systems.build_scene(units, stop_time=0.1, step=1e-3, analysis={"system": "bare"}), in_process=True)
    assert (list(shipped_cases(bare.package, bare.name, systems.load_scene)), bare.headline, bare.explore) == ([], (), None)
    assert (bare.figures(result), bare.motions(result), bare.summary(result)) == ([], [], ())
    page = report.for_run(result, tmp_path, systems.SYSTEMS).read_text(encoding="utf-8")
    assert "b.displacement_x" in page


def test_a_module_that_is_there_and_broken_is_not_taken_for_absent(tmp_path, monkeypatch):
    (tmp_path / "half_a_system").mkdir()
    (tmp_path / "half_a_system" / "__init__.py").touch()
    (tmp_path / "half_a_system" / "figures.py").write_text("import not_there\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ModuleNotFoundError, match="not_there"):
        _ = System("half", "Half", "half_a_system").figures


def test_a_misspelt_name_in_the_list_of_systems_is_one_message():
    with pytest.raises(BadInput, match=re.escape("'railwey', expected a folder") + ".*Did you mean 'railway'"):
        systems._system("railwey")


def test_a_folder_whose_object_has_another_name_is_one_message(monkeypatch):
    monkeypatch.setattr("cosimo.orchestrator.systems.wrist.SYSTEM", System("wirst", "Wrist", "cosimo"))
    with pytest.raises(BadInput, match=r"wrist.*SYSTEM = System\('wrist'"):
        systems._system("wrist")
