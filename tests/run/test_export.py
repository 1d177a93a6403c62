"""Signals as files of other programs: each is read back, by its own library or as signals of a scene."""

import sys
from dataclasses import replace
from math import inf, isnan, nan

import numpy as np
import pytest
from cosimo import BadInput, read_scene
from cosimo.components.core.errors import visible
from cosimo.orchestrator.run.run import run
from cosimo.orchestrator.units.signal_files import read_signals
from cosimo.orchestrator.views import export
from cosimo.tests.commands import exit_code
from cosimo.tests.support import two_masses


@pytest.fixture(scope="module")
def masses():
    return run(read_scene({**two_masses("jacobi", 5e-3, 1), "stop_time": 0.1}), in_process=True)


@pytest.mark.parametrize(
    ("name", "dialect"),
    [("s.csv", {}), ("s.csv", {"separator": ";", "decimal": ","}), ("s.csv", {"separator": "\t", "decimal": ","}), ("s.mat", {})],
)
def test_a_scene_reads_the_file_with_every_bit(name, dialect, masses, tmp_path):
    read = read_signals(masses.export(tmp_path / name, **dialect))
    assert read.table[:, 0].tobytes() == masses.time.tobytes()
    own = {v.name: (v.unit, read.table[:, k].tobytes()) for k, v in enumerate(read.own_variables[-len(masses.columns) :], 1)}
    names = {n: n if name.endswith("csv") else n.replace(".", "_") for n in masses.columns}
    assert own == {names[n]: (masses.measures[n], column.tobytes()) for n, column in masses.columns.items()}


def test_a_matrix_of_an_array_and_units_in_mat(masses, tmp_path):
    from scipy.io import loadmat

    arrays = replace(
        masses, columns={"u.w[1]": masses.time, "u.w[2]": 2.0 * masses.time}, measures={"u.w[1]": "N", "u.w[2]": "N"}
    )
    whole, some = (
        loadmat(arrays.export(tmp_path / "s.mat", signals), simplify_cells=True)
        for signals in (None, ["u.w[2]"])  # a column alone would not say which element it is
    )
    assert whole["u_w"].tolist() == np.column_stack((masses.time, 2.0 * masses.time)).tolist()
    assert (whole["units"], some["u_w_2"].tolist()) == ({"time": "s", "u_w": "N"}, (2.0 * masses.time).tolist())
    with pytest.raises(BadInput, match=r"u_w and u\.w, both u_w"):
        replace(masses, columns={"u.w": masses.time, "u_w": masses.time}).export(tmp_path / "s.mat")


def test_a_workbook_has_a_header_and_all_numbers(masses, tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    some = np.array([*[1.5, nan, inf], *masses.time[3:]])
    result = replace(
        masses, columns={"u.x": some}, texts={"u.name": np.full(some.size, "=1+1\x01", dtype=object)}, measures={"u.x": "m"}
    )
    sheet = openpyxl.load_workbook(result.export(tmp_path / "s.xlsx")).active
    header, *rows = sheet.iter_rows(values_only=True)
    assert header == ("time [s]", "u.x [m]", "u.name")
    assert [row[0] for row in rows] == masses.time.tolist()
    assert [row[1] for row in rows] == [None if not np.isfinite(x) else x for x in some]
    assert {row[2] for row in rows} == {visible("=1+1\x01")}
    assert {cell.data_type for cell in sheet["C"]} == {"s"}  # a text that looks like a formula is a text


def test_texts_and_numbers_that_are_not_finite_stand_in_a_csv(masses, tmp_path):
    result = replace(
        masses, columns={"u.x": np.full(masses.rows, nan)}, texts={"u.t": np.full(masses.rows, 'a;"b"', dtype=object)}
    )
    lines = result.export(tmp_path / "s.csv", separator=";", decimal=",").read_text(encoding="utf-8").splitlines()
    assert lines[:2] == ["time [s];u.x;u.t", '0,0;nan;"a;""b"""']
    assert isnan(float(lines[2].split(";")[1]))


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("s.ods", {}, r"a name that ends in \.csv, \.xlsx, \.mat"),
        ("s.csv", {"decimal": ","}, "two different signs"),
        ("s.csv", {"separator": "|"}, "two different signs"),
        ("s.xlsx", {"separator": ";"}, r"one for \.csv only"),
        ("s.csv", {"signals": ["a.x_uot"]}, "Did you mean"),
        ("missing/s.csv", {}, "a place that can be written"),
    ],
)
def test_what_cannot_be_written_is_one_message(name, options, message, masses, tmp_path):
    with pytest.raises(BadInput, match=message):
        masses.export(tmp_path / name, **options)
    assert list(tmp_path.iterdir()) == []


def test_limits_of_formats_and_a_missing_library_are_said(masses, tmp_path, monkeypatch):
    monkeypatch.setattr(export, "SHEET_ROWS", 10)
    with pytest.raises(BadInput, match="at most 9 of a sheet"):
        masses.export(tmp_path / "s.xlsx")
    monkeypatch.setattr(export, "MAT_BYTES", 100)
    with pytest.raises(BadInput, match="less than 2 GB"):
        masses.export(tmp_path / "s.mat")
    monkeypatch.setattr(export, "SHEET_ROWS", 1000)
    monkeypatch.setattr(export, "SHEET_COLUMNS", 3)
    with pytest.raises(BadInput, match="signals, expected at most 2 of a sheet"):
        masses.export(tmp_path / "s.xlsx")
    monkeypatch.undo()
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(BadInput, match="pip install openpyxl"):
        masses.export(tmp_path / "s.xlsx")
    assert list(tmp_path.iterdir()) == []


def test_the_command_exports_a_run_of_a_system(tmp_path):
    """A scene of a system is read back with the systems that there are."""
    assert exit_code(
        "run", "friction-drive-step", "--in-process", "--no-verify", "--stop", "0.01", "-o", str(tmp_path / "out")
    ) in (0, None)
    assert exit_code("export", str(tmp_path / "out"), "-o", str(tmp_path / "s.csv"), "--signal", "wheels.feed") in (0, None)
    assert (tmp_path / "s.csv").read_text().splitlines()[0] == "time [s],wheels.feed [m]"
