"""Time series as CSV files: what is written, kept on a restart, and read back."""

import math

import numpy as np
import pytest

from parisph.base.errors import StoreError
from parisph.io import series
from parisph.io.series import SeriesFile


def read(path):
    return series.table(*series.read_own(path))


def written(path, steps=4, **options):
    table = SeriesFile(path, {"pressure": "Pa", "reason": ""}, "pressure tap P2", **options)
    for step in range(steps):
        table.append(0.1 * step, step, (step / 3.0, "rtol"))
    return table


def test_numbers_come_back_to_the_last_digit(tmp_path):
    written(tmp_path / "p.csv").close()
    found = read(tmp_path / "p.csv")
    assert found.dtype.names == ("time", "step", "pressure", "reason")
    assert found["step"].dtype == np.int64
    np.testing.assert_array_equal(found["pressure"], [0.0, 1 / 3, 2 / 3, 1.0])
    assert list(found["reason"]) == ["rtol"] * 4
    assert series.units(tmp_path / "p.csv") == {"time": "s", "step": "", "pressure": "Pa", "reason": ""}
    assert (tmp_path / "p.csv").read_text().startswith("# pressure tap P2\n# time [s], step [-], pressure [Pa]")


def test_a_line_is_in_the_file_as_soon_as_it_is_appended(tmp_path):
    table = written(tmp_path / "p.csv", 2)
    assert len(read(tmp_path / "p.csv")) == 2  # not closed
    table.close()


def test_numpy_numbers_nan_and_none_are_written_as_plain_ones(tmp_path):
    table = SeriesFile(tmp_path / "p.csv", {"a": "", "b": "", "c": ""})
    table.append(np.float64(0.5), np.int64(1), (np.float32(0.25), math.nan, None))
    table.close()
    assert (tmp_path / "p.csv").read_text().splitlines()[-1] == "0.5,1,0.25,nan,"
    found = read(tmp_path / "p.csv")
    assert np.isnan(found["b"][0]) and np.isnan(found["c"][0])


def test_restart_keeps_the_lines_up_to_its_step_and_drops_a_cut_one(tmp_path):
    written(tmp_path / "p.csv").close()
    with open(tmp_path / "p.csv", "a") as file:
        file.write("0.4,1")  # the process died in the middle of a line
    table = SeriesFile(tmp_path / "p.csv", {"pressure": "Pa", "reason": ""}, "pressure tap P2", keep_to=2)
    table.append(0.3, 3, (7.0, "again"))
    table.close()
    found = read(tmp_path / "p.csv")
    assert list(found["step"]) == [0, 1, 2, 3]
    assert found["pressure"][-1] == 7.0


def test_a_cut_line_is_not_read(tmp_path):
    written(tmp_path / "p.csv").close()
    text = (tmp_path / "p.csv").read_text()
    (tmp_path / "p.csv").write_text(text[:-3])  # "...,rt": as many columns, but the last is not whole
    assert list(read(tmp_path / "p.csv")["step"]) == [0, 1, 2]


def test_a_series_of_other_columns_is_not_continued(tmp_path):
    written(tmp_path / "p.csv").close()
    with pytest.raises(StoreError, match="another run"):
        SeriesFile(tmp_path / "p.csv", {"height": "m"}, keep_to=1)
