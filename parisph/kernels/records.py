"""Arguments that most kernels share: the particles with their neighbours, and the walls near them.

A kernel is `f(out, cloud, walls, field, numbers)`. Records are named tuples of arrays, which cost numba nothing;
`cloud._replace(kind=...)` makes one with another array.
"""

from typing import NamedTuple

import numpy as np

from parisph.kernels.jit import axes_of


class Cloud(NamedTuple):
    """The particles of a rank, ghosts included, and the CSR neighbour lists of the owned ones.

    x, normal : (n_all, dim), position [m] and, of wall particles, unit normal into the fluid
    kind, role, corner : (n_all,) int8; volume : (n_all,) [m^dim]
    indptr : (n_owned + 1,) int32; indices : (nnz,) int32
    spacing : [m]; axes : of kernels.jit.axes_of
    """

    x: np.ndarray
    kind: np.ndarray
    role: np.ndarray
    normal: np.ndarray
    corner: np.ndarray
    volume: np.ndarray
    indptr: np.ndarray
    indices: np.ndarray
    spacing: float
    axes: tuple[int, ...]


class Shapes(NamedTuple):
    """What lines of sight need of the elements besides their corners.

    middle : (M, dim), centroids [m]; size : (M,), greatest distance of a corner from it [m]
    plane : (M, dim + 1), unit normal, and its product with a corner [m]
    number : (M,) of the plane, the same for elements in one plane (`plane_numbers`)
    """

    middle: np.ndarray
    size: np.ndarray
    plane: np.ndarray
    number: np.ndarray


class Walls(NamedTuple):
    """The wall elements near the particles of a rank, and CSR lists of those that each owned particle sees.

    corners : (M, dim, dim) [m]; fluid is on the left of the line from the first to the second corner, in 3D on the side
        from which the corners are anticlockwise
    velocity : (M, dim) [m/s]; sticks : (M,) bool, no-slip elements
    present : (M,), the part of each element that counts, 0 to 1
    indptr : (n_owned + 1,) int32; indices : (nnz,) int32
    shapes : Shapes
    """

    corners: np.ndarray
    velocity: np.ndarray
    present: np.ndarray
    sticks: np.ndarray
    indptr: np.ndarray
    indices: np.ndarray
    shapes: Shapes


class Rows(NamedTuple):
    """Buffers of matrix rows: row_I(p) = p_I - sum_J values_J p_J, with row_I(p) = -measure_I target_I.

    The target is the Laplacian at inner particles, and the normal derivative at walls. Row I starts at indptr[I] of the
    neighbour lists.

    count : (n,) int32, entries of each row besides its diagonal; columns : (nnz,) int32, local; values : (nnz,)
    measure : (n,) [m^2], at walls [m]; 0 for a row without a Laplacian or derivative
    """

    count: np.ndarray    # type: ignore[assignment] # instead of the method of tuples
    columns: np.ndarray
    values: np.ndarray
    measure: np.ndarray


class DivergenceRows(NamedTuple):
    """Buffers of the stencils of a divergence at inner particles: div u_I = sum_J flux_J . (u_J - u_I).

    Stencil I starts at indptr[I] of the neighbour lists.

    count : (n,) int32; columns : (nnz,) int32, those of the rows if the same kernel fills both
    flux : (nnz, dim) [1/m]; div : (n,) [1/s], of the velocity at filling
    """

    count: np.ndarray    # type: ignore[assignment] # instead of the method of tuples
    columns: np.ndarray
    flux: np.ndarray
    div: np.ndarray


def no_walls(n_owned: int, dim: int) -> Walls:
    """Return the Walls of `n_owned` particles without elements."""
    none = np.zeros(0, np.int32)
    return Walls(np.empty((0, dim, dim)), np.empty((0, dim)), np.empty(0), np.empty(0, np.bool_),
                 np.zeros(n_owned + 1, np.int32), none,
                 Shapes(np.empty((0, dim)), np.empty(0), np.empty((0, dim + 1)), np.zeros(0, np.int64)))


def cloud_of(x: np.ndarray, kind: np.ndarray, role: np.ndarray, normal: np.ndarray, indptr: np.ndarray,
             indices: np.ndarray, spacing: float) -> Cloud:
    """Return the Cloud of particles that are in no corner and have the volume of a cell."""
    n, dim = x.shape
    return Cloud(x, kind, role, normal, np.zeros(n, np.int8), np.full(n, spacing**dim), indptr, indices, spacing,
                 axes_of(dim))
