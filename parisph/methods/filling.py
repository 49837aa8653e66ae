"""Fluid that fills a scene of any walls, before the first step: even places, and the volume of each particle."""

from collections.abc import Iterable

import numpy as np
from mpi4py import MPI

from parisph.base.fields import FLUID, SURFACE
from parisph.kernels import packing
from parisph.kernels.solids import keep_off_solids
from parisph.methods.flow import Flow
from parisph.methods.wall_solids import WallSolids


def pack(flow: Flow, steps: int = packing.STEPS) -> None:
    """Move the inner fluid until it lies evenly up to the walls (kernels.packing.pack). Collective."""
    p, d, walls = flow.particles, flow.domain, flow.walls
    if not isinstance(walls, WallSolids):
        return
    for _ in range(steps):
        d.refresh()
        d.update(*walls.cover(flow))
        e, covered = walls.elements, p.covered_all
        move = packing.packing_move(p.x_all, p.kind_all, p.role_all, p.weight_all * covered,
                                    p.area_all * covered[:, None], e.corners, e.mean_of_nodes(covered), walls.table,
                                    d.indptr, d.indices, e.indptr, e.indices)
        p.x[:] += move
    d.refresh()


def weigh(flow: Flow, samples: Iterable[tuple[np.ndarray, np.ndarray]]) -> float:
    """Give each fluid particle the volume of the places that are nearest to it; return their sum [m^dim]. Collective.

    A particle on the surface beside a slope may then stand for more than half a cell, though nothing is above it:
    the field half says so.

    samples : places and the volumes around them, at least all near particles of this rank (kernels.packing.volumes)
    """
    p = flow.particles
    fluid = np.flatnonzero(p.kind_all == FLUID)
    own = fluid[fluid < p.n_owned]
    p.volume[own] = packing.volumes(p.x_all[fluid], samples, flow.spacing)[:len(own)]
    if isinstance(flow.walls, WallSolids):
        p.half[:] = (p.kind == FLUID) & (p.role == SURFACE) & (np.diff(flow.walls.elements.indptr) > 0)
        flow.domain.update("half")
    flow.domain.update("volume")
    return float(p.comm.allreduce(p.volume[own].sum(), op=MPI.SUM))


def scatter(flow: Flow, move: np.ndarray) -> None:
    """Displace the fluid by move (n_owned, dim) [m], but no nearer to walls than packing does. Collective."""
    p, d, walls = flow.particles, flow.domain, flow.walls
    if isinstance(walls, WallSolids):
        e = walls.elements
        keep_off_solids(move, p.x_all, p.kind_all, e.corners, packing.GUARD * flow.spacing, e.indptr, e.indices,
                        flow.axes)
    p.x[:] += move
    d.refresh()
