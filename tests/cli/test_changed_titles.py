"""Titles of pages: what a scene says of itself stands there only as long as it holds."""

import re

import pytest
from cosimo.orchestrator.cli.common import changed
from cosimo.orchestrator.systems import load_scene
from cosimo.tests.commands import exit_code, python

SCENE = load_scene("mass-on-spring")


def title_of(page):
    return re.search(r"<h1[^>]*>(.*?)</h1>", page.read_text(encoding="utf-8"), re.DOTALL)[1]


def run(*arguments):
    assert exit_code(*map(str, arguments)) == 0


def test_a_changed_scene_is_titled_as_changed(tmp_path):
    run("run", "mass-on-spring", "--in-process", "--stop", 0.5, "--set", "spring.stiffness=250.5", "-o", tmp_path)
    assert title_of(tmp_path / "report.html") == "mass-on-spring, changed: spring.stiffness = 250.5"


def test_a_scene_as_it_was_written_keeps_its_title():
    assert changed(SCENE, {}).title == SCENE.title
    assert changed(SCENE, {"master.step": 1e-3, "stop_time": 2.0}).title == SCENE.title  # how it is computed, and how long
    assert changed(SCENE, {"units.mass.tolerances.mass": "1 %"}).title == SCENE.title  # how well it is known


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"mass.effects.gravity": True}, "mass: effect gravity"),
        ({"mass.effects.gravity": False}, "mass: without effect gravity"),
        ({f"spring.{p}": 1.0 for p in ("stiffness", "damping")}, "spring.stiffness = 1, spring.damping = 1"),
    ],
)
def test_titles_name_what_was_changed(changes, text):
    assert changed(SCENE, changes).title == f"mass-on-spring, changed: {text}"


def test_a_sweep_is_titled_by_what_is_swept_and_names_the_changes(tmp_path):
    run("sweep", "mass-on-spring", "--over", "spring.stiffness=100:300:2", "--set", "spring.damping=2.5", "-o", tmp_path)
    assert title_of(tmp_path / "report.html") == "Sweep of spring.stiffness, 100 to 300 N/m"
    assert "mass-on-spring, changed: spring.damping = 2.5" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_a_table_by_its_file_is_a_number_of_lines_in_the_title(tmp_path):
    """And two of them, beside a wind from another file, are compared by their rows."""
    rotor = "tip_speed_ratio;power_coefficient\n0,4;0,03\n1,2;0,26\n2,4;0\n"
    for name, text in (("one", rotor), ("two", rotor.replace("0,26", "0,28"))):
        (tmp_path / f"{name}.csv").write_text(text, encoding="utf-8")
        table = f"turbine.performance_table.table={tmp_path / name}.csv"
        sets = ("--set", "turbine.effects.performance_table=true", "--set", table)
        run("run", "wind-pump-record", "--in-process", "--no-verify", "--stop", 1, *sets, "-o", tmp_path / name)
    assert "turbine.performance_table.table = a table of 4 lines" in title_of(tmp_path / "one" / "report.html")
    compare = "import sys; from cosimo.orchestrator.cli import main; main(['compare', *sys.argv[1:]])"
    printed = python(compare, tmp_path / "one", tmp_path / "two")  # in a process that has not read the tables
    assert re.search(r"turbine.performance_table.table │ 1,2;0,26 │ 1,2;0,28", printed)
