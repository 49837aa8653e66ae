"""Laplacians and gradients of a field on an arrangement of particles. Not collective."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from mpi4py import MPI

from parisph.base.arrays import Array, Floats
from parisph.base.fields import BALLISTIC, FLUID, FieldSet
from parisph.base.log import Timers
from parisph.case.numerics import Numerics, ResolvedNumerics
from parisph.kernels.cells import neighbour_lists
from parisph.kernels.records import Cloud, cloud_of
from parisph.methods import catalogue, lengths  # noqa: F401 (parts register)
from parisph.methods.boundary import Boundary
from parisph.methods.flow import Flow
from parisph.methods.parts import GRADIENTS, LAPLACIANS, SURFACE_GRADIENTS, WALL_ROWS
from parisph.parallel.domain import Domain
from parisph.parallel.particles import Particles
from parisph.patch.arrangement import Arrangement
from parisph.pressure.rows import PressureRows


class _Nothing:
    """A divergence without effect."""

    name = "nothing"

    def fill(self, flux: Floats, cloud: Cloud, u: Floats) -> None:
        pass


@dataclass(frozen=True)
class Discrete:
    """The rows of an arrangement: row_I(p) = p_I - sum_J values_J p_J, with row_I(p) = -measure_I target_I."""

    rows: PressureRows
    arrangement: Arrangement

    @property
    def measure(self) -> Floats:
        """(n,) [m^2], for walls [m]; 0 for particles without an equation, or with one that is not sound."""
        return self.rows.rows.measure[:len(self.arrangement.x)]

    def weighted(self, f: Floats) -> Floats:
        """Return sum_J values_J f_J of each row, (n,)."""
        n, buffers, start = len(self.arrangement.x), self.rows.rows, self.rows.cloud.indptr
        count = buffers.count[:n]
        entry = np.repeat(start[:-1] - np.concatenate([[0], np.cumsum(count)[:-1]]), count) + np.arange(count.sum())
        sums: Array = np.bincount(np.repeat(np.arange(n), count), buffers.values[entry] * f[buffers.columns[entry]],
                                  minlength=n)
        return sums

    def derivative(self, f: Floats) -> Floats:
        """Return the Laplacian of f (n,) by the rows, at wet walls its normal derivative: (n,), NaN if measure is 0."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.measure > 0.0, (f - self.weighted(f)) / -self.measure, np.nan)


def discrete(arrangement: Arrangement, laplacian: str, wall_rows: str = "sfdi") -> Discrete:
    """Return the rows of a Laplacian, with those of wet walls. Raises KeyError for a word without a part."""
    part, walls = LAPLACIANS[laplacian], WALL_ROWS[wall_rows]
    a, s = arrangement, arrangement.spacing
    reach = max(lengths.NEAR, part.reach, walls.reach)
    indptr, indices = neighbour_lists(a.x, len(a.x), reach * s)
    rows = PressureRows(a.dim, part, _Nothing(), walls, 0.0, lengths.MLS)
    cloud = cloud_of(a.x, a.kind, a.role.copy(), a.normal, indptr, indices, s)
    rows.fill(np.zeros_like(a.x), cloud, np.where(a.kind == FLUID, 1.0, 0.0))
    return Discrete(rows, a)


def gradient(arrangement: Arrangement, f: Floats, name: str, at_surface: str = "same") -> Floats:
    """Return the gradient of f (n,) at fluid: (n, dim), NaN at walls and at fluid with too few neighbours.

    name : of a part in GRADIENTS; at_surface : of one in SURFACE_GRADIENTS. Raises KeyError for a word without a part.
    """
    a, parts = arrangement, (GRADIENTS[name], SURFACE_GRADIENTS[at_surface])
    numerics = Numerics(spacing=a.spacing, preset="gentle", gradient=name, surface_gradient=at_surface)
    flow = _flow(a, parts, numerics.resolved())
    p = flow.particles
    p.p[:] = f[p.id]
    out = np.full((p.n_owned, a.dim), np.nan)
    for part in parts:
        part.write(out, p.p_all, flow)
    out[(p.kind != FLUID) | (p.role == BALLISTIC)] = np.nan
    found = np.empty_like(out)
    found[p.id] = out    # the domain has sorted them
    return found


def _flow(a: Arrangement, parts: Iterable[Any], numerics: ResolvedNumerics) -> Flow:
    """Return the Flow of particles at rest, on this rank alone."""
    names = [name for part in parts for name in part.needs(numerics)]
    particles = Particles(MPI.COMM_SELF, a.dim, FieldSet((*Boundary.fields, *names)))
    volume = np.where(a.kind == FLUID, a.spacing**a.dim, 0.0)
    particles.assign({"id": np.arange(len(a.x)), "x": a.x, "kind": a.kind, "corner": a.corner, "normal": a.normal,
                      "role": a.role, "volume": volume})
    reach = max(lengths.NEAR, *(part.reach for part in parts)) * a.spacing
    domain = Domain(particles, a.x.min(axis=0) - a.spacing, a.x.max(axis=0) + a.spacing, reach, skin=0.0)
    domain.refresh()
    return Flow(numerics, 1.0, lambda x, t: np.zeros_like(x), particles, domain, Boundary(domain.elements, a.spacing),
                Timers())
