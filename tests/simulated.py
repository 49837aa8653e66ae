"""Simulated partitions beside real ones: the counts of each rank. Collective."""

import numpy as np

from parisph.driver import Simulation
from parisph.parallel.domain import Domain
from run_scripts.studies.cost_model.partitions import Points, cut, shares
from tests.clouds import cloud, gathered, spread
from tests.scenes import scene


def check(comm, domain, x, weights=None):
    """Compare a domain that has just been divided, with particles x (n, dim) before that, with the simulation of it."""
    p, scene_of = domain.particles, Points(x, domain.lower, domain.upper, domain.width, weights)
    partition = cut(scene_of, comm.size)
    np.testing.assert_array_equal(partition.splitters, domain._partition.splitters)
    due = shares(scene_of, partition, domain.width)
    found = np.array(comm.allgather((p.n_owned, domain.n_sent, p.n_ghost, domain.receivers))).T
    for name, values in zip(("owned", "sent", "received", "to"), found, strict=True):
        np.testing.assert_array_equal(values, getattr(due, name), err_msg=name)
    assert comm.size == 1 or found[3].min() > 0


def check_cloud(comm, dim, kind="lattice", n=4000):
    """Check the first plan of a cloud of points."""
    p = spread(comm, cloud(kind, dim, n))
    x = gathered(comm, p, "x")
    domain = Domain(p, np.zeros(dim), np.ones(dim), 0.06, 0.015, 0.005)
    try:
        domain.refresh()
        check(comm, domain, x)
    finally:
        domain.destroy()


def check_run(comm, dim=2, steps=3):
    """Check the plan of a dam break by the work of particles; return updates of ghosts in a step."""
    name, spacing = {2: ("dam_break", 0.05), 3: ("dam_break_3d", 0.1)}[dim]
    s = Simulation(scene(name, spacing=spacing, jitter=0.2), comm)
    try:
        s.solve_start()
        before = s.domain.n_updates
        for _ in range(steps):
            s.advance()
        updates = (s.domain.n_updates - before) / steps
        p, domain = s.particles, s.domain
        x, work = (np.concatenate(s.comm.allgather(values)) for values in (p.x, domain._work()))
        domain._partition = None
        domain.redistribute(force=True)
        check(s.comm, domain, x, work)
        return updates
    finally:
        s.destroy()
