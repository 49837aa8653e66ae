"""The fluid at the start of a scene: lattice points in a shape, at least half a spacing from all walls (2D).

Points are counted by runs along vertical lattice lines. The ends of the runs follow from the shapes and the elements.
So each rank makes only its own points, and their numbers do not depend on the number of ranks.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from parisph.base.arrays import Flags, Floats, Ints
from parisph.case.bodies import StillWater
from parisph.case.ellipsoid import AnyShape
from parisph.case.fluids import Fluid
from parisph.case.lattice import FIT, STRETCH, Lattice
from parisph.case.shapes import Box, Tank
from parisph.geometry.columns import Intervals, between, crossings, gaps, near_pieces, union
from parisph.geometry.distance import area_vectors, nearest
from parisph.geometry.mesh import WallMesh, wall_mesh
from parisph.geometry.solid import Wall, corners_of, in_fluid

CUT = 0.5        # spacings: least distance of fluid from a wall
# The same for a single point at the surface on a slope: nearer to a slope of 15 degrees, the last particle slides
# off, by a motion that grows out of rounding by 1 % in a step. Slopes of over 45 degrees have fluid on both sides.
TIP = 0.7
LEVEL = 1e-3     # flatter walls count as level: a thin layer on them stays
EDGE = 0.01      # spacings: a point this close to the edge of a shape is inside
THIN = 0.75      # spacings: a thinner box has no lattice of its own
ROUNDING = 1e-6  # spacings: tolerance of distances from walls
FAR = 1e300      # [m], beyond all lines

Taken = tuple[AnyShape, Sequence[AnyShape]]    # a shape of other fluid and its holes


def taken(shapes: Sequence[AnyShape | StillWater], holes: Sequence[Sequence[AnyShape]], number: int) -> list[Taken]:
    """Return the other fluid to which a body of fluid gives way: the shapes before it, with their holes.

    Still water gives way to all other fluid and leaves its holes empty. So touching bodies join, and no place has two
    particles.
    """
    if isinstance(shapes[number], StillWater):
        return [(shape, ()) for shape in shapes if not isinstance(shape, StillWater)]
    return [(shape, own) for shape, own in zip(shapes[:number], holes) if not isinstance(shape, StillWater)]


@lru_cache(maxsize=64)
def filling_of(fluids: tuple[Fluid, ...], number: int, walls: tuple[Wall, ...], spacing: float) -> "Filling":
    """Return the Filling of one of the bodies of fluid of a scene (2D). Cached."""
    fluid = fluids[number]
    return Filling(fluid.shape, walls, spacing, fluid.holes,
                   taken([one.shape for one in fluids], [one.holes for one in fluids], number),
                   fluid.rise if fluid.raised and isinstance(fluid.shape, StillWater) else None)


class Filling:
    """The lattice points origin + step * index that one body of fluid fills.

    walls : all bodies of the scene, at the start
    spacing : [m]; holes : shapes without fluid inside this one
    others : other fluid, at least half a spacing away: shapes, and the holes of each; see `taken`
    rise : None, or a function of x (n,) [m] that gives the elevation (n,) [m] of the surface of still water. Columns
        are moved by it, not stretched, so the density of points is uniform.

    origin, step : (2,) [m]; that of still water starts at its level, that of other shapes as in case.lattice
    count : number of points
    even : whether they lie on the lattice of the tank as the only wall, or there is no wall
    """

    def __init__(self, shape: AnyShape | StillWater, walls: Sequence[Wall], spacing: float,
                 holes: Sequence[AnyShape] = (), others: Sequence[Taken] = (),
                 rise: Callable[[Floats], Floats] | None = None) -> None:
        mesh = wall_mesh(walls, spacing) if walls else None
        self._rise = rise
        self.shape, self.holes, self.others, self.spacing = shape, tuple(holes), tuple(others), spacing
        self.walls = tuple(walls)
        tank = next((wall for wall in walls if isinstance(wall, Tank)), None)
        self.even = not walls
        self.origin, self.step, first, last = self._frame(tank, mesh, len(walls))
        self._ends = first, last
        lines = self.origin[0] + np.arange(first[0], last[0] + 1) * self.step[0]
        lift = self._lift(lines)
        line, low, high = self._free(lines, mesh, first[1], last[1], lift)
        begin, end = self._rows(low - lift[line], high - lift[line])
        end = np.minimum(end, last[1])
        kept = end >= begin
        line, begin, end = line[kept], begin[kept], end[kept]
        middle = np.stack([line + first[0], (begin + end) // 2], axis=1)
        kept = in_fluid(walls, self.position(middle))
        if mesh is not None and isinstance(shape, StillWater):
            kept &= ~self._in_tip(middle, begin, end, mesh)
        self._line, self._begin = line[kept], begin[kept]
        self._before = np.concatenate([[0], np.cumsum(end[kept] - begin[kept] + 1)])
        self.count = int(self._before[-1])

    def _frame(self, tank: Tank | None, mesh: WallMesh | None, bodies: int) -> tuple[Floats, Floats, Ints, Ints]:
        """Return origin, step, and the least and the greatest index (2,) that may be filled."""
        s = self.spacing
        if isinstance(self.shape, StillWater):
            assert mesh is not None
            lower, upper = mesh.x0.min(axis=0), mesh.x0.max(axis=0)
            origin = np.array([lower[0] if tank is None else tank.bounds[0][0], self.shape.level])
            step = self._hanging_step(tank, self.shape.level - lower[1])
            first = np.ceil((lower - origin) / step).astype(np.int64)
            return origin, step, first, np.array([np.floor((upper[0] - origin[0]) / step[0]), 0], dtype=np.int64)
        if isinstance(self.shape, Box) and tank is not None and not _on_lattice(self.shape, tank, s):
            tank = None    # its own lattice, with points on its edges: the surface is where the user puts it
        self.even |= tank is not None and bodies == 1
        lattice = Lattice(self.shape, tank, s)
        return lattice.origin, lattice.step, lattice.first, lattice.first + lattice.counts - 1

    def _hanging_step(self, tank: Tank | None, depth: float) -> Floats:
        """Return the step (2,) [m] that divides the greatest depth [m] of still water, with cells of spacing^2.

        Otherwise the columns above a level bed could be up to half a cell too high or too low.
        """
        s = self.spacing
        rows = max(round(depth / s), 1)
        up = depth / rows
        if abs(depth / s - rows) <= FIT or abs(up / s - 1.0) > STRETCH:
            up = s
        across = s * s / up
        return np.array([across if tank is None else tank.width / max(round(tank.width / across), 1), up])

    def _in_tip(self, middle: Ints, begin: Ints, end: Ints, mesh: WallMesh) -> Flags:
        """Return which runs are a single point of the surface too near to a slope, (n,) bool."""
        found: Flags = (begin == end) & (end == 0)
        corners = mesh.corners()
        apart, element, _ = nearest(self.position(middle[found]), corners, self.spacing)
        area = area_vectors(corners[element])
        slopes = (np.abs(area[:, 0]) > LEVEL * np.linalg.norm(area, axis=1)) & (np.abs(area[:, 0]) < area[:, 1])
        found[found] = (apart < (TIP - ROUNDING) * self.spacing) & slopes
        return found

    def _lift(self, x: Floats) -> Floats:
        return np.zeros(len(x)) if self._rise is None else self._rise(x)

    def _rows(self, low: Floats, high: Floats) -> tuple[Ints, Ints]:
        """Return the first and the last row within intervals (n,) of heights [m]."""
        y, s = self.origin[1], self.step[1]
        first, last = np.ceil((low - y) / s - ROUNDING), np.floor((high - y) / s + ROUNDING)
        return first.astype(np.int64), last.astype(np.int64)

    def _free(self, lines: Floats, mesh: WallMesh | None, first: int, last: int, lift: Floats) -> Intervals:
        """Return the intervals of the lines inside the shape and away from walls, holes and other fluid."""
        bottom = self.origin[1] + (first - 0.5) * self.step[1] + lift.min(initial=0.0)
        top = self.origin[1] + (last + 0.5) * self.step[1] + lift.max(initial=0.0)
        taken = []
        if mesh is not None:
            corners = mesh.corners()
            taken.append(near_pieces(corners[:, 0], corners[:, 1], (CUT - ROUNDING) * self.spacing, lines))
        taken += [self._covered(hole, lines, -EDGE) for hole in self.holes]
        taken += [self._taken(other, own, lines) for other, own in self.others]
        if not isinstance(self.shape, (StillWater, Box)):    # first and last index bound a Box
            taken.append(gaps(self._covered(self.shape, lines, EDGE), len(lines), bottom, top))
        none = (np.empty(0, np.int64), np.empty(0), np.empty(0))
        return gaps(union(none, *taken), len(lines), bottom, top)

    def _taken(self, shape: AnyShape, holes: Sequence[AnyShape], lines: Floats) -> Intervals:
        """Return the intervals of the lines inside other fluid, or within half a spacing of it."""
        found = self._covered(shape, lines, CUT - ROUNDING)
        if not holes:
            return found
        free = union(gaps(found, len(lines), -FAR, FAR), *(
            self._covered(hole, lines, -(CUT - ROUNDING)) for hole in holes))
        return gaps(free, len(lines), -FAR, FAR)

    def _covered(self, shape: AnyShape, lines: Floats, edge: float) -> Intervals:
        """Return the intervals of the lines inside a shape, widened by `edge` spacings, narrowed if it is negative."""
        a = corners_of(shape)
        b = np.roll(a, -1, axis=0)
        line, low, high = between(*crossings(a, b, lines))
        inside = shape.inside(np.stack([lines[line], 0.5 * (low + high)], axis=1), 0.0)
        found = line[inside], low[inside], high[inside]
        near = near_pieces(a, b, abs(edge) * self.spacing, lines)
        if edge > 0.0:
            return union(found, near)
        outside = gaps(found, len(lines), -FAR, FAR)
        return gaps(union(outside, near), len(lines), -FAR, FAR)

    def position(self, index: Ints) -> Floats:
        """Return the positions (n, 2) [m] of lattice indices (n, 2)."""
        x = self.origin + index * self.step
        if self._rise is not None:
            x[:, 1] += self._lift(x[:, 0])
        return x

    def indices(self, start: int = 0, stop: int | None = None) -> Ints:
        """Return the lattice indices (n, 2) of points start to stop."""
        number = np.arange(start, self.count if stop is None else min(stop, self.count))
        run = np.searchsorted(self._before, number, side="right") - 1
        return np.stack([self._line[run] + self._ends[0][0], self._begin[run] + number - self._before[run]], axis=1)

    def cell(self, index: Ints) -> Floats:
        """Return the area (n,) [m2] of the lattice cells of indices (n, 2)."""
        return np.full(len(index), self.step.prod())

    def cells(self, index: Ints) -> Floats:
        """Return the area (n,) [m2] of a Box nearest to each of its points (n, 2), without other shapes.

        A point beside a wall has 3/2 cells, one on the surface 1/2.
        """
        assert isinstance(self.shape, Box)
        (first, last), (lower, upper) = self._ends, self.shape.bounds
        x, half = self.position(index), 0.5 * self.step
        sides = np.where(index == last, upper, x + half) - np.where(index == first, lower, x - half)
        return np.asarray(sides.prod(axis=1))

    def is_surface(self, index: Ints, others: "Sequence[Filling]" = ()) -> Flags:
        """Return which of the filled indices (n, 2) have a neighbour along an axis outside the fluid, (n,) bool.

        There is no free surface at a wall that the shape reaches. others : further fluid
        """
        free, fills = np.zeros(len(index), dtype=bool), {self, *others}
        for axis in range(2):
            for side in (-1, 1):
                beside = index.copy()
                beside[:, axis] += side
                x = self.position(beside)
                free |= ~np.any([fill.holds(x) for fill in fills], axis=0)
        return free

    def holds(self, x: Floats) -> Flags:
        """Return which points x (n, 2) [m] lie in the shape or on its edge, whatever the walls, (n,) bool."""
        edge = EDGE * self.spacing
        if isinstance(self.shape, StillWater):
            return x[:, 1] <= self.shape.level + self._lift(x[:, 0]) + edge
        inside = self.shape.inside(x, edge)
        for hole in self.holes:
            inside &= ~hole.inside(x, -edge) if not hasattr(hole, "points") else ~hole.inside(x, 0.0)
        return inside

    def wet(self, x: Floats) -> Flags:
        """Return which points x (n, 2) [m] are in this fluid, without the elevation of still water, (n,) bool."""
        found = x[:, 1] <= self.shape.level if isinstance(self.shape, StillWater) else self.shape.inside(x, 0.0)
        for hole in self.holes:
            found &= ~hole.inside(x, 0.0)
        for other, holes in self.others:
            found &= ~other.inside(x, 0.0) | np.any([np.zeros(len(x), bool), *(hole.inside(x, 0.0) for hole in holes)],
                                                    axis=0)
        found[found] = in_fluid(self.walls, x[found])
        return found


def _on_lattice(box: Box, tank: Tank, spacing: float) -> bool:
    """Return whether the edges of a box lie on the lattice of its tank, or it is too thin for its own lattice."""
    if np.any(box.size < THIN * spacing):
        return True
    step = Lattice(box, tank, spacing).step
    ends = (np.array(box.bounds) - tank.bounds[0]) / step
    return bool(np.all(np.abs(ends - np.round(ends)) <= FIT))
