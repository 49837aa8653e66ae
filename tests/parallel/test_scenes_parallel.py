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
# those in 3D take longest: they come together, as ranks have each one of them
ORDER = sorted(NAMES, key=lambda name: "breadth" not in COARSE[name] and name not in {
    *COARSER, "drop_3d", "sloshing_3d", "spheric2"})


def made(name, comm):
    """Return the Case of a scene, made on one rank: the names of its files differ. Collective."""
    sets = COARSE[name] | ({"spacing": COARSER[name]} if name in COARSER else {})
    return comm.bcast(scene(name, **sets).changed(**{"numerics.rtol": 1e-12}))


def ends(case, comm):
    """Return positions and pressures (n,) after some steps, sorted by id, on rank 0. Collective."""
    simulation = Simulation(case, comm)
    simulation.solve_start()
    for _ in range(STEPS):
        simulation.advance()
    found = simulation.gather("x", "p")
    simulation.destroy()
    return found


@pytest.fixture(scope="module")
def alone(comm):
    """Return a function that gives the ends of a scene on one rank. Each rank computes another scene. Collective."""
    kept = {}

    def found(name):
        if name not in kept:
            first = ORDER.index(name) // comm.size * comm.size
            names = ORDER[first:first + comm.size]
            cases = [made(one, comm) for one in names]
            mine = ends(cases[comm.rank], MPI.COMM_SELF) if comm.rank < len(cases) else None
            kept.update(zip(names, comm.allgather(mine)))
        return kept[name]
    return found


@pytest.mark.parametrize("name", ORDER)
def test_begins_on_several_ranks_as_on_one(comm, tmp_path, monkeypatch, alone, name):
    made_motion(tmp_path)
    monkeypatch.setenv(measured_data.VARIABLE, str(tmp_path))
    case = made(name, comm)
    together, one = ends(case, comm), alone(name)
    if comm.rank == 0:
        assert np.abs(together["x"] - one["x"]).max() < 1e-9 * case.numerics.spacing
        assert np.abs(together["p"] - one["p"]).max() < 1e-6 * np.abs(one["p"]).max() + 1e-9
    comm.Barrier()
