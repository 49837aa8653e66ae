"""Comparison of a probe with a reference series, for `parisph compare`. Not collective."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from parisph.base.errors import CaseError
from parisph.base.paths import AnyPath
from parisph.base.reading import listed
from parisph.base.table import LARGEST, read_reference
from parisph.base.table import names as columns_of
from parisph.base.text import named, shown
from parisph.truth import norms
from parisph.truth.recorded import Recorded


@dataclass(frozen=True)
class Comparison:
    """A probe beside its reference.

    result : what `parisph compare` prints: probe, column, time and value (the columns of the reference), shift [s], and
        what norms.judge returns
    found, truth : (time (n,) [s], values (n,)) of the run, not shifted, and of the reference
    """

    result: dict[str, Any]
    found: tuple[np.ndarray, np.ndarray]
    truth: tuple[np.ndarray, np.ndarray]

    @property
    def difference(self) -> tuple[np.ndarray, np.ndarray]:
        """Time (n,) [s] and run minus reference (n,), where they overlap."""
        at, ours, theirs = norms.on_reference(*self.found, *self.truth, self.result["shift"])
        return at, ours - theirs


def compare(run: Recorded, reference: AnyPath, probe: str | None = None, column: str | None = None,
            time: str | None = None, value: str | None = None, offset: float = 0.0, scale: float = 1.0,
            time_scale: float = 1.0, shift: float = 0.0, best_shift: float | None = None,
            rest: float | None = None) -> Comparison:
    """Return how far a probe is from a reference.

    Parameters
    ----------
    run : io.reader.Run
    reference : path of a text file with one header line, see base.reading.read_columns
    probe, column : name of the probe and of its column; may be left out where there is only one
    time, value : names of the reference's columns. By default its first, and the one named as the probe's
        or, where there is none, the first that is neither the time nor `step`
    offset, scale, time_scale : truth = offset + scale * value; t = time_scale * time [s]
    shift : [s], added to the run's time
    best_shift : None, or the largest time shift [s] either way among which the best one is sought
    rest : None, or the level at rest: the error is then a share of the wave alone

    Raises
    ------
    CaseError for names that are not there, numbers without meaning or series that do not overlap; StoreError for files.
    """
    _check_numbers(offset=offset, scale=scale, time_scale=time_scale, shift=shift, best_shift=best_shift, rest=rest)
    probe = _only(probe, run.probe_names, f"{run.folder} has the probes", "--probe")
    found = run.probe(probe)
    column = _only(column, [name for name in found.dtype.names if name not in ("time", "step")],
                   f"{probe} has the columns", "--column")
    time, value = _columns(reference, columns_of(reference), time, value, column)
    t, truth = read_reference(reference, time, value, offset, scale, time_scale)
    try:
        if best_shift is not None:
            shift = norms.best_shift(found["time"], found[column], t, truth, best_shift)
        judged = norms.judge(found["time"], found[column], t, truth, rest, shift)
    except ValueError as error:
        raise CaseError(f"{probe} against {named(reference)}: {error}") from None
    result = {"probe": probe, "column": column, "time": time, "value": value, "shift": shift, **judged}
    return Comparison(result, (found["time"], found[column]), (t, truth))


def text(result: Mapping[str, Any]) -> str:
    """Return the result of `compare` as lines."""
    of = "the wave" if result["relative_l2"] != result["z14"] else "the reference"
    return (f"{result['probe']}, {result['column']} against the column {result['value']} over {result['time']}: "
            f"{result['samples']} samples, t = {result['start']:.6g} to "
            f"{result['end']:.6g} s, run shifted by {result['shift']:+.4g} s\n"
            f"relative L2 error  {result['relative_l2']:.4g} of {of}\n"
            f"norm of Z14        {result['z14']:.4g}")


def _check_numbers(**numbers):
    """Raise CaseError for what makes every result nan or infinite, or has no meaning."""
    for name, value in numbers.items():
        limit = None
        if value is not None and not abs(value) <= LARGEST:
            limit = f"a number of at most {LARGEST:g} in size"
        elif name == "time_scale" and value <= 0.0:
            limit = "greater than 0"
        elif name == "best_shift" and value is not None and value < 0.0:
            limit = "at least 0: it is how far the run is shifted either way"
        if limit:
            raise CaseError(f"{name} = {value:g}: must be {limit}")


def _columns(reference, there, time, value, column):
    """Return the names of the reference's columns of time and of value. Raises CaseError if they are not there."""
    for name, option in ((time, "--time"), (value, "--value")):
        if name is not None and name not in there:
            raise CaseError(f"{named(reference)} has no column {shown(name)} (it has: {listed(there)}): "
                            f"choose one with {option}")
    time = time or there[0]
    values = [name for name in there if name not in (time, "time", "step")]
    if value is None and not values:
        raise CaseError(f"{named(reference)} has the columns {listed(there)}; a series needs a time and a value")
    return time, value or (column if column in values else values[0])


def _only(name, names, there, option):
    if name in names:
        return name
    if name is not None:
        raise CaseError(f"{there} {listed(names)}; there is no {shown(name)}: choose one with {option}")
    if len(names) != 1:
        raise CaseError(f"{there} {listed(names)}: choose one with {option}")
    return names[0]
