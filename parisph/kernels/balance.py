"""Rows that are not exact for linear pressure, made exact for the pressure that balances the body force; right-hand
sides of walls, and of particles without an equation."""

import numpy as np

from parisph.base.fields import INNER, WET
from parisph.kernels.jit import kernel

ROUNDING = 1e-9    # of the terms of a sum: what is less is zero


@kernel
def add_linear_part(target: np.ndarray, force: np.ndarray, density: float, count: np.ndarray, columns: np.ndarray,
                    values: np.ndarray, measure: np.ndarray, x: np.ndarray, role: np.ndarray, indptr: np.ndarray,
                    axes: tuple[int, ...]) -> None:
    """Add the Laplacian that a row finds for rho f_I . (x - x_I), which has none, to the target of inner particles.

    The row then means lap (p - rho f_I . x): water at rest is a solution on any particles, whatever the row does
    to linear functions.

    target : (n_owned,) [Pa/m^2]; force : (n_all, dim) per unit mass [m/s^2]; others as of pressure.rows.Rows
    """
    for i in range(len(indptr) - 1):
        if role[i] != INNER or measure[i] == 0.0:
            continue
        total = 0.0
        for k in range(indptr[i], indptr[i] + count[i]):
            for a in range(len(axes)):
                total += values[k] * force[i, a] * (x[columns[k], a] - x[i, a])
        target[i] += density * total / measure[i]


@kernel
def add_linear_part_at_walls(right: np.ndarray, pull: np.ndarray, density: float, count: np.ndarray,
                             columns: np.ndarray, values: np.ndarray, measure: np.ndarray, x: np.ndarray,
                             role: np.ndarray, normal: np.ndarray, indptr: np.ndarray, axes: tuple[int, ...]) -> None:
    """Add what the rows of wet wall particles find for rho a_I . (x - x_I), less its normal derivative, to the right.

    A row that is no normal derivative, but a mean of its neighbours or a mixture with it, is then exact for the
    pressure of water that moves with the wall. Rows that are exact anyway stay as they are to the bit.

    right : (n_owned,) [Pa]; pull : (n_owned, dim), a = force on the fluid less acceleration of the wall [m/s^2]
    normal : (n_all, dim), into the fluid; others as of pressure.rows.Rows
    """
    dim = len(axes)
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
def wall_targets(target: np.ndarray, role: np.ndarray, normal: np.ndarray, force: np.ndarray, moved: np.ndarray,
                 density: float) -> None:
    """Write rho (n . force - a) to the targets of wet wall particles, Eq. 25 (2014 paper).

    target : (n,) [Pa/m], changed; role : (n,); normal : (n, dim); force : (n_all, dim) per unit mass [m/s^2]
    density : [kg/m^3]
    moved : (n,), a, acceleration across the wall of fluid that slides along it [m/s^2]; (0,) if no wall moves
    """
    for i in range(len(target)):
        if role[i] == WET:
            across = 0.0
            for a in range(normal.shape[1]):
                across += normal[i, a] * force[i, a]
            target[i] = density * (across - moved[i] if len(moved) > 0 else across)


@kernel
def without_equation(right: np.ndarray, role: np.ndarray) -> None:
    """Write 0 to the right-hand sides (n,) of particles that are neither inner nor wet walls: their p is 0."""
    for i in range(len(right)):
        if role[i] != INNER and role[i] != WET:
            right[i] = 0.0
