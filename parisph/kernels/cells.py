"""Cell sort and neighbour lists."""

import math
from collections import namedtuple

import numpy as np

from parisph.kernels.jit import axes_of, inlined, kernel, subkernel

# Points x in a grid with a lower corner and (dim,) counts of cells of a size. Cell c contains
# member[start[c]:start[c + 1]].
_Cells = namedtuple("_Cells", "x lower size counts start member axes")

RINGS = 3    # cells in the reach of `far_from`: more would follow the reach more closely, and cost more
_ALL = np.zeros(0, np.bool_)    # no point is left out


def neighbour_lists(x: np.ndarray, n_owned: int, radius: float, left_out: np.ndarray = _ALL
                    ) -> tuple[np.ndarray, np.ndarray]:
    """Return the neighbours of the first n_owned points among all points, as CSR: indptr, indices, int32.

    A point is not its own neighbour. Owned neighbours come first, in ascending order (`_ordered`). Raises ValueError if
    the radius is not positive, or a position or distance is not finite.

    x : (n, dim) positions [m], dim 2 or 3; radius : points closer than this are neighbours [m]
    left_out : (n,) bool, points without neighbours that are no neighbours either; without rows none
    """
    x = np.ascontiguousarray(x)
    if not radius > 0.0:
        raise ValueError(f"radius {radius} must be positive")
    if n_owned == 0:
        return np.zeros(1, np.int32), np.zeros(0, np.int32)
    indptr, indices = _search(_sorted(x, radius, left_out=left_out), n_owned, radius, left_out)
    return indptr, _ordered(indptr, indices)


def far_from(x: np.ndarray, others: np.ndarray, reach: float) -> np.ndarray:
    """Return which points x (n, dim) [m] are farther than the reach [m] from all others (m, dim) [m], (n,) bool.

    Some that are farther by less than 1/RINGS of the reach along each axis are not among them. Raises ValueError as
    `neighbour_lists`.
    """
    if len(others) == 0:
        return np.ones(len(x), np.bool_)
    cells = _sorted(np.ascontiguousarray(others), reach / RINGS, x.sum(), rim=RINGS)
    near = cells.start[:-1] < cells.start[1:]
    for _ in range(RINGS):
        near = _with_adjacent(near, cells.counts, cells.axes)
    return _outside(np.ascontiguousarray(x), cells, near)


@kernel
def _outside(x, cells, near):
    """Return which points x (n, dim) are in no cell that is `near` (cells,) bool."""
    outside = np.ones(len(x), np.bool_)
    for i in range(len(x)):
        cell = _cell_of(x, i, cells)
        outside[i] = cell < 0 or not near[cell]
    return outside


@inlined
def _cell_of(x, i, cells):
    """Return the number of the cell that point i of x is in, -1 outside the grid."""
    cell, inside = 0, True
    for a in range(len(cells.axes)):
        k = math.floor((x[i, a] - cells.lower[a]) / cells.size)
        inside = inside and 0 <= k < cells.counts[a]
        cell = cell * cells.counts[a] + int(k)
    return cell if inside else -1


def _sorted(x, radius, other=0.0, rim=0, left_out=_ALL):
    """Return the _Cells of points x (n, dim) [m], at least as wide as the radius [m], with `rim` empty rows around.

    left_out : of `neighbour_lists`

    Raises ValueError if a point, or the sum `other` of further ones, is not finite.
    """
    lower, extent = np.empty((2, x.shape[1]))
    if not (_corners(lower, extent, x) and np.isfinite(other)):
        raise ValueError("a position, or the distance of two points, is not finite")
    counts, size = _grid(extent, radius, len(x))
    lower, counts, axes = lower - rim * size, counts + 2 * rim, axes_of(x.shape[1])
    return _Cells(x, lower, size, counts, *_sort(x, lower, size, counts, axes, left_out), axes)


@kernel
def _corners(lower, extent, x):
    """Write the lower corner and the sides of the bounding box of points; return whether all are finite."""
    finite = True
    for a in range(x.shape[1]):
        least, most = x[0, a], x[0, a]
        for i in range(len(x)):
            finite &= abs(x[i, a]) < math.inf
            least, most = min(least, x[i, a]), max(most, x[i, a])
        lower[a], extent[a] = least, most - least
        finite &= extent[a] < math.inf
    return finite


def _grid(extent, radius, n):
    """Return the counts and size of cells that are at least as wide as the radius and not many more than the points."""
    size = radius
    while True:
        counts = [math.floor(side / size) + 1 for side in extent.tolist()]
        if math.prod(counts) <= 4 * n + 1024:
            return np.array(counts, np.int64), size
        size *= 1.5  # limits memory if one droplet is far away


@subkernel
def _cell(point, lower, size, counts, axes):
    number = 0
    for a in range(len(axes)):
        k = int((point[a] - lower[a]) / size)
        number = number * counts[a] + min(max(k, 0), counts[a] - 1)
    return number


@kernel
def _sort(x, lower, size, counts, axes, left_out) -> tuple[np.ndarray, np.ndarray]:
    total, every = 1, len(left_out) == 0
    for a in range(len(axes)):
        total *= counts[a]
    start = np.zeros(total + 1, np.int32)
    cell = np.empty(len(x), np.int32)
    for i in range(len(x)):
        if every or not left_out[i]:
            cell[i] = _cell(x[i], lower, size, counts, axes)
            start[cell[i] + 1] += 1
    for c in range(total):
        start[c + 1] += start[c]
    fill = start[:-1].copy()
    member = np.empty(start[total], np.int32)
    for i in range(len(x)):
        if every or not left_out[i]:
            member[fill[cell[i]]] = i
            fill[cell[i]] += 1
    return start, member


@subkernel
def _enlarged(indices, n, size):
    """Return an array of `size` that begins with the first n indices."""
    larger = np.empty(size, np.int32)
    for k in range(n):    # numba takes a second longer to compile a copy of slices, for its error message
        larger[k] = indices[k]
    return larger


@kernel
def _search(cells, n_owned, radius, left_out):
    x, lower, size, counts, start, member, axes = cells
    dim = len(axes)
    blocks = 1
    for a in range(dim - 1):
        blocks *= 3
    last = counts[dim - 1]
    r2 = radius * radius
    place = x[member]  # members of a cell are contiguous in memory
    indptr = np.zeros(n_owned + 1, np.int32)
    indices = np.empty(24 * n_owned + 256, np.int32)
    n = np.uint32(0)    # unsigned, so that numba adds no test for a negative index: a third less time
    for i in range(n_owned):
        if len(left_out) > 0 and left_out[i]:
            indptr[i + 1] = n
            continue
        k_last = min(max(int((x[i, dim - 1] - lower[dim - 1]) / size), 0), last - 1)
        lo, hi = max(k_last - 1, 0), min(k_last + 1, last - 1)
        cx, cy = x[i, 0], x[i, 1]
        cz = x[i, 2] if dim == 3 else 0.0
        for block in range(blocks):
            rest, row, inside = block, 0, True
            for a in range(dim - 1):
                k = min(max(int((x[i, a] - lower[a]) / size), 0), counts[a] - 1) + rest % 3 - 1
                rest //= 3
                inside = inside and 0 <= k < counts[a]
                row = row * counts[a] + k
            if not inside:
                continue
            # members of cells along the last axis are contiguous
            first, stop = start[row * last + lo], start[row * last + hi + 1]
            if n + stop - first > len(indices):
                indices = _enlarged(indices, n, 2 * len(indices) + stop - first)
            for m in range(np.uint32(first), np.uint32(stop)):
                dx, dy = place[m, 0] - cx, place[m, 1] - cy
                d2 = dx * dx + dy * dy
                if dim == 3:
                    d2 += (place[m, 2] - cz) ** 2
                indices[n] = member[m]    # the next one overwrites it if it is not a neighbour
                n += np.uint32((d2 < r2) & (member[m] != i))
        indptr[i + 1] = n
    return indptr, indices[:n]


@kernel
def _ordered(indptr, indices):
    """Return the lists with the owned neighbours of each point first, in ascending order.

    Each point is appended to the lists of its neighbours, in the order of the points. This is faster than sorting, and
    it requires symmetric lists. If rounding makes a pair at the radius a neighbour in one direction only, the counts
    differ and the lists are returned unchanged. Two such pairs that cancel exchange neighbours whose weight is zero.
    """
    n = len(indptr) - 1
    found, fill = np.empty_like(indices), indptr[:-1].copy()
    for i in range(n):
        for k in range(np.uint32(indptr[i]), np.uint32(indptr[i + 1])):
            j = np.uint32(indices[k])
            if j < n:
                place = np.uint32(fill[j])
                if place == indptr[j + 1]:
                    return indices
                found[place] = i
                fill[j] = place + 1
    for i in range(n):
        free = fill[i]
        if free == indptr[i + 1]:    # no ghosts
            continue
        for k in range(indptr[i], indptr[i + 1]):
            if indices[k] >= n:
                if free == indptr[i + 1]:
                    return indices
                found[free] = indices[k]
                free += 1
        if free != indptr[i + 1]:
            return indices
    return found


def nearby(x: np.ndarray, others: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Return, for points x (n, dim) [m], which of the others (m, dim) [m] are within the radius [m], as CSR.

    Returns indptr (n + 1,) int32, indices (nnz,) int32. Raises ValueError as `neighbour_lists`.
    """
    x, others = np.ascontiguousarray(x), np.ascontiguousarray(others)
    if not radius > 0.0:
        raise ValueError(f"radius {radius} must be positive")
    if len(others) == 0 or len(x) == 0:
        return np.zeros(len(x) + 1, np.int32), np.zeros(0, np.int32)
    cells = _sorted(others, radius, x.sum(), rim=1)
    near = _with_adjacent(cells.start[:-1] < cells.start[1:], cells.counts, cells.axes)
    return _search_nearby(x, cells, radius, near)


@kernel
def _with_adjacent(some, counts, axes):
    """Return which cells are `some` (cells,) bool or next to these, (cells,) bool. The outermost cells are not."""
    found = np.zeros(len(some), np.bool_)
    for cell in range(len(found)):
        if some[cell]:
            for block in range(3 ** len(axes)):
                found[cell + _step(block, counts, axes)] = True
    return found


@inlined
def _step(block, counts, axes):
    """Return the offset of the number of one of the 3^dim adjacent cells."""
    step = 0
    for a in range(len(axes)):
        step = step * counts[a] + block % 3 - 1
        block //= 3
    return step


@kernel
def _search_nearby(x, cells, radius, beside):
    others, _, _, counts, start, member, axes = cells
    dim = len(axes)
    indptr = np.zeros(len(x) + 1, np.int32)
    indices = np.empty(4 * len(others) + 256, np.int32)
    n = 0
    for i in range(len(x)):
        cell = _cell_of(x, i, cells)
        if cell >= 0 and beside[cell]:
            for block in range(3**dim):
                there = cell + _step(block, counts, axes)
                if not 0 <= there < len(beside):
                    continue
                for m in range(start[there], start[there + 1]):
                    d2 = 0.0
                    for a in range(dim):
                        d2 += (others[member[m], a] - x[i, a]) ** 2
                    if d2 < radius * radius:
                        if n == len(indices):
                            indices = _enlarged(indices, n, 2 * n)
                        indices[n] = member[m]
                        n += 1
        indptr[i + 1] = n
    return indptr, indices[:n]


def nearest_points(x: np.ndarray, places: np.ndarray, spacing: float) -> np.ndarray:
    """Return for each place (m, dim) [m] the index (m,) int64 of the nearest of the points x (n, dim) [m].

    The first of equally near points is taken. Raises ValueError if there are no points, or one is not finite.

    spacing : typical distance between neighbouring points [m]
    """
    x, places = np.ascontiguousarray(x), np.ascontiguousarray(places)
    if len(x) == 0:
        raise ValueError("there is no point")
    found = np.empty(len(places), np.int64)
    _search_nearest(found, places, _sorted(x, spacing, places.sum()))
    return found


@kernel
def _search_nearest(found, places, cells):
    lower, size, counts, dim, last = cells.lower, cells.size, cells.counts, len(cells.axes), cells.counts.max()
    home = np.empty(dim, np.int64)
    for i in range(len(places)):
        away = 0    # cells between the place and the grid
        for a in range(dim):
            home[a] = math.floor((places[i, a] - lower[a]) / size)
            away = max(away, -home[a], home[a] - counts[a] + 1)
        best, ring = math.inf, away
        while ring <= last + away and best > ((ring - 1) * size) ** 2 * (ring > 0):
            best = _nearest_in_ring(found, best, i, home, ring, places, cells)
            ring += 1


@inlined
def _nearest_in_ring(found, best, i, home, ring, places, cells):
    """Search the cells that are `ring` cells away from the place's home cell; return the least distance^2."""
    x, counts, start, member = cells.x, cells.counts, cells.start, cells.member
    dim, side = len(cells.axes), 2 * ring + 1
    for block in range(side**dim):
        rest, cell, edge, inside = block, 0, False, True
        for a in range(dim):
            step = rest % side - ring
            rest //= side
            edge = edge or abs(step) == ring
            k = home[a] + step
            inside = inside and 0 <= k < counts[a]
            cell = cell * counts[a] + k
        if not (edge and inside):
            continue
        for m in range(start[cell], start[cell + 1]):
            d2 = 0.0
            for a in range(dim):
                d2 += (x[member[m], a] - places[i, a]) ** 2
            if d2 < best or (d2 == best and member[m] < found[i]):
                best, found[i] = d2, member[m]
    return best
