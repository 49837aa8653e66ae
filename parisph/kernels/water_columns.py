"""Measurements of a gauge: the bodies of water above a place, and the surface beside it."""

import math
from typing import NamedTuple

import numpy as np

from parisph.base.fields import BALLISTIC, FLUID, INNER, SURFACE
from parisph.base.probe_rows import BODY, HEIGHT, TOP, WIDTH
from parisph.kernels.jit import inlined, kernel


class Column(NamedTuple):
    """Place `at` (dim - 1,) of a gauge: within `half`, and surface particles within `beside` (negative: none) [m].

    In 3D it is round: its corners would be the highest places of a square under a slope.

    Vertical neighbours belong to one body unless they are farther apart than the gap, or than gap + stretch above an
    inner particle [m].
    """

    at: np.ndarray
    half: float
    beside: float
    gap: float
    stretch: float


@kernel
def column_rows(x: np.ndarray, kind: np.ndarray, role: np.ndarray, column: Column, floors: np.ndarray) -> np.ndarray:
    """Return rows (n, WIDTH) of a label and numbers: HEIGHT, BODY and TOP, one TOP for each BODY.

    Bodies consist of fluid that is not in free flight, and lie on one floor each.

    x : (n, dim) [m], the last axis upwards; kind, role : (n,); floors : (m,) heights of the floors, upwards [m]
    """
    at, half, beside, gap, stretch = column
    up, inside, most = x.shape[1] - 1, 0, 0
    reach = max(half, beside)
    for i in range(len(x)):
        if kind[i] == FLUID and abs(x[i, 0] - at[0]) <= reach:
            away = _away(x, i, at)
            inside += (role[i] != BALLISTIC) & (away <= half)
            most += (role[i] == SURFACE) & (away <= beside)
    y, tops = np.empty(inside), np.empty(inside)
    rows = np.zeros((most + 2 * inside, WIDTH))
    n, made = 0, 0
    for i in range(len(x)):
        if kind[i] != FLUID or abs(x[i, 0] - at[0]) > reach:
            continue
        away = _away(x, i, at)
        if role[i] == SURFACE and away <= beside:
            rows[made, 0] = HEIGHT
            for a in range(up + 1):
                rows[made, 1 + a] = x[i, a]
            made += 1
        if role[i] != BALLISTIC and away <= half:
            y[n], tops[n] = x[i, up], x[i, up] + (stretch if role[i] == INNER else 0.0)
            n += 1
    _sort(y, tops)
    floor, body = 0, -1
    for k in range(n):
        new = body < 0 or y[k] - rows[body, 2] > gap
        while floor < len(floors) and y[k] >= floors[floor]:
            floor, new = floor + 1, True
        if new:
            body, made = made, made + 2
            rows[body, 0], rows[body, 1], rows[body, 2], rows[body + 1, 0] = BODY, y[k], tops[k], TOP
        rows[body, 2] = max(rows[body, 2], tops[k])
        rows[body, 3] += 1.0
        rows[body + 1, 1] = y[k]
    return rows[:made]


@inlined
def _away(x, i, at):
    """Return the horizontal distance of a particle from a place at (dim - 1,)."""
    away = abs(x[i, 0] - at[0])
    for a in range(1, len(at)):
        away = math.hypot(away, x[i, a] - at[a])
    return away


@inlined
def _sort(y, reach):
    """Sort y (n,) upwards, and `reach` with it (Shell 1959)."""
    step = len(y) // 2
    while step > 0:
        for k in range(step, len(y)):
            own, belongs, j = y[k], reach[k], k
            while j >= step and y[j - step] > own:
                y[j], reach[j] = y[j - step], reach[j - step]
                j -= step
            y[j], reach[j] = own, belongs
        step = 1 if step == 2 else int(step / 2.2)
