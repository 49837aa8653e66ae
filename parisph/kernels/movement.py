"""Changes of fields of the fluid."""

import math

import numpy as np

from parisph.base.fields import FLUID
from parisph.kernels.jit import kernel


@kernel
def add_to_fluid(values: np.ndarray, change: np.ndarray, kind: np.ndarray) -> None:
    """Add a change (n, dim) to the values (n, dim) of fluid particles."""
    three = values.shape[1] == 3    # a loop takes twice as long
    for i in range(len(values)):
        if kind[i] == FLUID:
            values[i, 0] += change[i, 0]
            values[i, 1] += change[i, 1]
            if three:
                values[i, 2] += change[i, 2]


@kernel
def give_to_fluid(values: np.ndarray, new: np.ndarray, kind: np.ndarray) -> None:
    """Give new values (n, dim) to fluid particles."""
    three = values.shape[1] == 3
    for i in range(len(new)):
        if kind[i] == FLUID:
            values[i, 0] = new[i, 0]
            values[i, 1] = new[i, 1]
            if three:
                values[i, 2] = new[i, 2]


@kernel
def carry(u: np.ndarray, grad_u: np.ndarray, move: np.ndarray) -> None:
    """Add the change of velocities u (n, dim) over a move (n, dim) [m], by their gradient (n, dim, dim) [1/s]."""
    for i in range(len(move)):
        for a in range(move.shape[1]):
            for b in range(move.shape[1]):
                u[i, a] += grad_u[i, a, b] * move[i, b]


@kernel
def along(direction: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Return the component (n,) of vectors f (n, dim) along the directions (n, dim)."""
    out, three = np.empty(len(f)), f.shape[1] == 3
    for i in range(len(f)):
        out[i] = direction[i, 0] * f[i, 0] + direction[i, 1] * f[i, 1]
        if three:
            out[i] += direction[i, 2] * f[i, 2]
    return out


@kernel
def accelerate(u: np.ndarray, acceleration: np.ndarray, by_pressure: np.ndarray, grad: np.ndarray, force: np.ndarray,
               density: float, dt: float, kind: np.ndarray) -> None:
    """Add dt (f - grad/rho) to the velocities of fluid, and write the acceleration of all particles.

    u : (n, dim) [m/s], changed; acceleration : (n, dim), by_pressure : (n,), outputs, |grad|/rho [m/s^2]
    grad : (n, dim) [Pa/m]; force : (n_all, dim), per unit mass [m/s^2]; density [kg/m^3]; dt [s]; kind : (n,)
    """
    for i in range(len(u)):
        square, fluid = 0.0, kind[i] == FLUID
        for a in range(u.shape[1]):
            by = grad[i, a] / density
            square += by * by
            acceleration[i, a] = force[i, a] - by
            if fluid:
                u[i, a] += dt * acceleration[i, a]
        by_pressure[i] = math.sqrt(square)
