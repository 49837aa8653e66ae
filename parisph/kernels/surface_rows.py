"""Rows of surface particles: p = 0 on the free surface, which lies outside their centres."""

import math

import numpy as np

from parisph.base.fields import INNER, SURFACE, WET
from parisph.kernels.jit import inlined, kernel
from parisph.kernels.records import Cloud, Rows
from parisph.kernels.smoothing import quartic_weight

# Half a cell beside a wall, 3/2 spacings wide, is 3/4 of a cell. Where layers do not divide the depth, all parts are
# larger.
HALF = 0.81     # tuned 0.76 to 0.86: part of a cell up to which a particle lies on the surface; judged
FULL = 0.86     # tuned 0.81 to 0.99: part of a cell above which a particle represents a full one; judged
# in spacings
THIN = 0.3      # tuned 0.15 to 0.6: least distance of the last two layers; judged
THICK = 1.5     # tuned 1 to 3: largest distance of the last two layers; judged
# coefficients of a parabola for this distance, fitted on lattices (`_layer`)
FIRST, SECOND = 1.05, 2.3
FIRST_3D, SECOND_3D = 0.9, 2.2    # the same in 3D
LEAST = 0.5     # tuned 0.25 to 1: least mean depth of the neighbours in spacings, about one if orderly; judged


@kernel
def surface_rows(rows: Rows, cloud: Cloud, cells: np.ndarray, offset: float, radius: float) -> None:
    """Fill the rows of surface particles: pressure falls in proportion to the distance to zero on the surface.

    With the surface at the distance a outside the particle and the weighted mean of its inner neighbours at the depth
    d, p_I = a/(a + d) sum_J w_J p_J/sum_J w_J. Full cells end half a layer outside the centres: with p = 0 at the
    centres, a drop is too small by half a spacing all around, and a jet of two particles has no pressure. Layers of a
    stretching flow come closer together, so a is in proportion to their distance. A particle that represents half a
    cell lies on the surface, as at the start of a tank: its row stays p = 0. With a fixed a of half a spacing, falling
    columns five to twelve particles wide gain up to 2 % of their energy; with this rule, .01 %.

    cells : (n_all,), part of its cell that a particle represents
    offset : distance of a full cell's particle to the surface where layers are one spacing apart [m]
    radius : of the neighbours that count [m]
    """
    count, columns, values, _ = rows
    x, role, indptr, spacing, dim = cloud.x, cloud.role, cloud.indptr, cloud.spacing, len(cloud.axes)
    mean = np.empty(dim)
    for i in range(len(indptr) - 1):
        if role[i] != SURFACE:
            continue
        count[i] = 0
        outside = offset * _filled(i, cells)
        if outside == 0.0:
            continue
        n, total, first = 0, 0.0, indptr[i]
        mean[:] = 0.0
        for k in range(first, indptr[i + 1]):
            j = cloud.indices[k]
            if role[j] != INNER and role[j] != WET:
                continue
            w = quartic_weight(_square(i, j, cloud), radius * radius)
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
        depth = math.sqrt(depth)
        outside *= _layer(depth / spacing, cloud.axes)
        depth = max(depth, LEAST * spacing)
        for k in range(first, first + n):
            values[k] *= outside / ((outside + depth) * total)
        count[i] = n


@inlined
def _filled(i, cells):
    """Return the part of the outer half of its cell that a particle fills, 0 to 1.

    It depends on the constant volume alone. With a rule that asked for walls beside the particle, p = 0 would move
    suddenly when the particle meets or leaves a wall.
    """
    return min(max((cells[i] - HALF) / (FULL - HALF), 0.0), 1.0)


@inlined
def _layer(depth, axes):
    """Return the distance of the last two layers, in spacings, from the mean depth of the inner neighbours.

    Exact within 0.03 on the lattice and on compressed ones, that widen in one direction or in both. Where layers are
    more than a spacing apart, only the next one is within the radius.
    """
    missing = max(1.0 - depth, 0.0)
    first, second = (FIRST, SECOND) if len(axes) == 2 else (FIRST_3D, SECOND_3D)
    return min(max(max(depth, 1.0) - missing * (first + second * missing), THIN), THICK)


@inlined
def _square(i, j, cloud):
    r2 = 0.0
    for a in range(len(cloud.axes)):
        r2 += (cloud.x[j, a] - cloud.x[i, a]) ** 2
    return r2
