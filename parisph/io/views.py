"""Tables with units and snapshots of a run, shown as text and as HTML in notebooks."""

import html
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from parisph.base.arrays import Array
from parisph.base.errors import MissingLibrary

SHOWN = 6    # rows of a table, at its start and its end


class Table(np.ndarray[Any, Any]):
    """A structured array with one row per sample or step; its columns are plain arrays. units : {column: unit}"""

    name: str
    units: dict[str, str]

    @classmethod
    def of(cls, rows: Array, name: str, units: Mapping[str, str]) -> "Table":
        """Return a view of rows as a Table."""
        table = rows.view(cls)
        table.name, table.units = name, dict(units)
        return table

    def __array_finalize__(self, other: Any) -> None:
        self.name, self.units = getattr(other, "name", ""), getattr(other, "units", {})

    def __getitem__(self, key: Any) -> Any:
        found = super().__getitem__(key)
        whole = isinstance(found, Table) and found.dtype.names is not None and found.ndim == 1
        return found if whole or not isinstance(found, np.ndarray) else found.view(np.ndarray)

    def to_pandas(self) -> Any:
        """Return a pandas.DataFrame with the units in its `attrs`. Raises MissingLibrary without pandas."""
        try:
            import pandas
        except ImportError:
            raise MissingLibrary("pandas is not installed; write pip install pandas") from None
        names = self.dtype.names or ()
        frame = pandas.DataFrame({name: np.asarray(self[name]) for name in names})
        frame.attrs["units"] = {name: self.units.get(name, "") for name in names}
        return frame

    def __repr__(self) -> str:
        if self.dtype.names is None or self.ndim != 1:
            return repr(np.asarray(self))
        span = f", t = {self['time'][0]:.6g} to {self['time'][-1]:.6g} s" if "time" in self.dtype.names and len(
            self) else ""
        return f"<{self.name}: {len(self)} rows{span}: {', '.join(self._headings())}>"

    def _repr_html_(self) -> str:
        if self.dtype.names is None or self.ndim != 1:
            return f"<pre>{html.escape(repr(self))}</pre>"
        few = len(self) <= 2 * SHOWN
        rows = [[_cell(value) for value in row] for row in (self if few else self[:SHOWN])]
        if not few:
            rows += [["..."] * len(self.dtype.names), *([_cell(value) for value in row] for row in self[-SHOWN:])]
        return rows_as_html(f"{self.name}: {len(self)} rows", self._headings(), rows)

    def _headings(self) -> list[str]:
        names = self.dtype.names or ()
        return [f"{name} [{self.units[name]}]" if self.units.get(name) else name for name in names]


class Snapshot(dict[str, Any]):
    """The particles of a snapshot: arrays by the names of their fields, and `time` [s] and `step`."""

    def __repr__(self) -> str:
        fields = ", ".join(f"{name} {value.shape}" for name, value in self.items() if isinstance(value, np.ndarray))
        peak = f", peak = {self['peak']:.6g}" if "peak" in self else ""
        return (f"<snapshot at t = {self['time']:.6g} s, step {self['step']}{peak}: {len(self['x'])} particles: "
                f"{fields}>")

    def _repr_html_(self) -> str:
        rows = [[name, " x ".join(map(str, value.shape)),
                 f"{value.min():.6g}, {value.max():.6g}" if value.size and value.dtype.kind in "fiu" else ""]
                for name, value in self.items() if isinstance(value, np.ndarray)]
        title = f"Snapshot at t = {self['time']:.6g} s, step {self['step']}"
        return rows_as_html(title, ["field", "shape", "least and greatest"], rows)


def rows_as_html(title: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table as HTML, with all texts escaped: files of a run may be anybody's."""
    head = "".join(f"<th>{html.escape(name)}</th>" for name in headings)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><caption>{html.escape(title)}</caption>{f'<tr>{head}</tr>' if head else ''}{body}</table>"


def _cell(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, (float, np.floating)) else str(value)
