"""Settings for all tests: one thread a rank, parallel h5py. Before anything imports numpy."""

import pytest

from parisph.base import environment

environment.prepare()


@pytest.fixture
def simulated():
    """Return a function that makes a Simulation of a case on this rank, which is freed after the test."""
    from mpi4py import MPI

    from parisph.driver import Simulation

    made = []

    def new(case, *more, **options):
        made.append(Simulation(case, MPI.COMM_SELF, *more, **options))
        return made[-1]

    yield new
    for simulation in made:
        simulation.destroy()
