"""The moves of particles since the last plan and the last lists, and lost particles."""

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Floats
from parisph.base.errors import ParticleLost, agree
from parisph.kernels.jit import kernel
from parisph.parallel.particles import Particles


@dataclass(frozen=True)
class Survey:
    """Moves of particles [m]; largest values over all particles of all ranks.

    plan_drift, list_drift : distance moved from the plan's and from the lists' positions
    stray : distance outside the grid of cells
    mean_drift : root mean square distance from the plan's positions, of this rank's particles
    """

    plan_drift: float
    list_drift: float
    stray: float
    mean_drift: float


def survey(particles: Particles, plan_x: Floats | None, list_x: Floats | None,
           grid: tuple[Floats, Floats], tank: tuple[Floats, Floats] | None = None) -> Survey:
    """Check every particle once. Collective.

    Parameters
    ----------
    plan_x, list_x : (n_owned, dim) earlier positions [m], or None for an infinite drift
    grid : (lower, upper), (dim,) corners [m]
    tank : (lower, upper) or None; a particle outside of it is lost

    Raises
    ------
    ParticleLost on every rank: some particle's position is not finite, or outside the tank.
    """
    x, comm = particles.x, particles.comm
    everywhere = np.full(particles.dim, np.inf)
    walls = tank or (-everywhere, everywhere)
    found = np.zeros(4)
    squares = _survey(found, x, x if plan_x is None else plan_x, x if list_x is None else list_x, grid, walls)
    # A rank without earlier positions reports an infinite drift.
    found[:2] = np.where([plan_x is None, list_x is None], np.inf, np.sqrt(found[:2]))
    if comm.size > 1:
        comm.Allreduce(MPI.IN_PLACE, found, op=MPI.MAX)
    if found[3]:
        agree(comm, _loss(particles, walls))
    mean = np.inf if plan_x is None else np.sqrt(squares / max(len(x), 1))
    plan, last, stray, _ = found.tolist()
    return Survey(plan, last, stray, float(mean))


@kernel
def _survey(found: Floats, x: Floats, plan_x: Floats, list_x: Floats, grid: tuple[Floats, Floats],
            walls: tuple[Floats, Floats]) -> float:
    squares, (lower, upper) = 0.0, walls
    for i in range(len(x)):
        plan = last = 0.0
        for a in range(x.shape[1]):
            plan += (x[i, a] - plan_x[i, a]) ** 2
            last += (x[i, a] - list_x[i, a]) ** 2
            found[2] = max(found[2], grid[0][a] - x[i, a], x[i, a] - grid[1][a])
            # Written so that NaN fails the test.
            if not (np.isfinite(x[i, a]) and lower[a] <= x[i, a] <= upper[a]):
                found[3] = 1.0
        found[0], found[1] = max(found[0], plan), max(found[1], last)
        squares += plan
    return squares


def _loss(particles: Particles, walls: tuple[Floats, Floats]) -> ParticleLost | None:
    """Return the error to raise on this rank, or None."""
    x = particles.x
    broken = ~np.isfinite(x).all(axis=1)
    outside = ((x < walls[0]) | (x > walls[1])).any(axis=1)
    lost = np.flatnonzero(broken | outside)
    if not len(lost):
        return None
    first = lost[0]
    place = ", ".join(f"{value:.6g}" for value in x[first])
    what = "position is not a number" if broken[first] else "outside the tank"
    speed = float(np.sqrt((particles.u[first] ** 2).sum()))
    more = f" and {len(lost) - 1} more particles" if len(lost) > 1 else ""
    return ParticleLost(f"particle {particles.id[first]} at ({place}) m, speed {speed:.3g} m/s: {what}{more}")
