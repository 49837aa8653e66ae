"""Moving least squares at the points of a circle or sphere around a particle."""

from typing import NamedTuple

import numpy as np

from parisph.kernels.jit import inlined
from parisph.kernels.mls import linear_fit
from parisph.kernels.smoothing import quartic_weight


class Circle(NamedTuple):
    """A circle or sphere on which a field is interpolated by moving least squares.

    unit : (K, dim), its points as unit vectors (rankine.directions); size : its radius R [m]
    radius : of the weight of the moving least squares [m]
    """

    unit: np.ndarray
    size: float
    radius: float


@inlined
def fill_basis(basis: np.ndarray, m: int, axes: tuple[int, ...]) -> None:
    """Append the polynomials of degree 2 to those of degree 1: the harmonic ones, then r^2."""
    if len(axes) == 2:
        for k in range(m):
            x, y = basis[0, k], basis[1, k]
            basis[2, k], basis[3, k], basis[4, k] = x * x - y * y, x * y, x * x + y * y
        return
    for k in range(m):
        x, y, z = basis[0, k], basis[1, k], basis[2, k]
        basis[3, k], basis[4, k] = x * x - y * y, y * y - z * z
        basis[5, k], basis[6, k], basis[7, k] = x * y, x * z, y * z
        basis[8, k] = x * x + y * y + z * z


@inlined
def weigh(moments: np.ndarray, w: np.ndarray, basis: np.ndarray, at: np.ndarray, m: int, axes: tuple[int, ...]) -> None:
    """Write the weights of the neighbours at each point of the circle, and sum their moments.

    The particle in the centre counts without a column, because all its moments except the first are 0. Second moments
    follow from those of the harmonic polynomials and of r^2. The sums are scalars, which stay in registers.
    """
    dim = len(axes)
    for q in range(len(w)):
        px, py = at[0, q], at[1, q]
        sx, sy, sz, sd, se, sxy, sxz, syz, sr = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        s0 = quartic_weight(px * px + py * py + (at[2, q] ** 2 if dim == 3 else 0.0), 1.0)
        for k in range(m):
            r2 = (basis[0, k] - px) ** 2 + (basis[1, k] - py) ** 2
            if dim == 3:
                r2 += (basis[2, k] - at[2, q]) ** 2
            v = quartic_weight(r2, 1.0)
            w[q, k] = v
            s0 += v
            sx += v * basis[0, k]
            sy += v * basis[1, k]
            sd += v * basis[dim, k]
            sxy += v * basis[2 * dim - 1, k]
            sr += v * basis[len(basis) - 1, k]
            if dim == 3:
                sz += v * basis[2, k]
                se += v * basis[4, k]
                sxz += v * basis[6, k]
                syz += v * basis[7, k]
        moments[0, q], moments[1, q], moments[2, q] = s0, sx, sy
        if dim == 2:
            moments[3, q], moments[4, q], moments[5, q] = 0.5 * (sr + sd), sxy, 0.5 * (sr - sd)
        else:
            syy = (sr - sd + se) / 3.0
            moments[3, q], moments[7, q], moments[8, q], moments[9, q] = sz, sxz, syz, syy - se
            moments[4, q], moments[5, q], moments[6, q] = syy + sd, sxy, syy


@inlined
def sum_over_points(mean: np.ndarray, fit: np.ndarray, w: np.ndarray, basis: np.ndarray, unit: np.ndarray, m: int,
                    axes: tuple[int, ...]) -> None:
    """Sum the shape functions over the circle, unweighted and multiplied by each component of the normal."""
    dim = len(axes)
    for r in range(dim + 1):
        for k in range(m):
            mean[r, k] = 0.0
    for q in range(len(w)):
        for k in range(m):
            shape = fit[0, q] + fit[1, q] * basis[0, k] + fit[2, q] * basis[1, k]
            if dim == 3:
                shape += fit[3, q] * basis[2, k]
            shape *= w[q, k]
            mean[0, k] += shape
            mean[1, k] += shape * unit[q, 0]
            mean[2, k] += shape * unit[q, 1]
            if dim == 3:
                mean[3, k] += shape * unit[q, 2]


@inlined
def fit_around(fit: np.ndarray, moments: np.ndarray, w: np.ndarray, basis: np.ndarray, at: np.ndarray,
               centre: np.ndarray, m: int, axes: tuple[int, ...]) -> bool:
    """Write the weights and the linear fit of each point of the circle; return whether all fits are linear.

    Neighbours around a point may lie in a plane, as beside an edge without nodes. All points then have the weights of
    the centre. centre : (dim, points) zeros; other arguments as of `weigh` and mls.linear_fit
    """
    points = at.shape[1]
    for around in (at, centre):
        weigh(moments, w, basis, around, m, axes)
        spanned = linear_fit(fit, moments, at, points, axes) == points
        if spanned:
            return True
    return False
