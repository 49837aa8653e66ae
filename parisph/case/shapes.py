"""The shapes of a scene, and the tank."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Union

import numpy as np
from pydantic import AfterValidator, Field, ValidationInfo, field_validator, model_validator

from parisph.base.arrays import Flags, Floats
from parisph.base.text import shown
from parisph.case.breadth import Across, Breadth, Spread, flat, section_of, solid_box, within
from parisph.case.model import Model, Several
from parisph.case.motion import AnyMotion, AtRest

if TYPE_CHECKING:
    from typing_extensions import Self

def _in_the_section(point: tuple[float, ...]) -> tuple[float, ...]:
    if len(point) == 3:
        raise ValueError(f"{point} has three components: a Disc in 3D is a cylinder across the scene; give its centre "
                         "(x, z), and its ends across=(ya, yb)")
    return point


Length = Annotated[float, Field(gt=0, description="a length [m]")]
Point = Annotated[
    tuple[float, ...],
    Field(min_length=2, max_length=3, description="a point (x, y) [m], in 3D (x, y, z) or (x, z)"),
]
Centre = Annotated[
    tuple[float, ...],
    Field(min_length=2, max_length=3, description="a centre (x, y) [m], in 3D (x, z)"),
    AfterValidator(_in_the_section),
]
Slip = Annotated[Literal["free", "none"], Field(description='"free", or "none" where viscous fluid sticks')]
Name = Annotated[str, Field(max_length=60, pattern=r"^([A-Za-z][A-Za-z0-9_-]*)?$",
                            description="a name that begins with a letter, of letters, digits, _ and -")]


class _Block(Spread):
    """Base of Box and Tank: a rectangle in the section, which may have a breadth."""

    if TYPE_CHECKING:    # fields of each class; as fields of this class they would come first
        @property
        def width(self) -> float: ...
        @property
        def height(self) -> float: ...
        @property
        def at(self) -> tuple[float, ...]: ...
        @property
        def breadth(self) -> float | None: ...

    @model_validator(mode="after")
    def _placed_across(self) -> "Self":
        if len(self.at) == 3 and self.breadth is None:
            raise ValueError(f"at = {self.at}: has three components, of which y is across a 3D scene; give breadth=, "
                             f"or at={flat(self.at)} in the section")
        return self

    @property
    def extent(self) -> tuple[float, float] | None:
        """Ends across a 3D scene [m], or None for its whole breadth."""
        if self.breadth is None:
            return None
        start = self.at[1] if len(self.at) == 3 else 0.0
        return start, start + self.breadth

    @property
    def size(self) -> Floats:
        """Edge lengths (dim,) [m]; those of the section without a breadth."""
        return np.array([self.width, self.height] if self.breadth is None
                        else [self.width, self.breadth, self.height])

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corner, (dim,) each [m]; those of the section without a breadth."""
        lower = np.array(self.at)
        if self.breadth is not None and len(self.at) == 2:
            lower = np.insert(lower, 1, 0.0)
        return lower, lower + self.size


class Box(_Block):
    """A rectangle of fluid: width x height [m], with its lower left corner `at` [m].

    In 3D it is a block across the whole scene, or, with a `breadth` [m], from y to y + breadth: `at` is (x, y, z), or
    (x, z) with y = 0.

    >>> Box(width=2.0, height=0.5, at=(0.0, 0.1)).area
    1.0
    >>> Box(width=2.0, height=0.5, breadth=0.4, at=(0.0, 0.3, 0.1)).extent
    (0.3, 0.7)
    """

    kind: Literal["box"] = Field(default="box", init=False)
    width: Length
    height: Length
    at: Point = (0.0, 0.0)
    breadth: Breadth = None

    @property
    def area(self) -> float:
        """Area of its section [m2]."""
        return self.width * self.height

    def inside(self, x: Floats, tolerance: float) -> Flags:
        """Return which of the points x (n, dim) [m] lie in the closed box, widened by tolerance [m]."""
        lower, upper = self.bounds
        if x.shape[1] != len(lower):
            x, lower, upper = section_of(x), section_of(lower), section_of(upper)
        found: Flags = np.all((x >= lower - tolerance) & (x <= upper + tolerance), axis=1)
        return found


class Disc(Spread):
    """A disc of fluid: radius [m] about its centre `at` [m].

    In 3D it is a cylinder across the whole scene, or from ya to yb with `across=(ya, yb)` [m]; its centre is (x, z).

    >>> print(f"{Disc(radius=0.5, at=(1.0, 1.0)).area:.4f} m2")
    0.7854 m2
    """

    kind: Literal["disc"] = Field(default="disc", init=False)
    radius: Length
    at: Centre = (0.0, 0.0)
    across: Across = None
    edges: ClassVar[int] = 1

    @property
    def area(self) -> float:
        """[m2]"""
        return np.pi * self.radius**2

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corner of the bounding box, (dim,) each [m]; those of the section if across is None."""
        centre = np.array(self.at)
        return solid_box(centre - self.radius, centre + self.radius, self.across)

    def inside(self, x: Floats, tolerance: float) -> Flags:
        """Return which of the points x (n, dim) [m] lie in the closed disc, widened by tolerance [m]."""
        found: Flags = np.linalg.norm(section_of(x) - np.array(self.at), axis=1) <= self.radius + tolerance
        return found & within(x, self.across, tolerance)


class Polygon(Spread):
    """A polygon of fluid, by its corners in order [m], in either direction.

    In 3D it is a prism across the whole scene, or from ya to yb with `across=(ya, yb)` [m]; its corners are (x, z).

    >>> Polygon(points=((0.0, 0.0), (1.0, 0.0), (0.0, 0.5))).area
    0.25
    """

    kind: Literal["polygon"] = Field(default="polygon", init=False)
    points: Annotated[Several[tuple[float, ...]], Field(
        min_length=3, max_length=1000, description="corners ((x, y), ...) in order [m]")]
    across: Across = None

    @field_validator("points")
    @classmethod
    def _encloses(cls, points: tuple[tuple[float, ...], ...]) -> tuple[tuple[float, ...], ...]:
        if any(len(point) != 2 for point in points):
            raise ValueError("every corner must have two coordinates (x, y), in 3D (x, z): a Polygon is then a prism "
                             "with the ends across=(ya, yb)")
        if np.linalg.matrix_rank(np.array(points) - points[0]) < 2:
            raise ValueError("the corners enclose no area: give at least three that are not on one line")
        return points

    @model_validator(mode="after")
    def _uncrossed(self, info: ValidationInfo) -> "Polygon":
        points = list(self.points)
        if not info.context:    # an earlier run, opened only for reading, may have such a polygon
            check_line([p for p, last in zip(points, points[-1:] + points[:-1]) if p != last], True, False)
        return self

    @property
    def edges(self) -> int:
        """Number of edges."""
        return len(self.points)

    @property
    def area(self) -> float:
        """[m2]"""
        return _area(self.points)

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corner of the bounding box, (dim,) each [m]; those of the section if across is None."""
        points = np.array(self.points)
        return solid_box(points.min(axis=0), points.max(axis=0), self.across)

    def inside(self, x: Floats, tolerance: float) -> Flags:
        """Return which of the points x (n, dim) [m] lie in the polygon or within tolerance [m] of its edge."""
        here, x = within(x, self.across, tolerance), section_of(x)
        crossings: Flags = np.zeros(len(x), dtype=bool)
        near: Flags = np.zeros(len(x), dtype=bool)
        corners = np.array(self.points)
        for a, b in zip(corners, np.roll(corners, -1, axis=0)):
            along = np.clip(np.sum((x - a) * (b - a), axis=1) / max(np.sum((b - a) ** 2), 1e-300), 0.0, 1.0)
            near |= np.linalg.norm(x - a - along[:, None] * (b - a), axis=1) <= tolerance
            if a[1] != b[1]:
                at = a[0] + (x[:, 1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
                crossings ^= ((a[1] > x[:, 1]) != (b[1] > x[:, 1])) & (x[:, 0] < at)
        return (crossings | near) & here


def _area(points: Sequence[Sequence[float]]) -> float:
    x, y = np.array(points).T
    x, y = x - x[0], y - y[0]    # far from the origin the products would cancel
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


def check_line(points: Sequence[Sequence[float]], closed: bool, touching: bool = True) -> None:
    """Raise ValueError if two consecutive points are equal, or the line through them crosses, or touches, itself."""
    p = np.array(points, dtype=float)
    a, b = (p, np.roll(p, -1, axis=0)) if closed else (p[:-1], p[1:])
    same = np.flatnonzero((a == b).all(axis=1))
    if same.size:
        raise ValueError(f"points: {shown(points[same[0]])} is given twice in a row; leave one out")
    for i in range(len(a) - 1):
        j = _first_met(a, b, i, closed, touching)
        if j is not None:
            one, other = (f"from {shown(tuple(a[k].tolist()))} to {shown(tuple(b[k].tolist()))}" for k in (i, j))
            raise ValueError(f"points: the line {one} meets that {other}; give the points in order along one line")


def _first_met(a: Floats, b: Floats, i: int, closed: bool, touching: bool) -> int | None:
    """Return the first later piece that piece i crosses, or touches except at a shared end, or None."""
    j = np.arange(i + 1, len(a))
    before = _side(a[j], b[j], a[i]) * _side(a[j], b[j], b[i])
    across = _side(a[i], b[i], a[j]) * _side(a[i], b[i], b[j])
    if not touching:
        crossed = (before < 0.0) & (across < 0.0)
        return int(j[crossed][0]) if crossed.any() else None
    lower = np.maximum(np.minimum(a[i], b[i]), np.minimum(a[j], b[j]))
    upper = np.minimum(np.maximum(a[i], b[i]), np.maximum(a[j], b[j]))
    met = (before <= 0.0) & (across <= 0.0) & (lower <= upper).all(axis=1)
    for next_to, end, start in ((i + 1, b[i], a), (len(a) - 1 if closed and i == 0 else -1, a[i], b)):
        if i < next_to < len(a):    # pieces that join may not fold back on each other
            away, along = (b[next_to] if start is a else a[next_to]) - end, (a[i] if start is a else b[i]) - end
            folded = away[0] * along[1] - away[1] * along[0] == 0.0 and away @ along > 0.0
            met[next_to - i - 1] = folded
    return int(j[met][0]) if met.any() else None


def _side(a: Floats, b: Floats, p: Floats) -> Floats:
    """Return the cross product of b - a and p - a: positive if p is on the left."""
    return (b[..., 0] - a[..., 0]) * (p[..., 1] - a[..., 1]) - (b[..., 1] - a[..., 1]) * (p[..., 0] - a[..., 0])


class Lid(Model):
    """A lid that moves in its plane with `velocity` [m/s] along x, as in a lid-driven cavity.

    It acts on viscous fluid, or by friction on walls (`Case(friction=...)`).

    >>> Tank(width=1.0, height=1.0, lid=Lid(velocity=0.5), no_slip=True).closed
    True
    """

    velocity: float = Field(description="velocity of the lid along x [m/s]")


SIDES = ("left", "right", "bottom", "top")
ENDS = ("front", "back")    # the further sides of a tank in 3D: front at the least y, back at the greatest


class Tank(_Block):
    """A rectangular tank: width x height [m], with its lower left corner `at` [m].

    With a `breadth` [m] the scene is 3D: x along the tank, y across from the front wall to the back one, z up. `at` is
    then (x, y, z), or (x, z) with the front at y = 0.

    With a lid it is closed; without one water may leave it over the side walls. Viscous fluid sticks to the walls named
    in `no_slip`, and slips along the others; "front" and "back" are those across.

    >>> Tank(width=2.0, height=1.0, lid=True, no_slip=("bottom",)).sticky
    ('bottom',)
    >>> Tank(width=2.0, height=1.0, breadth=0.5).bounds[1].tolist()
    [2.0, 0.5, 1.0]
    """

    kind: Literal["tank"] = Field(default="tank", init=False)
    width: Length
    height: Length
    lid: Union[bool, Lid] = Field(default=False, description="whether the tank has a lid, or a Lid that moves")
    at: Point = (0.0, 0.0)
    no_slip: Union[bool, tuple[Literal["left", "right", "bottom", "top", "front", "back"], ...]] = Field(
        default=False, description="whether fluid sticks to all walls, or the names of no-slip walls")
    name: Name = ""
    motion: AnyMotion = AtRest()
    breadth: Breadth = None

    @model_validator(mode="after")
    def _sides_there(self) -> "Tank":
        across = [side for side in self.sticky if side in ENDS]
        if across and self.breadth is None:
            raise ValueError(f"no_slip: a tank in 2D has no wall {across[0]!r}; leave it out, or give breadth=")
        return self

    @property
    def closed(self) -> bool:
        """Whether there is a lid."""
        return bool(self.lid)

    @property
    def sticky(self) -> tuple[str, ...]:
        """Names of the walls to which viscous fluid sticks."""
        if isinstance(self.no_slip, tuple):
            return self.no_slip
        return (SIDES if self.breadth is None else SIDES + ENDS) if self.no_slip else ()


Shape = Annotated[Union[Box, Disc, Polygon], Field(discriminator="kind", description="a Box, Disc or Polygon")]
