"""The interface of all waves: elevation and velocity at any place and time.

Waves are data of a case. The same record gives a start, the truth of a gauge, and the motion of a wavemaker.
x is in the scene, y is measured from the bed, elevations from the still surface, and t = 0 is the start of the run.
In 3D, x of `elevation` and `velocity` is measured along the direction of the wave, from the origin of the scene;
`surface` and `flow` take places in the scene. SI units; g is the acceleration of gravity.
"""

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import AfterValidator, Field, SerializerFunctionWrapHandler, model_serializer

from parisph.base.arrays import Floats
from parisph.base.text import shown
from parisph.case.model import Model
from parisph.case.values import SMALLEST


def _level(direction: tuple[float, ...] | None) -> tuple[float, ...] | None:
    if direction is not None and not (direction[2] == 0.0 and np.linalg.norm(direction) >= SMALLEST):
        raise ValueError(f"{shown(direction)}: must be horizontal and not zero; give (x, y, 0), for example (1, 1, 0)")
    return direction


Depth = Annotated[float, Field(gt=0, description="depth of the still water [m]")]
Height = Annotated[float, Field(gt=0, description="height from trough to crest [m]")]
Period = Annotated[float, Field(gt=0, description="period [s]")]
Gravity = Annotated[float, Field(gt=0, description="acceleration of gravity [m/s2]")]
Place = Annotated[float, Field(description="position x of a crest at t = 0 [m]")]
Leftward = Annotated[bool, Field(description="whether the wave runs towards -x")]
Level = Annotated[tuple[float, float, float] | None, AfterValidator(_level)]


class WaveField(Model):
    """A wave on water of uniform `depth` [m] at rest, under gravity `g` [m/s2].

    direction : None, or (x, y, 0), the way along which the wave runs in a 3D scene; any length
    """

    direction: Level = Field(default=None, kw_only=True,
                             description="horizontal direction (x, y, 0) in a 3D scene, None for that of x")

    if TYPE_CHECKING:    # fields of each subclass
        @property
        def depth(self) -> float: ...
        @property
        def g(self) -> float: ...

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        cls.model_fields["direction"] = cls.model_fields.pop("direction")    # after those that may be given by position

    @model_serializer(mode="wrap")
    def _as_before(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out a direction that is not given: releases before 3D do not know it."""
        return {name: value for name, value in handler(self).items() if name != "direction" or value is not None}

    @property
    def varies_across(self) -> bool:
        """Whether the wave is not the same all across a 3D scene."""
        return self.direction is not None and self.direction[1] != 0.0

    @property
    def way(self) -> tuple[float, float]:
        """The unit vector (x, y) of its direction."""
        if self.direction is None:
            return 1.0, 0.0
        size = float(np.hypot(*self.direction[:2]))
        return self.direction[0] / size, self.direction[1] / size

    def along(self, x: ArrayLike, y: ArrayLike | None = None) -> Floats:
        """Return the distance [m] along the wave of places x, in 3D x and y [m], from the origin of the scene."""
        if y is None or self.direction is None:
            return np.asarray(x, dtype=float)
        found: Floats = self.way[0] * np.asarray(x, dtype=float) + self.way[1] * np.asarray(y, dtype=float)
        return found

    def surface(self, x: ArrayLike, y: ArrayLike | None, t: ArrayLike) -> Floats:
        """Return the elevation [m] at x, in 3D x and y [m] (None in 2D), and t [s], which broadcast."""
        return self.elevation(self.along(x, y), t)

    def flow(self, x: Floats, bed: float, t: float) -> Floats:
        """Return the velocity (n, dim) [m/s] at places x (n, dim) [m] above a bed at a height [m], at t [s]."""
        across = None if x.shape[1] == 2 else x[:, 1]
        u, v = self.velocity(self.along(x[:, 0], across), x[:, -1] - bed, t)
        return np.stack([u, v] if across is None else [self.way[0] * u, self.way[1] * u, v], axis=1)

    @abstractmethod
    def elevation(self, x: ArrayLike, t: ArrayLike) -> Floats:
        """Return the elevation [m] of the surface at x [m] and t [s], which broadcast."""

    @abstractmethod
    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> tuple[Floats, Floats]:
        """Return the velocity (u, v) [m/s] at x, y [m] and t [s], which broadcast; y is the height above the bed."""


class Travelling(WaveField):
    """A wave of permanent form, with a crest at x = `at` when t = 0."""

    if TYPE_CHECKING:    # fields of each subclass; as fields of this class they would come first
        @property
        def at(self) -> float: ...
        @property
        def leftward(self) -> bool: ...

    @property
    @abstractmethod
    def celerity(self) -> float:
        """Speed of the crests [m/s]."""

    @abstractmethod
    def _profile(self, ahead: Floats) -> Floats:
        """Return the elevation [m] at a distance ahead of the crest [m]."""

    @abstractmethod
    def _flow(self, ahead: Floats, y: Floats) -> tuple[Floats, Floats]:
        """Return the velocity (u, v) [m/s] of a wave towards +x, at distances ahead of the crest and heights y [m]."""

    def elevation(self, x: ArrayLike, t: ArrayLike) -> Floats:
        return self._profile(self._ahead(x, t))

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> tuple[Floats, Floats]:
        ahead, y = np.broadcast_arrays(self._ahead(x, t), np.asarray(y, dtype=float))
        u, v = self._flow(ahead, y)
        return self._sign * u, v

    @property
    def _sign(self) -> float:
        return -1.0 if self.leftward else 1.0

    def _ahead(self, x: ArrayLike, t: ArrayLike) -> Floats:
        """Return the distance [m] of x from the crest, positive in the direction of the wave."""
        ahead: Floats = self._sign * (np.asarray(x, dtype=float) - self.at) - self.celerity * np.asarray(t, dtype=float)
        return ahead


def no_higher(height: float, most: float, where: str, remedy: str) -> None:
    """Raise ValueError if the height of a wave exceeds `most` [m]; where : meaning of `most`."""
    if not height <= most:
        raise ValueError(f"height = {shown(height)}: must be at most {most:.4g} m, {where}; {remedy}")


def steepest(depth: float, length: float) -> float:
    """Return the height [m] of the highest steady wave of a length [m] in water of a depth [m].

    Fit of Williams' results by Fenton (1990, Eq 32), within 1 %.
    """
    ratio = length / depth
    return (
        depth
        * (0.141063 * ratio + 0.0095721 * ratio**2 + 0.0077829 * ratio**3)
        / (1.0 + 0.0788340 * ratio + 0.0317567 * ratio**2 + 0.0093407 * ratio**3)
    )


class InSection(WaveField):
    """The part in a section of a 3D scene, the plane at y [m], of a wave that is not the same all across."""

    of: WaveField
    y: float

    @property
    def depth(self) -> float:
        return self.of.depth

    @property
    def g(self) -> float:
        return self.of.g

    def elevation(self, x: ArrayLike, t: ArrayLike) -> Floats:
        return self.of.surface(x, self.y, t)

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> tuple[Floats, Floats]:
        u, v = self.of.velocity(self.of.along(x, self.y), y, t)
        return self.of.way[0] * u, v
