"""Scenes with particles at made-up places, for tests of probes."""

import numpy as np
from mpi4py import MPI

from parisph.base.fields import FLUID
from parisph.case.schema import Tank
from parisph.driver.solid_walls import elements_of
from parisph.geometry import build as geometry
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles
from parisph.watch import instruments
from tests.scenes import water

G, DENSITY = 9.81, 1000.0


def scene(watched, spacing=0.05, width=1.0, depth=0.5, tank=(1.0, 1.0), at=(0.0, 0.0), elevation=None,
          gravity=(0.0, -G), velocity=(0.0, 0.0), shape=None, jitter=0.0, lid=False, wave=None):
    """Return the Case of a box of water, in a tank of size `tank` at `at` or without one (None)."""
    walls = None if tank is None else Tank(width=tank[0], height=tank[1], lid=lid, at=at)
    return water(shape or (width, depth, at), walls, dict(spacing=spacing, jitter=jitter), density=DENSITY,
                 elevation=elevation, velocity=velocity, wave=wave, gravity=gravity, probes=watched)


class Watch:
    """The particles of a case, spread over the ranks of `comm`, and its samplers.

    change : function(arrays) that changes this rank's arrays before they become particles; it must
    do the same to each particle on any number of ranks
    """

    def __init__(self, case, comm=MPI.COMM_SELF, change=None):
        arrays = geometry.build(case, comm.rank, comm.size)
        if change is not None:
            change(arrays)
        s = case.numerics.spacing
        self.particles = Particles(comm, case.dim)
        self.particles.assign(arrays)
        self.domain = Domain(self.particles, *geometry.domain(case), 2.6 * s, 0.4 * s, 0.04 * s,
                             elements=elements_of(case, self.particles))
        self.domain.refresh()
        self.samplers = instruments.build(case, comm)

    def sample(self, time=0.0):
        """Return {probe name: tuple of values}. Collective."""
        return instruments.sample_all(self.samplers, self.particles, self.domain, time)

    def destroy(self):
        """Free the halo. Collective."""
        self.domain.destroy()


def at_walls(watch, walls, plain=None):
    """Let the fluid of a Watch represent the half cells of walls that its lattice is beside, as after a start.

    walls : (axis, place) of each; plain : Watch of the same scene before particles were moved
    """
    p, x = watch.particles, (plain or watch).particles.x
    s = watch.domain.elements.spacing
    beside = [np.where(np.abs(np.abs(x[:, axis] - place) - s) < 1e-6 * s, 1.5, 1.0) for axis, place in walls]
    p.beside[:] = np.where(p.kind == FLUID, np.prod(beside, axis=0) - 1.0, 0.0)
    return watch


def mirrored(x, walls):
    """Return places (n, dim) and their images behind each wall, in whose Voronoi diagram cells end at walls."""
    images = [x]
    for axis, place in walls:
        images.append(x.copy())
        images[-1][:, axis] = 2.0 * place - x[:, axis]
    return np.concatenate(images)


def only(found):
    """Return the value of the only column of the only probe."""
    ((value,),) = found.values()
    return value


def add_fluid(arrays, x, role):
    """Add fluid particles at x (n, 2) to the arrays of one rank."""
    n = len(x)
    more = {"id": -1 - np.arange(n), "x": np.asarray(x, float), "role": np.full(n, role, np.int8)}
    for name, values in arrays.items():
        arrays[name] = np.concatenate([values, more.get(name, np.zeros((n, *values.shape[1:]), values.dtype))])
