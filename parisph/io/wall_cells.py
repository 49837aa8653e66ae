"""The cells of snapshots: a vertex for each particle, and in 3D the triangles of the walls between their nodes.

Wall nodes are particles, so walls have the pressure of the snapshot at their corners.
"""

from dataclasses import dataclass

import numpy as np

from parisph.base.arrays import Array, Ints
from parisph.base.communicator import Communicator
from parisph.io.slabs import Slab

VERTEX, TRIANGLE = 1, 5    # VTK's numbers of cells
NO_BODY = -1    # of the cells of particles


@dataclass(frozen=True)
class WallCells:
    """The triangles of all walls. ids : (M, 3) int64, of the particles at their corners; body : (M,) int, numbers"""

    ids: Ints
    body: Array


def write_order(comm: Communicator, ids: Ints, offset: int, walls: WallCells) -> Ints:
    """Return the rows (M, 3) int64 of the corners of all walls in a file. Collective.

    ids : (n,) of this rank's rows; offset : its first row
    """
    low, high = int(walls.ids.min()), int(walls.ids.max())
    own = np.flatnonzero((ids >= low) & (ids <= high))
    found = np.full(high - low + 1, -1, np.int64)
    for there, rows in comm.allgather((ids[own], offset + own)):
        found[there - low] = rows
    corners: Ints = found[walls.ids - low]
    return corners


def cells(comm: Communicator, ids: Ints, offset: int, total: int, walls: WallCells | None) -> tuple[list[Slab], int]:
    """Return the datasets of the cells, and the number of triangles. Collective.

    ids : (n,) of this rank's rows; offset : its first row; total : rows of all ranks
    walls : None for cells of particles only. A triangle without one of its nodes is left out.

    Each rank writes its vertices and then a part of the triangles, so that its part of each dataset has no gaps.
    """
    n, corners, body = len(ids), np.empty((0, 3), np.int64), np.empty(0, np.int16)
    if walls is not None and len(walls.ids):
        corners = write_order(comm, ids, offset, walls)
        there = corners.min(axis=1) >= 0
        corners, body = corners[there], walls.body[there].astype(np.int16)
    low, high = (len(corners) * rank // comm.size for rank in (comm.rank, comm.rank + 1))
    own, many, before = corners[low:high], len(corners), offset + 3 * low
    numbers = np.concatenate([np.arange(offset, offset + n, dtype=np.int64), own.ravel()])
    sizes = np.repeat([1, 3], [n, len(own)])
    ends, first = before + np.cumsum(sizes), offset + low + 1
    if comm.rank == 0:    # offsets have a leading zero, one entry more than cells
        ends, first = np.concatenate(([0], ends)), 0
    found = [Slab("VTKHDF/Connectivity", numbers, before, total + 3 * many),
             Slab("VTKHDF/Offsets", ends.astype(np.int64), first, total + many + 1),
             Slab("VTKHDF/Types", np.repeat(np.array([VERTEX, TRIANGLE], np.uint8), [n, len(own)]), offset + low,
                  total + many)]
    if walls is not None:
        found.append(Slab("VTKHDF/CellData/body", np.concatenate([np.full(n, NO_BODY, np.int16), body[low:high]]),
                          offset + low, total + many,
                          {"meaning": "number of the body of a piece of wall, -1 for particles"}))
    return found, many
