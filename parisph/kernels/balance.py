"""Rows that are not exact for linear pressure, made exact for the pressure that balances the body force."""

import numpy as np

from parisph.base.fields import INNER
from parisph.kernels.jit import kernel


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
