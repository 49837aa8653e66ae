"""When particles are put in order anew and lists are rebuilt, on one rank."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph.base.errors import CaseError, ParisphError, ParticleLost
from parisph.base.fields import DRY, FLUID, WALL, WET
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles
from tests.clouds import close_pairs, cloud, gathered, listed_pairs, spread, stamps

RADIUS, SKIN, LIST_SKIN = 0.1, 0.04, 0.01


def made(dim=2, kind="lattice", **options):
    p = spread(MPI.COMM_SELF, cloud(kind, dim))
    return p, Domain(p, np.zeros(dim), np.ones(dim), RADIUS, SKIN, LIST_SKIN, **options)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("kind", ["lattice", "clusters", "corner"])
def test_first_refresh_sorts_along_the_curve_and_lists_all_pairs(dim, kind):
    p, domain = made(dim, kind)
    x = p.x.copy()
    assert domain.refresh() is True
    assert (np.diff(domain._partition.grid.keys(p.x)) >= 0).all()
    np.testing.assert_array_equal(np.sort(p.id), np.arange(len(x)))
    np.testing.assert_array_equal(p.x, x[p.id])
    for name, values in stamps(p.id, dim).items():
        np.testing.assert_array_equal(getattr(p, name), values)
    table, _ = listed_pairs(domain, len(x))
    np.testing.assert_array_equal(table, close_pairs(x, RADIUS + 2 * LIST_SKIN))
    np.testing.assert_array_equal(domain.global_rows, np.arange(len(x)))
    assert domain.global_rows.dtype == np.int32


def test_nothing_is_redone_within_the_skins():
    p, domain = made()
    domain.refresh()
    indices, before = domain.indices, p.id.copy()
    p.x[3] += [0.9 * LIST_SKIN, 0.0]
    assert domain.refresh() is False and domain.indices is indices
    p.x[3] += [0.0, 0.9 * LIST_SKIN]  # 1.27 list skins from the lists' position
    assert domain.refresh() is False and domain.indices is not indices
    indices = domain.indices
    p.x[3] += [0.0, 0.9 * LIST_SKIN]
    assert domain.refresh() is False and domain.indices is indices
    np.testing.assert_array_equal(p.id, before)
    assert (domain.n_plans, domain.n_lists) == (1, 2)


def test_moves_beyond_the_skin_in_the_mean_order_anew_and_start_a_new_count():
    p, domain = made()
    domain.refresh()
    far = np.argmin(p.x.sum(axis=1))
    p.x[far] += 3.0 * SKIN    # one particle alone makes no new order on one rank
    assert domain.redistribute() is False and domain.n_plans == 1
    p.x += 1.5 * SKIN  # along both axes: 2.1 skins
    assert domain.redistribute() is True and domain.n_plans == 2
    assert domain.redistribute() is False
    # Row numbers changed, so the lists must be made although no list skin was passed since.
    lists = domain.n_lists
    assert domain.refresh() is False and domain.n_lists == lists + 1


def test_lists_hold_every_near_pair_while_particles_move_on():
    p = spread(MPI.COMM_SELF, cloud("lattice", 2))
    domain = Domain(p, np.zeros(2), np.ones(2), RADIUS, 0.25 * SKIN, LIST_SKIN)
    random = np.random.default_rng(1)
    velocity = random.uniform(-1.0, 1.0, (p.n_owned, 2))
    plans = 0
    for _ in range(40):
        p.x += 0.1 * LIST_SKIN * velocity[p.id]
        plans += domain.refresh()
        table, _ = listed_pairs(domain, p.n_owned, RADIUS)
        np.testing.assert_array_equal(table, close_pairs(gathered(MPI.COMM_SELF, p, "x"), RADIUS))
    assert plans > 1 and 3 < domain.n_lists < 20


def test_forced():
    _, domain = made()
    domain.refresh()
    assert domain.redistribute(force=True) is True
    assert domain.refresh() is False and domain.n_lists == 2  # local numbers may have changed


def test_without_skins_every_move_counts():
    p = spread(MPI.COMM_SELF, cloud("lattice", 2))
    domain = Domain(p, (0, 0), (1, 1), RADIUS, 0.0)
    assert domain.refresh() is True and domain.refresh() is False
    p.x[0] += 1e-12
    assert domain.refresh() is True


def test_assigned_anew_is_planned_anew():
    p, domain = made()
    domain.refresh()
    x = cloud("clusters", 2)
    p.assign({"x": x, "id": np.arange(len(x))})
    assert domain.refresh() is True
    np.testing.assert_array_equal(listed_pairs(domain, len(x))[0], close_pairs(x, RADIUS + 2 * LIST_SKIN))


def test_particles_that_leave_the_box_get_another_grid():
    p, domain = made()
    domain.refresh()
    grid = domain._partition.grid
    p.x -= [0.0, 2.5 * SKIN]
    assert domain.refresh() is True and domain._partition.grid is grid  # still near: the border's cells take it
    p.x -= [0.0, 5.0]
    assert domain.refresh() is True and domain._partition.grid.origin[1] <= p.x[:, 1].min()
    np.testing.assert_array_equal(listed_pairs(domain, p.n_owned, RADIUS)[0],
                                  close_pairs(gathered(MPI.COMM_SELF, p, "x"), RADIUS))


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("first", [True, False])
def test_a_position_that_is_no_number_is_a_lost_particle(value, first):
    p, domain = made()
    if not first:
        domain.refresh()
    p.x[7, 1] = value
    with pytest.raises(ParticleLost, match=rf"particle {p.id[7]} at .* not a number"):
        domain.refresh()


def test_only_a_closed_tank_loses_what_leaves_it():
    for closed in (False, True):
        p, domain = made(closed=closed)
        domain.refresh()
        p.x[5] = [1.0 + 0.9 * RADIUS, 0.5]
        domain.refresh()
        row = np.flatnonzero(p.x[:, 0] > 1.0)[0]
        p.x[row] = [1.0 + 1.1 * RADIUS, 0.5]
        p.x[row - 1] = [0.5, -1.0]
        if closed:
            with pytest.raises(ParticleLost, match="outside the tank and 1 more"):
                domain.redistribute()
        else:
            domain.redistribute()


def test_no_particles_at_all():
    p = Particles(MPI.COMM_SELF, 2)
    p.assign({"x": np.zeros((0, 2))})
    domain = Domain(p, (0, 0), (1, 1), RADIUS, SKIN)
    assert domain.refresh() is True and domain.refresh() is False
    assert len(domain.indptr) == 1 and len(domain.indices) == len(domain.global_rows) == 0


@pytest.mark.parametrize("arguments", [
    {"lower": (0, 0, 0)}, {"upper": (0, 1)}, {"upper": (np.nan, 1)}, {"radius": 0.0}, {"radius": np.nan},
    {"skin": -1.0}, {"list_skin": -1.0},
])
def test_lengths_without_sense_are_refused(arguments):
    given = {"lower": (0, 0), "upper": (1, 1), "radius": RADIUS, "skin": SKIN, "list_skin": LIST_SKIN, **arguments}
    with pytest.raises(CaseError):
        Domain(Particles(MPI.COMM_SELF, 2), **given)


def test_unknown_field_is_refused_also_where_there_are_no_ghosts():
    _, domain = made()
    domain.refresh()
    domain.update("u", "p")
    with pytest.raises(ParisphError, match="no such particle field: pressure"):
        domain.update("u", "pressure")


@pytest.mark.parametrize("dim", [2, 3])
def test_nodes_far_from_water_have_no_lists_until_it_comes(dim):
    """A line of nodes with fluid at one end, which then is at the other: lists near it are the full ones."""
    x, kind = np.full((60, dim), 0.5), np.full(60, WALL, np.int8)
    x[:, 0], kind[0] = np.linspace(0.01, 0.99, 60), FLUID
    p = Particles(MPI.COMM_SELF, dim)
    p.assign({"id": np.arange(60), "kind": kind, "x": x})
    p.role[p.kind == WALL] = DRY
    domain = Domain(p, np.zeros(dim), np.ones(dim), RADIUS, SKIN, LIST_SKIN)
    radius = RADIUS + 2.0 * LIST_SKIN
    for place in (0.01, 0.985):
        p.x[p.id == 0, 0] = place
        domain.refresh()
        listed, away = np.diff(domain.indptr), np.abs(p.x[:, 0] - place)
        full = np.array([np.count_nonzero(np.abs(p.x[:, 0] - one) < radius) - 1 for one in p.x[:, 0]])
        np.testing.assert_array_equal(listed[away < radius], full[away < radius])
        assert not listed[away > 2.0 * radius * 4.0 / 3.0].any()
    p.role[np.argmin(p.x[:, 0])] = WET    # as beside water of another rank
    p.x[p.id == 0, 0] = 0.5
    domain.refresh()
    assert np.diff(domain.indptr)[p.x[:, 0] < RADIUS].all()
