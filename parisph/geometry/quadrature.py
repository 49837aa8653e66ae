"""Places all over the fluid of a scene at the start, each with the area around it (2D).

A particle stands for the volume of the places to which it is nearest (kernels.packing.volumes). The wetted region is
cut into narrow upright strips, so that every corner lies between two strips, and each strip into short pieces. The
sum is the area of the region to round-off where it is bounded by straight lines, whatever the size of the pieces.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from parisph.case.bodies import StillWater
from parisph.case.shapes import Shape
from parisph.geometry.columns import between, crossings, meet, overlapping
from parisph.geometry.fill import Taken
from parisph.geometry.outline import Wall, corners_of, in_fluid, outline_of

FINE = 8          # pieces of a spacing
CHUNK = 2**18     # pieces that are looked at in one go


def fluid_area(shape: Shape | StillWater, walls: Sequence[Wall], lower: Sequence[float], upper: Sequence[float],
               spacing: float, holes: Sequence[Shape] = (),
               stretch: Callable[[np.ndarray], np.ndarray] | None = None, others: Sequence[Taken] = ()) -> float:
    """Return the area [m2] of all fluid; see `samples`.

    stretch : None, or a function of places (n, 2) that gives the factor (n,) by which columns are stretched there
    """
    _, at, width, low, high = _pieces(shape, holes, others, walls, np.array(lower), np.array(upper), spacing)
    factor = 1.0 if stretch is None else stretch(np.stack([at, 0.5 * (low + high)], axis=1))
    return float(np.sum(width * (high - low) * factor))


def samples(shape: Shape | StillWater, walls: Sequence[Wall], lower: Sequence[float], upper: Sequence[float],
            spacing: float, holes: Sequence[Shape] = (), part: Sequence[Sequence[float]] | None = None,
            others: Sequence[Taken] = ()) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Yield places (m, 2) [m] all over the fluid, and the area (m,) [m2] around each of them. Not collective.

    shape : Box, Disc, Polygon or StillWater, without its holes and others, which are other fluid; see geometry.fill
    walls : bodies in front of which the fluid is
    lower, upper : (2,) [m], the box that holds the scene
    part : None, or the corners (2, 2) [m] of the part of the scene to look at. The places do not depend on it: a rank
        that looks at all places near its own particles finds for these what one rank would find.
    """
    _, at, width, low, high = _pieces(shape, holes, others, walls, np.array(lower), np.array(upper), spacing)
    if part is not None:
        near = (at >= part[0][0]) & (at < part[1][0]) & (high >= part[0][1]) & (low <= part[1][1])
        at, width, low, high = at[near], width[near], low[near], high[near]
    first, total = 0, np.cumsum(np.ceil((high - low) * FINE / spacing).astype(np.int64))
    while first < len(at):
        stop = max(int(np.searchsorted(total, (total[first - 1] if first else 0) + CHUNK)), first + 1)
        some = slice(first, stop)
        places, area = _divided(at[some], width[some], low[some], high[some], spacing)
        if part is not None:
            near = np.all((places >= part[0]) & (places < part[1]), axis=1)
            places, area = places[near], area[near]
        yield places, area
        first = stop


def _pieces(shape, holes, others, walls, lower, upper, spacing):
    """Return the fluid on the middle lines of strips: strip, place, width, lower and upper end [m]."""
    edges = (*holes, *(body for other, own in others for body in (other, *own)))
    a, b, sides = _sides(shape, edges, walls, lower, upper)
    cuts = np.unique(np.clip(np.concatenate([a[:, 0], sides, [lower[0], upper[0]]]), lower[0], upper[0]))
    number = np.maximum(np.ceil(np.diff(cuts) * FINE / spacing - 1e-9).astype(np.int64), 1)
    width = np.repeat(np.diff(cuts) / number, number)
    inside = np.arange(len(width)) - np.repeat(np.cumsum(number) - number, number)
    at = np.repeat(cuts[:-1], number) + (inside + 0.5) * width
    line, height = crossings(a, b, at)
    every = np.arange(len(at))
    line = np.concatenate([line, every, every])
    height = np.clip(height, lower[1], upper[1])
    height = np.concatenate([height, np.full(len(at), lower[1]), np.full(len(at), upper[1])])
    line, low, high = between(line, height)
    middle = np.stack([at[line], 0.5 * (low + high)], axis=1)
    wet = (high > low) & _is_wet(shape, holes, others, walls, middle)
    line, low, high = line[wet], low[wet], high[wet]
    return line, at[line], width[line], low, high


def _sides(shape, holes, walls, lower, upper):
    """Return all straight pieces that may bound the fluid, (n, 2) each, and further places [m] where it may end."""
    outlines = [outline_of(wall) for wall in walls]
    a, b = ([outline.elements[:, end] for outline in outlines] for end in (0, 1))
    for outline in outlines:
        if not outline.closed:    # an open wall continues beyond its ends
            far = 4.0 * np.linalg.norm(upper - lower) + np.abs(outline.points).max() + np.abs(lower).max()
            for end, way in zip((0, -1), outline.ways):
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
    found = [np.empty(0)]
    for i, j in overlapping(np.minimum(a, b), np.maximum(a, b)):
        d = b[i] - a[i]
        t, u = meet(a[i], d, a[j], b[j] - a[j])
        met = (t >= 0.0) & (t <= 1.0) & (u >= 0.0) & (u <= 1.0)
        found.append(a[i[met], 0] + t[met] * d[met, 0])
    return np.concatenate(found)


def _is_wet(shape, holes, others, walls, x):
    wet = x[:, 1] <= shape.level if isinstance(shape, StillWater) else shape.inside(x, 0.0)
    for hole in holes:
        wet &= ~hole.inside(x, 0.0)
    for other, own in others:
        has = other.inside(x, 0.0)
        for hole in own:
            has &= ~hole.inside(x, 0.0)
        wet &= ~has
    wet[wet] = in_fluid([outline_of(wall) for wall in walls], x[wet])
    return wet


def _divided(at, width, low, high, spacing):
    """Return the middles (m, 2) of short pieces of intervals, and their areas (m,)."""
    number = np.maximum(np.ceil((high - low) * FINE / spacing - 1e-9).astype(np.int64), 1)
    size = np.repeat((high - low) / number, number)
    inside = np.arange(len(size)) - np.repeat(np.cumsum(number) - number, number)
    y = np.repeat(low, number) + (inside + 0.5) * size
    return np.stack([np.repeat(at, number), y], axis=1), size * np.repeat(width, number)
