"""Wall rows: the normal derivative of pressure at wall particles."""

import numpy as np

from parisph.base.fields import WET
from parisph.kernels import harmonic
from parisph.kernels.jit import kernel, subkernel
from parisph.kernels.moments import invert, pair_weight, second_moment
from parisph.kernels.rankine import UNSOUND
from parisph.kernels.records import Cloud, Rows
from parisph.kernels.roles import outside

FLAT = 4.0e-3     # tuned 0.002 to 0.008: det/(trace/dim)^dim below which wall neighbours lie on a line; judged
# With a smaller diagonal, hardly any neighbour lies inwards.
INWARDS = 0.05    # tuned 0.025 to 0.1: least diagonal of a wall row, times the radius; judged


@kernel
def sfdi_rows(rows: Rows, cloud: Cloud, radius: float) -> None:
    """Fill the rows of wet wall particles by SFDI (Zheng et al. 2014, Eq. 26b; Eq. A6 corrected).

    n . grad p = sum_J Psi_IJ (p_J - p_I), that is Psi_II = -sum_J Psi_IJ, which the printed Eq. A6 omits. The measure
    is 1/sum_J Psi_IJ [m]. A row with too few neighbours for a normal derivative becomes their weighted mean, with
    measure 0. A row that extrapolates from neighbours on one side is mixed with the mean until no value is below
    -UNSOUND: where a cavity closed in a corner above all water, such a row had values of 11 and -6, and pressure
    reached -2.7 MPa. Means and mixtures need balance.add_linear_part_at_walls.
    """
    columns, values, x = rows.columns, rows.values, cloud.x
    normal, indptr, indices, axes = cloud.normal, cloud.indptr, cloud.indices, cloud.axes
    dim, radius2 = len(axes), radius * radius
    m, inverse = np.empty((dim, dim)), np.empty((dim, dim))
    for i in range(len(indptr) - 1):
        if cloud.role[i] != WET:
            continue
        second_moment(m, i, cloud, radius2, 2)
        sound = invert(m, inverse, axes) > FLAT
        n, total, weights, first = 0, 0.0, 0.0, indptr[i]
        for k in range(first, indptr[i + 1]):
            j = indices[k]
            if outside(cloud.role[j]):
                continue
            w, _ = pair_weight(i, j, x, radius2, 2, axes)
            if w == 0.0:
                continue
            psi = 0.0
            if sound:
                for a in range(dim):
                    for b in range(dim):
                        psi += normal[i, a] * inverse[a, b] * w * (x[j, b] - x[i, b]) / radius2
            columns[first + n] = j
            values[first + n] = psi
            total += psi
            weights += w
            n += 1
        rows.count[i] = n
        if sound and total * radius > INWARDS:
            for k in range(first, first + n):
                values[k] /= total
            rows.measure[i] = _mix_with_mean(rows, i, n, cloud, radius2, weights) / total
        else:
            rows.measure[i] = 0.0
            _take_mean(rows, i, n, cloud, radius2, weights)


@subkernel
def _mix_with_mean(rows, i, n, cloud, radius2, weights):
    """Mix a row with the weighted mean until no value is below -UNSOUND; return the part of the row."""
    share, values, first = 1.0, rows.values, cloud.indptr[i]
    for k in range(first, first + n):
        if values[k] < -UNSOUND:
            w, _ = pair_weight(i, rows.columns[k], cloud.x, radius2, 2, cloud.axes)
            share = min(share, (UNSOUND + w / weights) / (w / weights - values[k]))
    if share < 1.0:
        for k in range(first, first + n):
            w, _ = pair_weight(i, rows.columns[k], cloud.x, radius2, 2, cloud.axes)
            values[k] = share * values[k] + (1.0 - share) * w / weights
    return share


@subkernel
def _take_mean(rows, i, n, cloud, radius2, weights):
    """Replace a row by the weighted mean of its neighbours."""
    for k in range(cloud.indptr[i], cloud.indptr[i] + n):
        w, _ = pair_weight(i, rows.columns[k], cloud.x, radius2, 2, cloud.axes)
        rows.values[k] = w / weights


@kernel
def harmonic_rows(rows: Rows, cloud: Cloud, radius: float, most: float) -> None:
    """Replace SFDI wall rows by n . (harmonic stencil) where the neighbours allow values above -UNSOUND.

    most : largest ratio of the variances of a slope with and without terms of degree 2 (harmonic.coefficients)
    """
    count, columns, values, measure = rows
    normal, indptr, indices, dim = cloud.normal, cloud.indptr, cloud.indices, len(cloud.axes)
    c, work, b = harmonic.scratch(indptr, cloud.axes)
    for i in range(len(indptr) - 1):
        if cloud.role[i] != WET or not harmonic.coefficients(c, i, cloud, radius, most, work, b):
            continue
        total, lowest = 0.0, 0.0
        for k in range(indptr[i + 1] - indptr[i]):
            psi = 0.0
            for a in range(dim):
                psi += normal[i, a] * c[k, a]
            c[k, 0] = psi
            total += psi
            lowest = min(lowest, psi)
        if not (total * radius > INWARDS and lowest > -UNSOUND * total):
            continue
        n, first = 0, indptr[i]
        for k in range(first, indptr[i + 1]):
            if c[k - first, 0] != 0.0:
                columns[first + n] = indices[k]
                values[first + n] = c[k - first, 0] / total
                n += 1
        count[i] = n
        measure[i] = 1.0 / total
