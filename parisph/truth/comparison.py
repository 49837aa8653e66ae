"""Comparison of a probe with a reference series, for `parisph compare`. Not collective."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from parisph.base.arrays import Floats
from parisph.base.errors import CaseError
from parisph.base.paths import AnyPath
from parisph.base.reading import listed
from parisph.base.table import LARGEST, read_reference
from parisph.base.table import names as columns_of
from parisph.base.text import named, shown
from parisph.truth import norms
from parisph.truth.recorded import Recorded, own_columns

EDGE = 0.99     # share of the largest shift tried, beyond which the best one is at the limit
APART = 3.0     # standard deviations between the means of run and reference, beyond which a note says so
FEW = 5         # largest number of samples without that note


@dataclass(frozen=True)
class Comparison:
    """A probe beside its reference.

    result : probe, column, time and value (columns of the reference), shift [s], the entries of norms.judge, and
        `notes` (list of str) on what is doubtful
    found, truth : (time (n,) [s], values (n,)) of the run, not shifted, and of the reference
    """

    result: dict[str, Any]
    found: tuple[Floats, Floats]
    truth: tuple[Floats, Floats]

    @property
    def difference(self) -> tuple[Floats, Floats]:
        """Time (n,) [s] and run minus reference (n,), where they overlap."""
        at, ours, theirs = norms.on_reference(*self.found, *self.truth, self.result["shift"])
        return at, ours - theirs


def compare(run: Recorded, reference: AnyPath, probe: str | None = None, column: str | None = None,
            time: str | None = None, value: str | None = None, offset: float = 0.0, scale: float = 1.0,
            time_scale: float = 1.0, shift: float = 0.0, best_shift: float | None = None,
            rest: float | None = None) -> Comparison:
    """Return a probe beside a reference.

    run : io.reader.Run
    reference : path of a text file with one header line, see base.reading.read_columns
    probe, column : names; may be left out where there is only one
    time, value : columns of the reference; by default its first, and the one named as the probe's, else the first
        that is neither the time nor `step`
    offset, scale, time_scale : truth = offset + scale * value; t = time_scale * time [s]
    shift : [s], added to the run's time
    best_shift : None, or the largest shift [s] either way that is tried for the best one
    rest : None, or the level at rest: the error is then relative to the wave alone

    Raises CaseError: no such name, a number out of range, or series that do not overlap; StoreError : unreadable files
    """
    _check_numbers(offset=offset, scale=scale, time_scale=time_scale, shift=shift, best_shift=best_shift, rest=rest)
    probe = _only(probe, run.probe_names, f"{run.folder} has the probes", "--probe")
    found = run.probe(probe)
    column = _only(column, own_columns(found), f"{probe} has the columns", "--column")
    time, value = _columns(reference, columns_of(reference), time, value, column)
    truth, ours = read_reference(reference, time, value, offset, scale, time_scale), (found["time"], found[column])
    try:
        if best_shift is not None:
            shift = norms.best_shift(*ours, *truth, best_shift)
        judged = norms.judge(*ours, *truth, rest, shift)
    except ValueError as error:
        raise CaseError(f"{probe} against {named(reference)}: {error}") from None
    result = {"probe": probe, "column": column, "time": time, "value": value, "shift": shift, **judged,
              "notes": list(_doubts(ours, truth, shift, best_shift))}
    return Comparison(result, ours, truth)


def text(result: Mapping[str, Any]) -> str:
    """Return the result of `compare` as lines."""
    of = "the wave" if result["relative_l2"] != result["z14"] else "the reference"
    return (f"{result['probe']}, {result['column']} against the column {result['value']} over {result['time']}: "
            f"{result['samples']} samples, t = {result['start']:.6g} to "
            f"{result['end']:.6g} s, run shifted by {result['shift']:+.4g} s\n"
            f"relative L2 error  {result['relative_l2']:.4g} of {of}\n"
            f"norm of Z14        {result['z14']:.4g}" + "".join(f"\nnote: {note}" for note in result.get("notes", ())))


def _doubts(found: tuple[Floats, Floats], reference: tuple[Floats, Floats], shift: float,
            most: float | None) -> Iterator[str]:
    """Yield a note if the best shift is at the limit `most` [s], and one if the means differ by more than both vary."""
    if most and abs(shift) > EDGE * most:
        yield (f"the best shift is at its limit of {most:g} s: allow more with --best-shift, or check that time, "
               "value, scale and offset of the reference fit the run")
    at, ours, theirs = norms.on_reference(*found, *reference, shift)
    apart, spread = ours.mean() - theirs.mean(), max(ours.std(), theirs.std())
    if len(at) > FEW and abs(apart) > APART * spread:
        yield (f"the mean of the run is {ours.mean():.4g}, that of the reference {theirs.mean():.4g}: is another "
               f"quantity, unit or level meant? --offset {apart:.4g} adds the difference to the reference")


def _check_numbers(**numbers: float | None) -> None:
    """Raise CaseError for a number out of range."""
    for name, value in numbers.items():
        if value is None:
            continue
        limit = None
        if not abs(value) <= LARGEST:
            limit = f"a number of at most {LARGEST:g} in size"
        elif name == "time_scale" and value <= 0.0:
            limit = "greater than 0"
        elif name == "best_shift" and value < 0.0:
            limit = "at least 0: it is how far the run is shifted either way"
        if limit:
            raise CaseError(f"{name} = {value:g}: must be {limit}")


def _columns(reference: AnyPath, there: Sequence[str], time: str | None, value: str | None,
             column: str) -> tuple[str, str]:
    """Return the reference's columns of time and of value. Raises CaseError if one is missing."""
    for name, option in ((time, "--time"), (value, "--value")):
        if name is not None and name not in there:
            raise CaseError(f"{named(reference)} has no column {shown(name)} (it has: {listed(there)}): "
                            f"choose one with {option}")
    time = time or there[0]
    values = [name for name in there if name not in (time, "time", "step")]
    if value is None and not values:
        raise CaseError(f"{named(reference)} has the columns {listed(there)}; a series needs a time and a value")
    return time, value or (column if column in values else values[0])


def _only(name: str | None, names: Sequence[str], there: str, option: str) -> str:
    if name is not None:
        if name in names:
            return name
        raise CaseError(f"{there} {listed(names)}; there is no {shown(name)}: choose one with {option}")
    if len(names) != 1:
        raise CaseError(f"{there} {listed(names)}: choose one with {option}")
    return names[0]
