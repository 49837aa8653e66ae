"""Rows of surface particles: p = 0 on the free surface, which lies outside their centres."""

import math

import numpy as np

from parisph.base.fields import INNER, SURFACE, WALL, WET
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.smoothing import quartic_weight

BESIDE = 1.2    # spacings from a wall particle within which a particle also stands for the half spacing to the wall
# of a cell, up to which a particle lies on the surface: a half, and what its share of the whole volume adds
HALF = 0.6
LEAST = 0.5     # spacings, of the mean depth of the neighbours: an orderly surface has about one


@kernel
def surface_rows(count: np.ndarray, columns: np.ndarray, values: np.ndarray, x: np.ndarray, kind: np.ndarray,
                 role: np.ndarray, volume: np.ndarray, offset: float, spacing: float, radius: float, indptr: np.ndarray,
                 indices: np.ndarray, axes: tuple[int, ...]) -> None:
    """Fill the rows of surface particles: pressure falls in proportion to the distance to zero on the surface.

    With the surface at the distance a outside the particle and the weighted mean of its inner neighbours
    at the depth d, p_I = a/(a + d) sum_J w_J p_J/sum_J w_J. Where each particle stands for a full cell, the
    surface of the fluid is half a spacing outside the centres of the last ones: with p = 0 at the centres, a
    drop is by half a spacing too small all around, and a jet of two particles has no pressure at all. A
    particle that stands for half a cell lies on the surface, as at the start of a tank: its row stays p = 0.

    count, columns, values : rows of PressureRows, those of surface particles are written
    x, kind, role : (n_all, ...); volume : (n_all,) [m^dim]
    offset : distance to the surface of a particle with a full cell [m]
    radius : of the neighbours that count [m]
    """
    dim = len(axes)
    mean = np.empty(dim)
    for i in range(len(indptr) - 1):
        if role[i] != SURFACE:
            continue
        count[i] = 0
        outside = offset * _filled(i, x, kind, volume, spacing, indptr, indices, axes)
        if outside == 0.0:
            continue
        n, total, first = 0, 0.0, indptr[i]
        mean[:] = 0.0
        for k in range(first, indptr[i + 1]):
            j = indices[k]
            if role[j] != INNER and role[j] != WET:
                continue
            w = quartic_weight(_square(i, j, x, axes), radius * radius)
            if w == 0.0:
                continue
            for a in range(dim):
                mean[a] += w * (x[j, a] - x[i, a])
            columns[first + n] = j
            values[first + n] = w
            total += w
            n += 1
        if n == 0:
            continue
        depth = 0.0
        for a in range(dim):
            depth += (mean[a] / total) ** 2
        depth = max(math.sqrt(depth), LEAST * spacing)
        for k in range(first, first + n):
            values[k] *= outside / ((outside + depth) * total)
        count[i] = n


@inlined
def _filled(i, x, kind, volume, spacing, indptr, indices, axes):
    """Return how much of the outer part of its cell a particle fills, 0 to 1."""
    share = volume[i] / spacing ** len(axes)
    for k in range(indptr[i], indptr[i + 1]):
        if kind[indices[k]] == WALL and _square(i, indices[k], x, axes) < (BESIDE * spacing) ** 2:
            share /= 1.5
            break
    return min(max((share - HALF) / (1.0 - HALF), 0.0), 1.0)


@inlined
def _square(i, j, x, axes):
    r2 = 0.0
    for a in range(len(axes)):
        r2 += (x[j, a] - x[i, a]) ** 2
    return r2
