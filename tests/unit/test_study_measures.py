"""What a study measures in a run, and what it says where it cannot."""

from pathlib import Path

import numpy as np
import pytest

from parisph.base.errors import CaseError
from parisph.study import FinestError, Function, Quantity, SeriesError, TruthError
from parisph.study.measures import is_error, label_of, name_of
from parisph.study.measuring import value


class FakeRun:
    """What measures need of a run: a gauge that rises by `slope` [m/s] in 0 to 2 s, and a summary."""

    def __init__(self, slope=1.0, folder="a"):
        t = np.linspace(0.0, 2.0, 21)
        kind = [("time", float), ("step", int), ("y", float)]
        self.series = np.array(list(zip(t, range(21), slope * t)), dtype=kind)
        self.folder, self.probe_names = Path(folder), ["gauge"]
        errors = {"gauge": {"relative_l2": 0.1, "paper": 0.01}, "short": {"relative_l2": None, "reason": "too short"}}
        self.summary = {"errors": errors,
                        "energy_range": {"low": -0.25, "high": 0.0}, "energy_drift": None}

    def probe(self, name):
        return self.series


@pytest.fixture
def line(tmp_path):
    """The folder of a reference: the level t for t < 1 s, then 2 t."""
    (tmp_path / "line.csv").write_text("t,y\n" + "".join(f"{t / 10},{t / 10 * (1 + (t > 10))}\n" for t in range(21)))
    return tmp_path


@pytest.mark.parametrize(("measure", "expected"), [
    (TruthError("gauge"), 0.1), (TruthError("gauge", norm="paper"), 0.01), (Quantity("energy_range.low"), -0.25),
    (Quantity("energy_range.low", absolute=True), 0.25), (Quantity("energy_drift"), None),
    (Function("last", of=lambda run: run.probe("gauge")["y"][-1]), 2.0),
    (Function("none", of=lambda run: np.nan), None),
    (SeriesError("gauge", "line.csv", end=1.0), 0.0), (SeriesError("gauge", "line.csv", start=1.05), 0.5),
    (SeriesError("gauge", "line.csv", scale=2.0, end=1.0), 0.5), (FinestError("gauge"), None),
])
def test_value(line, measure, expected):
    found = value(measure, FakeRun(), line)
    assert found == (None if expected is None else pytest.approx(expected, abs=1e-12))


def test_difference_from_the_finest(line):
    finest = FakeRun(2.0, "b")
    assert value(FinestError("gauge", start=0.5), FakeRun(), line, finest) == pytest.approx(0.5)
    assert value(FinestError("gauge"), finest, line, finest) is None


@pytest.mark.parametrize(("measure", "says"), [
    (TruthError("short"), "too short"), (TruthError("other"), "has no error of other"),
    (Quantity("energy_range.middle"), "there is no 'middle' (there is: low, high)"),
    (Function("f", of=lambda run: 1 / 0), "ZeroDivisionError: division by zero"),
    (SeriesError("gauge", "line.csv", start=5.0), "series"),
])
def test_what_cannot_be_measured_says_why(line, measure, says):
    with pytest.raises(CaseError) as error:
        value(measure, FakeRun(), line)
    assert says in str(error.value)


def test_names_and_labels():
    some = [TruthError("a"), TruthError("a", norm="paper"), SeriesError("a", "b/c.csv"), FinestError("a"),
            Quantity("x.y")]
    assert [name_of(one) for one in some] == ["a", "a (paper)", "a against c", "a against the finest", "x.y"]
    assert label_of(TruthError("a")) == "error: a"
    assert label_of(FinestError("a")) == "difference of a from the finest run"
    assert is_error(TruthError("a")) and not is_error(Quantity("steps", error=False))
