"""The lattice on which a body of fluid and the walls of a tank start, in any number of dimensions.

In a tank it begins at the tank's lower corner, so wall particles lie on the wall and fluid at s, 2s, ... from it.
Without a tank it begins at the lower corner of a Box or Polygon, and has a point at the centre of a Disc
or an Ellipsoid.
"""

import numpy as np

from parisph.base.arrays import Floats, Ints
from parisph.case.ellipsoid import AnyShape, Ellipse
from parisph.case.shapes import Box, Disc, Tank

FIT = 1e-3      # spacings: tolerance for a length of a whole number of spacings
STRETCH = 0.15  # of a spacing: limit of the change of a step that makes up for another axis


class Lattice:
    """Points origin + step * index.

    shape : Box, Disc, Polygon or Ellipse
    spacing : [m]

    Attributes:
    origin, step : (dim,) [m]
    first, counts : (dim,) int64, least index and number of points of the smallest block around the fluid
    top : (dim,) int64 index of the tank's far corner; only with a tank
    """

    def __init__(self, shape: AnyShape, tank: Tank | None, spacing: float) -> None:
        lower, upper = shape.bounds
        tolerance = 0.01 * spacing
        if tank is None:
            self.origin = np.array(shape.at) if isinstance(shape, (Disc, Ellipse)) else lower
            size = shape.size if isinstance(shape, Box) else None
        else:
            self.origin = tank.bounds[0]
            size = tank.size
        self.step: Floats = np.full(len(lower), spacing)
        if size is not None:
            whole: Floats = size / np.maximum(np.round(size / spacing), 1)
            self.step = even_steps(size, spacing) if tank is None else whole
        self.first: Ints = np.ceil((lower - self.origin - tolerance) / self.step).astype(np.int64)
        last = np.floor((upper - self.origin + tolerance) / self.step).astype(np.int64)
        # per axis: whether the tank has a wall at its upper end
        self._closed_above = np.array([True] * (len(lower) - 1) + [tank is not None and tank.closed], dtype=bool)
        if tank is not None:  # the walls, and the open top's rim, belong to the wall particles
            self.top: Ints = np.round(tank.size / self.step).astype(np.int64)
            self.first = np.maximum(self.first, 1)
            last = np.minimum(last, self.top - self._closed_above)
        self.counts: Ints = np.maximum(last - self.first + 1, 0)

    def position(self, index: Ints) -> Floats:
        """Return the positions (n, dim) [m] of the lattice indices (n, dim)."""
        return self.origin + index * self.step

    def wall_indices(self) -> tuple[Ints, Ints]:
        """Return the indices (n, dim) of the points on the walls of the tank, in order, and their face sums (n, dim).

        The face sum adds the inward unit vectors of all walls on which a point lies: two in a corner. The rim of an
        open tank belongs to the side walls alone.
        """
        shape, closed, faces = tuple(self.top + 1), self._closed_above, []
        for axis, upper in enumerate(closed):
            for place in (0, self.top[axis])[: 1 + upper]:
                face = np.indices((*shape[:axis], 1, *shape[axis + 1:])).reshape(len(shape), -1)
                face[axis] = place
                faces.append(np.ravel_multi_index(tuple(face), shape))
        index: Ints = np.stack(np.unravel_index(np.unique(np.concatenate(faces)), shape), axis=1).astype(np.int64)
        return index, (index == 0).astype(np.int64) - ((index == self.top) & closed)


def misfit(length: float, spacing: float) -> float:
    """Return the distance of a length [m] from a whole number of spacings, in spacings."""
    return abs(length / spacing - round(length / spacing))


def even_steps(size: Floats, spacing: float) -> Floats:
    """Return the steps (dim,) [m] that divide a box of a size (dim,) [m] into cells of about spacing^dim [m^dim].

    The shortest side is divided first, into the nearest whole number of spacings. The others make up for it within
    STRETCH: smaller cells would be compressed fluid, which expands as soon as it moves.
    """
    step: Floats = np.full(len(size), spacing)
    free = 1.0      # spacing over step, product over the sides divided so far
    for done, axis in enumerate(np.argsort(size, kind="stable")):
        left = len(size) - done
        near = spacing * min(max(free ** (1.0 / left), 1.0 - STRETCH), 1.0 + STRETCH)
        step[axis] = size[axis] / max(round(float(size[axis] / near)), 1)
        free *= spacing / step[axis]
    return step
