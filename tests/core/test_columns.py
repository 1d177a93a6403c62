"""Tables of users: separators, decimal signs, encodings, comments, units in headers, and what is refused with line and column."""

import os

import numpy as np
import pytest
from cosimo.components.core.columns import read_table, table_of
from cosimo.components.core.errors import BadInput

PLAIN = "span [mm],height [ft],speed (km/h),note\n48500,17.5,36,a\n50000,18,72,b\n"
SI = {"span": [48.5, 50.0], "height": [17.5 * 0.3048, 18 * 0.3048], "speed": [10.0, 20.0]}
UNITS = {"span": "m", "height": "m", "speed": "m/s"}


def semicolons(text):
    return text.replace(",", ";").replace(".", ",")


@pytest.mark.parametrize(
    "data",
    [
        PLAIN.encode(),
        b"\xef\xbb\xbf" + PLAIN.replace("\n", "\r\n").encode(),
        semicolons(PLAIN).encode(),
        semicolons(PLAIN).replace(";", "\t").encode("utf-16"),
        PLAIN.encode("utf-16-le"),
        PLAIN.replace("note", "Bemerkung für µ").encode("latin-1"),
        ("# of a logger\nsep=,\n" + PLAIN)[len("# of a logger\n") :].encode(),
        ("# of a logger\n# " + PLAIN.replace(",note", "").replace(",a", "").replace(",b", "") + "# end\n").encode(),
        b"Span;HEIGHT;Speed\nmm;ft;km/h\n48500;17.5;36\n50000;18;72\n",
        b"span [mm];height, ft;speed\n48500;17.5;36 km/h\n50000;18;20 m/s\n",
    ],
    ids=["plain", "bom", "semicolons", "utf-16", "no bom", "latin-1", "sep", "# header", "line of units", "other ways"],
)
def test_one_table_in_the_ways_that_programs_write_it(tmp_path, data):
    (tmp_path / "t.csv").write_bytes(data)
    table = read_table(tmp_path / "t.csv")
    for name, unit in UNITS.items():
        assert table.numbers(name, unit) == pytest.approx(SI[name], rel=1e-12)


def test_a_name_may_end_with_its_unit():
    table = table_of("x_mm,x_in,F_kN\n1,2,3\n", "t")
    assert [table.numbers(*each)[0] for each in (("x_mm", "m"), ("x_in", "m"), ("F_kN", "m"), ("F_kN", "N"))] == [1e-3, 2, 3, 3e3]


def test_an_element_of_an_array_has_no_unit_and_empty_cells_no_number():
    table = table_of('"a.x[1,2]",a.y[1],deviation [1],"b, min"\n1,2,n/a,4\n5,6,-,8\n', "t")
    assert table.names == ("a.x[1,2]", "a.y[1]", "deviation", "b")
    assert np.isnan(table.numbers("deviation", "1")).all()
    assert table.numbers("b, min").tolist() == [4.0, 8.0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x [m]\n1,5\n", "t, line 2: got 2 cells, expected 1.*semicolons"),
        ('x [m]\n"1,234"\n', r"t, line 2, column 'x \[m\]': got '1,234', expected a number in m.*semicolons"),
        ("x [m];y\n1,5;0\n1.5;0\n", "decimals with ',' in line 2 and '.' in line 3"),
        (
            "x [m];y\n28.100;7,94\n",
            r"line 2, column 'x \[m\]': got '28.100' beside '7,94' in line 2.*Write 28100 or 28,100: .* 1000",
        ),
        ("x [m];y\n28,100;1\n1;7.94\n", r"'28,100' beside '7.94' in line 3.*Write 28100 or 28.100"),
        ("x [m]\n2026-01-01T00:00:01\n", "expected a number in m. Dates and times of a clock are not read"),
        ("x [m]\n00:00:01.5\n", "line 2, .*'00:00:01.5', expected a number in m. Dates and"),
        ("x [m]\n1_1\n", "line 2, column .* got '1_1', expected a number in m"),
        ("x [1000 m]\n1\n", r"column 'x \[1000 m\]': .* expected factors.*A unit has no number"),
        ("x [10^3 m]\n1\n", r"column 'x \[10\^3 m\]': .* expected factors.*A unit has no number"),
        ("x [furlong]\n1\n", "unit 'furlong', expected a unit of the dimension of m. Such as m, mm"),
        ("x [kN]\n1\n", "unit 'kN', expected a unit of the dimension of m"),
        ("x\n1\n", r"column 'x': got no unit, expected a name with its unit. m or mm\? Write 'x \[m\]'"),
        ("x [m]\n1 N\n", "line 2.*'1 N', expected a unit of the dimension of m"),
        ("x [m]\n2\n\n1e999\n", "line 4.*not finite"),
        ("y [m]\n1\n", "no column 'x'"),
        ("x [m],x [mm]\n1,2\n", "column 'x' 2 times"),
        ("", "a header and rows"),
    ],
)
def test_what_cannot_be_read_is_one_message(text, message):
    with pytest.raises(BadInput, match=message):
        table_of(text, "t").numbers("x", "m", asked=True)


def test_three_decimals_are_decimals_where_nothing_speaks_for_thousands():
    for text in ("x [m];y\n28.100;7.94\n", "x [m];y\n28,100;a.b\n", "x [m];y\n28.100;7,94\n1.5;1\n", "x [m];y\n0,125;7.94\n"):
        assert table_of(text, "t").numbers("x", "m")[0] == pytest.approx(
            float(text.split("\n")[1].split(";")[0].replace(",", "."))
        )


def test_files_that_are_no_tables_are_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "bytes").write_bytes(bytes(range(256)))
    for name, message in (("pipe", "a pipe, a device"), ("bytes", "no text"), ("none", "can be read"), (".", "can be read")):
        with pytest.raises(BadInput, match=message):
            read_table(tmp_path / name)
