"""Pressure systems for the tests of the solver: nonsymmetric rows on jittered particles.

The unit square, fluid particles on a jittered lattice, one layer of wall particles on the
boundary lines. Fluid rows: mean over a circle of the linear moving-least-squares
interpolant minus the centre, divided by its second moment (about 21 entries). Wall rows:
normal derivative by weighted least squares, diagonal -1 (as in a projection step).
"""

import gc
import os
from contextlib import contextmanager

import numpy as np
import pytest
from numba import njit

from parisph.pressure.solver import PressureSolver


def failing(*prefixes):
    """Return the options by which attempts fail: "" for the first one, "gamg_" and so on for later ones."""
    return [word for prefix in prefixes for word in (f"-pressure_{prefix}ksp_max_it", "1")]


# The options by which all attempts fail before the one that is expected.
chain = pytest.mark.parametrize("words, expected", [
    (failing(""), "gamg"), (failing("", "gamg_"), "asm"), (failing("", "gamg_", "asm_"), "lu")])
needs_proc = pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="memory is read from /proc")


def resident():
    """Return the memory of this process [kB]; not its peak, which earlier tests may have set."""
    gc.collect()
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") // 1024


@contextmanager
def solvers(comm):
    """Return a function (*options, **settings) that makes solvers, which are destroyed at the end. Collective."""
    made = []

    def new(*options, **settings):
        made.append(PressureSolver(comm, list(options), **settings))
        return made[-1]

    yield new
    for solver in made:
        solver.destroy()


@njit(cache=True)
def _fill(x, wall, normal, fixed, cell_of, start, members, cells, h, s):
    n = x.shape[0]
    indptr = np.zeros(n + 1, np.int32)
    indices = np.empty(60 * n, np.int32)
    values = np.empty(60 * n)
    near = np.empty(200, np.int32)
    row = np.empty(200)
    count = 0
    for i in range(n):
        m = 0
        ci, cj = cell_of[i] // cells, cell_of[i] % cells
        reach = 2.6 * s if wall[i] else 2.1 * s + 0.5 * s
        for a in range(max(ci - 1, 0), min(ci + 2, cells)):
            for b in range(max(cj - 1, 0), min(cj + 2, cells)):
                for k in range(start[a * cells + b], start[a * cells + b + 1]):
                    j = members[k]
                    if np.hypot(x[j, 0] - x[i, 0], x[j, 1] - x[i, 1]) < reach:
                        near[m] = j
                        m += 1
        row[:m] = 0.0
        if fixed[i]:
            for k in range(m):
                row[k] = 1.0 if near[k] == i else 0.0
        elif wall[i]:
            _wall_row(x, normal, i, near, m, row, reach, s)
        else:
            _circle_row(x, i, near, m, row, 2.1 * s, 0.5 * s, s)
        for k in range(m):
            if row[k] != 0.0:
                indices[count] = near[k]
                values[count] = row[k]
                count += 1
        indptr[i + 1] = count
    return indptr, indices[:count].copy(), values[:count].copy()


@njit(cache=True)
def _circle_row(x, i, near, m, row, h, radius, s):
    sectors = 8
    weight = np.empty(m)
    for k in range(sectors):
        angle = 2 * np.pi * k / sectors
        px, py = x[i, 0] + radius * np.cos(angle), x[i, 1] + radius * np.sin(angle)
        M = np.zeros((3, 3))
        for q in range(m):
            j = near[q]
            dx, dy = (x[j, 0] - px) / s, (x[j, 1] - py) / s
            weight[q] = max(0.0, 1.0 - (dx * dx + dy * dy) * (s / h) ** 2) ** 3
            e = (1.0, dx, dy)
            for a in range(3):
                for b in range(3):
                    M[a, b] += weight[q] * e[a] * e[b]
        c = np.array([M[1, 1] * M[2, 2] - M[1, 2] ** 2, M[1, 2] * M[0, 2] - M[0, 1] * M[2, 2],
                      M[0, 1] * M[1, 2] - M[1, 1] * M[0, 2]])
        c /= M[0, 0] * c[0] + M[0, 1] * c[1] + M[0, 2] * c[2]
        for q in range(m):
            j = near[q]
            dx, dy = (x[j, 0] - px) / s, (x[j, 1] - py) / s
            row[q] += weight[q] * (c[0] + c[1] * dx + c[2] * dy) / sectors
    second = 0.0
    for q in range(m):
        j = near[q]
        second += row[q] * ((x[j, 0] - x[i, 0]) ** 2 + (x[j, 1] - x[i, 1]) ** 2)
    total = 0.0
    for q in range(m):
        total += row[q]
    for q in range(m):
        if near[q] == i:
            row[q] -= total
        row[q] *= -4.0 * s * s / second          # minus s^2 times the Laplacian: positive diagonal


@njit(cache=True)
def _wall_row(x, normal, i, near, m, row, h, s):
    a = b = c = 0.0
    for q in range(m):
        dx, dy = x[near[q], 0] - x[i, 0], x[near[q], 1] - x[i, 1]
        r2 = dx * dx + dy * dy
        if r2 > 0.0:
            w = (1.0 - np.sqrt(r2) / h) ** 2 / r2
            a += w * dx * dx
            b += w * dx * dy
            c += w * dy * dy
    det = a * c - b * b
    total = 0.0
    for q in range(m):
        dx, dy = x[near[q], 0] - x[i, 0], x[near[q], 1] - x[i, 1]
        r2 = dx * dx + dy * dy
        if r2 > 0.0:
            w = (1.0 - np.sqrt(r2) / h) ** 2 / r2
            gx, gy = (c * dx - b * dy) * w / det, (a * dy - b * dx) * w / det
            row[q] = gx * normal[i, 0] + gy * normal[i, 1]
            total += row[q]
    for q in range(m):
        row[q] = -1.0 if near[q] == i else row[q] / total


def square(n, jitter=0.8, closed=False, seed=1, scatter=None):
    """Return (x, fixed, indptr, indices, values) of about n^2 particles in cell order.

    The top line is p = 0 unless `closed`; `scatter` [spacings] moves the fluid particles
    once more, at random, as a few time steps would (the order of the rows is kept).
    """
    s = 1.0 / n
    rng = np.random.default_rng(seed)
    line = np.arange(n + 1) * s
    gx, gy = np.meshgrid(line, line, indexing="ij")
    x = np.column_stack([gx.ravel(), gy.ravel()])
    normal = np.zeros_like(x)
    normal[:, 0] = (x[:, 0] < s / 2) * 1.0 - (x[:, 0] > 1 - s / 2)
    normal[:, 1] = (x[:, 1] < s / 2) * 1.0 - (x[:, 1] > 1 - s / 2)
    wall = np.any(normal != 0.0, axis=1)
    normal[wall] /= np.linalg.norm(normal[wall], axis=1)[:, None]
    fixed = (x[:, 1] > 1 - s / 2) & (not closed)
    x[~wall] += s * jitter * (rng.random((np.count_nonzero(~wall), 2)) - 0.5)
    order = np.lexsort((_snake(x, 4 * s), np.floor(x[:, 0] / (4 * s))))
    x, normal, wall, fixed = x[order], normal[order], wall[order], fixed[order]
    if scatter:
        x[~wall] += s * scatter * (rng.random((np.count_nonzero(~wall), 2)) - 0.5)
    return (x, fixed, *_assemble(x, wall, normal, fixed, s))


def _snake(x, strip):
    odd = np.floor(x[:, 0] / strip).astype(int) % 2
    return np.where(odd == 1, -x[:, 1], x[:, 1])


def _assemble(x, wall, normal, fixed, s):
    h = 2.7 * s
    cells = int(np.floor(1.0 / h)) + 1
    cell = np.minimum((x / h).astype(np.int64).clip(0), cells - 1)
    cell_of = cell[:, 0] * cells + cell[:, 1]
    members = np.argsort(cell_of, kind="stable")
    start = np.searchsorted(cell_of[members], np.arange(cells * cells + 1))
    return _fill(x, wall, normal, fixed, cell_of, start, members, cells, h, s)


def share(comm, system, owners=None):
    """Return this rank's rows (first, last, indptr, indices, values) of a system known to all.

    `owners` : number of ranks that get rows (the last ones); all by default.
    """
    indptr, indices, values = system
    n = indptr.size - 1
    owners = owners or comm.size
    place = comm.rank - (comm.size - owners)
    first, last = (n * place // owners, n * (place + 1) // owners) if place >= 0 else (0, 0)
    part = slice(indptr[first], indptr[last])
    return first, last, indptr[first:last + 1] - indptr[first], indices[part], values[part]


def product(system, p):
    """Return A p for a CSR system (numpy only, independent of the code under test)."""
    indptr, indices, values = system
    return np.add.reduceat(values * p[indices], indptr[:-1])
