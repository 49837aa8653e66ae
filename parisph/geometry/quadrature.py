"""Sample places of the fluid of a scene at the start, each with the area around it (2D).

The volume of a particle is that of the places to which it is nearest (kernels.packing.volumes). The wetted region is
cut into narrow vertical strips with every corner between two strips, and each strip into short pieces. If straight
lines bound the region, the sum equals its area to round-off, whatever the size of the pieces.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from parisph.base.arrays import Floats, Ints
from parisph.case.bodies import StillWater
from parisph.geometry.columns import between, crossings, meet, overlapping
from parisph.geometry.fill import Filling
from parisph.geometry.solid import corners_of, solid_of

FINE = 8          # pieces per spacing
CHUNK = 2**18     # pieces treated at once


def fluid_area(fill: Filling, lower: Sequence[float] | Floats, upper: Sequence[float] | Floats,
               stretch: Callable[[Floats], Floats] | None = None) -> float:
    """Return the area [m2] of a body of fluid; see `samples`.

    stretch : None, or a function of places (n, 2) [m] that gives the factor (n,) by which columns are stretched
    """
    at, width, low, high = _pieces(fill, np.array(lower), np.array(upper))
    factor = 1.0 if stretch is None else stretch(np.stack([at, 0.5 * (low + high)], axis=1))
    return float(np.sum(width * (high - low) * factor))


def samples(fill: Filling, lower: Sequence[float] | Floats, upper: Sequence[float] | Floats,
            ends: tuple[float, float] = (-np.inf, np.inf), fine: int = FINE) -> Iterator[tuple[Floats, Floats]]:
    """Yield sample places (m, 2) [m] of a body of fluid, with the area (m,) [m2] of each. Not collective.

    An elevation of still water is left out: see geometry.raised.
    lower, upper : (2,) [m], the box that contains the scene
    ends : range of x [m] from which to return places; the places do not depend on it, so a rank finds near its own
        particles what one rank would find there
    fine : pieces per spacing
    """
    at, width, low, high = _pieces(fill, np.array(lower), np.array(upper), fine)
    near = (at >= ends[0]) & (at < ends[1])
    at, width, low, high = at[near], width[near], low[near], high[near]
    first, total = 0, np.cumsum(np.ceil((high - low) * fine / fill.spacing).astype(np.int64))
    while first < len(at):
        stop = max(int(np.searchsorted(total, (total[first - 1] if first else 0) + CHUNK)), first + 1)
        some = slice(first, stop)
        number, y, size = _divided(low[some], high[some], fill.spacing / fine)
        yield np.stack([np.repeat(at[some], number), y], axis=1), size * np.repeat(width[some], number)
        first = stop


def _pieces(fill: Filling, lower: Floats, upper: Floats, fine: int = FINE) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the fluid on the middle lines of strips: x, width, lower and upper end [m]."""
    a, b, sides = _sides(fill, lower, upper)
    cuts = np.unique(np.clip(np.concatenate([a[:, 0], sides, [lower[0], upper[0]]]), lower[0], upper[0]))
    _, at, width = _divided(cuts[:-1], cuts[1:], fill.spacing / fine)
    line, height = crossings(a, b, at)
    every: Ints = np.arange(len(at))
    line = np.concatenate([line, every, every])
    height = np.clip(height, lower[1], upper[1])
    height = np.concatenate([height, np.full(len(at), lower[1]), np.full(len(at), upper[1])])
    line, low, high = between(line, height)
    wet = (high > low) & fill.wet(np.stack([at[line], 0.5 * (low + high)], axis=1))
    line, low, high = line[wet], low[wet], high[wet]
    return at[line], width[line], low, high


def _sides(fill: Filling, lower: Floats, upper: Floats) -> tuple[Floats, Floats, Floats]:
    """Return all straight pieces that may bound the fluid, (n, 2) each, and further x [m] where it may end."""
    solids = [solid_of(wall) for wall in fill.walls]
    pieces = [solid.elements for solid in solids]
    for outline in solids:
        if not outline.closed:    # continues beyond its ends
            far = 4.0 * np.linalg.norm(upper - lower) + np.abs(outline.points).max() + np.abs(lower).max()
            for end, way in zip(outline.points[[0, -1]], outline.ways):
                pieces.append(np.array([[end, end + far * way / np.linalg.norm(way)]]))
    shapes = [*fill.holes, *(shape for other, holes in fill.others for shape in (other, *holes))]
    if not isinstance(fill.shape, StillWater):
        shapes.insert(0, fill.shape)
    for corners in map(corners_of, shapes):
        pieces.append(np.stack([corners, np.roll(corners, -1, axis=0)], axis=1))
    if isinstance(fill.shape, StillWater):
        pieces.append(np.array([[(lower[0], fill.shape.level), (upper[0], fill.shape.level)]]))
    a, b = np.concatenate(pieces).swapaxes(0, 1)
    return a, b, np.concatenate([b[:, 0], _meetings(a, b)])


def _meetings(a: Floats, b: Floats) -> Floats:
    """Return the x [m] at which pieces cross: there the height of the fluid has a kink."""
    found = [np.empty(0)]
    for i, j in overlapping(np.minimum(a, b), np.maximum(a, b)):
        d = b[i] - a[i]
        t, u = meet(a[i], d, a[j], b[j] - a[j])
        met = (t >= 0.0) & (t <= 1.0) & (u >= 0.0) & (u <= 1.0)
        found.append(a[i[met], 0] + t[met] * d[met, 0])
    return np.concatenate(found)


def _divided(low: Floats, high: Floats, longest: float) -> tuple[Ints, Floats, Floats]:
    """Divide intervals into pieces of at most `longest` [m]: return how many of each, (n,), and their middles and
    lengths (m,) [m]."""
    number = np.maximum(np.ceil((high - low) / longest - 1e-9).astype(np.int64), 1)
    size = np.repeat((high - low) / number, number)
    inside = np.arange(len(size)) - np.repeat(np.cumsum(number) - number, number)
    return number, np.repeat(low, number) + (inside + 0.5) * size, size
