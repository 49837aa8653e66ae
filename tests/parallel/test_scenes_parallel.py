"""Every scene of cases/ begins on several ranks as on one."""

import numpy as np
import pytest
from mpi4py import MPI

from parisph.case import measured_data
from parisph.driver.simulation import Simulation
from tests.physics.test_coarse_scenes import COARSE, NAMES
from tests.scenes import made_motion, scene

STEPS = 4
# of scenes whose start takes long: coarser than where their volume is right, which is not asked here [m]
COARSER = {"breakwater_stl": 0.12, "flume_3d": 0.15}


def ends(case, comm):
    """Return positions and pressures (n,) after some steps, sorted by id, on rank 0. Collective."""
    simulation = Simulation(case, comm)
    simulation.solve_start()
    for _ in range(STEPS):
        simulation.advance()
    found = simulation.gather("x", "p")
    simulation.destroy()
    return found


@pytest.mark.parametrize("name", NAMES)
def test_begins_on_several_ranks_as_on_one(comm, tmp_path, monkeypatch, name):
    made_motion(tmp_path)
    monkeypatch.setenv(measured_data.VARIABLE, str(tmp_path))
    sets = COARSE[name] | ({"spacing": COARSER[name]} if name in COARSER else {})
    # made on one rank: the names of its files differ
    case = comm.bcast(scene(name, **sets).changed(**{"numerics.rtol": 1e-12}))
    together = ends(case, comm)
    if comm.rank == 0:
        alone = ends(case, MPI.COMM_SELF)
        assert np.abs(together["x"] - alone["x"]).max() < 1e-9 * case.numerics.spacing
        assert np.abs(together["p"] - alone["p"]).max() < 1e-6 * np.abs(alone["p"]).max() + 1e-9
    comm.Barrier()
