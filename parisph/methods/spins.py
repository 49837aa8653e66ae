"""Angular velocities and vorticities: one component in 2D, vectors of three in 3D."""

import numpy as np

from parisph.base.arrays import Floats

NEXT = ((0, 1, 2), (1, 2, 0), (2, 0, 1))    # (axis, the next one, the one after)


def add_cross(out: Floats, spin: Floats, vectors: Floats, factor: float) -> None:
    """Add factor * spin x vectors to out (n, dim).

    spin : in 2D () or (n,), anticlockwise; in 3D (3,) or (n, 3); vectors : (n, dim)
    """
    spin = factor * np.asarray(spin)    # numpy is slow along a short last axis
    if out.shape[1] == 2:
        out[:, 0] -= spin * vectors[:, 1]
        out[:, 1] += spin * vectors[:, 0]
        return
    for a, b, c in NEXT:
        out[:, a] += spin[..., b] * vectors[:, c] - spin[..., c] * vectors[:, b]


def centrifugal(spin: Floats, x: Floats) -> Floats:
    """Return -spin x (spin x x), (n, 3). spin : (3,) or (n, 3) [1/s]; x : (n, 3) [m]"""
    velocity, found = np.zeros_like(x), np.zeros_like(x)
    add_cross(velocity, spin, x, 1.0)
    add_cross(found, spin, velocity, -1.0)
    return found


def squared(spin: Floats, dim: int) -> Floats:
    """Return the square of angular velocities or vorticities, () or (n,) of dim 2, (3,) or (n, 3) of dim 3."""
    found: Floats = np.einsum("...a,...a->...", spin, spin) if dim == 3 else np.asarray(spin**2)
    return found


def gradient_of(spin: Floats, dim: int) -> Floats:
    """Return the gradient (dim, dim) of the velocity spin x x, by component and direction. spin : () or (3,)"""
    columns = np.zeros((dim, dim))    # row b: spin x (unit vector b)
    add_cross(columns, spin, np.eye(dim), 1.0)
    return columns.T
