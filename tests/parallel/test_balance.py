"""Work is spread evenly, and stays so; making plans again and again leaves nothing behind."""

import gc

import numpy as np
import pytest
from mpi4py import MPI

from parisph.base.fields import DRY, INNER
from parisph.parallel.partition import imbalance, split
from parisph.parallel.work import work_of
from tests.clouds import KINDS, cloud, domains, spread
from tests.systems import resident


@pytest.mark.parametrize("kind", KINDS)
def test_cuts_agree_on_all_ranks_and_are_those_of_one_rank_with_everything(comm, kind):
    """The truth counts weights below each key in the gathered keys."""
    random = np.random.default_rng(comm.rank + (kind == "lattice"))
    cells = random.integers(0, 500 if kind == "clusters" else 4096, 0 if kind == "corner" and comm.rank else 400)
    weights = random.integers(1, 1000 + 500 * comm.rank, len(cells))
    splitters = split(comm, cells, weights, 4096)
    assert len({part.tobytes() for part in comm.allgather(splitters)}) == 1
    below = np.zeros(4097, np.int64)
    for keys, each in comm.allgather((cells, weights)):
        below += [each[keys < key].sum() for key in range(4097)]
    for rank in range(1, comm.size):
        target = rank * below[-1] // comm.size
        assert abs(below[splitters[rank]] - target) == np.abs(below - target).min()


def scene(comm, domains, **options):
    """A lattice of which only the particles near one corner take part in the pressure equation."""
    p = spread(comm, cloud("lattice", 2, 4900))
    p.role[:] = np.where((p.x < 0.45).all(axis=1), INNER, DRY)
    domain = domains(p, (0, 0), (1, 1), 0.03, 0.004, 0.001, **options)
    return p, domain


def unevenness(comm, p, domain):
    """Return max/mean over the ranks of the work that is there. Collective."""
    return imbalance(comm.allgather(int(work_of(p.role, np.diff(domain.indptr)).sum())))


def test_work_is_spread_evenly_as_soon_as_it_is_known(comm, domains):
    p, domain = scene(comm, domains)
    domain.refresh()
    assert imbalance(comm.allgather(p.n_owned)) < 1.05
    assert comm.size == 1 or unevenness(comm, p, domain) > 1.2
    assert domain.refresh() is (comm.size > 1)
    assert unevenness(comm, p, domain) <= 1.05
    for _ in range(5):
        assert domain.refresh() is False    # even enough: left alone
    assert p.n_global == 4900


@pytest.mark.parametrize("move", [False, True])
def test_work_that_becomes_uneven_is_noticed_in_time_or_when_particles_move_anyway(comm, domains, move):
    p, domain = scene(comm, domains, balance_every=10)
    for _ in range(2):
        domain.refresh()
    p.role[:] = np.where((p.x > 0.55).all(axis=1), INNER, DRY)
    p.x[:] += 0.005 * (move & (p.x < 0.5))
    changed = [domain.refresh() for _ in range(1 if move else 10)]
    assert changed == ([True] if move else [False] * 9 + [comm.size > 1])
    assert unevenness(comm, p, domain) <= 1.05


def test_rebalancing_renumbers_and_says_so(comm, domains):
    p, domain = scene(comm, domains)
    domain.refresh()
    rows = p.offsets.copy()
    changed = domain.refresh()
    assert changed == (comm.size > 1) and changed == (not np.array_equal(rows, p.offsets))


def test_without_lists_particles_are_counted(comm, domains):
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
    assert max(counts) <= max(1.05 * 2500 / comm.size, 2500 / comm.size + fullest)


def test_cells_too_coarse_to_balance_are_not_renumbered_in_vain(comm, domains):
    p = spread(comm, cloud("corner", 2))
    domain = domains(p, (0, 0), (1, 1), 0.1, 0.02, balance_every=1)
    domain.refresh()
    p.role[:] = INNER if comm.rank else DRY
    for _ in range(5):
        assert domain.refresh() is False


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
    assert comm.allreduce(grown) / comm.size < 200    # kB
    assert p.n_global == 900
