"""What foreign names and places become in the files of a run and of a sweep: text as text, no name two files, no home directory."""

import csv
import json
from pathlib import Path
from xml.etree import ElementTree

import pytest
from cosimo import Result, load_scene, read_scene, run, write_scene
from cosimo.components.core.errors import UNSEEN
from cosimo.tests.commands import exit_code
from cosimo.tests.units.native import STATE, native_fmu

NASTY = "a&#10;b&#13;c&#9;&#x202e;&lt;script&gt;alert(1)&lt;/script&gt;,&quot;'/../&#x85;&#x2028;"
READ = "a\nb\rc\t\u202e<script>alert(1)</script>,\"'/../\x85\u2028"


@pytest.fixture
def scene(tmp_path, monkeypatch):
    """A scene whose FMUs lie below the home directory: names that are hard to write, and names that differ in capitals alone."""
    monkeypatch.setenv("HOME", str(tmp_path / "somebody"))
    folder = tmp_path / "somebody" / "models"
    folder.mkdir(parents=True)
    monkeypatch.chdir(folder)
    titled = ('modelName="van_der_pol"', f'modelName="van_der_pol" description="{NASTY}"')
    for file, name in (("Nasty.fmu", NASTY), ("cased.fmu", "X0"), ("nasty.fmu", "y" * 400)):
        changed = native_fmu("van_der_pol", 2, STATE[2], ('name="x1"', f'name="{name}"'), titled)
        Path(file).write_bytes(Path(changed).read_bytes())
    parts = {"N": "Nasty.fmu", "A": "cased.fmu", "a": "cased.fmu", "long": "nasty.fmu"}
    units = "".join(f'[units.{name}]\nfmu = "{file}"\n' for name, file in parts.items())
    title = json.dumps("\u202e\x1b title")
    Path("s.toml").write_text(f"title = {title}\nstop_time = 1.0\nmaster.step = 0.1\n{units}")
    return folder / "s.toml"


def test_files_of_a_run(scene):
    assert exit_code("run", scene, "-o", "out", "--no-verify") == 0
    page, info = (Path("out", name).read_text() for name in ("report.html", "run.json"))
    assert not UNSEEN.search(page)
    assert "<script>alert" not in page
    assert "\u27e8202E\u27e9&lt;script&gt;" in page
    assert str(scene.parent) not in page + info
    assert json.loads(info)["scene"]["units"]["A"]["fmu"] == "~/models/cased.fmu"
    with open("out/result.csv", newline="") as file:
        assert next(csv.reader(file)) == [
            "time",
            "N.x0",
            f"N.{READ}",
            "A.x0",
            "A.X0",
            "a.x0",
            "a.X0",
            "long.x0",
            f"long.{'y' * 400}",
        ]
    again = Result.read("out")
    assert again.scene.units["A"].fmu == str(scene.parent / "cased.fmu")
    assert again["A.X0"].tobytes() == run(load_scene(scene), verify="no")["A.X0"].tobytes()
    assert "\u202e" not in again._repr_html_()


def test_a_drawing_is_xml_whatever_a_title_holds(scene):
    assert exit_code("show", scene, "-o", "drawn") == 0
    text = Path("drawn/s.svg").read_text()
    ElementTree.fromstring(text)
    assert not UNSEEN.search(text)


def test_a_data_set_has_a_folder_for_each_name(scene):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("zarr")
    assert exit_code("sweep", scene, "--over", "A.mu=1,2", "--over", "a.mu=1,2", "-o", "out") == 0
    data = xarray.open_zarr("out/sweep.zarr", consolidated=False)
    names = [str(name) for name in data.variables]
    assert len({name.casefold() for name in names}) == len(names)
    assert all(name.isprintable() and "/" not in name and len(name) < 200 for name in names)
    long_names = {one.attrs.get("long_name") for one in data.variables.values()}
    assert {f"{signal}, mean" for signal in ("A.x0", "A.X0", "a.x0", "a.X0", f"N.{READ}", f"long.{'y' * 400}")} <= long_names
    assert {"A.mu", "a.mu"} <= long_names
    assert str(scene.parent) not in json.dumps(data.attrs, default=str) + Path("out/sweep.json").read_text()


def test_fmus_whose_files_would_be_one(scene, capsys):
    """Packed with numbers, and refused where each name is that of a file."""
    scene.write_text(scene.read_text().partition("\n")[2])  # XML holds no such title
    assert exit_code("ssp", scene, "-o", "s.ssp", "--force") == 0
    assert {u.fmu.rpartition("/")[2] for u in load_scene("s.ssp").units.values()} == {"Nasty.fmu", "cased.fmu", "nasty_2.fmu"}
    units = {name: {"component": "PlanarLink"} for name in ("Mass", "mass")}
    write_scene(read_scene({"stop_time": 1.0, "units": units, "master": {"step": 0.1}}), "two.toml")
    capsys.readouterr()
    assert exit_code("build", "--native", "--scene", "two.toml", "-o", "built") == 2
    assert "'Mass' and 'mass', whose FMUs would be one file" in capsys.readouterr().err
    assert exit_code("build", "a.b:Engine", "c.d:engine", "-o", "built") == 2
    assert "'a.b:Engine' and 'c.d:engine'" in capsys.readouterr().err
