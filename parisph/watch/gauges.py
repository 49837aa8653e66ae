"""Bodies of water in columns and along lines, as gauges and fronts need them of all ranks."""

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.probe_rows import BODY, TOP
from parisph.case.probes import WIDTH
from parisph.watch.sampling import View

# Lengths in spacings.
COLUMN = 1.5        # half the width of the column of water at a gauge
GAUGE_GAP = 1.5     # air under a gauge: more than this between one particle and the next above it
STRETCH = 1.25      # more than that above a particle inside the fluid: under the crest of a steep wave they lie apart
COLUMN_GAP = 2.1    # air in a column: falling water stretches, in the dam break to 1.6, beside a wall to 2.2
BED = 2.0           # water on the bed is as near to it as this
BED_GAP = 2.1       # and reaches from one particle to the next, as far as gradients do

ROUNDING = 1.0 + 1e-9


def bodies(z: Floats, gap: float, counts: Floats | None = None, ends: Floats | None = None) -> Floats:
    """Return the connected bodies (n, 3) along a line: lower end [m], upper end [m], particles; in order.

    Neighbours along the line belong to one body unless they are farther apart than `gap` [m].

    z : (n,) positions of particles, or lower ends of bodies, in any order [m]
    counts, ends : (n,), of bodies found before (each rank finds the bodies of its own particles;
        joining these gives the bodies of all particles)
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


def column_rows(view: View, at: float, gap: float, beside: float = -1.0) -> Floats:
    """Return rows (n, 4) of this rank's bodies of water in the column at x = `at`, as kernels.water_columns.

    Above a particle inside the fluid is water: there a body may have gaps that are longer by STRETCH. Water below a
    floor, such as an obstacle that does not stand on the bed, is no part of the water on it.

    gap : air that ends a body; beside : to either side of `at`, within which surface particles serve, too; negative for
        none; both in spacings
    """
    from parisph.kernels import water_columns

    p, s = view.particles, view.scene.spacing
    column = water_columns.Column(at, COLUMN * s * ROUNDING, beside * s, gap * s, STRETCH * s)
    found: Floats = water_columns.column_rows(p.x, p.kind, p.role, column, view.scene.floors_at(at, view.time))
    return found


def top(rows: Floats, view: View, at: float, gap: float) -> tuple[float, bool]:
    """Return the height of the water on the highest floor on which some stands [m], and whether there is any.

    That is the lowest floor where all are dry. Without walls it is the top of the largest body, nan without one.

    rows : of all ranks, from `column_rows` with the same x `at` [m] and gap [spacings]
    """
    s, floors = view.scene.spacing, view.scene.floors_at(at, view.time)
    for number in range(len(floors), -1 if not len(floors) else 0, -1):
        own = rows[np.searchsorted(floors, rows[:, 1], side="right") == number] if number else rows
        found, tops = bodies_of_all(own[own[:, 0] == BODY], gap * s), own[own[:, 0] == TOP, 1]
        if not len(found) or (number and found[0, 0] > floors[number - 1] + BED_GAP * s):
            continue
        low, end, _ = found[0] if number else found[np.argmax(found[:, 2])]
        return float(tops[(tops >= low) & (tops <= end)].max()), True
    return (float(floors[0]) if len(floors) else np.nan), False


def body_rows(found: Floats) -> Floats:
    """Return bodies (n, 3) of this rank as rows for all."""
    rows = np.empty((len(found), WIDTH))
    rows[:, 0], rows[:, 1:] = BODY, found
    return rows


def bodies_of_all(rows: Floats, gap: float) -> Floats:
    """Return the bodies (n, 3) that those of all ranks are together."""
    if len(rows) < 2:    # as for most gauges in most steps
        return rows[:, 1:]
    return bodies(rows[:, 1], gap, counts=rows[:, 3], ends=rows[:, 2])
