"""Intervals along vertical lines (2D): where lines cross outlines or come near them, and the gaps between.

A scene of N particles has sqrt(N) such lines, so every rank can treat all of them, but only its own particles. A set of
intervals is three arrays: line number, lower end, upper end.
"""

from collections.abc import Iterator

import numpy as np

from parisph.base.arrays import Floats, Ints

Intervals = tuple[Ints, Floats, Floats]


def meet(p: Floats, d: Floats, q: Floats, e: Floats) -> tuple[Floats, Floats]:
    """Return t and u (...) where lines p + t d and q + u e (..., 2) meet, not finite where they are parallel."""
    apart, slant = q - p, cross(d, e)
    with np.errstate(divide="ignore", invalid="ignore"):
        return cross(apart, e) / slant, cross(apart, d) / slant


def cross(a: Floats, b: Floats) -> Floats:
    """Return the cross products (...) of vectors (..., 2)."""
    product: Floats = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product


def _pairs(left: Floats, right: Floats, lines: Floats) -> tuple[Ints, Ints]:
    """Return the numbers of all pairs of a piece from `left` to `right` and a line that it meets."""
    first = np.searchsorted(lines, left, side="left")
    count = np.maximum(np.searchsorted(lines, right, side="right") - first, 0)
    piece = np.repeat(np.arange(len(left)), count)
    return piece, np.arange(len(piece)) - np.repeat(np.cumsum(count) - count, count) + first[piece]


def overlapping(lower: Floats, upper: Floats, some: int = 2**20) -> Iterator[tuple[Ints, Ints]]:
    """Yield the numbers of all pairs of boxes that overlap or touch, (m,) each, each pair once, about `some` at a time.

    lower, upper : (n, 2) [m], the corners of the boxes
    """
    order = np.argsort(lower[:, 0], kind="stable")
    low, high = lower[order], upper[order]
    last = np.searchsorted(low[:, 0], high[:, 0], side="right")    # of the boxes that begin before this one ends
    count = np.maximum(last - np.arange(len(order)) - 1, 0)
    before = np.concatenate([[0], np.cumsum(count)])
    start = 0
    while start < len(order):
        stop = max(int(np.searchsorted(before, before[start] + some, side="right")) - 1, start + 1)
        i = np.repeat(np.arange(start, stop), count[start:stop])
        j = i + 1 + np.arange(len(i)) - (before[i] - before[start])
        meet = (low[i, 1] <= high[j, 1]) & (low[j, 1] <= high[i, 1])
        yield order[i[meet]], order[j[meet]]
        start = stop


def near_pieces(a: Floats, b: Floats, reach: float, lines: Floats) -> Intervals:
    """Return where lines x = lines (n,), ascending, are within `reach` [m] of straight pieces from a to b (m, 2).

    The points near a piece are a convex set, so they form one interval on a line.
    """
    piece, line = _pairs(np.minimum(a[:, 0], b[:, 0]) - reach, np.maximum(a[:, 0], b[:, 0]) + reach, lines)
    a, b, x, ends = a[piece], b[piece], lines[line], []
    along = b - a
    side = reach * np.stack([-along[:, 1], along[:, 0]]) / np.maximum(np.hypot(along[:, 0], along[:, 1]), 1e-300)
    with np.errstate(divide="ignore", invalid="ignore"):
        for sign in (-1.0, 1.0):    # circles around both ends of a piece, and its two offset sides
            ends += [p[:, 1] + sign * np.sqrt(reach**2 - (x - p[:, 0]) ** 2) for p in (a, b)]
            t = (x - a[:, 0] - sign * side[0]) / along[:, 0]
            ends.append(np.where((t >= 0.0) & (t <= 1.0), a[:, 1] + t * along[:, 1] + sign * side[1], np.nan))
    low, high = np.fmin.reduce(ends), np.fmax.reduce(ends)
    met = low <= high    # false where a line only touches
    return line[met], low[met], high[met]


def crossings(a: Floats, b: Floats, lines: Floats) -> tuple[Ints, Floats]:
    """Return where straight pieces from a to b (m, 2) cross lines x = lines (n,), ascending: line, height [m]."""
    left, right = np.minimum(a[:, 0], b[:, 0]), np.maximum(a[:, 0], b[:, 0])
    piece, line = _pairs(left, right, lines)
    there = (lines[line] < right[piece])    # a line through a shared end crosses one of two pieces
    piece, line = piece[there], line[there]
    t = (lines[line] - a[piece, 0]) / (b[piece, 0] - a[piece, 0])
    return line, a[piece, 1] + t * (b[piece, 1] - a[piece, 1])


def between(line: Ints, height: Floats) -> Intervals:
    """Return the intervals between neighbouring heights (n,) on each line."""
    order = np.lexsort([height, line])
    line, height = line[order], height[order]
    same = line[1:] == line[:-1]
    return line[:-1][same], height[:-1][same], height[1:][same]


def beds(corners: Floats, columns: Floats, top: float) -> Floats:
    """Return the height (n,) [m] of the highest element below `top` with fluid above it, on lines x = columns (n,).

    corners : (M, 2, 2) [m], with the fluid on the left. Without such an element: the height of the lowest one.
    """
    up = corners[corners[:, 0, 0] < corners[:, 1, 0]]
    order = np.argsort(columns, kind="stable")
    line, height = crossings(up[:, 0], up[:, 1], columns[order])
    bed, below = np.full(len(columns), -np.inf), height < top
    np.maximum.at(bed, order[line[below]], height[below])
    return np.where(np.isfinite(bed), bed, corners[:, :, 1].min())


def union(*parts: Intervals) -> Intervals:
    """Return the union of all parts as disjoint intervals, in order."""
    line, low, high = (np.concatenate([part[k] for part in parts]) for k in range(3))
    line, at = np.concatenate([line, line]), np.concatenate([low, np.maximum(low, high)])
    step = np.repeat([1, -1], len(low))
    order = np.lexsort([-step, at, line])    # at one place, starts before ends: touching intervals are joined
    line, at = line[order], at[order]
    last = np.flatnonzero(np.cumsum(step[order]) == 0)
    first = np.append(0, last[:-1] + 1)[: len(last)]
    return line[first], at[first], at[last]


def gaps(taken: Intervals, lines: int, bottom: float, top: float) -> Intervals:
    """Return the gaps (also of length 0) that intervals leave on `lines` lines between bottom and top, in order."""
    every = np.arange(lines)
    below = every, np.full(lines, -np.inf), np.full(lines, bottom)
    above = every, np.full(lines, top), np.full(lines, np.inf)
    line, low, high = union(taken, below, above)
    same = line[1:] == line[:-1]
    return line[1:][same], high[:-1][same], low[1:][same]
