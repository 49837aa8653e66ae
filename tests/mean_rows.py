"""Wall rows that are all means of their neighbours, as some are where water leaves a wall."""

import numpy as np

from parisph.base.fields import WET
from parisph.kernels import walls


def install(monkeypatch) -> None:
    """Make the rows of all wet wall particles means, until the test ends."""
    full = walls.sfdi_rows

    def mean_rows(rows, cloud, radius):
        full(rows, cloud, radius)
        n, start = len(cloud.indptr) - 1, cloud.indptr
        for i in np.flatnonzero((cloud.role[:n] == WET) & (rows.count[:n] > 0)):
            rows.values[start[i]:start[i] + rows.count[i]] = 1.0 / rows.count[i]
            rows.measure[i] = 0.0
    monkeypatch.setattr(walls, "sfdi_rows", mean_rows)
