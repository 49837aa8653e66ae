"""The energy of the fluid."""

from collections.abc import Iterator
from typing import Any, Literal

import numpy as np
from pydantic import Field

from parisph.base.arrays import Array, Floats
from parisph.base.errors import CaseError
from parisph.base.fields import WET
from parisph.case.probes import Probe
from parisph.case.scene import Scene
from parisph.geometry.mesh import CONCAVE, CONVEX
from parisph.watch.sampling import ProbeScene, View

CELL = 2.6    # [spacings] distance of neighbours that bound the cell of a particle, in the lists of every method


class Energy(Probe):
    """Kinetic and potential energy of the fluid [J/m].

    It is that of all fluid, also in free flight, in the tank's frame. Each particle counts with the volume that it
    represents. Equal masses for particles on the surface, whose cells are half empty, and beside walls would cause an
    error of order s/H: the energy of the falling column would rise by .03 %.

    The potential energy is that of a uniform, constant body force, relative to the tank's lower corner (without a
    tank, the lower corner of the initial fluid); it is 0 for any other force.

    current : whether to add the energy by the volumes that particles represent now, and the sum of these volumes. They
        differ from those at the start for a particle that has come to a wall or to the surface, or has left it

    >>> Energy("energy", current=True).current
    True
    """

    columns = {"kinetic": "J/m", "potential": "J/m", "total": "J/m"}
    judged = "total"
    quantity, quantities = "energy", {"volume_now": "volume"}
    of_potential = ("potential", "total")

    kind: Literal["energy"] = Field(default="energy", init=False)
    current: bool = Field(default=False, description="whether to add the energy by the present volumes of particles")

    def title(self, scene: Any) -> str:
        return "Energy of the fluid" + ", by the volumes at the start and by those now" * self.current

    def problems(self, case: Scene) -> Iterator[str]:
        if self.current and case.dim != 2:
            yield "current volumes exist in 2D only; leave out current=True"

    def columns_in(self, scene: ProbeScene) -> dict[str, str]:
        if self.current and scene.dim != 2:
            raise CaseError(f"probe {self.name!r}: current volumes exist in 2D only; leave out current=True")
        found = {name: "J/m" if scene.dim == 2 else "J" for name in self.columns}
        now = {f"{name}_now": unit for name, unit in found.items()} | {"volume_now": "m^2"}
        return found | now if self.current else found

    def ghosts(self) -> tuple[str, ...]:
        return ("x", "role") if self.current else ()

    def sums(self, view: View) -> Floats:
        from parisph.kernels.energy import energy_sums

        volumes = [view.particles.volume]
        if self.current:
            volumes.append(_current_volumes(view))
        p, s = view.particles, view.scene
        return np.concatenate([energy_sums(volume, p.x, p.u, s.gravity, s.lower) for volume in volumes])

    def values(self, sums: Floats, rows: Floats, view: View) -> tuple[float, ...]:
        found: tuple[float, ...] = ()
        for kinetic, potential, volume in np.reshape(sums, (-1, 3)):
            kinetic, potential = view.scene.density * kinetic, view.scene.density * potential
            found += kinetic, potential, kinetic + potential, volume
        return found[:3] + found[4:]    # the volumes at the start add up to a constant


def _current_volumes(view: View) -> Floats:
    from parisph.kernels.volumes import current_volumes

    p, d, s = view.particles, view.domain, view.scene
    volume, e = np.empty(p.n_owned), d.elements
    cloud = p.cloud(d.indptr, d.indices, s.spacing)._replace(role=_with_edges(p.role_all, e.nodes, e.edges))
    current_volumes(volume, cloud, e.walls, e.edges == CONCAVE, min(d.radius, CELL * s.spacing))
    return volume


def _with_edges(role: Array, nodes: Array, edges: Array) -> Array:
    """Return roles (n_all,) with nodes on convex edges, which are always dry, made wet beside a wet node."""
    found, there = role.copy(), (nodes >= 0).all(axis=1)
    for end in (0, 1):
        wet = there & (edges[:, end] == CONVEX)
        wet[wet] = role[nodes[wet, 1 - end]] == WET
        found[nodes[wet, end]] = WET
    return found
