"""The limits on the time step."""

import numpy as np
from mpi4py import MPI

from parisph.base.errors import SolverDiverged
from parisph.base.fields import FLUID


def next_step(comm, particles, numerics, gravity, previous=None):
    """Return the time step [s]: fixed, or limited by velocity and acceleration. Collective.

    No fluid particle moves by more than `numerics.cfl` spacings, now (|u| dt) or from rest
    (g dt^2/2), and the step grows by at most a tenth from one to the next, so that a single
    calm step in an impact does not undo what the impact asked for.

    Parameters
    ----------
    gravity : float, the largest body force on this rank's fluid [m/s^2], 0 where there is none
    previous : float or None, the last step [s]

    Raises
    ------
    SolverDiverged on every rank: a velocity is no number.
    """
    if numerics.time_step is not None:
        return numerics.time_step
    fastest, gravity, lost = _largest_of_all(comm, _fastest(particles), gravity)
    if lost:
        raise SolverDiverged("the velocity of a particle is no number any more")
    move = numerics.cfl * numerics.spacing
    dt = np.inf if fastest == 0.0 else move / fastest
    if gravity > 0.0:
        dt = min(dt, np.sqrt(2.0 * move / gravity))
    if numerics.max_time_step is not None:
        dt = min(dt, numerics.max_time_step)
    if previous is not None:
        dt = min(dt, 1.1 * previous)
    return float(dt)


def _fastest(particles):
    fluid = particles.kind == FLUID
    if not fluid.any():
        return 0.0
    return float(np.sqrt((particles.u[fluid] ** 2).sum(axis=1).max()))


def _largest_of_all(comm, speed, force):
    """Return the largest speed and force of all ranks, and whether any was no number. Collective."""
    mine = np.array([speed, force])
    worst = np.append(np.nan_to_num(mine, nan=0.0, posinf=np.inf), float(np.isnan(mine[0])))
    comm.Allreduce(MPI.IN_PLACE, worst, op=MPI.MAX)
    return worst
