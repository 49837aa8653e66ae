"""Move particles to the ranks that own them."""

import numpy as np

from parisph.base.arrays import Ints
from parisph.parallel.messages import exchange, pack, unpack
from parisph.parallel.particles import Particles


def migrate(particles: Particles, owners: Ints) -> int:
    """Move each owned particle to its owner, with all fields that migrate. Collective.

    Parameters
    ----------
    particles : Particles; ghosts are dropped; particles that stay keep their order and come first
    owners : (n_owned,) the rank of each particle

    Fields that do not migrate get their default on particles that have moved.

    Returns
    -------
    int, the number of arrived particles, which come last
    """
    comm = particles.comm
    names = particles.fields.migrating
    leaving = np.flatnonzero(owners != comm.rank)
    leaving = leaving[np.argsort(owners[leaving], kind="stable")]
    counts = np.bincount(owners[leaving], minlength=comm.size)
    arrived, _ = exchange(comm, pack(particles, names, leaving), counts)
    if len(leaving):
        particles.reorder(np.flatnonzero(owners == comm.rank))
    stayed = particles.n_owned
    particles.resize(stayed + len(arrived), 0)
    for name, field in particles.fields.items():
        if not field.migrates:
            getattr(particles, name)[stayed:] = field.default
    unpack(particles, names, arrived, stayed)
    particles.renumber()
    return len(arrived)
