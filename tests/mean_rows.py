"""Wall rows that are all means of their neighbours, as some are where water leaves a wall."""

import numpy as np

from parisph.base.fields import WET
from parisph.kernels import walls


def install(monkeypatch) -> None:
    """Make the rows of all wet wall particles means, until the test ends."""
    full = walls.sfdi_rows

    def rows(count, columns, values, measure, x, role, normal, radius, indptr, *rest):
        full(count, columns, values, measure, x, role, normal, radius, indptr, *rest)
        n = len(indptr) - 1
        for i in np.flatnonzero((role[:n] == WET) & (count[:n] > 0)):
            values[indptr[i]:indptr[i] + count[i]] = 1.0 / count[i]
            measure[i] = 0.0
    monkeypatch.setattr(walls, "sfdi_rows", rows)
