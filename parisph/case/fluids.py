"""Bodies of fluid and their start."""

from typing import Annotated, Union

import numpy as np
from pydantic import Field, model_validator

from parisph.base.arrays import Floats
from parisph.base.text import shown
from parisph.case.bodies import StillWater
from parisph.case.breadth import lifted
from parisph.case.ellipsoid import Ellipsoid
from parisph.case.expressions import compile_expression, variable_names, vector_field
from parisph.case.model import Model, Several
from parisph.case.shapes import Box, Disc, Polygon, Shape
from parisph.case.waves import AnyWave

NEAR = 0.5         # spacings to both sides for differences: a jump has the vorticity of one spacing
ROUNDING = 1e-4    # of a velocity: a smaller change over a length counts as none
LEFT = 0.1         # of a vorticity: finer differences must keep more of it, or it counts as their error

Number = Union[float, str]  # a number, or an expression of position


FluidShape = Annotated[Union[Box, Disc, Polygon, Ellipsoid, StillWater],
                       Field(discriminator="kind", description="StillWater, a Box, Disc or Polygon, or an Ellipsoid")]


class Fluid(Model):
    """A body of fluid and its start.

    shape : Box, Disc, Polygon, StillWater, or in 3D an Ellipsoid; parts of it that lie in or behind walls are left out
    density : [kg/m3]
    velocity : components [m/s], numbers or expressions of x, y; in 3D three of x, y, z, or two in the section
    elevation : None, or the height of the free surface above the top of a Box or the level of StillWater [m], a
        number or an expression of x, in 3D of x, y; columns of a Box are stretched linearly to it, those of StillWater
        are moved up
    wave : None, or a wave (parisph.case.waves) that gives velocity and elevation at t = 0 instead of these two; the
        top of the Box is its still surface, and its height is the wave's depth. StillWater has this depth at its
        deepest place. In 3D it runs along x, or along its direction
    viscosity : kinematic [m2/s], 0 for none
    holes : shapes inside this one without fluid

    >>> water = Fluid(Box(width=1.0, height=0.4), density=1000.0, velocity=("0.1*cos(pi*x)", 0.0))
    >>> Fluid(Box(width=1.0, height=0.4), density=1000.0, elevation="0.02*cos(pi*x)").raised
    True
    >>> wave = SolitaryWave(height=0.05, depth=0.25, at=2.0)
    >>> moving = Fluid(Box(width=8.0, height=0.25), density=1000.0, viscosity=1e-6, wave=wave)
    >>> ring = Fluid(Disc(radius=0.5), density=1000.0, holes=(Disc(radius=0.2),))
    """

    shape: FluidShape
    density: float = Field(gt=0, description="density [kg/m3]")
    velocity: tuple[Number, ...] = Field(default=(0.0, 0.0),
                                         description="start velocity (u, v), in 3D (u, v, w) or (u, w) [m/s], numbers "
                                                     "or expressions of x, y (z)")
    elevation: Union[float, str, None] = Field(
        default=None, description="surface elevation above a Box [m], a number or an expression of x, in 3D of x, y"
    )
    viscosity: float = Field(default=0.0, ge=0, description="kinematic viscosity [m2/s]")
    wave: AnyWave | None = Field(default=None, description="wave that gives velocity and elevation at the start")
    holes: Annotated[Several[Shape], Field(max_length=100, description="shapes without fluid")] = ()

    @property
    def extent(self) -> tuple[float, float] | None:
        """Ends across a 3D scene [m], or None for its whole breadth."""
        return None if isinstance(self.shape, StillWater) else self.shape.extent

    @property
    def top(self) -> float:
        """Height of the surface without its elevation: the level, or the upper end of the shape [m]."""
        return self.shape.level if isinstance(self.shape, StillWater) else float(self.shape.bounds[1][-1])

    @property
    def raised(self) -> bool:
        """Whether the surface has an elevation at the start."""
        return self.elevation is not None or self.wave is not None

    @property
    def varies_across(self) -> bool:
        """Whether its section may not be the same at all places across a 3D scene."""
        oblique = self.wave is not None and self.wave.varies_across
        return isinstance(self.shape, Ellipsoid) or isinstance(self.elevation, str) or oblique

    def rise(self, x: Floats, y: Floats | None = None) -> Floats:
        """Return the elevation (n,) [m] of the surface at the start above the top of the shape, at x (n,) [m].

        y : (n,) [m] across a 3D scene
        """
        if self.wave is not None:
            if y is not None and self.wave.varies_across:
                return self.wave.surface(x, y, 0.0)
            columns, which = np.unique(x, return_inverse=True)
            return self.wave.surface(columns, None if y is None else 0.0, 0.0)[which]
        if self.elevation is None:
            return np.zeros(len(x))
        if y is None:
            return compile_expression(str(self.elevation), ("x",))(x=x)
        return compile_expression(str(self.elevation), ("x", "y"))(x=x, y=y)

    def start_velocity(self, x: Floats) -> Floats:
        """Return the velocity (n, dim) [m/s] at the start, at x (n, dim) [m]."""
        if self.wave is None:
            return vector_field(lifted(self.velocity, np.shape(x)[1]), with_time=False)(x)
        bed = self.top - self.wave.depth
        return self.wave.flow(x, bed, 0.0)

    def start_vorticity(self, x: Floats, length: float) -> Floats:
        """Return dv/dx - du/dy (n,) [1/s] of the velocity at the start, at x (n, 2) [m]; a wave has none.

        length : [m], over which the velocity varies little

        By central differences. It counts as 0 where a velocity beside a point is not known, and where it may be an
        error of rounding or of the differences: if differences over half the length, extrapolated, are far smaller.
        """
        if self.wave is not None:
            return np.zeros(len(x))
        found = self._curl(x, NEAR * length)
        finer = (4.0 * self._curl(x, 0.5 * NEAR * length) - found) / 3.0
        top = np.abs(self.start_velocity(x)).max(initial=0.0)
        known = (np.isfinite(found) & (np.abs(found) * length > ROUNDING * top)
                 & ~(np.abs(finer) < LEFT * np.abs(found)))
        return np.where(known, found, 0.0)

    def _curl(self, x: Floats, h: float) -> Floats:
        """Return dv/dx - du/dy (n,) [1/s] of the velocity at the start by central differences over 2 h [m]."""
        found = np.zeros(len(x))
        for along, component, sign in ((0, 1, 1.0), (1, 0, -1.0)):
            step = h * np.eye(2)[along]
            change = self.start_velocity(x + step) - self.start_velocity(x - step)
            found += sign * change[:, component] / (2.0 * h)
        return found

    @model_validator(mode="after")
    def _wave_fits(self) -> "Fluid":
        wave = self.wave
        if wave is None:
            return self
        if not isinstance(self.shape, (Box, StillWater)):
            kind = type(self.shape).__name__
            raise ValueError(f"wave = {wave.kind}: only a Box or StillWater has a top to raise; leave it out for a "
                             f"{kind}")
        if self.elevation is not None or any(component != 0.0 for component in self.velocity):
            raise ValueError(f"wave = {wave.kind}: it gives velocity and elevation; leave these two out")
        if isinstance(self.shape, Box) and abs(wave.depth - self.shape.height) > 1e-6 * wave.depth:
            raise ValueError(
                f"wave.depth = {wave.depth:g}: must be the height of the Box, {self.shape.height:g}; change one of them"
            )
        return self

    @model_validator(mode="after")
    def _consistent(self) -> "Fluid":
        if self.elevation is not None and not isinstance(self.shape, (Box, StillWater)):
            raise ValueError(
                f"elevation = {shown(self.elevation)}: only a Box or StillWater has a top to raise; "
                f"leave it out for a {type(self.shape).__name__}"
            )
        found = [self.faults(dim) for dim in (2, 3)]    # the scene says which
        if all(found):
            raise ValueError(found[len(self.velocity) == 3 or self.extent is not None][0])
        return self

    def faults(self, dim: int) -> list[str]:
        """Return the faults of velocity and elevation in a scene of `dim` dimensions, one line each."""
        found = []
        try:
            check_components("velocity", self.velocity, dim, with_time=False)
        except ValueError as error:
            found.append(str(error))
        if self.elevation is not None:
            try:
                compile_expression(str(self.elevation), variable_names(dim - 1, with_time=False))
            except ValueError as error:
                found.append(f"elevation: {error}")
        return found


def check_components(field: str, components: tuple[Number, ...], dim: int, with_time: bool) -> None:
    """Raise ValueError unless `components` are dim numbers or expressions that compile, or two of the section."""
    if len(components) not in (2, dim):
        must = "must have 2 components" if dim == 2 else "must have 3 components, or 2 in the section"
        raise ValueError(f"{field} = {shown(components)}: {must}, as the scene is {dim}D")
    for component in components:
        try:
            compile_expression(str(component), variable_names(dim, with_time))
        except ValueError as error:
            raise ValueError(f"{field}: {error}") from None
