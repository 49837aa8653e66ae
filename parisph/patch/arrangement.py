"""Particles of the unit square or cube, on a lattice or displaced from it, with or without walls.

Particles are displaced as in the papers (Z14 Sec. 2.2, Z17 Sec. 5.1): by k s (Rn - 1/2) in each direction, with Rn
uniform in [0, 1).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from parisph.base.arrays import Flags, Floats, Ints
from parisph.base.fields import CONTACT, FLUID, INNER, SURFACE, WALL, WET


@dataclass(frozen=True)
class Arrangement:
    """Particles and their lattice.

    x, normal : (n, dim) [m]; kind, corner, role : (n,) int8
    index : (n, dim) int, place on the lattice; cells : (dim,) int, number of cells of the square
    inside : (n,) bool, whether a particle is fluid of the square itself
    spacing : s [m]
    """

    x: Floats
    kind: NDArray[np.int8]
    corner: NDArray[np.int8]
    normal: Floats
    role: NDArray[np.int8]
    index: Ints
    cells: Ints
    inside: Flags
    spacing: float

    @property
    def dim(self) -> int:
        """2 or 3."""
        return self.x.shape[1]


def block(cells: int, jitter: float, seed: int, dim: int = 2, layers: int = 0, centred: bool = True) -> Arrangement:
    """Return displaced fluid of the unit square or cube, with layers of particles around it.

    centred : whether the cells^dim particles are in the middles of cells; else they are on the nodes, and those on the
        sides belong to the layers
    The particles of the layers have the role SURFACE, so that they have no equation.
    """
    line = np.arange(-layers, cells + layers + (not centred))
    index = _grid([line] * dim)
    random = np.random.default_rng(seed).random(index.shape)
    x = (index + 0.5 * centred + jitter * (random - 0.5)) / cells
    inside = np.all((index >= 0 if centred else index > 0) & (index < cells), axis=1)
    none = np.zeros(len(x), np.int8)
    role = np.where(inside, INNER, SURFACE).astype(np.int8)
    return Arrangement(x, none + np.int8(FLUID), none, np.zeros_like(x), role, index, np.full(dim, cells), inside,
                       1.0 / cells)


def tank(cells: Sequence[int], jitter: float, seed: int, lid: bool = False, spacing: float = 1.0) -> Arrangement:
    """Return an open tank of fluid, or a full closed one.

    Walls are on lattice planes, and fluid begins one spacing inside. Without a lid the last axis ends at the free
    surface, on the lattice plane `cells[-1]`, which is not displaced. The wall beside it has the role CONTACT.
    """
    top = np.array(cells)
    index = _grid([np.arange(c + 1) for c in top])
    upper = index == top
    upper[:, -1] &= lid
    inward = (index == 0).astype(float) - upper
    planes = np.abs(inward).sum(axis=1)
    kind = np.where(planes > 0, WALL, FLUID).astype(np.int8)
    surface = ~upper[:, -1] & (index[:, -1] == top[-1])
    role = np.where(kind == WALL, np.where(surface, CONTACT, WET), np.where(surface, SURFACE, INNER)).astype(np.int8)
    x = spacing * index
    moved = (kind == FLUID) & ~surface
    x[moved] += jitter * spacing * (np.random.default_rng(seed).random((np.count_nonzero(moved), len(top))) - 0.5)
    normal = np.where(planes[:, None] > 0, inward / np.sqrt(np.maximum(planes, 1))[:, None], 0.0)
    return Arrangement(x, kind, (planes > 1).astype(np.int8), normal, role, index, top, moved, spacing)


def _grid(lines: Sequence[Ints]) -> Ints:
    """Return all points of a lattice, (n, dim) int."""
    points: Ints = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, len(lines))
    return points
