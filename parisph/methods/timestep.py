"""The limits on the time step. None of them knows when the run ends."""

import numpy as np
from mpi4py import MPI

from parisph.base.errors import SolverDiverged
from parisph.base.fields import FLUID

GROWTH = 1.1    # from one step to the next, at most
GENTLE = 0.1    # of the longest move: what acceleration may add in the first step
REST = 9.81     # [m/s^2] that sets the first step of fluid which nothing moves


def next_step(comm, particles, numerics, gravity, previous=None, shortest=0.0):
    """Return the time step [s]: fixed, or limited by velocity and body force. Collective.

    No fluid particle moves by more than `numerics.cfl` spacings, now (|u| dt) or from rest
    (g dt^2/2), and the step grows by at most a tenth from one to the next, so that a single
    calm step in an impact does not undo what the impact asked for. Infinite where nothing limits it.

    Parameters
    ----------
    gravity : float, the largest body force on this rank's fluid [m/s^2], 0 where there is none
    previous : float or None, the last step [s]
    shortest : float, an adaptive step [s] that only a flow out of hand can ask for

    Raises
    ------
    SolverDiverged on every rank: a velocity is no number, or so large that the step is below `shortest`.
    """
    if numerics.time_step is not None:
        return numerics.time_step
    fastest, gravity, lost = _largest_of_all(comm, _fastest(particles), gravity)
    if lost:
        raise SolverDiverged("the velocity of a particle is no number any more")
    move = _longest_move(numerics)
    dt = np.inf if fastest == 0.0 else move / fastest
    if dt < shortest:
        raise SolverDiverged(f"a particle has reached {fastest:.3g} m/s, for which the time step would have to be {dt:.3g} s: "
                             "the flow is far too fast for this scene")
    dt = min(dt, _fall(move, gravity))
    if numerics.max_time_step is not None:
        dt = min(dt, numerics.max_time_step)
    if previous is not None:
        dt = min(dt, GROWTH * previous)
    return float(dt)


def first_step(comm, particles, numerics, acceleration, dt, force_at):
    """Return an adaptive step `dt` [s] as shortened for the first one of a run. Collective.

    Velocity alone says nothing of fluid that is let go. So the acceleration counts, that of the pressure
    at the start included: |u| dt + 10 |a| dt^2 is at most `numerics.cfl` spacings. From rest, steps then
    grow by a tenth each up to where velocity limits them, instead of falling to a tenth of the first.
    The body force at its end and half way must allow the step as well, for it may be zero at the start.
    What rests in no field has no time of its own: it gets that of a fall from rest on earth.

    Parameters
    ----------
    acceleration : (n_owned, dim) at the start [m/s^2]
    force_at : function of a time after the start [s], the largest body force on this rank's fluid then [m/s^2]
    """
    move, fluid = _longest_move(numerics), particles.kind == FLUID
    u, a = (np.sqrt((v[fluid] ** 2).sum(axis=1)) for v in (particles.u, acceleration))
    inverse = ((u + np.sqrt(u * u + 4.0 * move / GENTLE * a)) / (2.0 * move)).max(initial=0.0)
    inverse = comm.allreduce(float(inverse), op=MPI.MAX)
    if inverse > 0.0:
        dt = min(dt, 1.0 / inverse)
    if dt == np.inf:
        dt = _fall(move, REST)
    while True:
        allowed = _fall(move, comm.allreduce(max(force_at(dt), force_at(0.5 * dt)), op=MPI.MAX))
        if not dt > allowed:    # also where the force is no number, which the step itself will say
            return float(dt)
        dt = min(allowed, 0.5 * dt)


def rest_step(numerics):
    """Return the time [s] in which a particle falls from rest, on earth, by what an adaptive step may move it."""
    return float(_fall(_longest_move(numerics), REST))


def _longest_move(numerics):
    return numerics.cfl * numerics.spacing


def _fall(move, gravity):
    """Return the time [s] of a fall from rest over `move` [m]; infinite without a force."""
    return np.sqrt(2.0 * move / gravity) if gravity > 0.0 else np.inf


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
