"""Probes: gauges, pressure taps, the water front, energy, momentum and volume.

Call `samplers = build(case, comm)` once, then `sample_all(samplers, particles, domain, time)` for
each sample.
"""

from collections.abc import Sequence

import numpy as np

from parisph.base.communicator import Communicator
from parisph.base.errors import CaseError, agree
from parisph.base.fields import WET
from parisph.case import probes
from parisph.case.schema import Case
from parisph.geometry.mesh import CONCAVE, CONVEX
from parisph.kernels.energy import energy_sums
from parisph.kernels.interior import interior_cells
from parisph.kernels.records import cloud_of, no_walls
from parisph.kernels.volumes import current_volumes
from parisph.watch.body_force import force_on
from parisph.watch.discharge import Flux
from parisph.watch.gauges import ColumnHeight, SurfaceGauge, WaterFront
from parisph.watch.points import VelocityPoint, VelocityProfile
from parisph.watch.run_up import run_up
from parisph.watch.sampling import Sampler, Scene, Several, View, sample_all
from parisph.watch.wall_pressure import pressure_tap

__all__ = ["SAMPLERS", "build", "sample_all"]

# Lengths in spacings.
INSIDE = 2.1    # cells inside the fluid are farther from the surface
CELL = 2.6      # neighbours that bound the cell of a particle; the lists of every method have them


def build(case: Case, comm: Communicator) -> list[Sampler]:
    """Return the samplers of the case's probes, in their order. Collective.

    Raises
    ------
    CaseError on every rank: a probe for 2D only in a case in three dimensions.
    """
    error, samplers = None, []
    try:
        scene = Scene.of(case)
        samplers = [_sampler(probe, scene) for probe in case.probes]
    except CaseError as problem:
        error = problem
    agree(comm, error)
    return samplers


def _sampler(probe: probes.AnyProbe, scene: Scene) -> Sampler:
    return SAMPLERS[probe.kind](probe, scene)


def _array(probe: probes.ProbeArray, scene: Scene) -> Several:
    return Several(probe, scene, [_sampler(one, scene) for one in probe.probes])


class Energy(Sampler):
    """Kinetic and potential energy of all fluid, free flight included, in the tank's frame.

    Each particle counts with the volume that it represents. With equal masses, particles on the
    surface, whose cells are half empty, and beside walls would cause an error of order s/H: the
    energy of the falling column would rise by .03 %.

    The potential energy is that of a uniform, constant body force, relative to the tank's lower corner
    (without a tank, the lower corner of the initial fluid); it is 0 for any other force.

    With current=True also with the volumes that particles represent now (kernels.volumes), and the sum of
    these: what a particle represents changes when it comes to a wall or to the surface, or leaves it.
    """

    def __init__(self, probe: probes.Energy, scene: Scene) -> None:
        super().__init__(probe, scene)
        unit = "J/m" if scene.dim == 2 else "J"
        self.columns = {"kinetic": unit, "potential": unit, "total": unit}
        self.title = "Energy of the fluid"
        if probe.current:
            self._two_dimensional(scene)
            self.columns |= {"kinetic_now": unit, "potential_now": unit, "total_now": unit, "volume_now": "m^2"}
            self.title += ", by the volumes at the start and by those now"
            self.ghosts = ("x", "role")

    def _two_dimensional(self, scene):
        if scene.dim != 2:
            raise CaseError(f"probe {self.name!r}: current volumes exist in 2D only; leave out current=True")

    def sums(self, view: View) -> np.ndarray:
        volumes = [view.particles.volume]
        if self.probe.current:
            volumes.append(self._current_volumes(view))
        p, s = view.particles, self.scene
        return np.concatenate([energy_sums(volume, p.x, p.u, s.gravity, s.lower) for volume in volumes])

    def _current_volumes(self, view):
        p, d, s = view.particles, view.domain, self.scene
        volume, e, role, planes = np.empty(p.n_owned), d.elements, p.role_all, s.walls
        walls, concave = no_walls(p.n_owned, 2), np.empty((0, 2), bool)
        if e is not None:
            role, planes = _with_edges(role, e.nodes, e.edges), (np.full(2, -np.inf), np.full(2, np.inf))
            walls = walls._replace(corners=e.corners, indptr=e.indptr, indices=e.indices)
            concave = e.edges == CONCAVE
        cloud = cloud_of(p.x_all, p.kind_all, role, p.x_all, d.indptr, d.indices, s.spacing)
        current_volumes(volume, cloud, walls, concave, *planes, min(d.radius, CELL * s.spacing))
        return volume

    def values(self, sums: np.ndarray, rows: np.ndarray | None) -> Sequence[float]:
        found = ()
        for kinetic, potential, volume in np.reshape(sums, (-1, 3)):
            kinetic, potential = self.scene.density * kinetic, self.scene.density * potential
            found += kinetic, potential, kinetic + potential, volume
        return found[:3] + found[4:]    # the volumes at the start add up to a constant


def _with_edges(role, nodes, edges):
    """Return roles (n_all,) in which nodes on convex edges, which are always dry, are wet beside a wet node."""
    found, there = role.copy(), (nodes >= 0).all(axis=1)
    for end in (0, 1):
        wet = there & (edges[:, end] == CONVEX)
        wet[wet] = role[nodes[wet, 1 - end]] == WET
        found[nodes[wet, end]] = WET
    return found


class Momentum(Sampler):
    """Momentum of all fluid, in the tank's frame."""

    def __init__(self, probe: probes.Momentum, scene: Scene) -> None:
        super().__init__(probe, scene)
        unit = "kg/s" if scene.dim == 2 else "kg m/s"
        self.columns = {f"p{axis}": unit for axis in "xyz"[:scene.dim]}
        self.title = "Momentum of the fluid"

    def sums(self, view: View) -> np.ndarray:
        return view.particles.volume @ view.particles.u

    def values(self, sums: np.ndarray, rows: np.ndarray | None) -> np.ndarray:
        return self.scene.density * sums


class Volume(Sampler):
    """Mean Voronoi cell inside the fluid over spacing^2, and how many cells were averaged.

    It is 1 on the initial lattice. Inside means: inner particles farther than 2.1 spacings from
    every surface and ballistic particle. nan if there are none.
    """

    columns = {"cell": "", "count": "particles"}
    ghosts = ("x",)
    dims = (2,)
    title = "Mean Voronoi cell inside the fluid over the square of the spacing"

    def sums(self, view: View) -> np.ndarray:
        p, d, s = view.particles, view.domain, self.scene.spacing
        cloud = cloud_of(p.x_all, p.kind_all, p.role_all, p.normal_all, d.indptr, d.indices, s)
        return interior_cells(cloud, INSIDE * s, d.radius)

    def values(self, sums: np.ndarray, rows: np.ndarray | None) -> Sequence[float]:
        return (sums[0] / (sums[1] * self.scene.spacing**2) if sums[1] else np.nan), sums[1]


SAMPLERS = {
    "surface_gauge": SurfaceGauge, "pressure_tap": pressure_tap, "water_front": WaterFront,
    "column_height": ColumnHeight, "energy": Energy, "momentum": Momentum, "volume": Volume,
    "velocity_profile": VelocityProfile, "velocity_point": VelocityPoint, "run_up": run_up, "force": force_on,
    "flux": Flux, "probe_array": _array,
}
