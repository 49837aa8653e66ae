"""The walls of a scene at any time, for probes (2D)."""

from collections.abc import Sequence

import numpy as np

from parisph.base.arrays import Floats
from parisph.case.motion import AtRest, Motion, Translation
from parisph.geometry.columns import beds, crossings
from parisph.geometry.mesh import WallMesh, motions_of
from parisph.geometry.solid import Wall

BESIDE = 1e-6    # distance beside the end of a wall at which its floor is sought, over the width of the walls


class WallsNow:
    """Elements and bodies of the walls at a time. Not collective.

    mesh : of the walls; walls : geometry.standing.standing of a case
    """

    def __init__(self, mesh: WallMesh, walls: Sequence[Wall]) -> None:
        self.mesh, self.walls, motions = mesh, walls, motions_of(walls)
        self._motions = motions
        self._known: tuple[float, Floats] = (0.0, mesh.corners())
        self._floors: dict[float, Floats] = {}    # at the known time, by place
        moving = np.array([body.motion for body in mesh.bodies])[mesh.body]
        self._moving = [(motions[number], np.flatnonzero(moving == number)) for number in np.unique(moving[moving > 0])]

    @property
    def moving(self) -> bool:
        """Whether any wall moves."""
        return bool(self._moving)

    def corners(self, time: float) -> Floats:
        """Return the corners (M, 2, 2) [m] of the elements at a time [s]."""
        if self.moving and time != self._known[0]:    # computed once for all gauges
            x = self.mesh.x0.copy()
            for motion, own in self._moving:
                x[own] = motion.placed(x[own], time)
            self._known, self._floors = (time, self.mesh.corners(x)), {}
        return self._known[1]

    def bed(self, x: Floats, time: float) -> Floats:
        """Return the height (n,) [m] of the highest wall with fluid above it at x (n,), as `columns.beds`."""
        return beds(self.corners(time), x, np.inf)

    def floors(self, at: float, time: float) -> Floats:
        """Return the heights (n,) [m], upwards, of all walls with fluid above them at x = `at` [m].

        Where there is none, as beyond the end of a bed, it is that of the lowest wall.
        """
        corners = self.corners(time)
        if at not in self._floors:
            self._floors[at] = self._found_floors(corners, at)
        return self._floors[at]

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
