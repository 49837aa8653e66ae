"""The volume of the fluid, by its cells."""

from typing import Literal

import numpy as np
from pydantic import Field

from parisph.base.arrays import Floats
from parisph.case.probes import Probe
from parisph.watch.sampling import View

INSIDE = 2.1    # [spacings] least distance from the surface of cells inside the fluid


class Volume(Probe):
    """Mean Voronoi cell inside the fluid over what its particles represent: the square of the spacing, in 3D its cube.

    It is dimensionless, 1 on a lattice of the spacing; fluid of another shape may start with other cells. The column
    `count` is the number of averaged cells: those of inner particles farther than 2.1 spacings from all surface and
    ballistic particles, with what they represent of the half cells at walls. Without any, the mean is nan.

    >>> Volume("volume", every=10).every
    10
    """

    columns = {"cell": "", "count": "particles"}
    quantity, quantities = "mean cell inside the fluid $/\\,s^2$", {"count": "cells counted"}

    kind: Literal["volume"] = Field(default="volume", init=False)

    def ghosts(self) -> tuple[str, ...]:
        return ("x",)

    def sums(self, view: View) -> Floats:
        from parisph.kernels.interior import interior_cells
        from parisph.kernels.interior_volumes import interior_volumes, spiral
        from parisph.kernels.records import cloud_of

        p, d, s = view.particles, view.domain, view.scene.spacing
        cloud = cloud_of(p.x_all, p.kind_all, p.role_all, p.normal_all, d.indptr, d.indices, s)
        cells = p.weight + p.beside if "beside" in p.fields else np.zeros(0)
        cloud = cloud._replace(corner=p.corner_all)
        if view.scene.dim == 3:
            return np.array(interior_volumes(cloud, cells, INSIDE * s, d.radius, spiral()))
        return np.array(interior_cells(cloud, cells, INSIDE * s, d.radius))

    def values(self, sums: Floats, rows: Floats, view: View) -> tuple[float, ...]:
        return (sums[0] / (sums[1] * view.scene.spacing**view.scene.dim) if sums[1] else np.nan), sums[2]
