"""The fluid at the start of a scene with Surfaces: the points of the scene without them that are in the room."""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from parisph.base.arrays import Flags, Floats, Ints
from parisph.case.bodies import StillWater
from parisph.case.scene import Scene
from parisph.geometry.distance import area_vectors, nearest
from parisph.geometry.fill import CUT, ROUNDING
from parisph.geometry.layers import LayeredFilling
from parisph.geometry.scene_room import in_room, room_mesh, scene_room

CHUNK = 2**20    # points looked at together


class RoomFilling(LayeredFilling):
    """The points of a LayeredFilling that are in the room of its scene, CUT spacings or more from its Surfaces."""

    def __init__(self, case: Scene, number: int) -> None:
        super().__init__(case, number)
        self.even = False
        parts = [low + np.flatnonzero(self._free(super(RoomFilling, self).indices(low, low + CHUNK)))
                 for low in range(0, self.count, CHUNK)]
        self._kept: Ints = np.concatenate([np.empty(0, np.int64), *parts])
        self.count = len(self._kept)

    def _free(self, index: Ints) -> Flags:
        x, s = self.position(index), self.spacing
        found = in_room(self.case, x)
        apart = nearest(x[found], scene_room(self.case).corners, CUT * s)[0]
        found[found] = apart >= (CUT - ROUNDING) * s
        return found

    def indices(self, start: int = 0, stop: int | None = None) -> Ints:
        """Return the lattice indices (n, 3) of points start to stop: along x, of the layer, upwards."""
        number = self._kept[start:self.count if stop is None else stop]
        if not len(number):
            return np.empty((0, 3), np.int64)
        found: Ints = super().indices(int(number[0]), int(number[-1]) + 1)[number - number[0]]
        return found

    def samples(self, lower: Floats, upper: Floats, box: tuple[Floats, Floats]) -> Iterator[tuple[Floats, Floats]]:
        """Yield sample places (m, 3) [m] of the raised fluid in a part of the scene, and the volume (m,) [m3] of each.

        lower, upper : (3,) [m], corners of the part; box : of the whole scene
        """
        for places, volume in super().samples(lower, upper, box):
            inside = in_room(self.case, places)
            yield places[inside], volume[inside]

    def volume(self, box: tuple[Floats, Floats]) -> float:
        """Return the volume [m3] of the fluid: exactly that of still water, else from samples.

        box : corners (3,) [m] of the scene
        """
        fluid, alone = self.case.fluids[self.number], len(self.case.fluids) == 1 and not self._moving()
        if alone and isinstance(self.shape, StillWater) and not fluid.raised and not fluid.holes:
            return below(scene_room(self.case).corners, self.shape.level)
        return sum(float(volume.sum()) for _, volume in self.samples(*box, box))

    def _moving(self) -> bool:
        return any(body.motion > 0 for body in room_mesh(self.case).bodies)


@lru_cache(maxsize=4)
def room_fillings(case: Scene) -> tuple[RoomFilling, ...]:
    """Return the RoomFilling of each body of fluid of a scene with Surfaces. Cached."""
    return tuple(RoomFilling(case, number) for number in range(len(case.fluids)))


def below(corners: Floats, level: float) -> float:
    """Return the volume [m3] of a room up to a level [m]: the sum of the depths of water over floors, less ceilings.

    corners : (M, 3, 3) [m], with normals into the room. The integral of a positive linear function over a triangle is
    its area times the mean of the values at its corners; one that is negative at a part of it is cut there.
    """
    depth = np.sort(level - corners[:, :, 2], axis=1)[:, ::-1]
    a, b, c = depth.T    # descending
    plan, none = area_vectors(corners)[:, 2], np.zeros(len(corners))
    with np.errstate(divide="ignore", invalid="ignore"):
        one = a / 3.0 * (a / (a - b)) * (a / (a - c))           # only the first corner is below the level
        two = (a + b + c) / 3.0 - c / 3.0 * (c / (c - a)) * (c / (c - b))
    mean = np.where(a <= 0.0, none, np.where(b <= 0.0, one, np.where(c < 0.0, two, (a + b + c) / 3.0)))
    return float(np.sum(plan * mean))
