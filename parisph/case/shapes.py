"""The shapes of a scene: bodies of fluid and the tank that holds them."""

from typing import Annotated, ClassVar, Literal, Optional, Union

import numpy as np
from pydantic import AfterValidator, Field, field_validator, model_validator

from parisph.base.arrays import Flags, Floats
from parisph.base.text import shown
from parisph.case.expressions import compile_expression, variable_names, vector_field
from parisph.case.model import Model
from parisph.case.waves import AnyWave


def _in_the_plane(point: tuple[float, ...]) -> tuple[float, ...]:
    if len(point) == 3:
        raise ValueError(f"{point} has three components: scenes are 2D so far, give (x, y)")
    return point


Length = Annotated[float, Field(gt=0, description="a length [m]")]
Point = Annotated[
    tuple[float, ...],
    Field(min_length=2, max_length=3, description="a point (x, y) [m]"),
    AfterValidator(_in_the_plane),
]
Number = Union[float, str]  # a number, or an expression of position


class Box(Model):
    """A rectangle of fluid: width x height [m], with its lower left corner `at` [m].

    Examples
    --------
    >>> Box(width=2.0, height=0.5, at=(0.0, 0.1)).area
    1.0
    """

    kind: Literal["box"] = "box"
    width: Length
    height: Length
    at: Point = (0.0, 0.0)

    @property
    def area(self) -> float:
        """[m2]"""
        return self.width * self.height

    @property
    def size(self) -> Floats:
        """Edge lengths (dim,) [m]."""
        return np.array([self.width, self.height])

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corner, (dim,) each [m]."""
        lower = np.array(self.at)
        return lower, lower + self.size

    def inside(self, x: Floats, tolerance: float) -> Flags:
        """Return which of the points x (n, dim) [m] lie in the closed box, widened by tolerance [m]."""
        lower, upper = self.bounds
        within: Flags = np.all((x >= lower - tolerance) & (x <= upper + tolerance), axis=1)
        return within


class Disc(Model):
    """A disc of fluid: radius [m] about its centre `at` [m].

    Examples
    --------
    >>> print(f"{Disc(radius=0.5, at=(1.0, 1.0)).area:.4f} m2")
    0.7854 m2
    """

    kind: Literal["disc"] = "disc"
    radius: Length
    at: Point = (0.0, 0.0)
    edges: ClassVar[int] = 1

    @property
    def area(self) -> float:
        """[m2]"""
        return np.pi * self.radius**2

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corner of the bounding box, (dim,) each [m]."""
        centre = np.array(self.at)
        return centre - self.radius, centre + self.radius

    def inside(self, x: Floats, tolerance: float) -> Flags:
        """Return which of the points x (n, dim) [m] lie in the closed disc, widened by tolerance [m]."""
        within: Flags = np.linalg.norm(x - np.array(self.at), axis=1) <= self.radius + tolerance
        return within


class Polygon(Model):
    """A polygon of fluid, given by its corners in order, either way round [m].

    Examples
    --------
    >>> Polygon(points=((0.0, 0.0), (1.0, 0.0), (0.0, 0.5))).area
    0.25
    """

    kind: Literal["polygon"] = "polygon"
    points: Annotated[tuple[tuple[float, ...], ...], Field(
        min_length=3, max_length=1000, description="corners ((x, y), ...) in order [m]")]

    @field_validator("points")
    @classmethod
    def _encloses(cls, points: tuple[tuple[float, ...], ...]) -> tuple[tuple[float, ...], ...]:
        if any(len(point) != 2 for point in points):
            raise ValueError("every corner must have two coordinates (x, y): scenes are 2D so far")
        if _area(points) == 0.0:
            raise ValueError("the corners enclose no area: give at least three that are not on one line")
        return points

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
        """Lower and upper corner of the bounding box, (dim,) each [m]."""
        points = np.array(self.points)
        return points.min(axis=0), points.max(axis=0)

    def inside(self, x: Floats, tolerance: float) -> Flags:
        """Return which of the points x (n, 2) [m] lie in the polygon or within tolerance [m] of its edge."""
        crossings: Flags = np.zeros(len(x), dtype=bool)
        near: Flags = np.zeros(len(x), dtype=bool)
        corners = np.array(self.points)
        for a, b in zip(corners, np.roll(corners, -1, axis=0)):
            along = np.clip(np.sum((x - a) * (b - a), axis=1) / max(np.sum((b - a) ** 2), 1e-300), 0.0, 1.0)
            near |= np.linalg.norm(x - a - along[:, None] * (b - a), axis=1) <= tolerance
            if a[1] != b[1]:
                at = a[0] + (x[:, 1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
                crossings ^= ((a[1] > x[:, 1]) != (b[1] > x[:, 1])) & (x[:, 0] < at)
        return crossings | near


def _area(points: tuple[tuple[float, ...], ...]) -> float:
    x, y = np.array(points).T
    x, y = x - x[0], y - y[0]    # far from the origin the products would cancel
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


class Lid(Model):
    """A lid that moves in its plane with `velocity` [m/s] along x, as in a lid-driven cavity.

    Only viscous fluid notices.

    Examples
    --------
    >>> Tank(width=1.0, height=1.0, lid=Lid(velocity=0.5), no_slip=True).closed
    True
    """

    velocity: float = Field(description="velocity of the lid along x [m/s]")


SIDES = ("left", "right", "bottom", "top")


class Tank(Model):
    """A rectangular tank: width x height [m], with its lower left corner `at` [m].

    With a lid it is closed; without one its side walls end at the top, and water may leave
    it there. Viscous fluid sticks to the walls named in `no_slip`, and slips along the others.

    Examples
    --------
    >>> Tank(width=2.0, height=1.0, lid=True, no_slip=("bottom",)).sticky
    ('bottom',)
    """

    width: Length
    height: Length
    lid: Union[bool, Lid] = Field(False, description="whether the tank has a lid, or a Lid that moves")
    at: Point = (0.0, 0.0)
    no_slip: Union[bool, tuple[Literal["left", "right", "bottom", "top"], ...]] = Field(
        False, description="whether fluid sticks to all walls, or the names of those to which it sticks")

    @property
    def closed(self) -> bool:
        """Whether there is a lid."""
        return bool(self.lid)

    @property
    def sticky(self) -> tuple[str, ...]:
        """Names of the walls to which viscous fluid sticks."""
        if isinstance(self.no_slip, tuple):
            return self.no_slip
        return SIDES if self.no_slip else ()

    @property
    def size(self) -> Floats:
        """Edge lengths (dim,) [m]."""
        return np.array([self.width, self.height])

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corner, (dim,) each [m]."""
        lower = np.array(self.at)
        return lower, lower + self.size


Shape = Annotated[Union[Box, Disc, Polygon], Field(discriminator="kind", description="a Box, Disc or Polygon")]


class Fluid(Model):
    """A body of one fluid and how it starts.

    Attributes
    ----------
    shape : Box, Disc or Polygon
    density : [kg/m3]
    velocity : components [m/s], numbers or expressions of x, y
    elevation : None, or the height of the free surface above the top of a Box [m], a number or
        an expression of x; the columns of particles are stretched linearly to reach it
    wave : None, or a wave (parisph.case.waves) that gives velocity and elevation at t = 0, in place of these two; the
        top of the Box is its still surface, and the Box is as high as the wave's water is deep
    viscosity : kinematic [m2/s], 0 for none

    Examples
    --------
    >>> water = Fluid(Box(width=1.0, height=0.4), density=1000.0, velocity=("0.1*cos(pi*x)", 0.0))
    >>> Fluid(Box(width=1.0, height=0.4), density=1000.0, elevation="0.02*cos(pi*x)").raised
    True
    >>> wave = SolitaryWave(height=0.05, depth=0.25, at=2.0)
    >>> moving = Fluid(Box(width=8.0, height=0.25), density=1000.0, viscosity=1e-6, wave=wave)
    """

    shape: Shape
    density: float = Field(gt=0, description="density [kg/m3]")
    velocity: tuple[Number, ...] = Field((0.0, 0.0),
                                         description="start velocity (u, v) [m/s], numbers or expressions of x, y")
    elevation: Union[float, str, None] = Field(
        None, description="surface elevation above a Box [m], a number or an expression of x"
    )
    viscosity: float = Field(0.0, ge=0, description="kinematic viscosity [m2/s]")
    wave: Optional[AnyWave] = Field(None, description="wave that gives velocity and elevation at the start")

    @property
    def dim(self) -> int:
        """Number of dimensions: 2, as scenes in 3D are refused so far."""
        return len(self.shape.bounds[0])

    @property
    def raised(self) -> bool:
        """Whether the surface has an elevation at the start."""
        return self.elevation is not None or self.wave is not None

    def rise(self, x: Floats) -> Floats:
        """Return the elevation (n,) [m] of the surface at the start above the top of the shape, at x (n,) [m]."""
        if self.wave is not None:
            columns, which = np.unique(x, return_inverse=True)
            return self.wave.elevation(columns, 0.0)[which]
        if self.elevation is None:
            return np.zeros(len(x))
        return compile_expression(str(self.elevation), ("x",))(x=x)

    def start_velocity(self, x: Floats) -> Floats:
        """Return the velocity (n, dim) [m/s] at the start, at x (n, dim) [m]."""
        if self.wave is None:
            return vector_field(self.velocity, with_time=False)(x)
        bed = self.shape.bounds[1][-1] - self.wave.depth
        return np.stack(self.wave.velocity(x[:, 0], x[:, -1] - bed, 0.0), axis=1)

    @model_validator(mode="after")
    def _wave_fits(self) -> "Fluid":
        wave = self.wave
        if wave is None:
            return self
        if not isinstance(self.shape, Box):
            kind = type(self.shape).__name__
            raise ValueError(f"wave = {wave.kind}: only a Box has a top to raise; leave it out for a {kind}")
        if self.elevation is not None or tuple(self.velocity) != (0.0,) * self.dim:
            raise ValueError(f"wave = {wave.kind}: it gives velocity and elevation; leave these two out")
        if abs(wave.depth - self.shape.height) > 1e-6 * wave.depth:
            raise ValueError(
                f"wave.depth = {wave.depth:g}: must be the height of the Box, {self.shape.height:g}; change one of them"
            )
        return self

    @model_validator(mode="after")
    def _consistent(self) -> "Fluid":
        dim = self.dim
        check_components("velocity", self.velocity, dim, with_time=False)
        if self.elevation is not None:
            if not isinstance(self.shape, Box):
                raise ValueError(
                    f"elevation = {shown(self.elevation)}: only a Box has a top to raise; "
                    f"leave it out for a {type(self.shape).__name__}"
                )
            try:
                compile_expression(str(self.elevation), variable_names(dim - 1, with_time=False))
            except ValueError as error:
                raise ValueError(f"elevation: {error}") from None
        return self


def check_components(field: str, components: tuple[Number, ...], dim: int, with_time: bool) -> None:
    """Raise ValueError unless `components` are dim numbers or expressions that compile."""
    if len(components) != dim:
        raise ValueError(f"{field} = {shown(components)}: must have {dim} components, as the fluid's shape has")
    for component in components:
        try:
            compile_expression(str(component), variable_names(dim, with_time))
        except ValueError as error:
            raise ValueError(f"{field}: {error}") from None
