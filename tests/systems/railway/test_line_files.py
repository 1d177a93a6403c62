"""A line's table as a file: in a scene, on the command line, as tables for a crew and as drawings."""

import csv
import json
from xml.etree import ElementTree as ET

import pytest
from cosimo import BadInput, load_scene
from cosimo.components.railway.catenary import Catenary
from cosimo.components.railway.line.from_table import dropper_positions, resolved_sections
from cosimo.components.railway.line.table import read_line
from cosimo.orchestrator.cli.application import app
from cosimo.orchestrator.scene.files import SHIPPED
from cosimo.orchestrator.systems.railway import line
from cosimo.orchestrator.systems.railway.figures import line_sketches
from cosimo.orchestrator.systems.railway.records import _track
from cosimo.tests.systems.railway.made_up import made_up_run
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
    assert [float(r["cut length [m]"]) for r in rows] == pytest.approx(form.cut_length, abs=1e-12)
    assert all(float(r["length [m]"]) > float(r["cut length [m]"]) > 0.0 for r in rows)
    assert len(supports.read_text(encoding="utf-8").splitlines()) == form.support.size + 1
    picture = ET.parse(drawing).getroot()
    lateral = form.layout.lateral
    in_plan = len(set(lateral[:, 0])) if lateral.size and lateral[:, 2].any() else 0  # contact wires, where they are staggered
    assert len(picture.findall("{*}polyline")) == len(form.layout.supports) + form.length.size + len(form.layout.wires) + in_plan
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


@pytest.mark.parametrize("path", LINES, ids=lambda p: p.stem)
@pytest.mark.parametrize("height", [True, False], ids=["heights", "lengths"])
def test_the_table_of_a_crew_gives_the_same_line_again(path, height, tmp_path):
    """As it was written, and with cut lengths instead of heights."""
    form, title = line.read(path, {})
    file = line.save(form, title, tmp_path)[0]
    if not height:
        rows = list(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))
        keep = [c for c in rows[0] if c != "height [m]"]
        file.write_text("\n".join([",".join(keep), *(",".join(r[c] for c in keep) for r in rows)]), encoding="utf-8")
    again, _ = line.read(path, {}, file)
    both = again.layout.droppers, form.layout.droppers
    for name in ("position", "lower", "upper", "stiffness", "mass_below", "mass_above", "height"):
        assert getattr(both[0], name) == pytest.approx(getattr(both[1], name), rel=1e-9, abs=1e-9), name
    assert again.length == pytest.approx(form.length, abs=1e-9)
    assert again.preload == pytest.approx(form.preload, rel=1e-9, abs=1e-5)  # a length of 1e-10 m is 2e-5 N
    assert again.reaction == pytest.approx(form.reaction, rel=1e-9, abs=1e-5)


TWO_SPANS = "[[sections]]\ndroppers.stiffness = 2e5\nspans = [40, 50]\n"
DROPPERS = "position [m],height [m],cut length [m],stiffness [N/m]\n10,0.01,,\n30,,1.05,\n50,0,,1e5\n80,0,,\n"


@pytest.mark.parametrize(
    "write",
    [
        lambda text: text,
        lambda text: "\ufeff" + text.replace("\n", "\r\n"),
        lambda text: text.replace(",", ";").replace(".", ","),
        lambda text: text.replace(",", "\t").replace(".", ",") + "\t\t\t\n",
    ],
    ids=["plain", "with a byte order mark", "semicolons and decimal commas", "tabs"],
)
def test_droppers_of_spreadsheets_are_read(write):
    values = {"line_table.table": TWO_SPANS, "line_table.droppers": write(DROPPERS), "method": "implicit"}
    form = Catenary(["line_table"], values).form()
    d = form.layout.droppers
    assert d.position.tolist() == [10.0, 30.0, 50.0, 80.0]
    assert d.stiffness.tolist() == [2e5, 2e5, 1e5, 2e5]
    assert d.height[[0, 2, 3]].tolist() == [0.01, 0.0, 0.0]
    assert form.cut_length[1] == pytest.approx(1.05, abs=1e-9)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("height [m]\n1", "no column 'position'"),
        ("position\n1", r"column 'position': got no unit, .* m or mm\? Write 'position \[m\]'"),
        ("position [N]\n1", r"column 'position \[N\]': got unit 'N', expected a unit of the dimension of m"),
        ("position [m],position [m]\n1,2", "each column once"),
        ("position [m],height [m]\n10,5,3", "line 2: got 3 cells, expected 2.*Decimal commas need semicolons"),
        ("position [m],height [m]\n10,abc", r"line 2, column 'height \[m\]': got 'abc', expected a number in m"),
        ("position [m],mass [kg]\n10,-1", "line 2, mass: got -1"),
        ("position [m],height [m]\n,5", "line 2: got no position"),
        ("position [m]\n40", "line 2: got a dropper of contact wire 1 at 40 m, expected a place inside a span"),
        ("position [m],contact wire\n10,2", "line 2: got a dropper of contact wire 2"),
        ("position [m]\n10\n10", "increasing positions"),
        ("position [m]\n", "no row"),
        (DROPPERS.replace("0.01,,", "0.01,0.9,"), "a cut length of 0.9 of the dropper at 10 m.*which follows"),
    ],
)
def test_droppers_that_cannot_be_are_one_message(text, message):
    with pytest.raises(BadInput, match=message):
        Catenary(["line_table"], {"line_table.table": TWO_SPANS, "line_table.droppers": text, "method": "implicit"}).form()


def test_a_scene_takes_over_its_droppers(tmp_path):
    """From the file that the scene names; the marks of the report are at these droppers."""
    (tmp_path / "mine.toml").write_text(TWO_SPANS, encoding="utf-8")
    (tmp_path / "droppers.csv").write_text(DROPPERS, encoding="utf-8")
    text = SCENE.replace('"lines/mine.toml"', '"mine.toml", line_table.droppers = "droppers.csv"')
    (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
    values = load_scene(tmp_path / "scene.toml").units["catenary"].parameters
    assert values["line_table.droppers"] == DROPPERS
    assert _track(values).droppers == (10.0, 30.0, 50.0, 80.0)


def test_the_command_takes_droppers_and_refuses_what_they_leave_no_use_for(tmp_path):
    file, droppers = tmp_path / "mine.toml", tmp_path / "mine.csv"
    file.write_text(TWO_SPANS, encoding="utf-8")
    droppers.write_text(DROPPERS, encoding="utf-8")
    done = CliRunner().invoke(app, ["railway", "line", str(file), "--droppers", str(droppers), "-o", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert len((tmp_path / "out" / "droppers.csv").read_text(encoding="utf-8").splitlines()) == 5
    with pytest.raises(BadInput, match=r"dropper_stiffness = 300000\.0"):
        line.read(file, {"dropper_stiffness": 3e5})
    with pytest.raises(BadInput, match="span_length"):
        line.read(file, {"span_length": 50.0})


STAGGERED = (
    """[[sections]]
contact_wire.tension = 22e3
support.arm = { length = 1.2, angle = 10.0, mass = 0.9 }
spans = [{ length = 60, repeat = 10 }]
supports = """
    + str([{"stagger": 0.2 * (-1) ** k} for k in range(11)]).replace("'stagger':", "stagger =")
    + "\n"
)


def test_the_line_of_a_report_is_drawn_to_scale_about_the_window():
    """Spans 5 and 6: supports, droppers and stagger where the table has them, 880 px for 120 m."""
    run = made_up_run()
    values = {"line_table.table": STAGGERED, "method": "implicit"}
    run.scene = run.scene.with_changes({"units.catenary.effects": ["line_table"], "units.catenary.parameters": values})
    (sketch,) = line_sketches(run)
    drawing = ET.fromstring(sketch.svg)
    lines = [[tuple(map(float, at.split(","))) for at in e.get("points").split()] for e in drawing.findall("{*}polyline")]
    at = lambda x: pytest.approx(40.0 + (x - 240.0) * 880.0 / 120.0, abs=0.06)  # noqa: E731
    supports, droppers = lines[:3], lines[3:21]
    assert [points[0][0] for points in supports] == [at(x) for x in (240.0, 300.0, 360.0)]
    section = resolved_sections(read_line(STAGGERED))
    inside = [x for x in dropper_positions(section) if 240.0 < x < 360.0]
    assert [points[0][0] for points in droppers] == [at(x) for x in inside]
    form = Catenary(["line_table"], values).form()
    lengths = form.length[(form.layout.droppers.position > 240.0) & (form.layout.droppers.position < 360.0)]
    assert [a - b for (_, a), (_, b) in droppers] == pytest.approx(80.0 * lengths, abs=0.11)  # 80 px a metre up
    contact, messenger, plan = lines[21:]
    assert [(x, round(y, 1)) for x, y in plan] == [
        (at(x), plan[0][1] - 120.0 * b) for x, b in ((240.0, 0.0), (300.0, -0.4), (360.0, 0.0))
    ]
    assert [points[0][0] for points in (contact, messenger)] == [at(240.0)] * 2
    assert [points[-1][0] for points in (contact, messenger)] == [at(360.0)] * 2
    assert sum(e.text == "+293 N" for e in drawing.findall("{*}text")) == 2  # 4 b T / L


def test_a_uniform_line_has_no_drawing_of_its_own():
    assert line_sketches(made_up_run()) == []


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
