"""Where vertical lines meet the walls with fluid above them (3D).

Triangles are sorted into square bins over their bounds, so a line is tested against the few triangles of its bin.
"""

import numpy as np

from parisph.base.arrays import Floats, Ints
from parisph.geometry.distance import area_vectors

LEVEL = 1e-9    # least vertical part of a unit normal: a triangle with less is vertical
EDGE = 1e-6     # of a triangle: a line that misses it by less meets it, so it cannot pass between two neighbours
SAME = 1e-9     # of the extent of the walls: heights that differ by less are one


class UpperFaces:
    """The elements of a mesh that have fluid above them.

    corners : (M, 3, 3) [m] of all elements, with the fluid on the side of their normals
    """

    def __init__(self, corners: Floats) -> None:
        normal = area_vectors(corners)
        up = corners[normal[:, 2] > LEVEL * np.linalg.norm(normal, axis=1)]
        self.lowest = float(corners[:, :, 2].min())
        self._same = SAME * float(np.ptp(corners.reshape(-1, 3), axis=0).max())
        self._corners = up
        low, high = up[:, :, :2].min(axis=1), up[:, :, :2].max(axis=1)
        self._bin = (1.0 + 1e-3) * float((high - low).max(initial=0.0)) or 1.0
        self._origin = low.min(axis=0, initial=0.0) - self._bin
        first, last = (np.floor((end - self._origin) / self._bin + slack).astype(np.int64)
                       for end, slack in ((low, -EDGE), (high, EDGE)))
        self._across = int(last[:, 1].max(initial=0)) + 2
        # a triangle is shorter than a bin, so it lies in at most two by two
        keys = np.concatenate([((first[:, 0] + a) * self._across + first[:, 1] + b)
                               for a in (0, 1) for b in (0, 1)])
        there = np.concatenate([(first[:, 0] + a <= last[:, 0]) & (first[:, 1] + b <= last[:, 1])
                                for a in (0, 1) for b in (0, 1)])
        number = np.tile(np.arange(len(up)), 4)[there]
        order = np.argsort(keys[there], kind="stable")
        self._keys, self._number = keys[there][order], number[order]

    def crossings(self, at: Floats) -> tuple[Ints, Floats]:
        """Return where vertical lines at (n, 2) [m] meet these elements: line (k,), height (k,) [m].

        A line through an edge meets the elements on both sides.
        """
        place = np.floor((at - self._origin) / self._bin).astype(np.int64)
        key = np.where((place[:, 1] >= 0) & (place[:, 1] < self._across), place[:, 0] * self._across + place[:, 1], -1)
        first = np.searchsorted(self._keys, key)
        count = np.searchsorted(self._keys, key, side="right") - first
        line = np.repeat(np.arange(len(at)), count)
        own = self._number[np.arange(len(line)) - np.repeat(np.cumsum(count) - count - first, count)]
        a, b, c = np.moveaxis(self._corners[own], 1, 0)
        (bx, by), (cx, cy), (px, py) = ((end - a[:, :2]).T for end in (b[:, :2], c[:, :2], at[line]))
        whole = bx * cy - by * cx
        second, third = (px * cy - py * cx) / whole, (bx * py - by * px) / whole
        met = (second >= -EDGE) & (third >= -EDGE) & (second + third <= 1.0 + EDGE)
        height = a[:, 2] + second * (b[:, 2] - a[:, 2]) + third * (c[:, 2] - a[:, 2])
        return line[met], height[met]

    def highest(self, at: Floats) -> Floats:
        """Return the greatest height (n,) [m] at which lines at (n, 2) [m] meet these elements.

        Where there is none, as beyond the end of a bed, it is that of the lowest wall.
        """
        found = np.full(len(at), -np.inf)
        np.maximum.at(found, *self.crossings(at))
        return np.where(np.isfinite(found), found, self.lowest)

    def heights(self, at: Floats) -> Floats:
        """Return all heights (k,) [m], upwards, at which the line at (2,) [m] meets these elements, each once.

        Without any: the height of the lowest wall.
        """
        found = np.sort(self.crossings(at[None])[1])
        if not len(found):
            return np.array([self.lowest])
        once: Floats = found[np.concatenate([[True], np.diff(found) > self._same])]
        return once
