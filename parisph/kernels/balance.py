"""Hydrostatic corrections of pressure rows, and right-hand sides of walls and of particles without an equation."""

import numpy as np

from parisph.base.fields import INNER, WET
from parisph.kernels.jit import kernel
from parisph.kernels.records import Cloud, Rows

ROUNDING = 1e-9    # smallest sum, relative to the size of its terms, that is not rounding error


@kernel
def add_linear_part(target: np.ndarray, rows: Rows, cloud: Cloud, force: np.ndarray, density: float) -> None:
    """Add a row's Laplacian of rho f_I . (x - x_I), which should be zero, to the target of inner particles.

    The row then approximates lap (p - rho f_I . x), so water at rest is a solution on any particles.

    target : (n_owned,) [Pa/m^2]; force : (n_all, dim) per unit mass [m/s^2]; density [kg/m^3]
    """
    count, columns, values, measure = rows
    x, role, indptr, axes = cloud.x, cloud.role, cloud.indptr, cloud.axes
    for i in range(len(indptr) - 1):
        if role[i] != INNER or measure[i] == 0.0:
            continue
        total = 0.0
        for k in range(indptr[i], indptr[i] + count[i]):
            for a in range(len(axes)):
                total += values[k] * force[i, a] * (x[columns[k], a] - x[i, a])
        target[i] += density * total / measure[i]


@kernel
def add_linear_part_at_walls(right: np.ndarray, rows: Rows, cloud: Cloud, pull: np.ndarray, density: float) -> None:
    """Subtract the error of wet wall rows for rho a_I . (x - x_I) from the right-hand side.

    A row that is a mean of its neighbours, or mixed with one, then becomes exact for the pressure of water that moves
    with the wall. Exact rows stay unchanged to the bit.

    right : (n_owned,) [Pa]; density [kg/m^3]
    pull : (n_owned, dim), a = force on the fluid minus acceleration of the wall [m/s^2]
    """
    count, columns, values, measure = rows
    x, role, normal, indptr, dim = cloud.x, cloud.role, cloud.normal, cloud.indptr, len(cloud.axes)
    for i in range(len(indptr) - 1):
        if role[i] != WET:
            continue
        total, size = 0.0, 0.0
        for a in range(dim):
            lean, terms = -measure[i] * normal[i, a], abs(measure[i] * normal[i, a])
            for k in range(indptr[i], indptr[i] + count[i]):
                term = values[k] * (x[columns[k], a] - x[i, a])
                lean += term
                terms += abs(term)
            total += lean * pull[i, a]
            size += terms * abs(pull[i, a])
        if abs(total) > ROUNDING * size:
            right[i] -= density * total


@kernel
def wall_targets(target: np.ndarray, cloud: Cloud, force: np.ndarray, moved: np.ndarray, density: float) -> None:
    """Write rho (n . force - a) to the targets of wet wall particles, Eq. 25 (2014 paper).

    target : (n_owned,) [Pa/m], changed; force : (n_all, dim) per unit mass [m/s^2]; density [kg/m^3]
    moved : (n_owned,), a, the normal acceleration of fluid that slides along the wall [m/s^2]; (0,) if no wall moves
    """
    for i in range(len(target)):
        if cloud.role[i] == WET:
            across = 0.0
            for a in range(len(cloud.axes)):
                across += cloud.normal[i, a] * force[i, a]
            target[i] = density * (across - moved[i] if len(moved) > 0 else across)


@kernel
def without_equation(right: np.ndarray, role: np.ndarray) -> None:
    """Write 0 to the right-hand sides (n,) of particles that are neither inner nor wet walls, so that p = 0 there."""
    for i in range(len(right)):
        if role[i] != INNER and role[i] != WET:
            right[i] = 0.0
