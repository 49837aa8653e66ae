"""Voronoi cells of particles (2D): the measure of volume that disorder does not bias.

A kernel-sum density is wrong by several per cent on disordered particles, and the union of
discs hides losses. The mean area of the cells inside the fluid is neither.
"""

import math

import numpy as np

from parisph.kernels.jit import kernel


@kernel
def cell_areas(area, chosen, x, reach, indptr, indices):
    """Area of the Voronoi cell of chosen particles among their neighbours [m^2].

    area : (n_owned,) output; 0 where not chosen, and where the cell is not closed by
        neighbours within the reach (its size would be that of the lists, not of the fluid)
    chosen : (n_owned,) bool; x : (n_all, 2); reach : radius of the lists [m]
    """
    px, py = np.empty(64), np.empty(64)
    qx, qy = np.empty(64), np.empty(64)
    for i in range(len(indptr) - 1):
        area[i] = 0.0
        if not chosen[i]:
            continue
        # the square that holds every point nearer to i than to anything beyond the reach
        half = 0.5 * reach
        n = 4
        px[0], px[1], px[2], px[3] = -half, half, half, -half
        py[0], py[1], py[2], py[3] = -half, -half, half, half
        for k in range(indptr[i], indptr[i + 1]):
            j = indices[k]
            dx, dy = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1]
            n = _clip(px, py, n, dx, dy, 0.5 * (dx * dx + dy * dy), qx, qy)
        closed = n > 2
        total = 0.0
        for m in range(n):
            closed &= math.hypot(px[m], py[m]) < half * 1.000001
            o = (m + 1) % n
            total += px[m] * py[o] - px[o] * py[m]
        area[i] = 0.5 * total if closed else 0.0


@kernel
def _clip(px, py, n, dx, dy, limit, qx, qy):
    """Keep the part of the polygon where r . d <= limit; return its number of corners.

    A polygon with more corners than fit is given up: 0, and the cell counts as not closed.
    """
    count = 0
    for m in range(n):
        o = m + 1 if m + 1 < n else 0
        here, there = px[m] * dx + py[m] * dy - limit, px[o] * dx + py[o] * dy - limit
        if here <= 0.0:
            qx[count], qy[count] = px[m], py[m]
            count += 1
        if here < 0.0 < there or there < 0.0 < here:
            t = here / (here - there)
            qx[count], qy[count] = px[m] + t * (px[o] - px[m]), py[m] + t * (py[o] - py[m])
            count += 1
        if count > len(qx) - 2:  # the next corner may add two
            return 0
    for m in range(count):
        px[m], py[m] = qx[m], qy[m]
    return count
