"""The limits on the time step."""

import numpy as np

from parisph.base.fields import FLUID


def next_step(comm, particles, numerics, gravity, previous=None):
    """Return the time step [s]: fixed, or limited by velocity and acceleration. Collective.

    No fluid particle moves by more than `numerics.cfl` spacings, now (|u| dt) or from rest
    (g dt^2/2), and the step grows by at most a tenth from one to the next, so that a single
    calm step in an impact does not undo what the impact asked for.

    Parameters
    ----------
    gravity : float, magnitude of the body force [m/s^2]
    previous : float or None, the last step [s]
    """
    if numerics.time_step is not None:
        return numerics.time_step
    fastest = comm.allreduce(_fastest(particles), op=_max)
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


def _max(a, b):
    return max(a, b)
