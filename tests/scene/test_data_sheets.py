"""Parameters from a row of a table of the trade."""

import pytest
from cosimo.components.bearings.conductance import AngularContactConductance
from cosimo.components.bearings.deep_groove import DeepGrooveBearing
from cosimo.components.catalogue import CATALOGUE, component_class
from cosimo.components.core.errors import BadInput
from cosimo.orchestrator.cli.common import with_presets
from cosimo.orchestrator.scene.data_sheets import names_a_file, sheet_parameters
from cosimo.orchestrator.systems import load_scene

TABLE = (
    "designation;d [mm];B [mm];Z;Dw [mm];Dpw [in];C [kN];hertz\n6205;25;15;9;7,94;1,537;14;\n6306;30;19;8;11,9;2;28,1;fitted\n"
)


@pytest.fixture
def table(tmp_path):
    path = tmp_path / "bearings.csv"
    path.write_text(TABLE)
    return str(path)


def test_a_row_becomes_parameters_in_their_units_by_the_symbols_of_the_trade(table):
    values, remarks = sheet_parameters(f"{table}:6306", DeepGrooveBearing, ["rating_life"])
    assert values == pytest.approx(
        {"balls": 8, "ball_diameter": 11.9e-3, "pitch_diameter": 50.8e-3, "rating_life.load_rating": 28.1e3, "hertz": "fitted"}
    )
    assert isinstance(values["balls"], int)
    unknown, without, kept = remarks
    assert unknown.endswith(": B")
    assert without.endswith(": d (friction)")
    assert kept.endswith(": inner_conformity, outer_conformity, diametral_clearance")
    assert "hertz" not in sheet_parameters(f"{table}:6205", DeepGrooveBearing, [])[0]  # of an empty cell
    assert sheet_parameters(f"{table}:6205", AngularContactConductance, ["ring_walls"])[0]["ring_walls.bore"] == 0.025


def test_a_scene_takes_the_row_and_says_so(table, capsys):
    scene = load_scene("rotor-run-up")
    changes = with_presets(scene, [f"left={table}:6205"])
    assert "set aside, as their effects are off: d (friction), C (rating_life)" in " ".join(capsys.readouterr().err.split())
    assert scene.with_changes(changes).units["left"].parameters["ball_diameter"] == pytest.approx(7.94e-3)


@pytest.mark.parametrize(
    ("text", "row", "message"),
    [
        (TABLE, "", "got 2 rows, expected one row"),
        (TABLE, ":6204", "got 0 rows '6204'"),
        (TABLE + "6306;30;19;8;11;2;28;\n", ":6306", "got 2 rows '6306'"),
        ("name;Dw\nmine;11\n", "", "no unit, expected a name with its unit. m or mm?"),
        ("name;Dw [kg]\nmine;11\n", "", "a unit of the dimension of m"),
        ("name;Dw [mm];ball_diameter [mm]\nmine;11;11\n", "", "ball_diameter twice"),
        ("name;bore [mm]\nmine;11\n", "", "no column that is a parameter"),
        ("name;Dw [mm]\n", "", "got 0 rows"),
    ],
)
def test_what_no_row_says_is_one_message(tmp_path, text, row, message):
    path = tmp_path / "b.csv"
    path.write_text(text)
    with pytest.raises(BadInput) as error:
        sheet_parameters(f"{path}{row}", DeepGrooveBearing, [])
    assert message in str(error.value)


def test_names_of_files_and_of_presets_are_told_apart():
    texts = ("6205", "a.csv", "C:\\b.CSV:6205", "JIS 6306", "x.csv.old")
    assert [*map(names_a_file, texts)] == [False, True, True, False, False]
    presets = [preset for name in CATALOGUE for preset in component_class(name).presets]
    assert not any(map(names_a_file, presets))


def test_symbols_name_parameters():
    for cls in (component_class(name) for name in CATALOGUE):
        assert set(cls.symbols.values()) <= set(cls.variables)
