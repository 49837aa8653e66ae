"""Filling a scene with fluid before the first step: even places, and the volume of each particle."""

from collections.abc import Iterable

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Floats
from parisph.base.fields import FLUID, INNER, SURFACE, WALL
from parisph.kernels import packing, strain
from parisph.kernels.cells import nearest_points
from parisph.methods import lengths
from parisph.methods.flow import Flow

TIE = 1e-3    # spacings by which nodes are moved, so that none is equally near to two lattice particles


def pack(flow: Flow, steps: int = packing.STEPS) -> None:
    """Move the inner fluid until it lies evenly up to the walls (kernels.packing.packing_move). Collective."""
    p, d, walls = flow.particles, flow.domain, flow.walls
    if not len(walls.elements.mesh.x0):
        return
    for _ in range(steps):
        d.refresh()
        d.update(*walls.cover(flow))
        covered = p.covered_all
        elements = walls.elements.walls._replace(present=walls.elements.mean_of_nodes(covered))
        p.x[:] += packing.packing_move(flow.cloud, elements, p.weight_all * covered, p.area_all * covered[:, None],
                                       walls.table)
    d.refresh()


def weigh(flow: Flow, samples: Iterable[tuple[Floats, Floats]]) -> float:
    """Give each fluid particle the volume of the places nearest to it; return their sum [m^dim]. Collective.

    samples : places and the volumes around them, at least all near particles of this rank (kernels.packing.volumes)
    """
    p = flow.particles
    fluid = np.flatnonzero(p.kind_all == FLUID)
    own = fluid[fluid < p.n_owned]
    p.volume[own] = packing.volumes(p.x_all[fluid], samples, flow.spacing)[:len(own)]
    flow.domain.update("volume")
    return float(p.comm.allreduce(p.volume[own].sum(), op=MPI.SUM))


def halve(flow: Flow) -> None:
    """Write which fluid represents half a cell: surface particles beside walls at the start. Collective.

    Beside a slope such a particle may have a larger volume, though nothing is above it.
    """
    p = flow.particles
    p.half[:] = (p.kind == FLUID) & (p.role == SURFACE) & (np.diff(flow.walls.elements.walls.indptr) > 0)
    flow.domain.update("half")


def weigh_cells(flow: Flow) -> None:
    """Write the weight of the owned fluid: its volume without the half cells of nodes, over s^dim. Collective.

    The kernel sum over fluid and nodes is then that of the water: packing is even, but not as dense as a lattice where
    layers do not divide the depth. Each node's half cell belongs to its nearest fluid. The weight is the mean over the
    inner fluid around a particle, which removes disorder. Surface particles keep the weight of the lattice, because
    they stay in place and half of their cells is air.
    """
    p, d, s = flow.particles, flow.domain, flow.spacing
    fluid = np.flatnonzero(p.kind_all == FLUID)
    own = fluid[fluid < p.n_owned]
    inner = own[p.role[own] == INNER]
    cells = p.volume_all / s**p.dim
    d.update(*flow.walls.cover(flow))
    walls = np.flatnonzero((p.kind_all == WALL) & (p.covered_all > 0.0))
    if len(walls) and len(fluid):
        places = p.x_all[walls] + TIE * s * np.arange(1.0, p.dim + 1.0)
        nearest = fluid[nearest_points(p.x_all[fluid], places, s)]
        cells -= np.bincount(nearest, (p.weight_all * p.covered_all)[walls], p.n_all)
    p.weight[inner] = cells[inner]
    d.update("weight")
    mean = np.empty(p.n_owned)
    inside = flow.cloud._replace(kind=np.where(p.role_all == INNER, np.int8(FLUID), np.int8(WALL)))
    strain.mean_over_fluid(mean, inside, p.weight_all, lengths.NEAR * s)
    p.weight[inner] = mean[inner]
    d.update("weight")


def scatter(flow: Flow, move: Floats) -> None:
    """Displace the fluid by move (n_owned, dim) [m], but no closer to walls than packing does. Collective."""
    flow.walls.keep_off(move, flow, packing.GUARD)
    flow.particles.x[:] += move
    flow.domain.refresh()
