"""Probes: gauges, pressure taps, the water front, energy, momentum and volume.

Call `samplers = build(case, comm)` once, then `sample_all(samplers, particles, domain, time)` for
each sample.
"""

from collections.abc import Sequence

import numpy as np

from parisph.base.communicator import Communicator
from parisph.base.errors import CaseError, agree
from parisph.base.fields import INNER, SURFACE, WET
from parisph.case import probes
from parisph.case.schema import Case
from parisph.geometry.distance import nearest
from parisph.geometry.mesh import area_vectors
from parisph.kernels.interior import interior_cells
from parisph.kernels.volumes import current_volumes
from parisph.watch.elevation import COLUMN, bodies, surface_height
from parisph.watch.sampling import WIDTH, Sampler, Scene, View, sample_all

__all__ = ["SAMPLERS", "build", "sample_all"]

# Lengths in spacings.
GAUGE_GAP = 1.5     # air under a gauge: more than this between one particle and the next above it
COLUMN_GAP = 2.1    # air in a column: falling water stretches, to 1.6 in the dam break
BED = 2.0           # water on the bed is as near to it as this
BED_GAP = 2.1       # and reaches from one particle to the next, as far as gradients do
FACE = 3.0          # radius of the face of a pressure tap: 2.1 and 2.6 follow an impact less well, 3.6 no better
NODES = 4.0         # surface particles that may serve a gauge
INSIDE = 2.1        # cells inside the fluid are farther from the surface
PROFILE = 2.6       # neighbours that serve a point of a velocity profile
CELL = 2.6          # neighbours that bound the cell of a particle; the lists of every method have them

ROUNDING = 1.0 + 1e-9
HEIGHT, BODY = 0.0, 1.0  # what a row is: a surface particle (x, y), or a body (lower end, upper end, particles)


def build(case: Case, comm: Communicator) -> list[Sampler]:
    """Return the samplers of the case's probes, in their order. Collective.

    Raises
    ------
    CaseError on every rank: a probe for 2D only in a case in three dimensions.
    """
    error, samplers = None, []
    try:
        scene = Scene.of(case)
        samplers = [SAMPLERS[probe.kind](probe, scene) for probe in case.probes]
    except CaseError as problem:
        error = problem
    agree(comm, error)
    return samplers


class _Column(Sampler):
    """Bodies of water in the column at x = `at`."""

    columns = {"y": "m"}
    gap = GAUGE_GAP

    def __init__(self, probe, scene):
        super().__init__(probe, scene)
        bed = scene.bed_at(np.array([float(probe.at)]))
        self.bed = None if bed is None else float(bed[0])

    def rows(self, view):
        x, y = view.body
        chosen = np.abs(x - self.probe.at) <= COLUMN * self.scene.spacing * ROUNDING
        return _body_rows(bodies(y[chosen], self.gap * self.scene.spacing))

    def top(self, rows):
        """Return the height of the water that stands on the bed, or of the largest body without a bed [m].

        The bed itself where it is dry; nan where there is no water and no bed.
        """
        found, bed = _bodies_of_all(rows, self.gap * self.scene.spacing), self.bed
        if bed is not None:
            return found[0, 1] if len(found) and found[0, 0] <= bed + BED_GAP * self.scene.spacing else bed
        return found[np.argmax(found[:, 2]), 1] if len(found) else np.nan


class ColumnHeight(_Column):
    """Height of the topmost particle of the water that stands on the bed within 1.5 spacings of x = `at`.

    Surface particles of the lattice lie on the surface: nothing is added to their height. Air of
    more than 2.1 spacings ends the column. A dry bed gives the height of the bed.
    """

    gap = COLUMN_GAP

    def __init__(self, probe: probes.ColumnHeight, scene: Scene) -> None:
        super().__init__(probe, scene)
        self.title = f"Height of the water column at x = {probe.at:g} m"

    def values(self, sums: np.ndarray, rows: np.ndarray) -> Sequence[float]:
        return (self.top(rows),)


class SurfaceGauge(_Column):
    """Height of the free surface above x = `at`: a smooth fit if the surface is smooth.

    See surface.surface_height. Where the surface breaks, the value is that of ColumnHeight; on a dry
    bed it is the height of the bed.
    """

    dims = (2,)

    def __init__(self, probe: probes.SurfaceGauge, scene: Scene) -> None:
        super().__init__(probe, scene)
        self.title = f"Height of the free surface above x = {probe.at:g} m"
        reach = NODES * scene.spacing
        sides = (scene.lower[0], scene.upper[0]) if scene.tank else ()
        self.mirrors = [side for side in sides if abs(side - probe.at) < reach]

    def rows(self, view: View) -> np.ndarray:
        x, y = view.surface
        chosen = np.abs(x - self.probe.at) <= NODES * self.scene.spacing
        heights = np.zeros((np.count_nonzero(chosen), WIDTH - 1))
        heights[:, 0], heights[:, 1], heights[:, 2] = HEIGHT, x[chosen], y[chosen]
        return np.concatenate([heights, super().rows(view)])

    def values(self, sums: np.ndarray, rows: np.ndarray) -> Sequence[float]:
        height = rows[:, 0] == HEIGHT
        top = self.top(rows[~height])
        if not height.any() or not top > (-np.inf if self.bed is None else self.bed):
            return (top,)
        return (surface_height(self.probe.at, rows[height, 1], rows[height, 2], top, self.scene.spacing, self.mirrors),)


class WaterFront(Sampler):
    """Foremost x of the water on the bed that is connected to its main body.

    On the bed: within 2 spacings of it. The main body is the largest that has no gap of more than
    2.1 spacings along x, so that a droplet ahead is not the front. Without a tank the same of all
    the fluid.
    """

    columns = {"x": "m"}

    def __init__(self, probe: probes.WaterFront, scene: Scene) -> None:
        super().__init__(probe, scene)
        self.title = ("Position of the water's foremost particle along the bed" if scene.tank or scene.mesh is not None
                      else "Foremost position of the fluid")

    def rows(self, view: View) -> np.ndarray:
        x, y = view.body
        bed = self.scene.bed_at(x)
        if bed is not None:
            x = x[y <= bed + BED * self.scene.spacing * ROUNDING]
        return _body_rows(bodies(x, BED_GAP * self.scene.spacing))

    def values(self, sums: np.ndarray, rows: np.ndarray) -> Sequence[float]:
        found = _bodies_of_all(rows, BED_GAP * self.scene.spacing)
        return (found[np.argmax(found[:, 2]), 1] if len(found) else np.nan,)


def _body_rows(found):
    rows = np.empty((len(found), WIDTH - 1))
    rows[:, 0], rows[:, 1:] = BODY, found
    return rows


def _bodies_of_all(rows, gap):
    return bodies(rows[:, 1], gap, counts=rows[:, 3], ends=rows[:, 2])


class PressureTap(Sampler):
    """Pressure on a wall, by least squares of a linear pressure on the wall particles within the radius.

    The weight is (1 - r^2/radius^2)^2. A dry wall has p = 0. Only the wall of the tap counts; in a corner, only
    the particles of both walls.
    """

    columns = {"pressure": "Pa"}

    def __init__(self, probe: probes.PressureTap, scene: Scene) -> None:
        super().__init__(probe, scene)
        self.title = f"Pressure on the wall at ({', '.join(f'{a:g}' for a in probe.at)}) m"
        self.at = np.array(probe.at)
        self.radius = max(scene.spacing, probe.radius or FACE * scene.spacing)
        tolerance = 1e-6 * np.max(scene.upper - scene.lower)
        self.across = (np.abs(self.at - scene.lower) <= tolerance) | (np.abs(self.at - scene.upper) <= tolerance)
        self.axes = np.eye(scene.dim)    # the first across the wall
        if scene.mesh is not None:
            self.axes = _axes_on(scene.mesh, self.at)
            self.across = np.arange(scene.dim) == 0

    def sums(self, view: View) -> np.ndarray:
        x, p = view.walls
        away = (x - self.at) @ self.axes.T
        d = away / self.radius
        same_wall = (np.abs(away) < 0.5 * self.scene.step)[:, self.across].all(axis=1)
        weight = same_wall * np.clip(1.0 - (d[:, ~self.across] ** 2).sum(axis=1), 0.0, None) ** 2
        basis = np.column_stack([np.ones(len(x)), d[:, ~self.across]])
        return np.append((basis.T * weight) @ basis, (basis.T * weight) @ p)

    def values(self, sums: np.ndarray, rows: np.ndarray | None) -> Sequence[float]:
        n = 1 + np.count_nonzero(~self.across)
        moments, right = np.reshape(sums[:n * n], (n, n)), sums[n * n:]
        if np.isfinite(moments).all() and np.linalg.matrix_rank(moments) == n:
            return (np.linalg.solve(moments, right)[0],)
        return (right[0] / moments[0, 0] if moments[0, 0] > 0.0 else np.nan,)


def _axes_on(mesh, at):
    """Return the normal of the element nearest to a place, and the direction along it, (2, 2): its rows."""
    element = nearest(at[None], mesh.corners())[1][0]
    normal = area_vectors(mesh.corners()[[element]])[0]
    normal /= np.linalg.norm(normal)
    return np.array([normal, [-normal[1], normal[0]]])


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
        return np.concatenate([self._sums(view.particles, volume) for volume in volumes])

    def _sums(self, p, volume):
        """Return kinetic and potential energy over density, and the volume, by `volume` (n_owned,) [m^dim]."""
        total = volume.sum()
        return 0.5 * (volume @ (p.u * p.u)).sum(), self.scene.gravity @ (total * self.scene.lower - volume @ p.x), total

    def _current_volumes(self, view):
        p, d, s = view.particles, view.domain, self.scene
        volume, reach = np.empty(p.n_owned), min(d.radius, CELL * s.spacing)
        current_volumes(volume, p.x_all, p.kind_all, p.role_all, *s.walls, s.spacing, reach, d.indptr, d.indices)
        return volume

    def values(self, sums: np.ndarray, rows: np.ndarray | None) -> Sequence[float]:
        found = ()
        for kinetic, potential, volume in np.reshape(sums, (-1, 3)):
            kinetic, potential = self.scene.density * kinetic, self.scene.density * potential
            found += kinetic, potential, kinetic + potential, volume
        return found[:3] + found[4:]    # the volumes at the start add up to a constant


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
        return interior_cells(p.x_all, p.role_all, INSIDE * s, d.radius, d.indptr, d.indices)

    def values(self, sums: np.ndarray, rows: np.ndarray | None) -> Sequence[float]:
        return (sums[0] / (sums[1] * self.scene.spacing**2) if sums[1] else np.nan), sums[1]


class VelocityProfile(Sampler):
    """Velocity and pressure at points along a line, by least squares of a quadratic polynomial.

    The weight is (1 - r^2/radius^2)^2, the radius PROFILE spacings. Walls count with their own velocity, as far as they
    are wet. Where particles do not determine the polynomial, the value is nan.
    """

    def __init__(self, probe: probes.VelocityProfile, scene: Scene) -> None:
        super().__init__(probe, scene)
        self.places, self.radius = probe.places, PROFILE * scene.spacing
        names = [*"uvw"[:scene.dim], "p"]
        self.columns = {f"{name}_{k}": "Pa" if name == "p" else "m/s" for k in range(len(self.places))
                        for name in names}
        self.title = (f"Velocity and pressure at {len(self.places)} points from "
                      f"({', '.join(f'{a:g}' for a in probe.start)}) to ({', '.join(f'{a:g}' for a in probe.end)}) m")

    def sums(self, view: View) -> np.ndarray:
        p = view.particles
        use = np.isin(p.role, (INNER, SURFACE, WET))
        x, values = p.x[use], np.column_stack([p.u[use], p.p[use]])
        found = []
        for place in self.places:
            d = (x - place) / self.radius
            weight = np.clip(1.0 - (d**2).sum(axis=1), 0.0, None) ** 2
            near = weight > 0.0
            basis = _quadratic(d[near])
            weighted = basis * weight[near, None]
            found += [(weighted.T @ basis).ravel(), (weighted.T @ values[near]).ravel()]
        return np.concatenate(found)

    def values(self, sums: np.ndarray, rows: np.ndarray | None) -> Sequence[float]:
        n, quantities = _quadratic(np.zeros((1, self.scene.dim))).shape[1], self.scene.dim + 1
        table = np.reshape(sums, (len(self.places), n * (n + quantities)))
        return tuple(value for line in table
                     for value in _at_centre(line[:n * n].reshape(n, n), line[n * n:].reshape(n, quantities)))


def _quadratic(d):
    """Return the polynomials up to degree 2 at d (n, dim): (n, 6), in 3D (n, 10); the first is 1."""
    dim = d.shape[1]
    return np.column_stack([np.ones(len(d)), d, *(d[:, a] * d[:, b] for a in range(dim) for b in range(a, dim))])


def _at_centre(moments, right):
    """Return the fitted values at the centre, nan if the moments do not determine them."""
    if not np.isfinite(moments).all() or np.linalg.matrix_rank(moments) < len(moments):
        return np.full(right.shape[1], np.nan)
    return np.linalg.solve(moments, right)[0]


SAMPLERS = {
    "surface_gauge": SurfaceGauge, "pressure_tap": PressureTap, "water_front": WaterFront,
    "column_height": ColumnHeight, "energy": Energy, "momentum": Momentum, "volume": Volume,
    "velocity_profile": VelocityProfile,
}
