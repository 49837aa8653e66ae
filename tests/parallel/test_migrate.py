"""Particles on their way to other ranks, and errors that all ranks must hear of."""

import numpy as np
import pytest

from parisph.base.errors import CaseError, ParticleLost
from parisph.base.fields import FIELDS
from parisph.parallel.migrate import migrate
from tests.clouds import cloud, domains, gathered, spread


def fill(p):
    """Give every field values that depend on the id."""
    for name, field in FIELDS.items():
        if name != "id":
            view = getattr(p, name)
            parts = np.arange(1, view[:1].size + 1).reshape(view.shape[1:]) if p.n_owned else 1
            key = np.multiply.outer(p.id, parts).reshape(view.shape)
            view[...] = (key % 100 if field.dtype in (np.int8, np.int32) else np.sin(key)
                         + len(name)).astype(field.dtype)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("to", ["anywhere", "last", "stay", "next"])
def test_migration_conserves_ids_and_every_field(comm, dim, to):
    p = spread(comm, cloud("clusters", dim))
    fill(p)
    names = ["id", *(name for name, field in FIELDS.items() if field.migrates and name != "id")]
    before = gathered(comm, p, *names)
    random = np.random.default_rng(comm.rank)
    owners = {"anywhere": random.integers(0, comm.size, p.n_owned), "last": np.full(p.n_owned, comm.size - 1),
              "stay": np.full(p.n_owned, comm.rank), "next": np.full(p.n_owned, (comm.rank + 1) % comm.size)}[to]
    due = np.concatenate(comm.allgather(owners))[np.argsort(np.concatenate(comm.allgather(p.id)))]
    arrived = migrate(p, owners)
    assert (due[p.id] == comm.rank).all()
    assert comm.allreduce(arrived) == comm.allreduce(int((owners != comm.rank).sum()))
    assert p.n_global == len(before[0]) and p.n_ghost == 0
    for name, old, new in zip(names, before, gathered(comm, p, *names), strict=True):
        np.testing.assert_array_equal(old, new, err_msg=name)


def test_those_that_stay_keep_their_order_and_the_numbers_are_learned(comm):
    p = spread(comm, cloud("lattice", 2))
    staying = p.id[p.id % 3 > 0]
    migrate(p, np.where(p.id % 3 > 0, comm.rank, 0))
    assert comm.rank == 0 or np.array_equal(p.id, staying)
    if comm.rank == 0:
        np.testing.assert_array_equal(p.id[p.id % 3 > 0][:len(staying)], staying)
    counts = comm.allgather(p.n_owned)
    np.testing.assert_array_equal(p.offsets, np.concatenate([[0], np.cumsum(counts)]))


def test_fields_that_do_not_migrate_arrive_with_their_default(comm):
    names = [name for name, field in FIELDS.items() if not field.migrates]
    p = spread(comm, cloud("lattice", 2))
    fill(p)
    mine = set(p.id)
    migrate(p, np.full(p.n_owned, (comm.rank + 1) % comm.size))
    moved = np.array([i not in mine for i in p.id], dtype=bool)
    for name in names:
        assert np.all(getattr(p, name)[moved] == FIELDS[name].default), name


def message_of(comm, kind, action):
    """Return the message of the error, the same on all ranks."""
    with pytest.raises(kind) as caught:
        action()
    messages = comm.allgather(str(caught.value))
    assert len(set(messages)) == 1
    return messages[0]


@pytest.mark.parametrize("planned", [False, True])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_position_that_is_no_number_on_one_rank_is_raised_on_all(comm, domains, planned, value):
    p = spread(comm, cloud("lattice", 2))
    domain = domains(p, (0, 0), (1, 1), 0.1, 0.02)
    if planned:
        domain.refresh()
    culprit = comm.size - 1
    number = comm.bcast(int(p.id[4]), root=culprit)
    if comm.rank == culprit:
        p.x[4, 0] = value
    said = message_of(comm, ParticleLost, domain.refresh)
    assert f"particle {number} at" in said and "not a number" in said
    assert comm.size == 1 or said.startswith(f"rank {culprit}: ")


def test_leaving_a_closed_tank_on_one_rank_is_raised_on_all(comm, domains):
    p = spread(comm, cloud("lattice", 3))
    domain = domains(p, (0, 0, 0), (1, 1, 1), 0.1, 0.02, closed=True)
    domain.refresh()
    if comm.rank == 0:
        p.x[0, 2] = 1.2
    assert "outside the tank" in message_of(comm, ParticleLost, domain.redistribute)


def test_arrays_that_do_not_fit_on_one_rank_are_refused_on_all(comm):
    p = spread(comm, cloud("lattice", 2))
    wrong = {"x": np.zeros((3, 2)), "p": np.zeros(4 if comm.rank == comm.size - 1 else 3)}
    assert "field p has shape (4,)" in message_of(comm, CaseError, lambda: p.assign(wrong))
    assert p.n_global == len(cloud("lattice", 2))  # nothing has changed
