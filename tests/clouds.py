"""Clouds of points for tests, the same on every rank, and brute-force truths about them."""

import numpy as np
import pytest

from parisph.parallel.domain import Domain
from parisph.parallel.hilbert import key_of, machine
from parisph.parallel.particles import Particles

KINDS = ("lattice", "clusters", "corner")


def cloud(kind, dim, n=600, seed=3):
    """Return (n, dim) points in the unit square or cube: a jittered lattice, tight clusters, or one small corner."""
    random = np.random.default_rng(seed)
    if kind == "lattice":
        side = round(n ** (1.0 / dim))
        x = np.stack(np.meshgrid(*[(np.arange(side) + 0.5) / side] * dim), axis=-1).reshape(-1, dim)
        return x + random.uniform(-0.3, 0.3, x.shape) / side
    if kind == "clusters":
        centres = random.random((5, dim))
        x = centres[random.integers(0, 5, n)] + random.normal(0.0, 0.04, (n, dim))
        return np.concatenate([x, random.random((n // 10, dim))])
    return 0.02 * random.random((60, dim))


def keys_of_cells(cells, bits):
    """Return the places on the space-filling curve (n,) of cells (n, dim) of a grid of 2^bits a side."""
    tables = machine(cells.shape[1])
    return np.array([key_of(cell, bits, *tables) for cell in cells])


def spread(comm, x):
    """Return Particles with x and stamped fields, each rank having a slice of the ids."""
    mine = np.array_split(np.arange(len(x)), comm.size)[comm.rank]
    p = Particles(comm, x.shape[1])
    p.assign({"id": mine, "x": x[mine], **stamps(mine, x.shape[1])})
    return p


@pytest.fixture
def domains():
    """Make Domain(...) of the same arguments; freed on all ranks at the end, also of a test that fails."""
    made = []

    def make(*arguments, **options):
        made.append(Domain(*arguments, **options))
        return made[-1]

    yield make
    for domain in made:
        domain.destroy()


def stamps(ids, dim):
    """Return values of fields that tell of which particle they are: dict of name -> (n, ...)."""
    return {"u": np.outer(ids, np.arange(1, dim + 1)) + 0.25, "p": np.sqrt(ids + 1.0),
            "role": (ids % 6).astype(np.int8), "kind": (ids % 2).astype(np.int8),
            "phi": 1.0 / (ids + 1.0), "x0": np.outer(ids, np.ones(dim))}


def gathered(comm, p, *names):
    """Return the named owned fields of all ranks, in the order of ids. Collective."""
    order = np.argsort(np.concatenate(comm.allgather(p.id)))
    found = [np.concatenate(comm.allgather(np.ascontiguousarray(getattr(p, name))))[order] for name in names]
    return found[0] if len(names) == 1 else found


def close_pairs(x, radius):
    """Return the (n, n) truth: which points are nearer to each other than the radius."""
    distance2 = ((x[:, None] - x[None]) ** 2).sum(axis=-1)
    near = distance2 < radius**2
    np.fill_diagonal(near, False)
    return near


def listed_pairs(domain, n, radius=None):
    """Return which ids stand in the lists of the owned ids, (n, n) int, and the owned ids.

    radius : count only pairs nearer than this one
    """
    p, table = domain.particles, np.zeros((n, n), int)
    rows = np.repeat(np.arange(p.n_owned), np.diff(domain.indptr))
    columns = domain.indices
    if radius is not None:
        near = ((p.x[rows] - p.x_all[columns]) ** 2).sum(axis=1) < radius**2
        rows, columns = rows[near], columns[near]
    np.add.at(table, (p.id[rows], p.id_all[columns]), 1)
    return table, p.id
