"""Tables over time from files: forms, units of measure, what is refused, and the memory that a long one takes."""

from __future__ import annotations

import os
import tracemalloc

import numpy as np
import pyarrow as arrow
import pytest
from cosimo import BadInput
from cosimo.orchestrator.units.signal_files import HEAD, PIECE, _csv, read_signals
from pyarrow import feather, parquet
from scipy.io import savemat


@pytest.fixture
def read(tmp_path):
    """The class of a text in a file."""

    def of(text, name="table.csv"):
        (tmp_path / name).write_bytes(text.encode())
        return read_signals(tmp_path / name)

    return of


def columns(table):
    """(name, unit) of the columns."""
    return list(table.columns().items())


@pytest.mark.parametrize(
    "text",
    [
        "time [s],y [mm]\n0,1.5\n0.5,2\n",
        "y (mm);t [ms]\n1,5;0\n2;500\n",
        "t\ty\nmin\tmm\n0\t1.5\n0.008333333333333333\t2\n",
        "# made by a logger\n# time, y [mm]\n0,1.5\n0.5,2\n",
        "seconds,y [mm]\n0,1.5\n0.5,2\n",
    ],
)
def test_forms_of_a_csv_table(read, text):
    table = read(text)
    assert columns(table) == [("y", "mm")]
    np.testing.assert_allclose(table.table, [[0.0, 1.5], [0.5, 2.0]], rtol=1e-15)


def test_times_in_ms_are_the_decimals_in_s(read):
    times = [0.1, 0.3, 123.4, 999.7]
    table = read("time [ms],y\n" + "".join(f"{t},0\n" for t in times))
    assert table.table[:, 0].tolist() == [0.0001, 0.0003, 0.1234, 0.9997]


def test_names_of_columns_are_any_text(read):
    assert columns(read("time,a.b [kN],w[1],step,two words\n0,1,2,3,4\n")) == [
        ("a.b", "kN"),
        ("w[1]", ""),
        ("step", ""),
        ("two words", ""),
    ]


def test_parquet_arrow_and_mat(tmp_path):
    rows = {"y [mm]": [1.0, 2.0, 3.0], "time [ms]": [0, 1, 2]}
    parquet.write_table(arrow.table(rows), tmp_path / "a.parquet")
    feather.write_feather(arrow.table(rows), tmp_path / "a.feather")
    with arrow.OSFile(str(tmp_path / "a.arrow"), "wb") as file, arrow.ipc.new_stream(file, arrow.table(rows).schema) as stream:
        stream.write_table(arrow.table(rows))
    for name in ("a.parquet", "a.feather", "a.arrow"):
        table = read_signals(tmp_path / name)
        assert columns(table) == [("y", "mm")]
        assert table.table.tolist() == [[0.0, 1.0], [0.001, 2.0], [0.002, 3.0]]
    savemat(tmp_path / "a.mat", {"y": np.array([1.0, 2.0]), "t": np.array([0.0, 1.0]), "w": np.array([[1, 2], [3, 4]])})
    table = read_signals(tmp_path / "a.mat")
    assert columns(table) == [("y", ""), ("w[1]", ""), ("w[2]", "")]
    assert table.table.tolist() == [[0.0, 1.0, 1.0, 2.0], [1.0, 2.0, 3.0, 4.0]]


LONG = "time,y\n" + "".join(f"{k / 1000},{k}\n" for k in range(20_000))  # longer than the head of a file


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "nothing, expected a header and rows"),
        ("time,y\n", "a header alone"),
        ("time\n0\n", "1 column"),
        ("time,y,y\n0,1,2\n", "column 'y' twice"),
        ("time,,y\n0,1,2\n", "column 2 without a name"),
        ("time,start\n0,1\n", "column 'start', expected names that are none of"),
        ("time [kg],y\n0,1\n", "column 'time \\[kg\\]': got unit 'kg'"),
        ("time,y\n0,1\n2,1\n1,1\n", "line 4, column 'time': got 1 s behind 2 s, expected times that do not go back"),
        ("time,y\n0,1\n1,1\n1,2\n1,3\n", "line 5, column 'time': got 1 s for the third time"),
        ("time,y\n0,1\n1,\n", "line 3, column 'y': got no number"),
        ("time,y\n0,1\n1,nan\n", "line 3, column 'y': got no number"),
        ("time,y\n0,1\n,2\n", "line 3, column 'time': got no number"),
        ("time,y,z\n0,1,\n1,1,\n", "column 'z': got no numbers, expected a number in each row. Delete the column"),
        ("time,y\n0,on\n1,off\n", "line 2, column 'y': got 'on', expected a number"),
        ("time,y\n0,1\n1,inf\n", "line 3, column 'y': got a number that is not finite"),
        ("time,y\n0,1,5\n", "line 2: got 3 cells, expected 2, as the header has. Decimal commas need semicolons"),
        (LONG + "30,x\n", "line 20002, column 'y': got 'x', expected a number"),
        (LONG + "\n10,1\n", "line 20003, column 'time': got 10 s behind 19.999 s"),
        (LONG + "30,\n", "line 20002, column 'y': got no number"),
    ],
)
def test_a_bad_table_is_one_message_with_row_and_column(read, text, words):
    with pytest.raises(BadInput, match=words):
        read(text)


def test_a_missing_file_and_another_kind_are_told(tmp_path):
    with pytest.raises(BadInput, match=r"none\.csv.*a file that can be read"):
        read_signals(tmp_path / "none.csv", "units.road.signals")
    (tmp_path / "a.xlsx").write_text("")
    with pytest.raises(BadInput, match=r"a table: \.csv"):
        read_signals(tmp_path / "a.xlsx")
    parquet.write_table(arrow.table({"time": [0.0], "y": ["a"]}), tmp_path / "a.parquet")
    with pytest.raises(BadInput, match="column 'y': got values of type string"):
        read_signals(tmp_path / "a.parquet")
    (tmp_path / "b.parquet").write_text("no such")
    with pytest.raises(BadInput, match="a content that cannot be read"):
        read_signals(tmp_path / "b.parquet")
    savemat(tmp_path / "a.mat", {"t": np.arange(3.0), "y": np.arange(4.0)})
    with pytest.raises(BadInput, match="variable 'y': got 4 values, expected 3, as there are times"):
        read_signals(tmp_path / "a.mat")


def test_a_long_table_has_the_numbers_of_the_reader_of_all_tables(read):
    """Pieces behind the head go another way, with cells that it does not take, too."""
    rng = np.random.default_rng(2)
    rows = np.column_stack([np.arange(30_000) / 1e3, rng.normal(size=30_000) * 10.0 ** rng.integers(-12, 12, 30_000)])
    text = "time;y\n" + "".join(f"{a!r};{b!r}\n".replace(".", ",") for a, b in rows.tolist())
    assert len(text) > 4 * HEAD
    np.testing.assert_array_equal(read(text).table, rows)
    odd = text.replace("\n20,0;", "\n# a remark\n\n20,0; ")
    assert odd != text
    np.testing.assert_array_equal(read(odd).table, rows)


def test_a_file_that_has_changed_is_read_again(read):
    assert read("time,y\n0,1\n").table.tolist() == [[0.0, 1.0]]
    assert read("time,y\n0,1\n1,22\n").table.tolist() == [[0.0, 1.0], [1.0, 22.0]]


def test_a_long_table_is_in_memory_once_while_it_is_read(tmp_path):
    """Beside it there are pieces, however long the file is."""
    rows, path = 1_000_000, tmp_path / "long.csv"
    with open(path, "w") as file:
        file.write("time [ms],y [mm]\n")
        for k in range(0, rows, 10_000):
            file.write("".join(f"{i},{i % 97}.25\n" for i in range(k, k + 10_000)))
    assert os.path.getsize(path) > 3 * PIECE
    read: list[int] = []
    tracemalloc.start()
    try:
        table = _csv(str(path), os.path.getsize(path), read.append)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert sum(read) == os.path.getsize(path)
    assert table.table.shape == (rows, 2)
    assert table.table[-1].tolist() == [999.999, (rows - 1) % 97 + 0.25]
    assert peak < 1.5 * table.table.nbytes + 6 * PIECE
