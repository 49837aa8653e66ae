"""The probes of a run, as they are compared with a truth. io.reader.Run is a Recorded."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from parisph.base.arrays import Array, Floats
from parisph.base.errors import ParisphError
from parisph.case.probes import ProbeArray, singles
from parisph.case.schema import Case


class Recorded(Protocol):
    """A run whose probes can be read."""

    folder: Path
    probe_names: list[str]

    def probe(self, name: str) -> Array:
        """Return the series of a probe, a structured array (samples,) with the columns `time`, `step` and its own."""

    def units(self, name: str) -> dict[str, str]:
        """Return {column: unit} of a probe."""


def own_columns(table: Array) -> list[str]:
    """Return the names of the columns of a probe's series, without time and step."""
    return [name for name in table.dtype.names or () if name not in ("time", "step")]


class ProbeRecord(NamedTuple):
    """The series of one probe.

    name : in an array as "gauges.x1"; probe : its description; table : content of its file
    columns : names of its columns in the table; prefix : of these in an array; file : name of the probe of the file
    """

    name: str
    probe: Any
    table: Array
    columns: list[str]
    prefix: str
    file: str

    def values(self, column: str) -> Floats:
        """Return a column (samples,). In an array, the only column of a probe has the name of the probe."""
        values: Floats = self.table[self.named(column)]
        return values

    def named(self, column: str) -> str:
        """Return the name of a column in the table."""
        return self.columns[0] if len(self.columns) == 1 else self.prefix + column


def probe_records(case: Case, run: Recorded, wanted: Callable[[Any], bool]) -> Iterator[ProbeRecord]:
    """Yield the series of each wanted probe, also in arrays. Not collective.

    Probes that have no file yet are left out. Files of other probes are not read.
    """
    for probe in case.probes:
        mine = [(name, one) for name, one in singles([probe]) if wanted(one)]
        if not mine:
            continue
        try:
            table = run.probe(probe.name)
        except ParisphError:
            continue
        columns = own_columns(table)
        for name, one in mine:
            prefix = f"{one.name}_" if isinstance(probe, ProbeArray) else ""
            own = [one.name] if prefix and one.name in columns else [
                column for column in columns if column.startswith(prefix)]
            yield ProbeRecord(name, one, table, own, prefix, probe.name)
