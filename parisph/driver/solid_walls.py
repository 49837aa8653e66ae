"""Walls of any shape in a simulation: their elements, and the fluid between them, before the first step."""

from collections.abc import Collection

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Floats
from parisph.base.errors import CaseError
from parisph.base.fields import FLUID, INNER, WALL
from parisph.case.schema import Case
from parisph.geometry import build
from parisph.geometry.mesh import no_mesh
from parisph.methods import filling
from parisph.methods.boundary import Boundary
from parisph.methods.flow import Flow
from parisph.methods.positions import KeepApart
from parisph.methods.rigid_bodies import Prescribed
from parisph.parallel.particles import Particles
from parisph.parallel.wall_elements import WallElements

LEAST = 0.25    # of a cell: half of a half cell at a wall
APART = 4    # passes that part close pairs of a jittered start, to below rounding


def fields(case: Case) -> tuple[str, ...]:
    """Return the names of the fields that walls need."""
    moving = len(build.scene_motions(case)) > 1
    return (*Boundary.fields, "wall_u") if moving else Boundary.fields


def elements_of(case: Case, particles: Particles) -> WallElements:
    """Return the elements of the walls of a case. Collective.

    particles : all particles; the last ones are the nodes of the walls, also in every checkpoint

    Raises CaseError, on all ranks, if an earlier release that wrote the checkpoint divided these walls differently.
    """
    mesh = build.scene_mesh(case) or no_mesh(case.dim)
    nodes = particles.comm.allreduce(int(np.count_nonzero(particles.kind == WALL)))
    if nodes != len(mesh.x0):
        raise CaseError(f"the checkpoint has {nodes} particles on walls, and this release has {len(mesh.x0)} for "
                        "them: continue with the release of the run, which `parisph info` names, or start it again "
                        "with parisph run and its case.json")
    last = particles.comm.allreduce(int(particles.id.max(initial=-1)), op=MPI.MAX)
    movers = [Prescribed(motion) for motion in build.scene_motions(case)]
    return WallElements(mesh, last + 1 - len(mesh.x0), case.numerics.spacing, movers)


def complete(case: Case, flow: Flow, names: Collection[str]) -> None:
    """Give particles the fields of walls that a checkpoint of an earlier release lacks. Collective.

    In such a release, a tank without other walls had no elements. names : fields of the checkpoint
    """
    p = flow.particles
    if not p.n_global:
        return
    if flow.half_cells and "beside" not in names:
        p.beside[:] = _beside_of_volumes(flow)
    if "area" in names:
        return
    walls = np.flatnonzero(p.kind == WALL)
    p.body[:] = -1
    if len(walls):
        nodes = build.wall_nodes(case, p.id[walls] - flow.walls.elements.first)
        for name in ("weight", "area", "edge", "body"):
            getattr(p, name)[walls] = nodes[name]
    flow.domain.refresh()


def _beside_of_volumes(flow: Flow) -> Floats:
    """Return the half cells of walls that fluid represented at the start, over s^dim: (n_owned,). Not collective.

    They are exact where fluid began on the lattice, but for edges of columns in 3D. Elsewhere the weight is a mean, and
    only half cells that stand out of the scatter count. Fluid at a water line represents none of the nodes there.
    """
    p, cells = flow.particles, flow.cells[:flow.particles.n_owned]
    found = cells - p.weight
    return np.where((p.kind == FLUID) & (p.half == 0) & (found > LEAST), found, 0.0)


def fill(case: Case, flow: Flow) -> None:
    """Pack the fluid of a scene, set its volumes, and jitter it. Collective.

    Fluid on the lattice of a lone tank is even (build.even), and its jittered particles are not moved further. In other
    scenes a method that keeps pairs apart does so here too: its first step would do it after the pressure solve.
    """
    p, d, s = flow.particles, flow.domain, case.numerics.spacing
    even = build.even(case)
    d.refresh()
    if not even:
        filling.pack(flow)
    if not build.weighed(case):
        own, reach = p.x[p.kind == FLUID], d.radius + s
        filling.weigh(flow, build.samples(case, own.min(axis=0) - reach, own.max(axis=0) + reach) if len(own) else ())
    if even:
        filling.halve_on_lattice(flow)
    else:
        filling.weigh_cells(flow)
    if case.numerics.jitter > 0.0:
        _jitter(case, flow, even)
    started = {name: values for name, values in build.started(case, p.id, p.x).items() if name in p.fields}
    for name, values in started.items():
        view = getattr(p, name)
        view[p.kind == FLUID] = values[p.kind == FLUID]
    d.update(*started)    # the first pressure looks at ghosts before any step has sent them


def _jitter(case: Case, flow: Flow, even: bool) -> None:
    p, d = flow.particles, flow.domain
    move = build.jitter(case, p.id, p.role != INNER)
    move[p.kind != FLUID] = 0.0
    if even:
        p.x[:] += move
        d.refresh()
        return
    filling.scatter(flow, move)
    apart = KeepApart()
    if apart.name in flow.numerics.regularisers and apart.wanted(flow.numerics):
        for _ in range(APART):
            apart.apply(flow, 0.0)
        d.refresh()
