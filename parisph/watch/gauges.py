"""Bodies of water in columns and along lines on all ranks, for gauges and fronts."""

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.probe_rows import BODY, TOP, WIDTH
from parisph.watch.sampling import View

# Lengths in spacings.
COLUMN = 1.5        # half the width of the column of water at a gauge, in 3D its radius
GAUGE_GAP = 1.5     # longest distance of particles in a column without air between them, for a gauge
STRETCH = 1.25      # added above a particle inside the fluid: they are farther apart below the crest of a steep wave
COLUMN_GAP = 2.1    # the same for a column: falling water stretches, in the dam break to 1.6, beside a wall to 2.2
BED = 2.0           # height above the bed, up to which water is on it
BED_GAP = 2.1       # longest distance of water from the bed, and of its particles along it: the reach of gradients

ROUNDING = 1.0 + 1e-9

Place = tuple[float, ...]    # of a gauge: x, in 3D (x, y) [m]


def bodies(z: Floats, gap: float, counts: Floats | None = None, ends: Floats | None = None) -> Floats:
    """Return the connected bodies (n, 3) along a line: lower end [m], upper end [m], particles; in order.

    Neighbours along the line belong to one body unless they are farther apart than `gap` [m]. Each rank finds the
    bodies of its own particles; joined, they are the bodies of all particles.

    z : (n,) positions of particles, or lower ends of bodies, in any order [m]
    counts, ends : (n,) particles and upper ends [m] if bodies are joined
    """
    order = np.argsort(z)
    z = z[order]
    if len(z) == 0:
        return np.empty((0, 3))
    reach = z if ends is None else np.maximum.accumulate(ends[order])
    first = np.flatnonzero(np.concatenate([[True], z[1:] - reach[:-1] > gap]))
    last = np.append(first[1:], len(z)) - 1
    number = np.ones(len(z)) if counts is None else counts[order]
    return np.column_stack([z[first], reach[last], np.add.reduceat(number, first)])


def column_rows(view: View, place: Place, gap: float, beside: float = -1.0) -> Floats:
    """Return rows (n, WIDTH) of this rank's bodies of water in the column at a place, as kernels.water_columns.

    Gaps above a particle inside the fluid may be longer by STRETCH. Water below a floor, such as an obstacle above the
    bed, is separate from the water on it.

    place : x, in 3D (x, y) [m]
    gap : longest distance of particles of a body; beside : distance from the place within which surface particles count
        too, negative for none; both in spacings
    """
    from parisph.kernels import water_columns

    p, s = view.particles, view.scene.spacing
    at, beside = _off_the_walls(np.array(place), view), beside * s
    beside += float(np.linalg.norm(at - place)) * (beside > 0.0)
    column = water_columns.Column(at, COLUMN * s * ROUNDING, beside, gap * s, STRETCH * s)
    found: Floats = water_columns.column_rows(p.x, p.kind, p.role, column, view.scene.floors_at(place, view.time))
    return found


def _off_the_walls(at: Floats, view: View) -> Floats:
    """Return the middle of the column at a place (dim - 1,) [m], a spacing or more from vertical walls.

    Particles keep that distance, and 1.6 spacings beside a wall where a column falls. Of a column around a corner only
    a quarter would have any.
    """
    found, s = at.copy(), view.scene.spacing
    for axis, wall in view.scene.mirrors_at(view.time):
        if axis < len(at) and abs(found[axis] - wall) < s:
            inward = 1.0 if wall < view.scene.middle[axis] else -1.0
            found[axis] = wall + inward * s
    return found


def top(rows: Floats, view: View, place: Place, gap: float) -> tuple[float, bool]:
    """Return the height of the water on the highest wet floor [m], and whether there is water.

    If all floors are dry, it is the height of the lowest. Without walls it is the top of the largest body, else nan.

    rows : of all ranks, from `column_rows` with the same place [m] and gap [spacings]
    """
    s, floors = view.scene.spacing, view.scene.floors_at(place, view.time)
    for number in range(len(floors), -1 if not len(floors) else 0, -1):
        own = rows[np.searchsorted(floors, rows[:, 1], side="right") == number] if number else rows
        found, tops = bodies_of_all(own[own[:, 0] == BODY], gap * s), own[own[:, 0] == TOP, 1]
        if not len(found) or (number and found[0, 0] > floors[number - 1] + BED_GAP * s):
            continue
        low, end, _ = found[0] if number else found[np.argmax(found[:, 2])]
        return float(tops[(tops >= low) & (tops <= end)].max()), True
    return (float(floors[0]) if len(floors) else np.nan), False


def body_rows(found: Floats) -> Floats:
    """Return bodies (n, 3) of this rank as rows (n, WIDTH) for all ranks."""
    rows = np.zeros((len(found), WIDTH))
    rows[:, 0], rows[:, 1:4] = BODY, found
    return rows


def bodies_of_all(rows: Floats, gap: float) -> Floats:
    """Return the bodies (n, 3) of all ranks from their rows, joined."""
    if len(rows) < 2:    # most gauges in most steps
        return rows[:, 1:4]
    return bodies(rows[:, 1], gap, counts=rows[:, 3], ends=rows[:, 2])
