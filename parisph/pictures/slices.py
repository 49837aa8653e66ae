"""Slices of a 3D flow: the particles near a plane, and the walls in it, as the 2D views draw them."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from parisph.base.arrays import Floats
from parisph.base.errors import CaseError
from parisph.base.fields import WALL
from parisph.base.text import shown
from parisph.case.schema import Case
from parisph.case.sections import section
from parisph.geometry.build import domain, scene_mesh
from parisph.geometry.mesh import WallMesh
from parisph.pictures.frames import PictureFrame

AXES = "xyz"
ROUNDED = 1e-6    # spacings: of two layers half a spacing from the plane, the one at the greater coordinate is shown


def parsed(text: str) -> tuple[int, float]:
    """Return the number of the axis and the place [m] of a slice such as "y=0.47". Raises CaseError."""
    found = re.fullmatch(r"\s*([xyz])\s*=\s*([-+0-9.eE]+)\s*", text)
    try:
        place = float(found[2]) if found else np.nan
    except ValueError:
        place = np.nan
    if found is None or not np.isfinite(place):
        raise CaseError(f"--slice {shown(text)}: must be a coordinate and its value in metres, such as y=0.47")
    return AXES.index(found[1]), place


@dataclass(frozen=True)
class Slice(PictureFrame):
    """A plane across an axis of a 3D scene, in the frame of its tank, as the frame of a picture of points (n, 2).

    scene : the 3D case; room : frame of its points (n, 3); axis : 0, 1 or 2; place : [m]
    """

    scene: Case = field(kw_only=True)
    room: PictureFrame = field(kw_only=True)
    axis: int = field(kw_only=True)
    place: float = field(kw_only=True)

    @classmethod
    def through(cls, case: Case, frame: str, text: str | None) -> "Slice":
        """Return the slice that a text such as "y=0.47" names, or the middle of the breadth. Raises CaseError."""
        lower, upper = _bounds(case)
        axis, place = (1, float(0.5 * sum(case.breadth or (lower[1], upper[1])))) if text is None else parsed(text)
        if not lower[axis] <= place <= upper[axis]:
            raise CaseError(f"--slice {AXES[axis]}={place:g}: nothing is there; the scene reaches from {AXES[axis]} = "
                            f"{lower[axis]:g} to {upper[axis]:g} m")
        room = PictureFrame.of(case, frame)
        down = room.gravity[[0, 2]] if axis == 1 and room.gravity is not None else None
        return cls(room.motion, room.world, down, 3, scene=case, room=room, axis=axis, place=place)

    @property
    def names(self) -> tuple[str, str]:
        """The names of the axes of the picture."""
        across, up = self._shown
        return AXES[across], AXES[up]

    @property
    def said(self) -> str:
        """The slice as text, "y = 0.47 m"."""
        return f"${AXES[self.axis]}$ = {self.place:.4g} m"

    @cached_property
    def section(self) -> Case | None:
        """The 2D scene of the plane, whose outlines are its walls; None across x or z, and without walls."""
        if self.axis != 1 or not self.scene.bodies:
            return None
        found = section(self.scene, self.place, self.place)
        return found.model_copy(update={"probes": self.scene.probes})

    def box(self) -> tuple[Floats, Floats]:
        """Return the lower and upper corner (2,) [m] of the picture around all walls and the fluid at the start."""
        lower, upper = domain(self.scene)
        return lower[list(self._shown)], upper[list(self._shown)]

    def flat(self, x: Floats) -> Floats:
        """Return the two components (n, 2) of vectors (n, 3) in the picture."""
        found: Floats = x[:, list(self._shown)]
        return found

    def placed(self, x: Floats, time: float) -> Floats:
        """Return places (n, 2) [m] of the slice in the picture at a time [s]."""
        if not self.moved:
            return np.asarray(x)
        whole = np.full((len(x), 3), self.place)
        whole[:, list(self._shown)] = x
        return self.flat(self.room.placed(whole, time))

    def near(self, snapshot: Mapping[str, Any]) -> dict[str, Any]:
        """Return the particles within half a spacing of the plane, as a snapshot in 3D."""
        away = (snapshot["x"][:, self.axis] - self.place) / self.scene.numerics.spacing - ROUNDED
        rows = (away > -0.5) & (away <= 0.5)
        return {name: value[rows] if isinstance(value, np.ndarray) and len(value) == len(rows) else value
                for name, value in snapshot.items()}

    def snapshot(self, snapshot: Mapping[str, Any]) -> dict[str, Any]:
        """Return the particles near the plane of a snapshot in 3D, with x (m, 2) [m]; velocities keep (m, 3)."""
        found = self.room.snapshot(self.near(snapshot))
        return {**found, "x": self.flat(found["x"])}

    def walls(self, snapshot: Mapping[str, Any]) -> Floats:
        """Return the cuts of the walls without an outline in the section, (k, 2, 2) [m] in the picture."""
        ends = self.cut(snapshot).reshape(-1, 3)
        return self.flat(self.room.placed(ends, snapshot["time"])).reshape(-1, 2, 2)

    def cut(self, snapshot: Mapping[str, Any]) -> Floats:
        """Return the straight pieces (k, 2, 3) [m] in which the elements of walls without outline cross the plane."""
        mesh, nodes = self._mesh, snapshot["x"][snapshot["kind"] == WALL]    # in the order of the nodes
        if mesh is None or len(nodes) != len(mesh.x0):
            return np.empty((0, 2, 3))
        elements = mesh.elements
        if self.section is not None:    # Surfaces follow the other bodies
            first = len(mesh.bodies) - len(self.scene.surfaces)
            elements = elements[mesh.element_body >= first]
        return crossing(nodes[elements], self.axis, self.place)

    @property
    def _shown(self) -> tuple[int, int]:
        """The numbers of the axes of the picture: across it, and up."""
        across, up = (axis for axis in range(3) if axis != self.axis)
        return across, up

    @cached_property
    def _mesh(self) -> WallMesh | None:
        needed = self.section is None or self.scene.surfaces
        return scene_mesh(self.scene) if needed else None


def _bounds(case: Case) -> tuple[Floats, Floats]:
    """Return lower and upper corner (3,) [m] of a box around walls and fluid at the start."""
    boxes = [case.fluid_bounds, *([case.wall_bounds] if case.wall_bounds is not None else [])]
    return np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)


def crossing(corners: Floats, axis: int, place: float) -> Floats:
    """Return the straight pieces (k, 2, 3) in which triangles (m, 3, 3) cross the plane x[axis] = place.

    A corner on the plane counts as one above it, so that a triangle has two ends or none.
    """
    away = corners[:, :, axis] - place
    above = away >= 0.0
    crossed = above.any(axis=1) & ~above.all(axis=1)
    x, away, above = corners[crossed], away[crossed], above[crossed]
    after = [1, 2, 0]
    parted = above != above[:, after]    # two of three sides
    with np.errstate(divide="ignore", invalid="ignore"):
        share = away / (away - away[:, after])
    met = x + np.where(parted, share, 0.0)[:, :, None] * (x[:, after] - x)
    found: Floats = met[parted].reshape(-1, 2, 3)
    return found
