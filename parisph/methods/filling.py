"""Filling a scene with fluid before the first step: even places, and the volume of each particle."""

from collections.abc import Iterable

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Flags, Floats
from parisph.base.fields import FLUID, INNER, SURFACE, WALL
from parisph.kernels import halves, packing, strain, surface_rows
from parisph.kernels.cells import nearest_points
from parisph.methods import lengths
from parisph.methods.flow import Flow

AT_WALL = 1.5    # tuned 1.3 to 1.9: spacings from a node within which fluid may have more than its cell; judged
TIE = 1e-3    # spacings by which nodes, and places in 3D, are moved, so that none is equally near to two particles


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
    if p.dim == 3:    # in scenes with two equal halves, rounding would give places in the middle to one of them
        tie = TIE * flow.spacing * np.arange(1.0, p.dim + 1.0)
        samples = ((places + tie, volume) for places, volume in samples)
    p.volume[own] = packing.volumes(p.x_all[fluid], samples, flow.spacing)[:len(own)]
    flow.domain.update("volume")
    return float(p.comm.allreduce(p.volume[own].sum(), op=MPI.SUM))


def weigh_cells(flow: Flow) -> None:
    """Write the weight of the owned fluid: its volume without the half cells of nodes, over s^dim. Collective.

    The kernel sum over fluid and nodes is then that of the water: packing is even, but not as dense as a lattice where
    layers do not divide the depth. Each node's half cell belongs to its nearest fluid. The weight is the mean over the
    inner fluid around a particle, which removes disorder. Surface particles keep the weight of the lattice, because
    they stay in place and half of their cells is air. Also marks those that represent half a cell (`halve`).
    """
    p, d, s = flow.particles, flow.domain, flow.spacing
    inner = np.flatnonzero((p.kind == FLUID) & (p.role == INNER))
    cells, beside = p.volume_all / s**p.dim, _beside(flow)
    cells -= beside
    remember_beside(flow)
    halve(flow, cells, (beside > 0.0) | _at_slopes(flow))
    p.weight[inner] = cells[inner]
    d.update("weight", "half")
    mean = np.empty(p.n_owned)
    inside = flow.cloud._replace(kind=np.where(p.role_all == INNER, np.int8(FLUID), np.int8(WALL)))
    strain.mean_over_fluid(mean, inside, p.weight_all, lengths.NEAR * s)
    p.weight[inner] = mean[inner]
    d.update("weight")


def _beside(flow: Flow) -> Floats:
    """Return the half cells of nodes for which each fluid particle is the nearest (n_all,). Collective."""
    p, s, found = flow.particles, flow.spacing, np.zeros(flow.particles.n_all)
    flow.domain.update(*flow.walls.cover(flow))
    fluid, walls = np.flatnonzero(p.kind_all == FLUID), np.flatnonzero((p.kind_all == WALL) & (p.covered_all > 0.0))
    if len(walls) and len(fluid):
        places = p.x_all[walls] + TIE * s * np.arange(1.0, p.dim + 1.0)
        nearest = fluid[nearest_points(p.x_all[fluid], places, s)]
        found += np.bincount(nearest, (p.weight_all * p.covered_all)[walls], p.n_all)
    return found


def _at_slopes(flow: Flow) -> Flags:
    """Return which fluid particles (n_all,) are within AT_WALL of a covered node in 3D. Not collective.

    There the nearest fluid of all nodes before the end of the water on a slope may be inner fluid.
    """
    p, found = flow.particles, np.zeros(flow.particles.n_all, bool)
    fluid, walls = np.flatnonzero(p.kind_all == FLUID), np.flatnonzero((p.kind_all == WALL) & (p.covered_all > 0.0))
    if p.dim == 3 and len(fluid) and len(walls):
        near = walls[nearest_points(p.x_all[walls], p.x_all[fluid], flow.spacing)]
        found[fluid] = np.linalg.norm(p.x_all[near] - p.x_all[fluid], axis=1) < AT_WALL * flow.spacing
    return found


def halve_on_lattice(flow: Flow) -> None:
    """Mark the surface particles that represent half a cell, of fluid on the lattice of its tank. Collective.

    Where three walls meet at the surface, a particle has 9/8 of a cell, half of which is above the water.
    """
    beside = _beside(flow)
    remember_beside(flow)
    halve(flow, flow.cells - beside, beside > 0.0)
    flow.domain.update("half")


def remember_beside(flow: Flow) -> None:
    """Write the half cells of nodes that fluid represents where a part asks for them. Collective.

    Each is divided by the measure of the steps, so that water at its walls carries few away (halves.claims).
    """
    if flow.half_cells:
        p, weight = flow.particles, flow.walls.claimed_at_start(flow)
        p.share_all[:] = p.kind_all == FLUID
        halves.wall_share(p.share_all, flow.cloud, weight)
        flow.domain.update("share")
        weight = np.divide(weight, p.share_all, out=np.zeros(p.n_all), where=p.share_all > 0.0)
        halves.half_cells_around(p.beside, flow.cloud, weight)


def halve(flow: Flow, cells: Floats, at_walls: Flags) -> None:
    """Mark the surface particles that represent half a cell. Not collective.

    One at a wall is like the nearest one away from walls, because the last one before a slope includes the tip of the
    water.

    cells : (n_all,), volumes without the half cells of nodes, in cells; at_walls : (n_all,) bool
    """
    p = flow.particles
    surface = (p.kind_all == FLUID) & (p.role_all == SURFACE)
    edge, free = np.flatnonzero((surface & at_walls)[:p.n_owned]), np.flatnonzero(surface & ~at_walls)
    p.half[:] = (surface & (cells < surface_rows.HALF))[:p.n_owned]
    if len(edge) and len(free):
        like = free[nearest_points(p.x_all[free], p.x[edge], flow.spacing)]
        near = np.linalg.norm(p.x_all[like] - p.x[edge], axis=1) < lengths.NEAR * flow.spacing
        p.half[edge[near]] = cells[like[near]] < surface_rows.HALF


def scatter(flow: Flow, move: Floats) -> None:
    """Displace the fluid by move (n_owned, dim) [m], but no closer to walls than packing does. Collective."""
    flow.walls.keep_off(move, flow, packing.GUARD)
    flow.particles.x[:] += move
    flow.domain.refresh()
