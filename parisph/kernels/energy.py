"""Energy of particles."""

import numpy as np

from parisph.kernels.jit import kernel


@kernel
def energy_sums(volume: np.ndarray, x: np.ndarray, u: np.ndarray, gravity: np.ndarray, datum: np.ndarray) -> np.ndarray:
    """Return the sums of kinetic and potential energy over density [m^(dim+2)/s^2] and of volume [m^dim]: (3,).

    The potential is zero at the datum. volume : (n,) [m^dim]; x, u : (n, dim) [m], [m/s]; gravity, datum : (dim,)
    """
    found = np.zeros(3)
    for i in range(len(volume)):
        square, fall = 0.0, 0.0
        for a in range(len(gravity)):
            square += u[i, a] * u[i, a]
            fall += gravity[a] * (datum[a] - x[i, a])
        found[0] += 0.5 * volume[i] * square
        found[1] += volume[i] * fall
        found[2] += volume[i]
    return found
