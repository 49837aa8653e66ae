"""The initial lattice of a scene: its fluid points and its wall points.

In a tank the lattice begins at the tank's lower corner, so that wall particles lie on the wall and
fluid at s, 2s, ... from it. Without a tank it begins at the lower corner of a Box or Polygon, and has
a point at the centre of a Disc. It works in any number of dimensions.
"""

import math
from collections.abc import Sequence

import numpy as np

from parisph.base.arrays import Flags, Floats, Ints
from parisph.case.shapes import Box, Disc, Polygon, Tank

FIT = 1e-3      # a length fits if it is a whole number of spacings within this part of one spacing
STRETCH = 0.15  # of a spacing, by which the step along one axis may make up for that along another
CHUNK = 2**18   # lattice points looked at in one go; bounds the memory of a large scene
SAMPLES = {2: 8, 3: 4}  # along each edge of a cell that is cut by the surface of the fluid


class Lattice:
    """Points origin + step * index of one scene.

    Parameters
    ----------
    shape : Box, Disc or Polygon
    tank : Tank or None
    spacing : [m]
    layers : of wall particles: one on the wall, and further ones behind it

    Attributes
    ----------
    origin, step : (dim,) [m]
    first, counts : (dim,) int64, least index and number of points of the smallest block that holds the fluid
    top : (dim,) int64 index of the tank's far corner, or None without a tank
    """

    def __init__(self, shape: Box | Disc | Polygon, tank: Tank | None, spacing: float, layers: int = 1) -> None:
        self.shape, self.tank, self.spacing, self.layers = shape, tank, spacing, layers
        lower, upper = shape.bounds
        self.tolerance = 0.01 * spacing
        if tank is None:
            self.origin = np.array(shape.at) if isinstance(shape, Disc) else lower
            size = shape.size if isinstance(shape, Box) else None
        else:
            self.origin = tank.bounds[0]
            size = tank.size
        # The step is the spacing, but for the rounding in a spacing such as 0.0416667.
        self.step: Floats = np.full(len(lower), spacing)
        if size is not None:
            whole: Floats = size / np.maximum(np.round(size / spacing), 1)
            self.step = even_steps(size, spacing) if tank is None else whole
        self.first: Ints = np.ceil((lower - self.origin - self.tolerance) / self.step).astype(np.int64)
        last = np.floor((upper - self.origin + self.tolerance) / self.step).astype(np.int64)
        self.top: Ints | None = None
        # for each axis whether the tank has a wall at its upper end
        self._closed_above = np.array([True] * (len(lower) - 1) + [tank is not None and tank.closed], dtype=bool)
        if tank is not None:  # the walls, and the open top's rim, belong to the wall particles
            self.top = np.round(tank.size / self.step).astype(np.int64)
            self.first = np.maximum(self.first, 1)
            last = np.minimum(last, self.top - self._closed_above)
        self.counts: Ints = np.maximum(last - self.first + 1, 0)

    def position(self, index: Ints) -> Floats:
        """Return the positions (n, dim) [m] of the lattice indices (n, dim)."""
        return self.origin + index * self.step

    def index(self, x: Floats) -> Ints:
        """Return the indices (n, dim) of the lattice points nearest to x (n, dim) [m]."""
        nearest: Ints = np.round((x - self.origin) / self.step).astype(np.int64)
        return nearest

    def is_fluid(self, index: Ints) -> Flags:
        """Return which lattice indices (n, dim) are fluid."""
        inside: Flags = np.all((index >= self.first) & (index < self.first + self.counts), axis=1)
        inside[inside] = self.shape.inside(self.position(index[inside]), self.tolerance)
        return inside

    def is_surface(self, index: Ints) -> Flags:
        """Return which of the *fluid* lattice indices (n, dim) lack a neighbour along an axis.

        A wall counts as a neighbour where the fluid reaches it. The uppermost particles of water one spacing
        below a lid are on the surface; those of water up to the lid are at the same height, but inside.
        """
        open_side = np.zeros(len(index), dtype=bool)
        for axis in range(index.shape[1]):
            for side in (-1, 1):
                beside = index.copy()
                beside[:, axis] += side
                open_side |= ~(self.is_fluid(beside) | self._is_touched_wall(beside))
        return open_side

    def cells(self, index: Ints) -> Floats:
        """Return the volume of fluid that each of the *fluid* lattice indices (n, dim) represents, in cells.

        This is the fluid in its own cell, and an equal share of the fluid in neighbouring cells whose points
        are not fluid particles: on a wall, or just outside a curved surface. A particle beside a wall
        represents 3/2 cells, one on a plane surface 1/2. The sum is all the fluid of a Box. Parts of other
        shapes that are thinner than a cell and contain no particle are missing. Every particle represents
        some volume, even in the sharpest corner.
        """
        share = np.ones(len(index))
        beside = [index + offset for offset in _offsets(index.shape[1])]
        edge = ~np.all([self.is_fluid(other) for other in beside], axis=0)
        share[edge] = self._filling(index[edge])
        for other in beside:
            empty = np.flatnonzero(edge)[~self.is_fluid(other[edge])]
            share[empty] += self._filling(other[empty]) * self._takes(index[empty], other[empty])
        volume: Floats = np.maximum(share, 1.0 / SAMPLES[index.shape[1]] ** index.shape[1])
        return volume

    def _filling(self, index: Ints) -> Floats:
        """Return the fraction of the cells around lattice indices (n, dim) that is fluid, (n,)."""
        dim = index.shape[1]
        m = SAMPLES[dim]
        at = (np.indices((m,) * dim).reshape(dim, -1).T + 0.5) / m - 0.5
        filled = np.zeros(len(index))
        for offset in at:
            filled += self.shape.inside(self.position(index + offset), 0.0)
        return filled / len(at)

    def _takes(self, index: Ints, empty: Ints) -> Floats:
        """Return the share of fluid points (n, dim) in the cells of `empty` points beside them, (n,).

        The fluid points nearest to the empty one have equal shares.
        """
        distance = np.abs(index - empty).sum(axis=1)
        nearest, number = np.full(len(index), 9), np.zeros(len(index))
        for offset in sorted(_offsets(index.shape[1]), key=lambda offset: np.abs(offset).sum()):
            far = np.abs(offset).sum()
            there = self.is_fluid(empty + offset) & (far <= nearest)
            nearest[there] = far
            number += there
        return np.where(distance == nearest, 1.0 / number, 0.0)

    def has_surface(self) -> bool:
        """Return whether any fluid particle is on the surface.

        Checks CHUNK points at a time, and stops at the first.
        """
        total = int(np.prod(self.counts))
        for low in range(0, total, CHUNK):
            index = self._unravel(np.arange(low, min(low + CHUNK, total)))
            if np.any(self.is_surface(index[self.is_fluid(index)])):
                return True
        return False

    def _is_touched_wall(self, index: Ints) -> Flags:
        """Return which lattice indices (n, dim) lie on a wall, and in the fluid's shape up to its edge."""
        if self.top is None:
            return np.zeros(len(index), dtype=bool)
        touched: Flags = np.any((index <= 0) | ((index >= self.top) & self._closed_above), axis=1)
        touched[touched] = self.shape.inside(self.position(index[touched]), self.tolerance)
        return touched

    def fluid_indices(self, start: int = 0, stop: int | None = None) -> Ints:
        """Return the indices (n, dim) of fluid particles number start to stop, in the lattice's order.

        Only these are held in memory, whatever the size of the scene.
        """
        total = int(np.prod(self.counts))
        if isinstance(self.shape, Box):
            return self._unravel(np.arange(start, total if stop is None else min(stop, total)))
        found: list[Ints] = [np.empty((0, len(self.counts)), dtype=np.int64)]
        seen = 0
        for low in range(0, total, CHUNK):
            index = self._unravel(np.arange(low, min(low + CHUNK, total)))
            index = index[self.is_fluid(index)]
            found.append(index[max(start - seen, 0) : None if stop is None else max(stop - seen, 0)])
            seen += len(index)
        return np.concatenate(found)

    def count(self) -> int:
        """Return the number of fluid particles."""
        if isinstance(self.shape, Box):
            return int(np.prod(self.counts))
        total = int(np.prod(self.counts))
        return sum(
            int(np.count_nonzero(self.is_fluid(self._unravel(np.arange(low, min(low + CHUNK, total))))))
            for low in range(0, total, CHUNK)
        )

    def _unravel(self, number: Ints) -> Ints:
        return self.first + np.stack(np.unravel_index(number, self.counts), axis=1).astype(np.int64)

    def wall_count(self) -> int:
        """Return the number of wall particles."""
        return sum(self._shell_sizes())

    def wall_indices(self, start: int = 0, stop: int | None = None) -> tuple[Ints, Ints]:
        """Return the indices (n, dim) of wall particles number start to stop, and their face sums (n, dim).

        The face sum adds the inward unit vectors of all walls that a particle lies on: two of them in
        a corner. The rim of an open tank belongs to the side walls alone. Only these are held in memory.
        """
        if self.top is None:
            empty = np.empty((0, len(self.counts)), dtype=np.int64)
            return empty, empty
        closed, sizes = self._closed_above, self._shell_sizes()
        stop, before = sum(sizes) if stop is None else stop, 0
        found: list[Ints] = []
        inward: list[Ints] = []
        for layer, size in enumerate(sizes):
            number = np.arange(max(start - before, 0), max(min(stop - before, size), 0))
            index = _boundary(_points(self.top, closed, layer), closed, number) - layer
            found.append(index)
            inward.append((index == -layer).astype(np.int64) - ((index == self.top + layer) & closed))
            before += size
        return np.concatenate(found), np.concatenate(inward)

    def _shell_sizes(self) -> list[int]:
        """Return the numbers of wall particles in the layers, from the one on the wall outwards."""
        if self.top is None:
            return []
        closed = self._closed_above
        return [boundary_size(_points(self.top, closed, layer), closed) for layer in range(self.layers)]


def _points(top: Ints, closed: Flags, layer: int) -> list[int]:
    """Number of lattice points along each edge of a tank, walls included, and `layer` points behind each wall."""
    return [int(n) + 1 + layer * (1 + int(upper)) for n, upper in zip(top, closed)]


def boundary_size(counts: Sequence[int], closed: Sequence[bool] | Flags) -> int:
    """Return how many points of a block of `counts` points lie on a face: at the lower end of an axis, or the upper
    where closed."""
    return math.prod(counts) - math.prod(n - 1 - int(upper) for n, upper in zip(counts, closed))


def _boundary(counts: Sequence[int], closed: Flags, number: Ints) -> Ints:
    """Return the indices (n, dim) of the points number (n,) on the faces of a block, in the order of their indices."""
    if len(counts) == 1:
        return np.where(number == 0, 0, counts[0] - 1)[:, None]
    layer, edge = math.prod(counts[1:]), boundary_size(counts[1:], closed[1:])
    between = counts[0] - 1 - int(closed[0])    # layers of which only the edge is on a face
    first, last = number < layer, number >= layer + between * edge
    index: Ints = np.empty((len(number), len(counts)), dtype=np.int64)
    index[:, 0] = np.where(first, 0, np.where(last, counts[0] - 1, 1 + (number - layer) // edge))
    inside = np.where(first, number, number - layer - between * edge)
    whole = first | last
    index[whole, 1:] = np.stack(np.unravel_index(inside[whole], counts[1:]), axis=1)
    index[~whole, 1:] = _boundary(counts[1:], closed[1:], (number[~whole] - layer) % edge)
    return index


def _offsets(dim: int) -> Ints:
    """Return the steps (3^dim - 1, dim) from a lattice point to those around it."""
    steps: Ints = np.indices((3,) * dim).reshape(dim, -1).T - 1
    around: Ints = steps[np.any(steps != 0, axis=1)]
    return around


def misfit(length: float, spacing: float) -> float:
    """Return the distance of a length [m] from a whole number of spacings, in spacings."""
    return abs(length / spacing - round(length / spacing))


def nearest_spacings(lengths: Sequence[float], spacing: float) -> tuple[float, ...]:
    """Return the largest spacing <= and the smallest >= `spacing` that divide all lengths, or () if none does.

    The common measure of the lengths is found by Euclid's algorithm, down to a twentieth of the spacing.
    """
    measure = 0.0
    for length in lengths:
        a, b = max(measure, length), min(measure, length)
        while b > 1e-6 * max(lengths):
            a, b = b, a - b * round(a / b)
            b = abs(b)
        measure = a
    if measure < spacing / 20.0:
        return ()
    n = measure / spacing
    return tuple(dict.fromkeys(measure / k for k in (int(np.ceil(n)), int(np.floor(n))) if k >= 1))


def even_steps(size: Floats, spacing: float) -> Floats:
    """Return the steps (dim,) [m] that divide a box of a size (dim,) [m] into cells of about spacing^dim [m^dim].

    The shortest side is divided first, into the nearest whole number of spacings. The others make up for that, as far
    as their steps stay near the spacing: smaller cells would be compressed fluid, which expands as soon as it moves.
    """
    step: Floats = np.full(len(size), spacing)
    free = 1.0      # what the sides divided so far lack of a cell of the spacing
    for done, axis in enumerate(np.argsort(size, kind="stable")):
        left = len(size) - done
        near = spacing * min(max(free ** (1.0 / left), 1.0 - STRETCH), 1.0 + STRETCH)
        step[axis] = size[axis] / max(round(float(size[axis] / near)), 1)
        free *= spacing / step[axis]
    return step
