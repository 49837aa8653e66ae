"""Reference series: what is read of them, and what is refused in one line that says where to look."""

import numpy as np
import pytest

from parisph.base import table
from parisph.base.errors import StoreError


def test_truth_is_scaled_sorted_and_may_lack_the_last_line_end(tmp_path):
    (tmp_path / "t.csv").write_text("# a comment, with a comma\nset,T,z\nb,3,30\na,1,10\na,2,\na,4,40")
    time, value = table.read_reference(tmp_path / "t.csv", "T", "z", offset=1.0, scale=2.0, time_scale=0.5)
    np.testing.assert_array_equal(time, [0.5, 1.5, 2.0])
    np.testing.assert_array_equal(value, [21.0, 61.0, 81.0])


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("name", "column", "scale", "says"), [
    ("t.csv", "x", 1.0, "no column 'x' .it has: set, T, z"),
    ("t.csv", "set", 1.0, "line 2 of column 'set' holds a word, not a number"),
    ("t.csv", "z", 1e300, "reaches more than 1e.30 when scaled"), (".", "z", 1.0, "it is a folder"),
    ("/dev/zero", "z", 1.0, "not a regular file"), ("gone.csv", "z", 1.0, "gone.csv"),
    ("a" * 300, "z", 1.0, "File name too long"),
    ("run", "z", 1.0, "it is a folder; give the file .*/run/probes/NAME.csv"),
])
def test_a_truth_that_cannot_be_read_is_named(tmp_path, name, column, scale, says):
    (tmp_path / "run" / "probes").mkdir(parents=True)
    (tmp_path / "t.csv").write_text("set,T,z\na,0,1e20\na,1,2\n")
    with pytest.raises(StoreError, match=says):
        table.read_reference(tmp_path / name, "T", column, scale=scale)


@pytest.mark.parametrize("content, message", [
    (b"\xff\xfe\x00T,z", "it is not text in UTF-8: see byte 0"), (b"T,z\n0,\0\n", "it is not text: see character"),
    (b"", "no line with the names"), (b"# only\n\n", "no line with the names"),
    (b"T,z,T\n0,1,2\n", "two columns are named 'T'"), (b"T,z,\n0,1,\n", "column 3 has no name"),
    (b"T,z\n0,1\n1\n", "line 3 has 1 value, and there are 2 columns"),
    (b"T,z\n0,1\n# gap\n1,1e300\n", "line 4 of column 'z' holds a number of more than 1e.30"),
    (b"T,z\n0,inf\n", "line 2 of column 'z'"), (b'T,z\n0,"1\n', "line 2 is not one of a CSV file"),
    (b"T,z\n0," + b"1" * 200_000, "line 2 is not one of a CSV file"), (b"z\n1\n", "no column 'T' .it has: z"),
    (b"T" * 5000 + b",z\n1,2\n", "no column 'T' .it has: T*[.]{3}"),
    (b"T,z\n0,1,0,5\n", "line 2 has 4 values, and there are 2 columns; where numbers have decimal commas, separate"),
    (b"T;z\n0,5;1\n1;1.5\n", "line 2 has a number with a comma, and line 3 one with a point: write all of them in one"),
    (b"T;z\n0;1.234,5\n", "line 2 has a number with marks between thousands: leave them out"),
    (b"T [s] z\n0 1\n", "line 2 has 2 values, and there are 3 columns; columns are separated by blanks: put names"),
    (b"T,a;z,b\nx,1;2,y\n", "may be separated by semicolons or by commas: put names with such characters in double"),
    (b"0 1\n1 2\n", "its first line has numbers: write a line with the names of the columns above it"),
])
@pytest.mark.filterwarnings("error")
def test_a_file_that_is_no_series_is_refused_in_one_line(tmp_path, content, message):
    (tmp_path / "t.csv").write_bytes(content)
    with pytest.raises(StoreError, match=message) as error:
        table.read_reference(tmp_path / "t.csv", "T", "z")
    assert "t.csv" in str(error.value) and "\n" not in str(error.value) and len(str(error.value)) < 500


def test_gaps_are_left_out(tmp_path):
    (tmp_path / "t.csv").write_text("\ufeffT, z\n0,1\n1,\n2,nan\n3,4\n", encoding="utf-8")
    time, value = table.read_reference(tmp_path / "t.csv", "T", "z")
    assert list(time) == [0.0, 3.0] and list(value) == [1.0, 4.0]


@pytest.mark.parametrize("content", [
    "T;z\n0,5;-1,25\n1;2,5e1\n", "T;z\n0.5;-1.25\n1;25\n", "T\tz\n0,5\t-1,25\n1\t25\n", "T  z\n 0.5 -1.25\n1\t25\n",
    '"T" z\n0,5 -1,25\n1  25\n', 'T, z\n"0,5","-1,25"\n1, 25\n', "T;z;mean, of all\n"
    "0,5;-1,25;3\n1;25;\n", "T;z;a,b\n0,5;-1,25;1,5\n1,0;25,0;2,5\n", "T;z\r\n0,5;-1,25\r\n1;25\r\n",
])
def test_columns_are_separated_by_what_splits_all_lines_and_decimals_may_have_commas(tmp_path, content):
    (tmp_path / "t.csv").write_text(content, newline="")
    time, value = table.read_reference(tmp_path / "t.csv", "T", "z")
    assert time.tolist() == [0.5, 1.0] and value.tolist() == [-1.25, 25.0]
