"""A drop in 3D: an ellipsoid of fluid, and the ellipses that are its sections."""

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from parisph.base.arrays import Flags, Floats
from parisph.case.breadth import Spread
from parisph.case.shapes import Length, Shape

LEAST = 1e-9    # of a half axis: that of a section at an end


class Ellipse(Spread):
    """A section of an Ellipsoid: half axes [m] along x and upwards about a centre [m]. It exists in sections only."""

    kind: Literal["ellipse"] = Field(default="ellipse", init=False)
    axes: tuple[Length, Length]
    at: tuple[float, float]

    @property
    def area(self) -> float:
        """[m2]"""
        return np.pi * self.axes[0] * self.axes[1]

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corner of the bounding box, (2,) each [m]."""
        return np.subtract(self.at, self.axes), np.add(self.at, self.axes)

    def inside(self, x: Floats, tolerance: float) -> Flags:
        """Return which of the points x (n, 2) [m] lie in the ellipse with both half axes longer by tolerance [m]."""
        return _inside(x - np.array(self.at), np.array(self.axes) + tolerance)


class Ellipsoid(Spread):
    """An ellipsoid of fluid in 3D, a drop: half axes `axes` [m] along x, y and z about its centre `at` (x, y, z) [m].

    With equal half axes it is a ball. Without walls, one is enough to make a scene 3D.

    >>> drop = Ellipsoid(axes=(0.5, 0.4, 0.3), at=(1.0, 0.0, 2.0))
    >>> print(f"{drop.volume:.4f} m3, y from {drop.extent[0]:g} to {drop.extent[1]:g} m")
    0.2513 m3, y from -0.4 to 0.4 m
    """

    kind: Literal["ellipsoid"] = Field(default="ellipsoid", init=False)
    axes: Annotated[tuple[Length, Length, Length], Field(description="half axes (a, b, c) along x, y and z [m]")]
    at: Annotated[tuple[float, float, float], Field(description="centre (x, y, z) [m]")] = (0.0, 0.0, 0.0)

    @property
    def volume(self) -> float:
        """[m3]"""
        return 4.0 / 3.0 * np.pi * float(np.prod(self.axes))

    @property
    def area(self) -> float:
        """Mean area of its sections [m2]."""
        return self.volume / (2.0 * self.axes[1])

    @property
    def extent(self) -> tuple[float, float]:
        """Ends across [m]."""
        return self.at[1] - self.axes[1], self.at[1] + self.axes[1]

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corner of the bounding box, (3,) each [m]."""
        return np.subtract(self.at, self.axes), np.add(self.at, self.axes)

    def inside(self, x: Floats, tolerance: float) -> Flags:
        """Return which of the points x (n, 3) [m] lie in the ellipsoid with half axes longer by tolerance [m]."""
        return _inside(x - np.array(self.at), np.array(self.axes) + tolerance)

    def section(self, y: float) -> Ellipse:
        """Return its section in the plane at y [m], next to nothing at its ends and beyond."""
        size = max(float(np.sqrt(max(1.0 - self._from_centre(y) ** 2, 0.0))), LEAST)
        return Ellipse(axes=(size * self.axes[0], size * self.axes[2]), at=(self.at[0], self.at[2]))

    def slice_area(self, low: float, high: float) -> float:
        """Return the mean area [m2] of its sections between low and high [m], which are not beyond its ends."""
        a, b = self._from_centre(low), self._from_centre(high)
        return np.pi * self.axes[0] * self.axes[2] * (1.0 - (a * a + a * b + b * b) / 3.0)

    def _from_centre(self, y: float) -> float:
        return (y - self.at[1]) / self.axes[1]


AnyShape = Shape | Ellipse | Ellipsoid    # of fluid; the sections of an Ellipsoid are Ellipses


def _inside(x: Floats, axes: Floats) -> Flags:
    """Return which of the points x (n, m) [m] lie within half axes (m,) [m]: none if one of these is not positive."""
    if not np.all(axes > 0.0):
        return np.zeros(len(x), dtype=bool)
    found: Flags = np.sum((x / axes) ** 2, axis=1) <= 1.0
    return found
