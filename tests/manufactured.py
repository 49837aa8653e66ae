"""A manufactured Poisson problem on lattice or jittered particles, with known values around it."""

import numpy as np
from mpi4py import MPI

from parisph.base.fields import INNER, SURFACE
from parisph.kernels.cells import neighbour_lists
from parisph.pressure.solver import PressureSolver
from tests.made_rows import cloud_of, parts_of, rows_of_method


def disordered(spacing, jitter, margin, seed, dim=2):
    """Return particles (n, dim) of the unit square or cube with a margin around it, and which lie inside.

    The lattice is moved by jitter s (Rn - 1/2) in each direction (Zheng, Ma & Duan 2014, Sec. 2.2).
    """
    cells = round(1.0 / spacing)
    line = np.arange(-margin, cells + margin + 1)
    index = np.stack(np.meshgrid(*[line] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
    x = spacing * (index + jitter * (np.random.default_rng(seed).random(index.shape) - 0.5))
    return x, np.all((index > 0) & (index < cells), axis=1)


def wave(x):
    """Return cos(4 pi x + 8 pi y), the function of the paper, and its Laplacian."""
    f = np.cos(4.0 * np.pi * x[:, 0] + 8.0 * np.pi * x[:, 1])
    return f, -80.0 * np.pi**2 * f


def smooth(x):
    """Return sin(x + 2 y [+ 3 z]), and its Laplacian: a function that the particles resolve well."""
    k = np.arange(1.0, x.shape[1] + 1.0)
    f = np.sin(x @ k)
    return f, -(k @ k) * f


def poisson_error(method, spacing, jitter, field=wave, seed=1, dim=2):
    """Solve lap p = lap f in the unit square or cube, p = f on the particles around it.

    Returns the relative error |p - f| / |f| inside, and the error of the discrete
    Laplacian of f itself, relative to that of the largest Laplacian (both rms).
    """
    reach = parts_of(method).reach
    x, inner = disordered(spacing, jitter, int(np.ceil(reach)) + 1, seed, dim)
    n = len(x)
    role = np.where(inner, INNER, SURFACE).astype(np.int8)
    indptr, indices = neighbour_lists(x, n, reach * spacing)
    rows = rows_of_method(method, dim)
    rows.fill(np.zeros_like(x), cloud_of(x, role, spacing, indptr, indices))
    f, laplacian = field(x)
    right = np.where(inner, rows.right_hand_side(laplacian), 0.0) + known_part(rows, n, np.where(inner, 0.0, f))
    right[~inner] = 0.0  # the solver's p is zero there; f has gone to the other side
    *matrix, _ = rows.csr(role, np.arange(n, dtype=np.int32))
    solver = PressureSolver(MPI.COMM_SELF, rtol=1e-9)
    p, _ = solver.solve(*matrix, right, None)
    solver.destroy()
    found = (f - known_part(rows, n, f))[inner] / -rows.rows.measure[:n][inner]
    truncation = np.sqrt(np.mean((found - laplacian[inner]) ** 2)) / np.abs(laplacian).max()
    return np.linalg.norm((p - f)[inner]) / np.linalg.norm(f[inner]), truncation


def known_part(rows, n, f):
    """Return sum_J values_J f_J for each row, (n,)."""
    count = rows.rows.count[:n]
    entry = np.repeat(rows.cloud.indptr[:-1] - np.concatenate([[0], np.cumsum(count)[:-1]]),
                      count) + np.arange(count.sum())
    return np.bincount(np.repeat(np.arange(n), count), rows.rows.values[entry] * f[rows.rows.columns[entry]],
                       minlength=n)


def orders(spacings, errors):
    """Return the observed orders between successive spacings."""
    spacings, errors = np.log(spacings), np.log(errors)
    return np.diff(errors) / np.diff(spacings)
