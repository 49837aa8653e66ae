"""Bodies of a scene beside the tank: beds, obstacles and plates, and the still water that lies between them."""

from collections.abc import Sequence
from typing import Annotated, Literal, Optional, Union

import numpy as np
from pydantic import Field, model_validator

from parisph.base.arrays import Floats
from parisph.base.text import shown
from parisph.case.model import Model
from parisph.case.shapes import Shape

Name = Annotated[str, Field(max_length=60, pattern=r"^([A-Za-z][A-Za-z0-9_-]*)?$",
                            description="a name that begins with a letter, of letters, digits, _ and -")]
Slip = Annotated[Literal["free", "none"], Field(description='"free", or "none" where viscous fluid sticks')]
Line = Annotated[tuple[tuple[float, float], ...],
                 Field(min_length=2, max_length=1000, description="points ((x, y), ...) in order [m]")]


class Profile(Model):
    """A bed or a wall, open at both ends: straight lines between points [m], with fluid above it.

    The points may be given either way round. Where the first lies above the last, as at a vertical wall, nothing is
    above: then `side` says on which side of the way along the points the fluid is.

    Examples
    --------
    >>> Profile(points=((0.0, 0.0), (2.0, 0.0), (4.0, 0.5)), name="beach").fluid_on_left
    True
    """

    kind: Literal["profile"] = "profile"
    points: Line
    name: Name = ""
    slip: Slip = "free"
    side: Optional[Literal["left", "right"]] = Field(
        None, description="side of the way from the first to the last point on which the fluid is, None for above")

    @model_validator(mode="after")
    def _one_line(self) -> "Profile":
        _check_line(self.points, closed=False)
        if self.side is None and self.points[0][0] == self.points[-1][0]:
            raise ValueError(f"points: the first and the last have the same x = {self.points[0][0]:g}, so that neither "
                             'side is above; give side="left" or side="right", as seen along the points')
        return self

    @property
    def fluid_on_left(self) -> bool:
        """Whether the fluid is on the left of the way along the points."""
        return self.points[0][0] < self.points[-1][0] if self.side is None else self.side == "left"


class Obstacle(Model):
    """A solid with fluid around it: a Box, Disc or Polygon, which may stand on a bed or overlap other bodies.

    Examples
    --------
    >>> Obstacle(Box(width=0.1, height=0.2, at=(1.0, 0.0)), name="box").slip
    'free'
    """

    kind: Literal["obstacle"] = "obstacle"
    shape: Shape
    name: Name = ""
    slip: Slip = "free"

    @model_validator(mode="after")
    def _one_outline(self) -> "Obstacle":
        if self.shape.kind == "polygon":
            _check_line(self.shape.points, closed=True)
        return self


class Plate(Model):
    """A thin wall without thickness, with fluid on both sides: straight lines between points [m].

    Examples
    --------
    >>> Plate(points=((1.0, 0.0), (1.0, 0.3)), name="baffle", slip="none").name
    'baffle'
    """

    kind: Literal["plate"] = "plate"
    points: Line
    name: Name = ""
    slip: Slip = "free"

    @model_validator(mode="after")
    def _one_line(self) -> "Plate":
        _check_line(self.points, closed=False)
        return self


class StillWater(Model):
    """Water at rest that fills what the walls enclose, up to a level [m].

    Examples
    --------
    >>> StillWater(level=0.3).level
    0.3
    """

    kind: Literal["still_water"] = "still_water"
    level: float = Field(description="height of the water surface [m]")


Body = Annotated[Union[Profile, Obstacle, Plate],
                 Field(discriminator="kind", description="a Profile, Obstacle or Plate")]


def _check_line(points: Sequence[Sequence[float]], closed: bool) -> None:
    """Raise ValueError if two consecutive points are one, or the line through them meets itself."""
    p = np.array(points, dtype=float)
    a, b = (p, np.roll(p, -1, axis=0)) if closed else (p[:-1], p[1:])
    same = np.flatnonzero((a == b).all(axis=1))
    if same.size:
        raise ValueError(f"points: {shown(points[same[0]])} is given twice in a row; leave one out")
    for i in range(len(a) - 1):
        j = _first_met(a, b, i, closed)
        if j is not None:
            one, other = (f"from {shown(tuple(a[k].tolist()))} to {shown(tuple(b[k].tolist()))}" for k in (i, j))
            raise ValueError(f"points: the line {one} meets that {other}; give the points in order along one line")


def _first_met(a: Floats, b: Floats, i: int, closed: bool) -> Optional[int]:
    """Return the first later piece that piece i touches or crosses, other than where they join, or None."""
    j = np.arange(i + 1, len(a))
    before = _side(a[j], b[j], a[i]) * _side(a[j], b[j], b[i]) <= 0.0
    across = _side(a[i], b[i], a[j]) * _side(a[i], b[i], b[j]) <= 0.0
    lower = np.maximum(np.minimum(a[i], b[i]), np.minimum(a[j], b[j]))
    upper = np.minimum(np.maximum(a[i], b[i]), np.maximum(a[j], b[j]))
    met = before & across & (lower <= upper).all(axis=1)
    for next_to, end, start in ((i + 1, b[i], a), (len(a) - 1 if closed and i == 0 else -1, a[i], b)):
        if i < next_to < len(a):    # pieces that join may not fold back on each other
            away, along = (b[next_to] if start is a else a[next_to]) - end, (a[i] if start is a else b[i]) - end
            folded = away[0] * along[1] - away[1] * along[0] == 0.0 and away @ along > 0.0
            met[next_to - i - 1] = folded
    return int(j[met][0]) if met.any() else None


def _side(a: Floats, b: Floats, p: Floats) -> Floats:
    """Return the cross product of b - a and p - a: positive where p lies to the left."""
    return (b[..., 0] - a[..., 0]) * (p[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (p[..., 0] - a[..., 0])
