"""The force of the pressure on a body, and its moment."""

from collections.abc import Iterator
from typing import Any, Literal, Optional

import numpy as np
from pydantic import Field

from parisph.base.arrays import Flags, Floats, Ints
from parisph.base.probe_rows import WIDTH
from parisph.base.text import point
from parisph.case import probe_checks
from parisph.case.breadth import lifted, section_of
from parisph.case.expressions import uniform_field
from parisph.case.probes import Measure, OfPressure, Point, up
from parisph.case.scene import Scene
from parisph.case.scenery import body_names
from parisph.geometry.mesh import WallMesh
from parisph.geometry.probe_places import ENDS, Places, on_side
from parisph.geometry.solid import solid_of
from parisph.methods.rigid_bodies import PressureLoad, node_pressures
from parisph.methods.surface_load import SurfaceLoad
from parisph.watch.sampling import ProbeScene, View
from parisph.watch.walls_now import WallsNow

IN_3D = {"fx": "N", "fy": "N", "fz": "N", "mx": "N m", "my": "N m", "mz": "N m"}    # columns

DRY_BEHIND = "piston", "flap"    # kinds of bodies with a dry side


class Force(OfPressure):
    """Force [N/m] of the fluid's pressure on a body, and its anticlockwise moment [N m/m].

    The pressure includes its hydrostatic part. With `still` there are also the columns fx_dynamic, fy_dynamic and
    moment_dynamic. These are without the force of water at rest up to the height `still`, rho g (still - y) below it
    and 0 above, on the wall at its place then. They are 0 for water at rest.

    In 3D the force [N] has the columns fx, fy, fz and the moment [N m] mx, my, mz, with the z axis upwards. They are
    integrals of a pressure that is linear on each triangle of the body.

    Friction on the body is not included. The time of a sample is that for which its pressure is solved, the middle of a
    step; with method="SPH", the end.

    A sample is a mean over neighbouring steps, with weights that decrease linearly to 0 at the means before and after.
    These are a step away, or with Numerics(pressure_mean=) at least that many times 2 min(0.3 s/u, 0.02 sqrt(s/a)).
    Here u is the largest speed, and a the largest of the body force, the mean acceleration by pressure and the
    acceleration of walls. Particles do not resolve shorter times. The trapezoidal rule over the samples of all steps
    gives the impulse of the pressure, up to the ends of the run. With method="SPH" a sample is that of one step.

    In an impact the impulse is up to 4 % more than the momentum that the fluid loses: particles of the surface
    represent half a cell, and push as a whole one.

    on : name of the body, also of a Surface; side : of a tank, None for all of it
    about : point of the moment [m]; in 3D (x, z) is a point of the section at y = 0
    still : height of the still level [m], for the dynamic part
    acted : whether to add the force that acts in the step, in the columns fx_acted, fy_acted and moment_acted

    >>> Force("load", side="right", about=(1.0, 0.0)).side
    'right'
    """

    columns = {"fx": "N/m", "fy": "N/m", "moment": "N m/m"}
    impacts = ("fx", "fy", "fz")
    quantity, quantities = "force", {name: "moment" for name in ("moment", "mx", "my", "mz")}

    kind: Literal["force"] = Field(default="force", init=False)
    on: str = Field(default="tank", description="name of the body")
    side: Optional[Literal["left", "right", "bed", "lid", "front", "back"]] = Field(
        default=None, description="side of the tank, front and back in 3D")
    about: Point = (0.0, 0.0)
    still: Optional[float] = Field(default=None, description="height of the still level, for the dynamic part [m]")

    def title(self, scene: ProbeScene) -> str:
        what = f"{self.on}{f', {self.side} side' * bool(self.side)}"
        dynamic = ("" if self.still is None else
                   f"; dynamic: less that of water at rest up to {up(scene.dim)} = {self.still:g} m")
        return (f"Force of the pressure on {what}, and its moment about {point(self.about)} m, with the hydrostatic "
                f"part{dynamic}")

    def columns_in(self, scene: Any) -> dict[str, str]:
        found = dict(self.columns if scene.dim == 2 else IN_3D)
        return found if self.still is None else found | {f"{name}_dynamic": unit for name, unit in found.items()}

    def at_rest(self, scene: ProbeScene, x: Floats) -> Floats:
        """Return the pressure (n,) [Pa] at x (n, dim) [m] of water at rest up to the still level; 0 above it."""
        found: Floats = -scene.density * scene.gravity[-1] * np.maximum((self.still or 0.0) - x[:, -1], 0.0)
        return found

    def problems(self, case: Scene) -> Iterator[str]:
        if case.dim == 2:
            yield from probe_checks.components(case, about=self.about)
        if self.still is not None:
            force = None if case.turns else uniform_field(case.gravity)
            if force is None or force[:-1].any() or not force[-1] < 0.0:
                yield (f"still = {self.still:g}: there is no hydrostatic force unless gravity is constant and straight "
                       "down; leave it out")
        missing = list(probe_checks.body(case, self.on, surfaces=True))
        yield from missing
        if not missing:
            kinds = dict(zip(body_names(case.bodies), (body.kind for body in case.bodies)))
            if kinds.get(self.on) != "tank" and self.side is not None:
                yield f"side = {self.side!r}: only a tank has sides; leave it out"
            elif self.side == "lid" and not case.lidded:
                yield "side = 'lid': the tank has none; give it one, or choose another side"
            elif self.side in ENDS and case.dim == 2:
                yield f"side = {self.side!r}: only a 3D scene has one; choose another side"

    def misplaced(self, places: Places) -> Iterator[str]:
        """See Probe: fluid touches that side of the body."""
        if places.mesh is not None and not len(self.elements(places.mesh)):
            side = "" if self.side is None else f"the {self.side} side of "
            yield f"no fluid touches {side}{self.on}; choose another side or body, or leave the probe out"

    def elements(self, mesh: WallMesh) -> Ints:
        """Return the elements (n, dim) of its body, or of one side of it."""
        return on_side(mesh, [body.name for body in mesh.bodies].index(self.on), self.side)

    def begin(self, scene: ProbeScene) -> Measure:
        return BodyForce(self, scene)


class BodyForce(Measure):
    """Load of the pressure on a body with the present places of its nodes.

    See methods.rigid_bodies.PressureLoad, in 3D methods.surface_load.SurfaceLoad.
    """

    def __init__(self, probe: Force, scene: ProbeScene) -> None:
        self.probe, self.scene, now = probe, scene, scene.now
        assert now is not None    # its body is a wall
        mesh, elements = now.mesh, probe.elements(now.mesh)
        self._load = PressureLoad(mesh, elements) if scene.dim == 2 else SurfaceLoad(mesh, elements)
        self._size, self._about = mesh.x0.shape, np.array(lifted(probe.about, scene.dim))
        self._faces = _faces(scene, now, probe.on) if probe.still is not None else []
        self._bodies = np.unique(mesh.body[[*elements.flat, *(node for face in self._faces for node in face)]])

    def rows(self, view: View) -> Floats:
        """Return a row (node, place, pressure) for each wall particle here that may be a node of the body."""
        wall, node, pressure = node_pressures(view.particles, view.domain.elements)
        rows = np.zeros((len(wall), WIDTH))
        rows[:, 0], rows[:, 1:1 + self.scene.dim], rows[:, -1] = node, view.particles.x[wall], pressure
        return rows[np.isin(view.particles.body[wall], self._bodies)]

    def values(self, sums: Floats, rows: Floats, view: View) -> tuple[float, ...]:
        x, p, node = np.zeros(self._size), np.full(self._size[0], np.inf), rows[:, 0].astype(int)
        x[node], p[node], about = rows[:, 1:1 + self.scene.dim], rows[:, -1], self._about
        found = self._load.of(x, p, about)
        if self.probe.still is None:
            return found
        still = self.probe.at_rest(self.scene, x)
        wet = (still > 0.0) & ~(np.isposinf(p) & self._behind(x))
        rest = self._load.of(x, np.where(np.isnan(p), np.nan, np.where(wet, still, np.inf)), about)
        return (*found, *np.subtract(found, rest))

    def _behind(self, x: Floats) -> Flags:
        """Return whether nodes x (n, dim) [m] are on the dry side of a wavemaker, (n,) bool."""
        found, x = np.zeros(len(x), dtype=bool), section_of(x)
        for start, end in self._faces:
            way, off = x[end] - x[start], x - x[start]
            found |= way[0] * off[:, 1] - way[1] * off[:, 0] < 0.0
        return found


def _faces(scene: ProbeScene, now: WallsNow, on: str) -> list[Ints]:
    """Return the nodes at both ends of the face of each wavemaker except the body `on`.

    Fluid is on the left of the direction from the first to the last.
    """
    mesh, place, found = now.mesh, section_of(now.mesh.x0), []
    for number, body in enumerate(mesh.bodies):
        if body.name != on and scene.kinds.get(body.name) in DRY_BEHIND:
            own = np.unique(mesh.elements[mesh.element_body == number])
            ends = solid_of(now.walls[number]).points[[0, -1]]
            found.append(np.array([own[np.argmin(np.linalg.norm(place[own] - end, axis=1))] for end in ends]))
    return found
