"""Work is spread evenly, and stays so; making plans again and again leaves nothing behind."""

import gc

import numpy as np
import pytest
from mpi4py import MPI

from parisph.parallel.partition import imbalance, split
from tests.clouds import KINDS, cloud, domains, spread


@pytest.mark.parametrize("kind", KINDS)
def test_cuts_agree_on_all_ranks_and_are_those_of_one_rank_with_everything(comm, kind):
    """The truth counts weights below each key in the gathered keys."""
    random = np.random.default_rng(comm.rank + (kind == "lattice"))
    cells = random.integers(0, 500 if kind == "clusters" else 4096, 0 if kind == "corner" and comm.rank else 400)
    weight = 700 + 100 * comm.rank
    splitters = split(comm, cells, weight, 4096)
    assert len({part.tobytes() for part in comm.allgather(splitters)}) == 1
    below = np.zeros(4097, np.int64)
    for keys, each in comm.allgather((cells, weight)):
        below += each * np.searchsorted(np.sort(keys), np.arange(4097))
    for rank in range(1, comm.size):
        target = rank * below[-1] // comm.size
        assert abs(below[splitters[rank]] - target) == np.abs(below - target).min()


def cost(p):
    """A load that grows towards one corner: 1, 3 and 5 in the quarters of the box."""
    return 1e-6 * (1.0 + 2.0 * (p.x > 0.5).sum(axis=1)).sum()


def work(comm, domain, times):
    """Let `times` steps pass; return the imbalance at their end. Collective."""
    for _ in range(times):
        domain.record_load(cost(domain.particles))
        domain.redistribute()
    return imbalance(comm.allgather(cost(domain.particles)))


def test_measured_work_is_spread_evenly(comm, domains):
    p = spread(comm, cloud("lattice", 2, 4900))
    domain = domains(p, (0, 0), (1, 1), 0.03, 0.004, balance_every=5)
    domain.refresh()
    assert imbalance(comm.allgather(p.n_owned)) < 1.05
    before = work(comm, domain, 0)
    assert comm.size == 1 or before > 1.2
    assert work(comm, domain, 3) == before and domain.n_plans == 1  # not looked at yet
    after = work(comm, domain, 30)
    assert after <= 1.15
    plans = domain.n_plans
    assert plans == 1 if comm.size == 1 else 2 <= plans <= 6
    work(comm, domain, 20)
    assert domain.n_plans == plans  # even enough: left alone
    assert p.n_global == 4900


def test_only_work_since_the_last_look_counts(comm, domains):
    p = spread(comm, cloud("lattice", 2, 2500))
    domain = domains(p, (0, 0), (1, 1), 0.04, 0.004, balance_every=1)
    domain.refresh()
    domain.record_load(10.0 + 10.0 * comm.rank)
    assert domain.redistribute() is (comm.size > 1)
    domain.record_load(1.0)
    assert domain.redistribute() is False


def test_rebalancing_renumbers_and_says_so(comm, domains):
    p = spread(comm, cloud("lattice", 2, 2500))
    domain = domains(p, (0, 0), (1, 1), 0.04, 0.004, balance_every=1)
    domain.refresh()
    rows = p.offsets.copy()
    domain.record_load(cost(p))
    changed = domain.redistribute()
    assert changed == (comm.size > 1) and changed == (not np.array_equal(rows, p.offsets))


def test_without_measurements_particles_are_counted(comm, domains):
    """Particles that all flow to one side change owners by their number."""
    p = spread(comm, cloud("lattice", 2, 2500))
    domain = domains(p, (0, 0), (1, 1), 0.04, 0.004, balance_every=3)
    for _ in range(30):
        p.x[:, 0] *= 0.93
        p.x[:, 1] = 1.0 - 0.96 * (1.0 - p.x[:, 1])
        domain.refresh()
    domain.redistribute(force=True)
    for _ in range(3):
        domain.redistribute()
    cells = domain._partition.grid.cells(domain._partition.grid.keys(p.x))
    fullest = np.unique(np.concatenate(comm.allgather(cells)), return_counts=True)[1].max()
    counts = comm.allgather(p.n_owned)
    assert max(counts) <= max(1.15 * 2500 / comm.size, 2500 / comm.size + fullest)


def test_cells_too_coarse_to_balance_are_not_renumbered_in_vain(comm, domains):
    p = spread(comm, cloud("corner", 2))
    domain = domains(p, (0, 0), (1, 1), 0.1, 0.02, balance_every=1)
    domain.refresh()
    for _ in range(5):
        domain.record_load(1.0 + comm.rank)
        assert domain.redistribute() is False


def test_an_old_plan_is_freed(comm, domains):
    p = spread(comm, cloud("lattice", 2))
    domain = domains(p, (0, 0), (1, 1), 0.1, 0.02)
    domain.refresh()
    domain.update("u", "p")
    old = domain._halo
    if comm.size == 1:
        assert old is None
        return
    forest, units = old._forest, list(old._units.values())
    assert forest and len(units) == 1
    domain.redistribute(force=True)
    assert domain._halo is not old and not forest
    assert all(unit == MPI.DATATYPE_NULL for unit in units)


def resident():
    """Resident memory of this process [bytes]."""
    gc.collect()
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * 4096


def test_memory_is_flat_over_many_plans(comm, domains):
    p = spread(comm, cloud("lattice", 2, 900))
    domain = domains(p, (0, 0), (1, 1), 0.08, 0.01)
    random = np.random.default_rng(comm.rank)

    def plans(count):
        for _ in range(count):
            p.x += random.uniform(-0.01, 0.01, p.x.shape)
            np.clip(p.x, 0.0, 1.0, out=p.x)
            domain.redistribute(force=True)
            domain.refresh()
            domain.update("u")
            domain.update("u", "p", "role")

    plans(60)  # pools of MPI, PETSc and Python fill
    before = resident()
    plans(300)
    grown = resident() - before
    assert comm.allreduce(grown) / comm.size < 200_000
    assert p.n_global == 900
