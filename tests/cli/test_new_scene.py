"""`cosimo new line, scene, case, table`: from files of a crew and of a measurement to a judged report, without copied connections."""

import json
import tomllib

import numpy as np
import pytest
from cosimo import load_scene
from cosimo.components.railway.line.table import read_line
from cosimo.orchestrator.systems.railway.frequency_response import receptance
from cosimo.tests.commands import exit_code

HEADS = "position [m];section;contact height [m];system height [m];held;contact stiffness [N/m]"
FITTED = {"head_mass": 7.2, "head_stiffness": 4200.0, "head_damping": 10.0,
          "frame_mass": 15.0, "frame_stiffness": 50.0, "frame_damping": 90.0}  # fmt: skip


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder with the supports of an overlap, German decimals, and the frequency response of a pantograph."""
    first = [(x, 5.3, 1.2) for x in (0, 50, 100, 150, 200, 250, 300)] + [(350, 5.36, 1.2), (400, 5.8, 1.0), (450, 6.2, 0.8)]
    second = [(300, 6.2, 0.8), (350, 5.8, 1.0), (400, 5.36, 1.2)] + [(x, 5.3, 1.2) for x in range(450, 901, 50)]
    rows = [(x, k, h, s, "yes;50000" if h == 5.8 else ";") for k, own in ((1, first), (2, second)) for x, h, s in own]
    text = "\n".join([HEADS, *(f"{x};{k};{h};{s};{held}".replace(".", ",") for x, k, h, s, held in rows)])
    (tmp_path / "supports.csv").write_text(text, encoding="utf-8")
    frequency = np.arange(0.5, 20.01, 0.5)
    lines = [f"{f},{z.real},{z.imag}" for f, z in zip(frequency, receptance(frequency, FITTED), strict=True)]
    (tmp_path / "head.csv").write_text("\n".join(["frequency [Hz],real [m/N],imaginary [m/N]", *lines]))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.full
def test_five_commands_from_a_crews_files_to_a_judged_report(folder):
    assert exit_code("new", "line", "line.toml", "supports.csv", "--contact-tension", "22 kN") == 0
    assert exit_code("railway", "fit-pantograph", "head.csv", "--masses", 2, "-o", "fitted") == 0
    two = ["--pantograph", "fitted/pantograph.toml", "--pantographs", 2, "--distance", 100, "--speed", "160 km/h"]
    assert exit_code("new", "scene", "mine.toml", "--line", "line.toml", *two) == 0
    assert exit_code("new", "case", "case.toml", "mine.toml", "--speeds", "160 km/h, 220 km/h", "--limits", "en50367") == 0
    assert exit_code("validate", "case.toml", "-o", "out", "--in-process", "--no-verify") == 0
    (case,) = json.loads((folder / "out" / "validation.json").read_text())["cases"]
    assert case["outcome"] == "unconfirmed"
    lines = (folder / "mine.toml").read_text(encoding="utf-8")
    assert "static_force = 120  # N, of EN 50318:2002: give that of your pantograph" in lines
    assert "working_height = 0  # m, default" in lines
    conditions = {row["condition"] for row in case["rows"]}
    assert "160 km/h: leading.both_wires, AC up to 200 km/h" in conditions
    assert "220 km/h: trailing.both_wires, AC above 200 km/h" in conditions
    assert load_scene("mine.toml").units["leading"].parameters["head_mass"] == pytest.approx(7.2, rel=1e-6)


def test_winter_summer_wear_and_stitch_wires_are_options(folder, capsys):
    """One line, one scene, one case with a run for each of them; what a fitted pantograph does not know is asked for or told."""
    rows = "\n".join(str(50 * k) for k in range(9))
    (folder / "plain.csv").write_text(f"position [m]\n{rows}\n")
    stitch = ("--stitch-half-length", "9 m", "--stitch-tension", "3.5 kN", "--stitch-mass", "0.31 kg/m")
    assert (
        exit_code("new", "line", "line.toml", "plain.csv", "--messenger-axial-stiffness", "11.6 MN", "--wear", "10%", *stitch)
        == 0
    )
    section = read_line((folder / "line.toml").read_text(encoding="utf-8")).sections[0]
    assert (section.messenger.fixed, section.messenger.axial_stiffness, section.span.wear) == (True, 11.6e6, 0.1)
    assert (section.stitch.half_length, section.stitch.tension, section.stitch.mass) == (9.0, 3500.0, 0.31)
    values = "\n".join(f"{key} = {value}" for key, value in FITTED.items())
    (folder / "fitted.toml").write_text(f'[units.mine]\ncomponent = "Pantograph"\n[units.mine.parameters]\n{values}\n')
    assert "7 messenger supports between the anchors, " in capsys.readouterr().out
    for preset, told in (("EN 50318:2018", True), ("DSA250", False)):  # one without a static force of its own, one with
        named = ("--line", "line.toml", "--speed", "120 km/h", "--pantograph", preset)
        assert exit_code("new", "scene", f"{preset[:2]}.toml", *named) == 0
        assert ("static_force = 120 N, of EN 50318:2002: give that of" in capsys.readouterr().err) == told
    fitted = ("--line", "line.toml", "--pantograph", "fitted.toml", "--speed", "120 km/h")
    assert exit_code("new", "scene", "told.toml", *fitted) == 0
    assert "static_force = 120 N, of EN 50318:2002: give that of your pantograph" in capsys.readouterr().err
    own = ("--static-force", "90 N", "--working-height", "0.1 m")
    assert exit_code("new", "scene", "mine.toml", *fitted, *own, "--temperature", "-10", "--wear", "0%") == 0
    assert "static_force" not in capsys.readouterr().err
    scene = load_scene("mine.toml")
    given = scene.units["pantograph"].parameters
    assert (given["static_force"], given["working_height"]) == (90.0, 0.1)
    assert scene.units["catenary"].parameters["temperature.change"] == -10.0
    seasons = ("--over", "catenary.temperature.change=-30,40", "--over", "catenary.wear.share=0:0.2:3")
    assert exit_code("new", "case", "case.toml", "mine.toml", "--speeds", "120 km/h", *seasons, "--limits", "en50367") == 0
    runs = tomllib.loads((folder / "case.toml").read_text(encoding="utf-8"))["runs"]
    assert len(runs) == 6
    assert runs[0]["condition"] == "120 km/h, temperature.change = -30, wear.share = 0"
    assert scene.with_changes(runs[-1]["changes"]).units["catenary"].parameters["wear.share"] == pytest.approx(0.2)
    for arguments, named in (
        (
            ("case", "new.toml", "mine.toml", "--over", "catenary.temprature.change=1,2", "--limits", "en50367"),
            "temperature.change",
        ),
        (("case", "new.toml", "mine.toml", "--over", "catenary.wear.share=0.9,0.1", "--limits", "en50367"), "0.9"),
        (("scene", "new.toml", *fitted, "--static-force", "90"), "90 N"),
        (("scene", "new.toml", *fitted, "--wear", "20"), "20%"),
    ):
        assert exit_code("new", *arguments) == 2, arguments
        assert named in capsys.readouterr().err, arguments
    assert not (folder / "new.toml").exists()


COMPOUND = ("--messenger-tension", "24.5 kN", "--auxiliary-tension", "14.7 kN", "--auxiliary-mass", "1.375 kg/m")
ABOVE = ("--auxiliary-height", "0.15 m")


def test_a_compound_line_is_written_from_its_supports(folder, capsys):
    """In an overlap with main droppers at distances, and in a plain line where each span counts its own; with two contact wires, too."""
    placed = ("--first-main-dropper", "6 m", "--main-dropper-gap", "9 m", "--auxiliary-axial-stiffness", "18 MN")
    assert exit_code("new", "line", "overlap.toml", "supports.csv", *COMPOUND, *ABOVE, *placed) == 0
    assert "19 messenger supports between the anchors, 168 droppers, 126 main droppers" in capsys.readouterr().out
    for section in read_line((folder / "overlap.toml").read_text(encoding="utf-8")).sections:
        auxiliary, main = section.auxiliary, section.main_droppers
        assert (auxiliary.tension, auxiliary.mass, auxiliary.height) == (14700.0, 1.375, 0.15)
        assert (auxiliary.fixed, auxiliary.axial_stiffness) == (True, 18e6)
        assert (main.first, main.gap, main.stiffness) == (6.0, 9.0, 200e3)
    (folder / "counted.csv").write_text("position [m],main droppers\n0,4\n48,5\n98,\n148,0\n198,\n")
    twin = ("--second-contact-tension", "20 kN", "--main-dropper-gap", "10 m")
    assert exit_code("new", "line", "counted.toml", "counted.csv", *COMPOUND, *ABOVE, *twin) == 2
    assert "got the dropper at" in capsys.readouterr().err  # nothing holds the auxiliary wire up in the last span
    (folder / "counted.csv").write_text("position [m],main droppers\n0,4\n48,5\n98,\n148,3\n198,\n")
    assert exit_code("new", "line", "counted.toml", "counted.csv", *COMPOUND, *ABOVE, *twin) == 0
    (section,) = read_line((folder / "counted.toml").read_text(encoding="utf-8")).sections
    main = [span.main_positions for span in section.spans]
    assert main == [(6.0, 18.0, 30.0, 42.0), (5.0, 15.0, 25.0, 35.0, 45.0), None, (8.33333333, 25.0, 41.6666667)]
    assert section.second_contact_wire.tension == 20e3
    assert exit_code("new", "scene", "scene.toml", "--line", "overlap.toml", "--speed", "160 km/h", "--temperature", "-10") == 0
    assert "pantograph.second_wire <-> catenary.second_wire[1]" in load_scene("scene.toml").connections


@pytest.mark.parametrize(
    ("options", "rows", "message"),
    [
        (COMPOUND, ("50,",), "--auxiliary-height: got nothing, beside others of an auxiliary wire"),
        (ABOVE, ("50,",), "--auxiliary-tension: got nothing"),
        (("--main-dropper-gap", "9 m"), ("50,",), "--auxiliary-tension: got nothing"),
        ((), ("50,4", "100,"), "--auxiliary-tension: got nothing"),
        ((*COMPOUND, "--auxiliary-height", "0.15"), ("50,",), "got '0.15', expected a number with its unit"),
        ((*COMPOUND, "--auxiliary-height", "1.2 m"), ("50,",), "expected an upper wire above the lower one"),
        ((*COMPOUND, *ABOVE, "--first-main-dropper", "26 m"), ("50,",), "more than twice the 26 m of the first dropper"),
        ((*COMPOUND, *ABOVE), ("50,2.5", "100,"), "line 3, column 'main droppers': got 2.5, expected a whole number from 0"),
        ((*COMPOUND, *ABOVE), ("50,-1", "100,"), "got -1, expected a whole number from 0"),
        ((*COMPOUND, *ABOVE), ("50,4",), "main droppers at 50 m, the last support"),
    ],
)
def test_what_is_no_auxiliary_wire_is_one_message(tmp_path, monkeypatch, capsys, options, rows, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "supports.csv").write_text("\n".join(["position [m],main droppers", "0,", *rows, ""]))
    assert exit_code("new", "line", "line.toml", "supports.csv", *options) == 2
    assert message in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "line.toml").exists()


def test_units_are_joined_by_their_ports(tmp_path):
    assert exit_code("new", "scene", tmp_path / "plain.toml", "Pantograph", "wire=LumpedCatenary") == 0
    assert load_scene(tmp_path / "plain.toml").connections == ("pantograph.contact <-> wire.contact",)
    assert exit_code("new", "scene", tmp_path / "rotor.toml", "BeamRotor", "DeepGrooveBearing") == 0


@pytest.mark.parametrize("name", ["en50318-2018-ac-stitched", "overlap", "mass-on-spring"])
def test_a_copy_of_a_shipped_scene_is_the_scene(tmp_path, name):
    assert exit_code("new", "scene", tmp_path / "mine" / "my.toml", "--from", name) == 0
    mine, shipped = load_scene(tmp_path / "mine" / "my.toml"), load_scene(name)
    assert (mine.connections, mine.master, mine.stop_time) == (shipped.connections, shipped.master, shipped.stop_time)
    assert {n: u.component for n, u in mine.units.items()} == {n: u.component for n, u in shipped.units.items()}
    for unit, settings in mine.units.items():
        for key, value in settings.parameters.items():
            if str(value).endswith(".toml"):  # the table of a line came with the scene
                other = shipped.units[unit].parameters[key]
                assert (tmp_path / "mine" / value).read_bytes() == (tmp_path / other).read_bytes()
            else:
                assert value == shipped.units[unit].parameters[key]
    assert exit_code("new", "scene", tmp_path / "mine" / "my.toml", "--from", name) == 2  # overwrites nothing


def test_nothing_passes_by_a_table_of_a_scenes_own_figures_until_a_row_has_a_source(tmp_path, capsys):
    limits = tmp_path / "limits.toml"
    assert exit_code("new", "table", limits, "lumped-catenary") == 0
    run = ("run", "lumped-catenary", "--in-process", "--no-verify", "--limits", limits)
    assert exit_code(*run) == 0
    rows = limits.read_text(encoding="utf-8").count("[[rows]]")
    assert f"Not assessed: {rows} of {rows} rows without a range" in capsys.readouterr().out
    text = limits.read_text(encoding="utf-8")
    first = 'standing = "missing"  # 116.391 in one run of lumped-catenary'
    for ends, standing, source, told in (
        ("low = 1.0\n", "missing", "", "a range that is missing"),
        ("low = 1.0\n", "verbatim", "", "source = None"),
        ("low = 1.0\n", "verbatim", 'source = "run"', "a key of [sources]"),
        ("low = 1.0\n", "verbatim", 'source = "sheet"', "1 of 1 rows inside the range"),
        ("", "verbatim", 'source = "sheet"', "no low and no high"),
    ):
        assert first in text
        filled = text.replace(first, f'{ends}standing = "{standing}"\n{source}').replace("# sheet =", "sheet =")
        limits.write_text(filled, encoding="utf-8")
        code = exit_code(*run)
        shown = capsys.readouterr()
        assert told in shown.out + shown.err
        assert code == (0 if "inside the range" in told else 2)
        assert "Passed" not in shown.out
    assert exit_code("sweep", "lumped-catenary", "--over", "pantograph.speed=60,70", "--limits", limits) == 2
    # a table as 0.7 wrote it: its only source are the numbers that it judges
    old = '[sources]\nrun = "one run of lumped-catenary by cosimo, and 10% on either side: to be replaced by the source of each range"\n'
    row = (
        '[[rows]]\nquantity = "mean"\nmeasure = "pantograph.mean"\nunit = "N"\nlow = 1.0\nstanding = "computed"\nsource = "run"\n'
    )
    limits.write_text(old + row, encoding="utf-8")
    assert exit_code(*run) == 2
    assert "where the range was read" in capsys.readouterr().err


def test_a_standards_frame_has_its_figures_and_no_number_of_it(tmp_path, capsys):
    for standard, count in (("iec63453", 9), ("tsi-ene", 5)):
        limits = tmp_path / f"{standard}.toml"
        assert exit_code("new", "table", limits, "en50318-2002", "--standard", standard) == 0
        rows = tomllib.loads(limits.read_text(encoding="utf-8"))["rows"]
        assert len(rows) == count
        assert {row["standing"] for row in rows} == {"missing"}
        assert not any({"low", "high"} & row.keys() for row in rows)
    assert "point 4.2.12" in limits.read_text(encoding="utf-8")
    for scene, standard, named in (("en50318-2002", "iec63435", "'iec63453'"), ("mass-on-spring", "en50318", "no figures")):
        assert exit_code("new", "table", tmp_path / "new.toml", scene, "--standard", standard) == 2
        assert named in capsys.readouterr().err


def test_two_supports_are_a_line_and_one_is_none(folder, capsys):
    for supports, code in (("0\n50\n", 0), ("0\n", 2)):
        (folder / "few.csv").write_text("position [m]\n" + supports)
        assert exit_code("new", "line", f"{code}.toml", "few.csv") == code
    assert "supports at 0 m, expected at least two" in capsys.readouterr().err


def test_bad_input_leaves_no_file(folder, capsys):
    (folder / "line.toml").write_text("")
    (folder / "bad.csv").write_text("position [m];hight [m]\n0;5,3\n")
    (folder / "back.csv").write_text("position [m]\n0\n50\n40\n")
    (folder / "short.csv").write_text("position [m]\n0\n50\n100\n")
    (folder / "commas.csv").write_text("position [m],contact height [m]\n0,5,3\n50,5,3\n")
    before = set(folder.iterdir())
    for arguments, named in (
        (("line", "line.toml", "supports.csv"), "there already"),
        (("line", "new.txt", "supports.csv"), "ends with .toml"),
        (("line", "new.toml", "bad.csv"), "'contact height'"),
        (("line", "new.toml", "back.csv"), "behind the one before"),
        (("line", "new.toml", "commas.csv"), "need semicolons"),
        (("line", "new.toml", "supports.csv", "--contact-tension", "22 kg"), "dimension of N"),
        (("line", "new.toml", "supports.csv", "--contact-tension", "22"), "22 kN or 22 N?"),
        (("line", "new.toml", "supports.csv", "--messenger-tension", "16"), "16 kN or 16 N?"),
        (("line", "new.toml", "supports.csv", "--system-height", "1.2"), "1.2 mm or 1.2 m?"),
        (("line", "new.toml", "supports.csv", "--support-stiffness", "500"), "500 kN/m or 500 N/m?"),
        (("scene", "new.toml", "--line", "line.toml", "--speed", "160"), "160 km/h or 160 m/s?"),
        (("case", "new.toml", "lumped-catenary", "--limits", "en50367", "--speeds", "160, 200"), "160 km/h or 160 m/s?"),
        (("scene", "new.toml"), "nothing to make it of"),
        (("scene", "new.toml", "Pantograph", "--temperature", "20"), "--temperature: no effect without --line"),
        (("scene", "new.toml", "--from", "overlap", "--pantographs", "2"), "--pantographs: no effect without --line"),
        (("scene", "new.toml", "Pantograph", "--speed", "100 km/h"), "--speed: no effect without --line"),
        (("scene", "new.toml", "Pantograph", "--from", "overlap"), "units and --from"),
        (("scene", "new.toml", "--from", "overlpa"), "'overlap'"),
        (("scene", "line.toml", "--from", "mass-on-spring"), "there already"),
        (("scene", "new.toml", "Pantograf"), "'Pantograph'"),
        (("scene", "new.toml", "Pantograph", "Pantograph"), "names that are unique"),
        (("scene", "new.toml", "Pantograph", "--limits", "en5036"), "'en50367'"),
        (("case", "new.toml", "lumped-catenary"), "no --limits"),
        (("case", "new.toml", "lumped-catenary", "--limits", "en5036"), "'en50367'"),
        (("case", "new.toml", "mass-on-spring", "--limits", "en50367", "--speeds", "200 km/h"), "parameter speed"),
    ):
        assert exit_code("new", *arguments) == 2, arguments
        assert named in capsys.readouterr().err, arguments
    assert set(folder.iterdir()) == before


def test_a_line_that_is_too_short_says_how_long_it_must_be(folder, capsys):
    (folder / "short.csv").write_text("position [m]\n0\n50\n100\n150\n")
    assert exit_code("new", "line", "short.toml", "short.csv") == 0
    assert exit_code("new", "scene", "mine.toml", "--line", "short.toml") == 2
    assert "Make the line longer" in capsys.readouterr().err
    assert not (folder / "mine.toml").exists()


def test_a_line_whose_droppers_would_push_gets_no_scene(folder, capsys):
    table = """
    [[sections]]
    contact_wire = { tension = 22e3, mass = 1.35 }
    messenger = { tension = 16e3, mass = 1.08 }
    droppers = { first = 4.5, gap = 6.5, stiffness = 200e3 }
    span = { relative_sag = 0.02 }
    support = { system_height = 1.2, stiffness = 500e3 }
    spans = [50, 60, 60, 60, 60, 60, 60]
    supports = [5.3, 5.3, 5.3, 5.3, 5.3, 5.3, 5.3, 5.3]
    """
    (folder / "steep.toml").write_text(table)
    assert exit_code("new", "scene", "mine.toml", "--line", "steep.toml") == 2
    assert "48 of 62 droppers with thrust at rest: -535.7 N at 10.3571 m" in capsys.readouterr().err
    assert not (folder / "mine.toml").exists()
