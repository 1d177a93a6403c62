"""A line's table as a file: in a scene, on the command line, as tables for a crew and as drawings."""

import csv
import json
from xml.etree import ElementTree as ET

import pytest
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.cli import app
from cosimo.orchestrator.scene.files import SHIPPED
from cosimo.orchestrator.systems import load_scene
from cosimo.orchestrator.systems.railway import line
from typer.testing import CliRunner

LINES = sorted((SHIPPED / "railway" / "lines").glob("*.toml"))
SCENE = """stop_time = 0.1
connections = ["pantograph.contact_force -> catenary.contact_force", "catenary.wire_height -> pantograph.wire_height",
               "pantograph.contact_position -> catenary.contact_position"]
[units.catenary]
component = "Catenary"
effects = ["line_table"]
parameters = { line_table.table = "lines/mine.toml" }
[units.pantograph]
component = "Pantograph"
[master]
algorithm = "gauss-seidel"
step = 1e-3
"""


@pytest.mark.parametrize("path", LINES, ids=lambda p: p.stem)
def test_a_crew_gets_every_dropper(path, tmp_path):
    form, title = line.read(path, {})
    droppers, supports, drawing = line.save(form, title, tmp_path)
    with droppers.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == form.length.size
    assert [float(r["cut length [m]"]) for r in rows] == pytest.approx(form.cut_length, abs=5.1e-5)
    assert all(float(r["length [m]"]) > float(r["cut length [m]"]) > 0.0 for r in rows)
    assert len(supports.read_text(encoding="utf-8").splitlines()) == form.support.size + 1
    picture = ET.parse(drawing).getroot()
    assert len(picture.findall("{*}polyline")) == len(form.layout.supports) + form.length.size + len(form.layout.wires)
    text = line.text_drawing(form, 100).splitlines()
    assert max(map(len, text)) <= 130
    assert sum(row.count("^") for row in text[-3:-2]) == form.layout.supports.size


def test_a_scene_takes_over_the_text_of_its_line(tmp_path):
    (tmp_path / "lines").mkdir()
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8")
    with pytest.raises(BadInput, match=r"mine\.toml"):
        load_scene(tmp_path / "scene.toml")
    table = "[[sections]]\nspans = [40, 50, 60]\n"
    (tmp_path / "lines" / "mine.toml").write_text(table, encoding="utf-8")
    scene = load_scene(tmp_path / "scene.toml")
    (tmp_path / "lines" / "mine.toml").unlink()
    assert scene.with_changes({"stop_time": 0.2}).units["catenary"].parameters["line_table.table"] == table


def test_commands_show_a_line_and_its_schema(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text('title = "Mine"\n[[sections]]\nspans = [40, 50, 60]\n', encoding="utf-8")
    for command in (["show", str(file)], ["railway", "line", str(file), "-o", str(tmp_path / "out")]):
        done = CliRunner().invoke(app, command)
        assert done.exit_code == 0, done.output
        assert "Mine" in done.output
        assert "cut length" in done.output
    assert (tmp_path / "out" / "line.svg").exists()
    done = CliRunner().invoke(app, ["railway", "line", "--schema"])
    assert "sections" in json.loads(done.output)["properties"]
