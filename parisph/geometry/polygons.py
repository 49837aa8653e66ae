"""The walls of bodies that touch or overlap (2D): the parts of their outlines that touch fluid, joined into chains.

Outlines are cut where they meet. Pieces inside another body are removed, and pieces where two bodies lie face to face.
The rest is joined so that the fluid is between a piece and the next one: a plate on a bed has a node on each side of
its foot. No library for polygons keeps the body of each piece and accepts open outlines.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from parisph.base.arrays import Flags, Floats, Ints
from parisph.geometry.columns import cross, meet, overlapping
from parisph.geometry.solid import Solid

CLOSE = 1e-6    # spacings: points nearer than this are merged


@dataclass(frozen=True)
class Chain:
    """Consecutive straight pieces, with the fluid on their left.

    points : (n, 2) [m]; closed : whether the last is joined to the first
    body : (n,) or, if open, (n - 1,) int, the number of the body of each piece
    angle : (n,) [rad], of the fluid at each point: pi on a straight wall and at the ends of an open chain
    marks : numbers of points, besides its corners, at which the mesh has a node (geometry.extrusion)
    """

    points: Floats
    body: Ints
    angle: Floats
    closed: bool
    marks: tuple[int, ...] = ()

    @property
    def elements(self) -> Floats:
        """The first and the last point of each piece, (pieces, 2, 2) [m]."""
        found: Floats = np.stack([self.points, np.roll(self.points, -1, axis=0)], axis=1)[: len(self.body)]
        return found


def joined(outlines: Sequence[Solid], spacing: float) -> list[Chain]:
    """Return the chains that the fluid between all outlines touches.

    outlines : of bodies 0, 1, ... with the same motion; spacing : [m]
    """
    points, pieces, body = _cut(outlines, CLOSE * spacing)
    keep = _seen(outlines, points, pieces, body)
    return _chains(points, pieces[keep], body[keep])


def _fluid_angle(back: Floats, ahead: Floats) -> Floats:
    """Return the angle of the fluid between directions (n, 2), clockwise from `back` to `ahead`, in (0, 2 pi]."""
    angle = (np.arctan2(back[:, 1], back[:, 0]) - np.arctan2(ahead[:, 1], ahead[:, 0])) % (2.0 * np.pi)
    return np.where((angle < 1e-9) | (angle > 2.0 * np.pi - 1e-9), 2.0 * np.pi, angle)


def _cut(outlines: Sequence[Solid], close: float) -> tuple[Floats, Ints, Ints]:
    """Cut outlines where they meet; return points (n, 2), pieces (m, 2) as numbers of points, and their bodies (m,)."""
    a, b = np.concatenate([outline.elements for outline in outlines]).swapaxes(0, 1)
    body = np.repeat(np.arange(len(outlines)), [len(outline.elements) for outline in outlines])
    owner, along = _meetings(a, b, body, close)
    number, points = merged(np.concatenate([a, b, a[owner] + along[:, None] * (b - a)[owner]]), close)
    first, last, between = number[: len(a)], number[len(a) : 2 * len(a)], number[2 * len(a) :]
    owner = np.concatenate([np.arange(len(a)), owner, np.arange(len(a))])
    along = np.concatenate([np.zeros(len(a)), along, np.ones(len(a))])
    at = np.concatenate([first, between, last])
    order = np.lexsort([along, owner])
    owner, at = owner[order], at[order]
    real = (owner[1:] == owner[:-1]) & (at[1:] != at[:-1])
    return points, np.stack([at[:-1], at[1:]], axis=1)[real], body[owner[:-1][real]]


def _meetings(a: Floats, b: Floats, body: Ints, close: float) -> tuple[Ints, Floats]:
    """Return the pieces that others touch or cross, and where, as fractions of their length, (n,) each."""
    pairs = np.concatenate([np.stack(pair) for pair in overlapping(np.minimum(a, b) - close, np.maximum(a, b) + close)],
                           axis=1)
    pairs = np.concatenate([pairs, pairs[::-1]], axis=1)
    i, j = pairs[:, np.lexsort(pairs[::-1])]
    i, j = i[body[i] != body[j]], j[body[i] != body[j]]
    d, e = (b - a)[i], (b - a)[j]
    length = np.hypot(d[:, 0], d[:, 1])
    t, u = meet(a[i], d, a[j], e)
    slanted = np.abs(cross(d, e)) > 1e-12 * length * np.hypot(e[:, 0], e[:, 1])
    found = []
    for end in (a, b):
        apart = end[j] - a[i]
        found.append(np.where(np.abs(cross(d, apart)) <= close * length, np.sum(d * apart, axis=1) / length**2, np.nan))
    t = np.concatenate([*found, np.where(slanted & (u >= 0.0) & (u <= 1.0), t, np.nan)])
    owner, length = np.tile(i, 3), np.tile(length, 3)
    inner = np.argsort(owner, kind="stable")    # per piece, touching ends first: `_merged` keeps the first place
    inner = inner[((t * length > close) & ((1.0 - t) * length > close))[inner]]
    return owner[inner], t[inner]


def merged(places: Floats, close: float) -> tuple[Ints, Floats]:
    """Merge places (n, 2) nearer than `close` into the first; return the point number (n,) of each, and the points."""
    groups = np.stack([_groups(places[:, axis], close) for axis in range(2)], axis=1)
    _, first, number = np.unique(groups, axis=0, return_index=True, return_inverse=True)
    return number.reshape(-1), places[first]


def _groups(values: Floats, close: float) -> Ints:
    """Return group numbers (n,) of values; neighbouring values in a group differ by at most `close`."""
    order = np.argsort(values, kind="stable")
    group = np.empty(len(values), dtype=np.int64)
    group[order] = np.concatenate([[0], np.cumsum(np.diff(values[order]) > close)])
    return group


def _seen(outlines: Sequence[Solid], points: Floats, pieces: Ints, body: Ints) -> Flags:
    """Return which pieces bound fluid, (m,) bool: not inside another body, not face to face with one, and not twice."""
    two_sided = np.array([o.two_sided for o in outlines])
    keep, on = np.ones(len(pieces), dtype=bool), np.zeros((len(pieces), len(outlines)), dtype=bool)
    place, first = np.unique(np.sort(pieces, axis=1), axis=0, return_inverse=True)
    first = first.reshape(-1)
    order = np.argsort(first, kind="stable")
    for same in np.split(order, np.cumsum(np.bincount(first, minlength=len(place)))[:-1]):
        on[np.ix_(same, body[same])] = True
        if len(same) > 1:
            keep[same] = _kept(pieces[same, 0] < pieces[same, 1], two_sided[body[same]])
    middle = 0.5 * (points[pieces[:, 0]] + points[pieces[:, 1]])
    for number, outline in enumerate(outlines):
        asked = np.flatnonzero(keep & ~on[:, number])
        keep[asked] = outline.in_front(middle[asked])
    return keep


def _kept(forward: Flags, thin: Flags) -> Flags:
    """Return which of the pieces in one place stay: one for each direction with fluid on its left.

    forward : (n,) bool, their directions; thin : (n,) bool, whether of a plate. Between solids is no fluid.
    """
    solid = [(forward & ~thin).any(), (~forward & ~thin).any()]
    keep = np.zeros(len(forward), dtype=bool)
    for way, other in ((True, 1), (False, 0)):
        there = np.flatnonzero(forward == way)
        if there.size and not solid[other]:
            keep[there[0]] = True
    return keep


def _chains(points: Floats, pieces: Ints, body: Ints) -> list[Chain]:
    """Join pieces to chains, those with an open start first."""
    after, angle = _next_pieces(points, pieces)
    has_before = np.zeros(len(pieces), dtype=bool)
    has_before[after[after >= 0]] = True
    used, chains = np.zeros(len(pieces), dtype=bool), []
    for start in [*np.flatnonzero(~has_before), *range(len(pieces))]:
        row, piece = [], start
        while piece >= 0 and not used[piece]:
            used[piece] = True
            row.append(piece)
            piece = after[piece]
        if row:
            chains.append(_chain(points, pieces, body, angle, np.array(row), piece == row[0]))
    return chains


def _chain(points: Floats, pieces: Ints, body: Ints, angle: Floats, row: Ints, closed: bool) -> Chain:
    at = points[pieces[row, 0]]
    if closed:
        return Chain(at, body[row], angle[np.roll(row, 1)], True)
    end = points[pieces[row[-1:], 1]]
    return Chain(np.concatenate([at, end]), body[row], np.concatenate([[np.pi], angle[row[:-1]], [np.pi]]), False)


def _next_pieces(points: Floats, pieces: Ints) -> tuple[Ints, Floats]:
    """Return for each piece the one that follows it, -1 for none, and the angle of the fluid between them [rad]."""
    ends = np.concatenate([pieces[:, 1], pieces[:, 0]])
    order = np.argsort(ends, kind="stable")
    after, angle = np.full(len(pieces), -1), np.full(len(pieces), np.pi)
    direction = points[pieces[:, 1]] - points[pieces[:, 0]]
    count = np.bincount(ends, minlength=len(points))
    for around in np.split(order, np.cumsum(count)[:-1]):
        coming, going = around[around < len(pieces)], around[around >= len(pieces)] - len(pieces)
        for piece in coming:
            back = np.broadcast_to(-direction[piece], (len(around) - 1, 2))
            others = coming[coming != piece]
            turn = _fluid_angle(back, np.concatenate([direction[going], -direction[others]]))
            if len(going) and turn[: len(going)].min() <= turn.min():
                nearest = int(np.argmin(turn[: len(going)]))
                after[piece], angle[piece] = going[nearest], turn[nearest]
    return after, angle
