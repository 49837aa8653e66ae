"""SPH pressure rows."""

import math

from parisph.base.fields import INNER
from parisph.kernels.jit import kernel
from parisph.kernels.records import Cloud, Rows
from parisph.kernels.roles import outside
from parisph.kernels.smoothing import cubic_spline_slope


@kernel
def isph_rows(rows: Rows, cloud: Cloud, h: float, volume: float) -> None:
    """Fill the rows of inner particles with the SPH Laplacian (Zheng, Ma & Duan 2014, Eq. 20a).

    lap p_i = sum_j 2 V (r_ij . grad W_ij)/(r_ij^2 + delta^2) (p_i - p_j), delta = 0.1 h. A row without neighbours
    within the kernel's support is empty, with measure 0.

    h : smoothing length of the cubic spline [m]; volume : of a particle, at equal sizes [m^dim]
    """
    count, columns, values, measure = rows
    x, role, indptr, indices, dim = cloud.x, cloud.role, cloud.indptr, cloud.indices, len(cloud.axes)
    delta2 = (0.1 * h) ** 2
    for i in range(len(indptr) - 1):
        if role[i] != INNER:
            continue
        n, total, first = 0, 0.0, indptr[i]
        for k in range(first, indptr[i + 1]):
            j = indices[k]
            if outside(role[j]):
                continue
            r2 = 0.0
            for a in range(dim):
                r2 += (x[j, a] - x[i, a]) ** 2
            c = -2.0 * volume * cubic_spline_slope(math.sqrt(r2), h, dim) * r2 / (r2 + delta2)
            columns[first + n] = j
            values[first + n] = max(c, 0.0)
            total += values[first + n]
            n += 1
        # all listed neighbours may be outside the support, or coincident
        count[i] = n if total > 0.0 else 0
        measure[i] = 1.0 / total if total > 0.0 else 0.0
        for k in range(first, first + count[i]):
            values[k] /= total
