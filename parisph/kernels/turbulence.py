"""The sub-particle stress of turbulence by Smagorinsky's model."""

import math

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels.jit import kernel, subkernel


@kernel
def eddy_viscosity(nu_t: np.ndarray, g: np.ndarray, kind: np.ndarray, length: float, axes: tuple[int, ...]) -> None:
    """Eddy viscosity of Smagorinsky (1963), nu_t = length^2 sqrt(2 S : S), with S = (g + g^T)/2.

    Its length is C_s s: C_s = 0.1 to 0.2 in shear flows. Only the product with the mean rate of strain is modelled,
    without damping at walls.

    nu_t : (n_owned,) output [m^2/s], zero for walls
    g : (n_owned, dim, dim), g[i, a, b] = d u_a / d x_b [1/s] (kernels.strain.velocity_gradient)
    kind : (n_all,); length : [m]
    """
    for i in range(len(nu_t)):
        nu_t[i] = length * length * _strain_rate(g, i, axes) if kind[i] == FLUID else 0.0


@kernel
def stress(tau: np.ndarray, nu_t: np.ndarray, g: np.ndarray, kind: np.ndarray, length: float, isotropic: float,
           axes: tuple[int, ...]) -> None:
    """Kinematic sub-particle stress tau/rho of owned fluid (Dalrymple & Rogers 2006, Eqs. 8 to 10).

    tau_ab/rho = 2 nu_t S_ab - (2/3) nu_t tr(S) delta_ab - (2/3) isotropic length^2 (2 S : S) delta_ab

    The middle term, zero in incompressible flow, is kept. The last one stands for the energy of the eddies,
    k = isotropic length^2 (2 S : S). It acts as a pressure, and a projection solves for the sum of both: there
    isotropic = 0. Weakly compressible fluid takes C_I/C_s^2 with C_I = 0.0066.

    tau : (n_owned, dim, dim) output [m^2/s^2], zero for walls; nu_t : (n_owned,) [m^2/s]
    g, kind, length : as in `eddy_viscosity`
    """
    dim = len(axes)
    for i in range(len(nu_t)):
        tau[i] = 0.0
        if kind[i] != FLUID:
            continue
        trace = 0.0
        for a in range(dim):
            trace += g[i, a, a]
        rate = _strain_rate(g, i, axes)
        sphere = (nu_t[i] * trace + isotropic * (length * rate) ** 2) * 2.0 / 3.0
        for a in range(dim):
            for b in range(dim):
                tau[i, a, b] = nu_t[i] * (g[i, a, b] + g[i, b, a])
            tau[i, a, a] -= sphere


@subkernel
def _strain_rate(g, i, axes):
    """Return sqrt(2 S : S)."""
    square = 0.0
    for a in range(len(axes)):
        for b in range(len(axes)):
            square += (0.5 * (g[i, a, b] + g[i, b, a])) ** 2
    return math.sqrt(2.0 * square)
