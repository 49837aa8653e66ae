"""The simulated partitions of the cost model are those of real ranks."""

import pytest
from mpi4py import MPI

from tests.simulated import check_cloud, check_run


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("kind", ["lattice", "clusters"])
def test_ranks_have_the_particles_neighbours_and_ghosts_of_the_simulation(comm, dim, kind):
    check_cloud(comm, dim, kind)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_run_has_the_counts_of_the_simulation_and_as_many_messages_as_one_rank_tells(comm, dim):
    assert check_run(comm, dim) == check_run(MPI.COMM_SELF, dim)
