"""Fluid that fills a scene of any walls, before the first step: even places, and the volume of each particle."""

from collections.abc import Iterable

import numpy as np
from mpi4py import MPI

from parisph.base.fields import FLUID, INNER, SURFACE, WALL
from parisph.kernels import packing, strain
from parisph.kernels.cells import nearest_points
from parisph.kernels.records import no_walls
from parisph.kernels.solids import keep_off_solids
from parisph.methods import lengths
from parisph.methods.flow import Flow
from parisph.methods.wall_solids import WallSolids

TIE = 1e-3    # spacings by which nodes are moved, so that none is as near to two particles of a lattice


def pack(flow: Flow, steps: int = packing.STEPS) -> None:
    """Move the inner fluid until it lies evenly up to the walls (kernels.packing.packing_move). Collective."""
    p, d, walls = flow.particles, flow.domain, flow.walls
    if not isinstance(walls, WallSolids):
        return
    for _ in range(steps):
        d.refresh()
        d.update(*walls.cover(flow))
        e, covered = walls.elements, p.covered_all
        elements = no_walls(0, p.dim)._replace(corners=e.corners, present=e.mean_of_nodes(covered), indptr=e.indptr,
                                               indices=e.indices)
        p.x[:] += packing.packing_move(flow.cloud, elements, p.weight_all * covered, p.area_all * covered[:, None],
                                       walls.table)
    d.refresh()


def weigh(flow: Flow, samples: Iterable[tuple[np.ndarray, np.ndarray]]) -> float:
    """Give each fluid particle the volume of the places that are nearest to it; return their sum [m^dim]. Collective.

    A particle on the surface beside a slope may then stand for more than half a cell, though nothing is above it:
    the field half says so.
    The field weight, where a scene has it, becomes that of its cell without the half cells of walls.

    samples : places and the volumes around them, at least all near particles of this rank (kernels.packing.volumes)
    """
    p = flow.particles
    fluid = np.flatnonzero(p.kind_all == FLUID)
    own = fluid[fluid < p.n_owned]
    p.volume[own] = packing.volumes(p.x_all[fluid], samples, flow.spacing)[:len(own)]
    flow.domain.update("volume")
    if "weight" in p.fields:
        _weigh_cells(flow, fluid, own)
    if isinstance(flow.walls, WallSolids):
        p.half[:] = (p.kind == FLUID) & (p.role == SURFACE) & (np.diff(flow.walls.elements.indptr) > 0)
        flow.domain.update("half")
    return float(p.comm.allreduce(p.volume[own].sum(), op=MPI.SUM))


def _weigh_cells(flow, fluid, own):
    """Write the weight of the owned fluid: the volume that it stands for without the half cells of nodes, over s^dim.

    Then the sum of the kernels over fluid and nodes is that of the water: packing is even, but where layers do not
    divide the depth, not as dense as a lattice. Each node's half cell is that of its nearest fluid. The mean over the
    inner fluid around a particle is taken, so that no disorder is kept. Surface particles keep the weight of the
    lattice: it stays where it is there, and half of their cells is air.

    fluid : the numbers of all fluid, own : of the owned
    """
    p, d, s = flow.particles, flow.domain, flow.spacing
    inner = own[p.role[own] == INNER]
    cells = p.volume_all / s**p.dim
    if isinstance(flow.walls, WallSolids):
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


def scatter(flow: Flow, move: np.ndarray) -> None:
    """Displace the fluid by move (n_owned, dim) [m], but no nearer to walls than packing does. Collective."""
    p, d, walls = flow.particles, flow.domain, flow.walls
    if isinstance(walls, WallSolids):
        e = walls.elements
        keep_off_solids(move, p.x_all, p.kind_all, e.corners, packing.GUARD * flow.spacing, e.indptr, e.indices,
                        flow.axes)
    p.x[:] += move
    d.refresh()
