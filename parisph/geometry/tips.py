"""Fluid too narrow for particles, as under a pipe on its bed: a solid fills it (2D).

Where two walls meet at a small angle, the fluid between them ends in a wedge. Where a curved wall comes close to
another, it has a neck. Particles pushed into these find no place, and water at rest beside them moves (measured for
discs of 1.5 to 5 spacings on a bed, or up to .4 above it, and for notches of 20 degrees). So the fluid ends where it is
WIDTH wide: there the mesh has a short wall across it. A smaller spacing fills less. A slit between parallel walls stays
open: water rests there, and carries the pressure to the bodies around it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import count

import numpy as np
from pydantic import Field

from parisph.base.arrays import Floats
from parisph.base.errors import CaseError
from parisph.case.bodies import Obstacle
from parisph.case.shapes import Polygon, Slip
from parisph.geometry.columns import overlapping
from parisph.geometry.distance import nearest
from parisph.geometry.mesh import chains_of, places_along, reaches
from parisph.geometry.polygons import CLOSE, Chain
from parisph.geometry.solid import Wall

SHARP = np.radians(30.0)    # angle of the fluid below which its tip is filled: at 28 degrees water rests, at 21 not
WIDTH = 0.75     # spacings across the end of a filled tip: room for particles, and long enough for an element
LONGEST = 20.0   # spacings: a longer wedge, as under a slab tilted by a degree, stays open
BENT = np.radians(45.0)      # a side ends where the wall turns by more at a point
TURNED = np.radians(75.0)    # or by more in total
PLACES = 400     # along a wedge where its width is measured


class Filled(Obstacle):
    """A solid added in place of fluid that is too narrow.

    beside : numbers of the two bodies beside it
    """

    beside: tuple[int, int] = Field(kw_only=True)


@dataclass(frozen=True)
class Tip:
    """One filled place: its solid, where (2,) [m], the gap between the two bodies there [m], and its length [m]."""

    solid: Filled
    at: tuple[float, float]
    gap: float
    length: float


@lru_cache(maxsize=8)
def tips(walls: tuple[Wall, ...], spacing: float) -> tuple[Tip, ...]:
    """Return the tips and the necks of the fluid between walls with the same motion; spacing : [m]."""
    found: list[Tip] = []
    chains = chains_of(walls, spacing)
    for one, other, at, gap, corners, length in [*_wedges(chains, spacing), *_necks(chains, walls, spacing)]:
        slip: Slip = "none" if all(getattr(walls[body], "slip", "free") == "none" for body in (one, other)) else "free"
        used = {wall.name for wall in (*walls, *(tip.solid for tip in found))}
        name = next(name for number in count(1) if (name := f"filled{number}") not in used)
        try:
            solid = Filled(shape=Polygon(points=tuple(map(tuple, corners.tolist()))), motion=walls[one].motion,
                           name=name, slip=slip, beside=(one, other))
        except CaseError:    # its sides cross, as in a small pocket
            continue
        found.append(Tip(solid, (float(at[0]), float(at[1])), gap, length))
    return tuple(found)


Found = tuple[int, int, Floats, float, Floats, float]    # bodies, place, gap, corners, length


def _wedges(chains: Sequence[Chain], spacing: float) -> Iterator[Found]:
    for chain in chains:
        pieces = len(chain.body)
        for k in np.flatnonzero(chain.angle < SHARP).tolist():
            start = chain.points[k]
            far = _apart(_side(chain, k - 1, -1, start, spacing), _side(chain, k + 1, 1, start, spacing), spacing)
            if far is not None:
                back, ahead, length = far
                yield (int(chain.body[(k - 1) % pieces]), int(chain.body[k % pieces]), start, 0.0,
                       np.concatenate([back, ahead[:0:-1]]), length)


def _necks(chains: Sequence[Chain], walls: Sequence[Wall], spacing: float) -> Iterator[Found]:
    """Places where a curved wall comes nearest to another one, between two chains with the same motion."""
    boxes = [np.array([chain.points.min(axis=0), chain.points.max(axis=0)]) for chain in chains]
    reach, done = WIDTH * spacing, np.empty((0, 2))
    if len(chains) < 2:
        return
    lower, upper = np.array([box[0] for box in boxes]), np.array([box[1] for box in boxes])
    pairs = np.concatenate([np.stack(pair, axis=1) for pair in overlapping(lower - reach, upper + reach)])
    for i, j in sorted(map(tuple, np.concatenate([pairs, pairs[:, ::-1]]).tolist())):
        one, other = chains[i], chains[j]
        if not one.closed or walls[one.body[0]].motion != walls[other.body[0]].motion:
            continue
        curved = (one.angle > np.pi + CLOSE) & (one.angle < np.pi + BENT)
        gap, piece, foot = nearest(one.points, other.elements, reach)
        least = curved & (gap < reach) & (gap <= np.roll(gap, 1)) & (gap <= np.roll(gap, -1))
        for k in np.flatnonzero(least).tolist():
            at, m = one.points[k], int(piece[k])
            if len(done) and np.linalg.norm(done - at, axis=1).min() < spacing:
                continue
            ahead = _apart(_side(one, k + 1, 1, at, spacing), _side(other, m, -1, foot[k], spacing), spacing)
            back = _apart(_side(other, m + 1, 1, foot[k], spacing), _side(one, k - 1, -1, at, spacing), spacing)
            if ahead is None or back is None:
                continue
            corners = np.concatenate([ahead[0], ahead[1][::-1], back[0][1:], back[1][:0:-1]])
            done = np.concatenate([done, corners])
            yield (int(one.body[k % len(one.body)]), int(other.body[m]), 0.5 * (at + foot[k]), float(gap[k]), corners,
                   ahead[2] + back[2])


def _apart(one: Floats, other: Floats, spacing: float) -> tuple[Floats, Floats, float] | None:
    """Return two sides (n, 2) [m] up to where they are WIDTH apart, and the length [m] there, the same along both.

    Return None if they never are.
    """
    sides = one, other
    reach = [reaches(side) for side in sides]
    along = np.linspace(0.0, min(length[-1] for length in reach), PLACES)
    across = np.linalg.norm(places_along(one, reach[0], along) - places_along(other, reach[1], along), axis=1)
    wide = np.flatnonzero(across >= WIDTH * spacing)
    if not wide.size or wide[0] == 0:
        return None
    far = float(along[wide[0]])
    back, ahead = (np.concatenate([side[length < far - CLOSE * spacing], places_along(side, length, np.array([far]))])
                   for side, length in zip(sides, reach))
    return back, ahead, far


def _side(chain: Chain, first: int, step: int, start: Floats, spacing: float) -> Floats:
    """Return the points (n, 2) [m] of a chain from a place on it through point `first` to a sharp turn or LONGEST."""
    points, found, length, turned = chain.points, [start], 0.0, 0.0
    for number in range(len(points) - 1):
        at = first + step * number
        if not chain.closed and not 0 <= at < len(points):
            break
        at %= len(points)
        way = float(np.linalg.norm(points[at] - found[-1]))
        if way > CLOSE * spacing:
            found.append(points[at])
            length += way
        bend = abs(float(chain.angle[at]) - np.pi)
        turned += bend
        if length >= LONGEST * spacing or bend > BENT or turned > TURNED:
            break
    return np.array(found)

