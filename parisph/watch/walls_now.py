"""The walls of a scene at any time, for probes."""

from collections.abc import Sequence

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.motion import AtRest, Motion, Translation
from parisph.geometry.columns import beds, crossings
from parisph.geometry.mesh import WallMesh, motions_of
from parisph.geometry.solid import Wall
from parisph.geometry.upper_faces import UpperFaces

BESIDE = 1e-6    # distance beside the end of a wall at which its floor is sought, over the width of the walls


class WallsNow:
    """Elements and bodies of the walls at a time. Not collective.

    mesh : of the walls; walls : geometry.spans.scene_walls of a case
    """

    def __init__(self, mesh: WallMesh, walls: Sequence[Wall]) -> None:
        self.mesh, self.walls, motions = mesh, walls, motions_of(walls)
        self._motions = motions
        self._known: tuple[float, Floats] = (0.0, mesh.corners())
        # at the known time
        self._floors: dict[tuple[float, ...], Floats] = {}    # by place
        self._faces: UpperFaces | None = None    # 3D
        moving = np.array([body.motion for body in mesh.bodies])[mesh.body]
        self._moving = [(motions[number], np.flatnonzero(moving == number)) for number in np.unique(moving[moving > 0])]

    @property
    def moving(self) -> bool:
        """Whether any wall moves."""
        return bool(self._moving)

    def corners(self, time: float) -> Floats:
        """Return the corners (M, dim, dim) [m] of the elements at a time [s]."""
        if self.moving and time != self._known[0]:    # computed once for all gauges
            x = self.mesh.x0.copy()
            for motion, own in self._moving:
                x[own] = motion.placed(x[own], time)
            self._known, self._floors, self._faces = (time, self.mesh.corners(x)), {}, None
        return self._known[1]

    def bed(self, places: Floats, time: float) -> Floats:
        """Return the height (n,) [m] of the highest wall with fluid above it, as `columns.beds`.

        places : (n, dim - 1) [m], x, in 3D (x, y)
        """
        if self.mesh.dim == 3:
            return self._upper(time).highest(places)
        return beds(self.corners(time), places[:, 0], np.inf)

    def floors(self, place: tuple[float, ...], time: float) -> Floats:
        """Return the heights (n,) [m], upwards, of all walls with fluid above them at (x,), in 3D (x, y) [m].

        Where there is none, as beyond the end of a bed, it is that of the lowest wall.
        """
        corners = self.corners(time)
        if place not in self._floors:
            self._floors[place] = (self._found_floors(corners, place[0]) if self.mesh.dim == 2 else
                                   self._upper(time).heights(np.array(place)))
        return self._floors[place]

    def _upper(self, time: float) -> UpperFaces:
        corners = self.corners(time)
        self._faces = self._faces or UpperFaces(corners)
        return self._faces

    def _found_floors(self, corners: Floats, at: float) -> Floats:
        up, aside = corners[corners[:, 0, 0] < corners[:, 1, 0]], BESIDE * float(np.ptp(self.mesh.x0[:, 0]))
        for place in (at, at - aside, at + aside):
            found = crossings(up[:, 0], up[:, 1], np.array([place]))[1]
            if len(found):
                return np.sort(found)
        return np.array([corners[:, :, 1].min()])

    def number(self, name: str) -> int:
        """Return the number of the body of this name."""
        return [body.name for body in self.mesh.bodies].index(name)

    def motion_of(self, number: int) -> Motion:
        """Return the motion of a body."""
        return self._motions[self.mesh.bodies[number].motion]

    def upright(self, number: int) -> bool:
        """Whether vertical sides of a body stay vertical."""
        return isinstance(self.motion_of(number), (AtRest, Translation))
