"""The volume of fluid that each particle stands for at the start: that of the places to which it is nearest (2D).

The wetted region is cut into narrow upright strips, so that every corner lies between two strips, and each strip into short
pieces; a piece belongs to the particle nearest to its middle. The sum is the area of the region to round-off where it is bounded
by straight lines, whatever the size of the pieces.
"""

from collections.abc import Sequence

import numpy as np

from parisph.case.bodies import StillWater
from parisph.geometry.columns import between, crossings
from parisph.geometry.outline import corners_of, in_fluid, outline_of

FINE = 8          # pieces of a spacing
CHUNK = 2**18     # pieces that are looked at in one go
RINGS = 3         # cells of a spacing around a piece in which its particle is looked for; farther ones come later


def fluid_area(shape, walls: Sequence, lower: Sequence[float], upper: Sequence[float], spacing: float,
               holes: Sequence = ()) -> float:
    """Return the area [m2] of all fluid; see `volumes`."""
    _, _, width, low, high = _pieces(shape, holes, walls, np.array(lower), np.array(upper), spacing)
    return float(np.sum(width * (high - low)))


def volumes(x: np.ndarray, shape, walls: Sequence, lower: Sequence[float], upper: Sequence[float], spacing: float,
            holes: Sequence = (), part: Sequence | None = None) -> np.ndarray:
    """Return the area (n,) [m2] of the fluid for which each particle stands. Not collective.

    x : (n, 2) particles [m]; shape : Box, Disc, Polygon or StillWater, without its holes; walls : bodies in front of which the
    fluid is; lower, upper : (2,) [m], the box that holds the scene
    part : None, or the corners (2, 2) [m] of the part of the scene to look at. A rank that gives its own particles and those near
    them, and a part that holds all places nearest to its own, finds for these what one rank would find.
    """
    found = np.zeros(len(x))
    line, at, width, low, high = _pieces(shape, holes, walls, np.array(lower), np.array(upper), spacing)
    if part is not None:
        near = (at >= part[0][0]) & (at <= part[1][0]) & (high >= part[0][1]) & (low <= part[1][1])
        line, at, width, low, high = line[near], at[near], width[near], low[near], high[near]
    cells = _Cells(x, spacing)
    first, total = 0, np.cumsum(np.ceil((high - low) * FINE / spacing).astype(np.int64))
    while first < len(line):
        stop = max(int(np.searchsorted(total, (total[first - 1] if first else 0) + CHUNK)), first + 1)
        some = slice(first, stop)
        places, area = _divided(at[some], width[some], low[some], high[some], spacing)
        if part is not None:
            near = np.all((places >= part[0]) & (places < part[1]), axis=1)
            places, area = places[near], area[near]
        np.add.at(found, cells.nearest(places), area)
        first = stop
    return found


def _pieces(shape, holes, walls, lower, upper, spacing):
    """Return the intervals of fluid on the middle lines of strips: strip, place [m], width [m], lower and upper end [m]."""
    a, b, sides = _sides(shape, holes, walls, lower, upper)
    cuts = np.unique(np.clip(np.concatenate([a[:, 0], sides, [lower[0], upper[0]]]), lower[0], upper[0]))
    number = np.maximum(np.ceil(np.diff(cuts) * FINE / spacing - 1e-9).astype(np.int64), 1)
    width = np.repeat(np.diff(cuts) / number, number)
    inside = np.arange(len(width)) - np.repeat(np.cumsum(number) - number, number)
    at = np.repeat(cuts[:-1], number) + (inside + 0.5) * width
    line, height = crossings(a, b, at)
    every = np.arange(len(at))
    line = np.concatenate([line, every, every])
    height = np.concatenate([np.clip(height, lower[1], upper[1]), np.full(len(at), lower[1]), np.full(len(at), upper[1])])
    line, low, high = between(line, height)
    middle = np.stack([at[line], 0.5 * (low + high)], axis=1)
    wet = (high > low) & _is_wet(shape, holes, walls, middle)
    line, low, high = line[wet], low[wet], high[wet]
    return line, at[line], width[line], low, high


def _sides(shape, holes, walls, lower, upper):
    """Return all straight pieces that may bound the fluid, (n, 2) each, and further places [m] where it may end."""
    outlines = [outline_of(wall) for wall in walls]
    a, b = [o.starts for o in outlines], [o.ends for o in outlines]
    for outline in outlines:
        if not outline.closed:    # an open wall continues beyond its ends
            far = 4.0 * np.linalg.norm(upper - lower) + np.abs(outline.points).max() + np.abs(lower).max()
            for end, beside in ((0, 1), (-1, -2)):
                way = outline.points[end] - outline.points[beside]
                a.append(outline.points[[end]])
                b.append(outline.points[[end]] + far * way / np.linalg.norm(way))
    for body in (*(() if isinstance(shape, StillWater) else (shape,)), *holes):
        corners = corners_of(body)
        a.append(corners)
        b.append(np.roll(corners, -1, axis=0))
    if isinstance(shape, StillWater):
        a.append(np.array([[lower[0], shape.level]]))
        b.append(np.array([[upper[0], shape.level]]))
    a, b = np.concatenate(a), np.concatenate(b)
    return a, b, np.concatenate([b[:, 0], _meetings(a, b)])


def _meetings(a, b):
    """Return the x [m] at which pieces cross: there the height of the fluid has a kink."""
    found = []
    for i in range(len(a)):
        p, d, e = a[i + 1 :] - a[i], b[i] - a[i], b[i + 1 :] - a[i + 1 :]
        slant = d[0] * e[:, 1] - d[1] * e[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (p[:, 0] * e[:, 1] - p[:, 1] * e[:, 0]) / slant
            u = (p[:, 0] * d[1] - p[:, 1] * d[0]) / slant
        met = (t >= 0.0) & (t <= 1.0) & (u >= 0.0) & (u <= 1.0)
        found.append(a[i, 0] + t[met] * d[0])
    return np.concatenate(found) if found else np.empty(0)


def _is_wet(shape, holes, walls, x):
    wet = x[:, 1] <= shape.level if isinstance(shape, StillWater) else shape.inside(x, 0.0)
    for hole in holes:
        wet &= ~hole.inside(x, 0.0)
    wet[wet] = in_fluid([outline_of(wall) for wall in walls], x[wet])
    return wet


def _divided(at, width, low, high, spacing):
    """Return the middles (m, 2) of short pieces of intervals, and their areas (m,)."""
    number = np.maximum(np.ceil((high - low) * FINE / spacing - 1e-9).astype(np.int64), 1)
    size = np.repeat((high - low) / number, number)
    inside = np.arange(len(size)) - np.repeat(np.cumsum(number) - number, number)
    y = np.repeat(low, number) + (inside + 0.5) * size
    return np.stack([np.repeat(at, number), y], axis=1), size * np.repeat(width, number)


class _Cells:
    """Points sorted into square cells, to find the nearest of a place."""

    def __init__(self, x, size):
        self.x, self.size = x, size
        self.lower = x.min(axis=0)
        place = self._place(x)
        self.counts = place.max(axis=0) + 1
        number = place[:, 0] * self.counts[1] + place[:, 1]
        self.order = np.argsort(number, kind="stable")
        self.start = np.concatenate([[0], np.cumsum(np.bincount(number, minlength=self.counts.prod()))])

    def _place(self, x):
        return np.floor((x - self.lower) / self.size).astype(np.int64)

    def nearest(self, places):
        """Return the number (m,) of the point nearest to each place (m, 2): within RINGS cells, else of all."""
        best, apart2 = np.full(len(places), -1), np.full(len(places), np.inf)
        cell = self._place(places)
        for ring in range(RINGS + 1):
            for dx in range(-ring, ring + 1):
                for dy in range(-ring, ring + 1):
                    if max(abs(dx), abs(dy)) == ring:
                        self._look(places, cell + [dx, dy], ring, best, apart2)
        for k in np.flatnonzero(best < 0):
            best[k] = np.argmin(np.sum((self.x - places[k]) ** 2, axis=1))
        return best

    def _look(self, places, cell, ring, best, apart2):
        """Look at the points of one cell of each place; a cell in this ring is at least ring - 1 sizes away."""
        open_ = np.all((cell >= 0) & (cell < self.counts), axis=1) & (apart2 > ((ring - 1) * self.size) ** 2 * (ring > 1))
        which = np.flatnonzero(open_)
        number = cell[which, 0] * self.counts[1] + cell[which, 1]
        first, count = self.start[number], self.start[number + 1] - self.start[number]
        for k in range(int(count.max(initial=0))):
            there = count > k
            row, point = which[there], self.order[first[there] + k]
            d2 = np.sum((self.x[point] - places[row]) ** 2, axis=1)
            nearer = d2 < apart2[row]
            best[row[nearer]], apart2[row[nearer]] = point[nearer], d2[nearer]
