"""Ghosts and neighbour lists on any number of ranks, against brute force over all particles."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph.base.fields import FIELDS, WALL, WET
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles
from tests.clouds import KINDS, close_pairs, cloud, domains, gathered, listed_pairs, spread, stamps

RADIUS, SKIN, LIST_SKIN = 0.11, 0.03, 0.01


@pytest.fixture
def make(comm, domains):
    """Function of (kind, dim) to (particles, domain)."""
    def of(kind, dim, n=600):
        p = spread(comm, cloud(kind, dim, n))
        return p, domains(p, np.zeros(dim), np.ones(dim), RADIUS, SKIN, LIST_SKIN)
    return of


def check_lists(comm, domain, n, radius, drifted=True):
    """Each owned particle finds exactly the neighbours that a search in all particles finds, once.

    Only a node of a wall that is far from all fluid and from wet nodes may have none.
    """
    table, ids = listed_pairs(domain, n, radius if drifted else None)
    x, kind, role = gathered(comm, domain.particles, "x", "kind", "role")
    truth = close_pairs(x, radius)
    dry = (kind == WALL) & (role != WET)
    apart = dry & ~close_pairs(x, 2.0 * radius)[:, ~dry].any(axis=1)
    truth[apart] &= table[apart] > 0
    truth[:, apart] &= table[:, apart] > 0
    np.testing.assert_array_equal(table[ids], truth[ids])
    assert comm.allreduce(len(ids)) == n


def check_ghosts(domain, names):
    """Each ghost has its owner's values of the stamped fields, and nobody is here twice."""
    p = domain.particles
    due = stamps(p.id_all, p.dim)
    for name in names:
        np.testing.assert_array_equal(getattr(p, f"{name}_all"), due[name], err_msg=name)
    assert len(np.unique(p.id_all)) == p.n_all


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("kind", KINDS)
def test_first_plan_fills_every_exchanged_field_and_finds_every_pair(comm, make, kind, dim):
    p, domain = make(kind, dim)
    n = p.n_global
    assert domain.refresh() is True
    check_ghosts(domain, [name for name in stamps(p.id, dim) if FIELDS[name].exchanged])
    domain.update("phi", "x0")
    domain.redistribute(force=True)
    for name in ("phi", "x0"):  # not exchanged: zero, and not what happened to lie in memory
        assert not getattr(p, f"{name}_all")[p.n_owned:].any()
    assert domain.refresh() is False
    check_lists(comm, domain, n, RADIUS + 2 * LIST_SKIN, drifted=False)
    assert comm.size == 1 or kind == "corner" or comm.allreduce(p.n_ghost) > 0


@pytest.mark.parametrize("dim, n", [(2, 3000), (3, 2000)])
def test_ghosts_are_all_that_can_come_near_until_the_next_plan(comm, make, dim, n):
    """Both of a pair may move by the skin; and the lists reach farther than the radius."""
    p, domain = make("lattice", dim, n)
    domain.refresh()
    x = gathered(comm, p, "x")
    here = np.isin(np.arange(len(x)), p.id_all)
    reach = RADIUS + 2 * SKIN + 2 * LIST_SKIN
    for i in p.id:
        assert here[((x - x[i]) ** 2).sum(axis=1) < reach**2].all()
    assert comm.size == 1 or not here.all()  # or the test would say nothing


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("kind", KINDS)
def test_ranks_are_ranges_of_the_curve_and_sorted(comm, make, kind, dim):
    p, domain = make(kind, dim)
    domain.refresh()
    part = domain._partition
    keys = part.grid.keys(p.x)
    assert (np.diff(keys) >= 0).all()
    assert (part.owners(part.grid.cells(keys)) == comm.rank).all()


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("kind", KINDS)
def test_update_brings_new_values_of_all_types_to_the_ghosts(comm, make, kind, dim):
    p, domain = make(kind, dim)
    domain.refresh()
    for name in ("p", "u", "role", "phi", "x0"):
        getattr(p, f"{name}_all")[...] = -1
    for name, values in stamps(p.id, dim).items():
        getattr(p, name)[...] = values
    domain.update("p")
    check_ghosts(domain, ["p"])
    assert (p.phi_all[p.n_owned:] == -1).all()  # not asked for
    domain.update("u", "role", "phi", "x0")
    check_ghosts(domain, ["p", "u", "role", "phi", "x0"])


def test_numbers_that_a_double_cannot_hold_arrive_whole(comm, make):
    p, domain = make("lattice", 2)
    domain.refresh()
    before = p.id_all.copy()
    p.id += 2**62 + 1
    domain.update("p", "id", "role")
    np.testing.assert_array_equal(p.id_all - (2**62 + 1), before)


@pytest.mark.parametrize("kind", KINDS)
def test_global_rows_are_contiguous_on_a_rank_and_known_of_ghosts(comm, make, kind):
    p, domain = make(kind, 2)
    domain.refresh()
    np.testing.assert_array_equal(domain.global_rows[:p.n_owned], p.offset + np.arange(p.n_owned))
    assert p.offset == sum(comm.allgather(p.n_owned)[:comm.rank])
    p.p_all[...] = -1.0
    p.p = domain.global_rows[:p.n_owned]
    domain.update("p")
    np.testing.assert_array_equal(p.p_all, domain.global_rows)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("kind", ["lattice", "clusters"])
def test_moving_particles_keep_finding_all_neighbours_and_keep_their_fields(comm, make, kind, dim):
    p, domain = make(kind, dim, n=300)
    n = p.n_global
    velocity = np.random.default_rng(5).uniform(-1.0, 1.0, (n, dim)) / np.sqrt(dim)
    x = gathered(comm, p, "x")
    plans = moves = 0
    for _ in range(25):
        owner = dict.fromkeys(p.id)
        p.x += 0.9 * LIST_SKIN * velocity[p.id]
        x += 0.9 * LIST_SKIN * velocity
        plans += domain.refresh()
        moves += comm.allreduce(sum(i not in owner for i in p.id))
        check_lists(comm, domain, n, RADIUS)
        check_ghosts(domain, ["p", "u", "kind"])
        np.testing.assert_allclose(p.x_all, x[p.id_all], atol=1e-14)
        for name, values in stamps(p.id, dim).items():
            np.testing.assert_array_equal(getattr(p, name), values, err_msg=name)
    assert 2 < plans < 20 and (moves > 0 or comm.size == 1)


def test_all_particles_in_one_corner_leave_other_ranks_empty_and_working(comm, make):
    p, domain = make("corner", 2)
    domain.refresh()
    counts = comm.allgather(p.n_owned)
    assert sorted(counts) == [0] * (comm.size - 1) + [60]  # the corner is one cell
    domain.update("u", "p")
    check_lists(comm, domain, 60, RADIUS)


def test_far_drops_with_nothing_between(comm, domains):
    p = spread(comm, np.concatenate([cloud("corner", 2), cloud("corner", 2) + 3.0]))
    domain = domains(p, (0.0, 0.0), (3.1, 3.1), RADIUS, SKIN)
    domain.refresh()
    domain.update("u")
    check_lists(comm, domain, 120, RADIUS)
    assert comm.size == 1 or max(comm.allgather(p.n_owned)) == 60


@pytest.mark.parametrize("n", [0, 1, 2])
def test_fewer_particles_than_ranks(comm, domains, n):
    p = spread(comm, np.random.default_rng(0).random((n, 2)))
    domain = domains(p, (0.0, 0.0), (1.0, 1.0), RADIUS, SKIN)
    domain.refresh()
    domain.update("u", "x")
    assert comm.allreduce(p.n_owned) == n == p.n_global
    check_lists(comm, domain, n, RADIUS)


def test_pairs_exactly_as_far_apart_as_the_halo_is_wide(comm, domains):
    """A lattice whose spacing divides the width and the cells."""
    x = np.stack(np.meshgrid(*[np.arange(17) / 16] * 2), axis=-1).reshape(-1, 2)
    p = spread(comm, x)
    radius = 0.125 * (1.0 + 1e-12)
    domain = domains(p, (0.0, 0.0), (1.0, 1.0), radius, 0.0)
    domain.refresh()
    check_lists(comm, domain, len(x), radius)
    inside = ((p.x > 0.2) & (p.x < 0.8)).all(axis=1)
    assert (np.diff(domain.indptr)[inside] == 12).all()


def test_same_particles_as_on_one_rank(comm, make):
    p, domain = make("clusters", 2)
    domain.refresh()
    alone = Particles(MPI.COMM_SELF, 2)
    x, ids = gathered(comm, p, "x", "id")
    alone.assign({"x": x, "id": ids})
    serial = Domain(alone, domain.lower, domain.upper, RADIUS, SKIN, LIST_SKIN)
    serial.refresh()
    table, mine = listed_pairs(domain, len(x))
    np.testing.assert_array_equal(table[mine], listed_pairs(serial, len(x))[0][mine])
