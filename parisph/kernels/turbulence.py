"""Eddy viscosity of Smagorinsky's turbulence model."""

import math

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels.jit import kernel, subkernel


@kernel
def eddy_viscosity(nu_t: np.ndarray, g: np.ndarray, kind: np.ndarray, length: float, axes: tuple[int, ...]) -> None:
    """Write the eddy viscosity of Smagorinsky (1963), nu_t = length^2 sqrt(2 S : S), with S = (g + g^T)/2.

    Its length is C_s s: C_s = 0.1 to 0.2 in shear flows. There is no damping at walls.

    nu_t : (n_owned,) output [m^2/s], zero for walls
    g : (n_owned, dim, dim), g[i, a, b] = d u_a / d x_b [1/s] (kernels.strain.velocity_gradient)
    kind : (n_all,); length : [m]
    """
    for i in range(len(nu_t)):
        nu_t[i] = length * length * _strain_rate(g, i, axes) if kind[i] == FLUID else 0.0


@subkernel
def _strain_rate(g, i, axes):
    """Return sqrt(2 S : S)."""
    square = 0.0
    for a in range(len(axes)):
        for b in range(len(axes)):
            square += (0.5 * (g[i, a, b] + g[i, b, a])) ** 2
    return math.sqrt(2.0 * square)
