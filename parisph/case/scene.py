"""The fields of a case, each valid by itself, and the properties that follow from them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, Union

import numpy as np
from pydantic import Discriminator, Field, Tag, field_validator, model_validator

from parisph.base import vocabulary
from parisph.base.arrays import Floats
from parisph.base.text import shown
from parisph.case.absorb import Absorber, AnyZone, Zone
from parisph.case.bodies import Body, Flap, Piston, Profile, StillWater, Walls, motion_of
from parisph.case.breadth import Spread, lifted, solid_box
from parisph.case.ellipsoid import Ellipsoid
from parisph.case.expressions import uniform_field, vector_field
from parisph.case.fluids import Fluid
from parisph.case.friction import Friction
from parisph.case.lattice import FIT
from parisph.case.model import Model, Several
from parisph.case.motion import AtRest, Frame
from parisph.case.numerics import Numerics, Output
from parisph.case.probes import AnyProbe
from parisph.case.shapes import Box, Tank
from parisph.case.surface_body import Surface


def _how_many(value: Any) -> str:
    return "several" if isinstance(value, (list, tuple)) else "one"


Fluids = Annotated[
    Union[Annotated[Fluid, Tag("one")],
          Annotated[Several[Fluid], Field(min_length=1, max_length=100), Tag("several")]], Discriminator(_how_many)]

if TYPE_CHECKING:
    Zones = Union[AnyZone, Sequence[AnyZone]]    # one need not be in a list
else:
    Zones = tuple[AnyZone, ...]


class Scene(Model):
    """The fields of a Case, which describes them, and properties that follow from them."""

    title: str = Field(min_length=1, max_length=200, description="one line for readers")
    source: str = Field(default="", max_length=200, description="where the scene is from, such as a paper")
    fluid: Fluids = Field(kw_only=True, description="a Fluid, or several")
    walls: Walls | None = Field(default=None, kw_only=True, description="a Tank or another body, or several")
    gravity: tuple[Union[float, str], ...] = Field(
        kw_only=True, description="body force (x, y), in 3D (x, y, z) or (x, z) [m/s2], numbers or expressions of "
                                  "x, y, t (z)")
    frame: Frame = Field(default=AtRest(), kw_only=True)
    absorb: Zones = Field(default=(), kw_only=True)
    friction: Friction | None = Field(default=None, kw_only=True,
                                      description="friction of turbulent flow on walls, or None")
    numerics: Numerics = Field(kw_only=True)
    output: Output = Field(default=Output(), kw_only=True)
    probes: Several[AnyProbe] = Field(default=(), kw_only=True)
    end_time: float = Field(kw_only=True, gt=0, description="end of the run [s]")
    asked: Numerics | None = Field(default=None, kw_only=True,
                                   description="the numerics as they were asked for, in a stored case")

    @field_validator("absorb", mode="before")
    @classmethod
    def _one_or_more(cls, zones: object) -> object:
        return (zones,) if isinstance(zones, (Model, dict)) else zones

    @field_validator("gravity", mode="before")
    @classmethod
    def _a_vector(cls, gravity: object) -> object:
        if isinstance(gravity, (int, float, str)) and not isinstance(gravity, bool):
            down = f"{0.0 - abs(gravity):g}" if isinstance(gravity, (int, float)) else repr(gravity)
            raise ValueError(f"must have two components (x, y) [m/s2], of which y points up, not {shown(gravity)}; "
                             f"write gravity=(0, {down})")
        return gravity

    @field_validator("friction", mode="before")
    @classmethod
    def _a_friction(cls, friction: object) -> object:
        if friction is not None and not isinstance(friction, (Friction, dict)):
            raise ValueError("must be a Friction; write friction=Friction(), or leave it out")
        return friction

    @field_validator("probes", mode="before")
    @classmethod
    def _several(cls, probes: object) -> object:
        if isinstance(probes, Model):
            raise ValueError(f"must be a list; write probes=[{type(probes).__name__}(...)]")
        return probes

    @model_validator(mode="after")
    def _gravity_of_the_scene(self) -> "Scene":
        vars(self)["gravity"] = lifted(self.gravity, self.dim)    # type checkers treat a record as frozen
        return self

    @property
    def dim(self) -> int:
        """Number of dimensions: 3 with a `breadth`, else 2. The last axis points up."""
        return 2 if self.breadth is None else 3

    @property
    def breadth(self) -> tuple[float, float] | None:
        """The ends (y0, y1) [m] of a 3D scene, its front and its back; None in 2D.

        They are those of its Tank, else of a Profile with a breadth, else, without walls, of its Boxes and
        Ellipsoids together.
        """
        tank = self.tank
        if tank is not None and tank.extent is not None:
            return tank.extent
        for body in self.bodies:
            if isinstance(body, Profile) and body.breadth is not None:
                return 0.0, body.breadth
        ends = [fluid.shape.extent for fluid in self.fluids if isinstance(fluid.shape, (Box, Ellipsoid))]
        known = [] if self.bodies else [pair for pair in ends if pair is not None]
        return (min(low for low, _ in known), max(high for _, high in known)) if known else None

    def extent_of(self, part: Spread | Fluid) -> tuple[float, float] | None:
        """Return the ends (ya, yb) [m] across a 3D scene of a shape, a body or a fluid; None in 2D."""
        whole = self.breadth
        return whole if whole is None or part.extent is None else part.extent

    def box_of(self, part: Spread) -> tuple[Floats, Floats]:
        """Return the lower and upper corner of the box around a shape or a body, (dim,) each [m].

        A wavemaker has none. In 3D it reaches across the whole scene unless it has an extent of its own.
        """
        lower, upper = part.bounds    # type: ignore[attr-defined]    # of all but wavemakers
        return (lower, upper) if len(lower) == self.dim else solid_box(lower, upper, self.breadth)

    @property
    def fluids(self) -> tuple[Fluid, ...]:
        """All bodies of fluid."""
        return (self.fluid,) if isinstance(self.fluid, Fluid) else tuple(self.fluid)

    @property
    def zones(self) -> tuple[AnyZone, ...]:
        """All zones that absorb waves: Sponge and Relaxation."""
        return (self.absorb,) if isinstance(self.absorb, Zone) else tuple(self.absorb)

    @property
    def bodies(self) -> tuple[Body, ...]:
        """All walls but surfaces: Tank, Profile, Obstacle, Plate, Piston and Flap."""
        return tuple(body for body in self.all_bodies if not isinstance(body, Surface))

    @property
    def surfaces(self) -> tuple[Surface, ...]:
        """All Surfaces, named surface, surface-1, ... if they have no name of their own."""
        found = [body for body in self.all_bodies if isinstance(body, Surface)]
        return tuple(body if body.name else body.model_copy(update={"name": body.kind + (f"-{k}" if k else "")})
                     for k, body in enumerate(found))

    @property
    def all_bodies(self) -> tuple[Body | Surface, ...]:
        """All walls."""
        if self.walls is None:
            return ()
        return tuple(self.walls) if isinstance(self.walls, Sequence) else (self.walls,)

    @property
    def tank(self) -> Tank | None:
        """The first Tank, or None."""
        return next((body for body in self.bodies if isinstance(body, Tank)), None)

    @property
    def lone_tank(self) -> Tank | None:
        """The Tank if it is the only wall and rests in the frame of the scene, or None."""
        alone = self.tank is not None and len(self.all_bodies) == 1 and isinstance(self.tank.motion, AtRest)
        return self.tank if alone else None

    @property
    def lidded(self) -> bool:
        """Whether the scene is a tank with a lid, from which nothing can leave."""
        return self.tank is not None and self.tank.closed

    @property
    def density(self) -> float:
        """Density of all fluid [kg/m3]."""
        return self.fluids[0].density

    @property
    def viscosity(self) -> float:
        """Kinematic viscosity of all fluid [m2/s]."""
        return self.fluids[0].viscosity

    @property
    def wall_bounds(self) -> tuple[Floats, Floats] | None:
        """Lower and upper corner of the box around all walls but wavemakers, (dim,) each [m], or None."""
        boxes = [self.box_of(body) for body in self.bodies if not isinstance(body, (Piston, Flap))]
        if not boxes:
            return None
        return np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)

    def bounds_of(self, fluid: Fluid) -> tuple[Floats, Floats]:
        """Return the lower and upper corner of a box around a body of fluid at the start, (dim,) each [m].

        Still water is as wide as the walls, up to wavemakers.
        """
        if not isinstance(fluid.shape, StillWater):
            return self.box_of(fluid.shape)
        lower, upper = (corner.copy() for corner in self.wall_bounds or (np.zeros(self.dim), np.zeros(self.dim)))
        lower[0], upper[0] = self.ends
        upper[-1] = fluid.shape.level
        return lower, np.maximum(upper, lower)

    @property
    def ends(self) -> tuple[float, float]:
        """Least and greatest x [m] between the walls and in front of wavemakers; 0 without walls."""
        lower, upper = self.wall_bounds or (np.zeros(2), np.zeros(2))
        ends = [float(lower[0]), float(upper[0])]
        for body in self.bodies:
            if isinstance(body, (Piston, Flap)):
                ends[body.fluid_on_left] = body.place
        return ends[0], ends[1]

    @property
    def fluid_bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corner of a box around all fluid at the start, (dim,) each [m]."""
        boxes = [self.bounds_of(fluid) for fluid in self.fluids]
        return np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)

    def points(self, across: int, up: int) -> list[Floats]:
        """Return points (n, dim) [m] of a grid over each body of fluid that lie in its shape.

        across : number along x; up : number along each further axis
        """
        found = []
        for fluid in self.fluids:
            lower, upper = self.bounds_of(fluid)
            many = [across] + [up] * (self.dim - 1)
            axes = [np.linspace(a, b, count) for a, b, count in zip(lower, upper, many)]
            x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, self.dim)
            found.append(x if isinstance(fluid.shape, StillWater) else x[fluid.shape.inside(x, 0.0)])
        return found

    @property
    def closed(self) -> bool:
        """Whether a tank with a lid is full: no free surface, pressure up to a constant.

        It is full if still water reaches the lid, or, without other bodies, if a Box fills it.
        """
        tank = self.tank
        if tank is None or not tank.closed or len(self.fluids) != 1 or self.fluids[0].raised or self.fluids[0].holes:
            return False
        shape = self.fluids[0].shape
        if isinstance(shape, StillWater):
            return abs(shape.level - float(tank.bounds[1][-1])) <= FIT * self.numerics.spacing
        if self.lone_tank is None or not isinstance(shape, Box):
            return False
        gaps = np.abs(np.array(self.box_of(shape)) - np.array(tank.bounds))
        return bool(np.all(gaps < 0.5 * self.numerics.spacing))

    @property
    def driven(self) -> bool:
        """Whether the body force, a motion of the tank or of walls, or a zone may do work on the fluid.

        The work of a uniform, constant force is counted as potential energy.
        """
        moving = any(not isinstance(motion_of(body), AtRest) for body in self.bodies)
        return moving or bool(self.zones) or self.constant_force is None

    @property
    def absorber(self) -> Absorber | None:
        """The Absorber of the zones that absorb waves, or None."""
        if not self.zones or self.wall_bounds is None:
            return None
        lower, upper = self.fluid_bounds
        level = float(upper[-1])
        g = float(np.linalg.norm(self.body_force(np.array([upper], dtype=float), 0.0)))
        return Absorber(self.zones, self.ends, level, level - float(lower[-1]), g)

    def body_force(self, x: Floats, t: float) -> Floats:
        """Return the body force (n, dim) [m/s2] at x (n, dim) [m] and t [s] in the frame of the tank, with its inertia.

        It is the force on fluid at rest in this frame. The Coriolis force is a separate part of a method.
        """
        force = self.frame.seen(vector_field(self.gravity, with_time=True)(x, t), t)
        frame = self.frame.acceleration_within(x, t)
        for axis in range(self.dim):    # numpy is slow along a short last axis
            force[:, axis] -= frame[:, axis]
        return force

    @property
    def constant_force(self) -> Floats | None:
        """The body force (dim,) [m/s2] if it is the same at every place and time, as in a tank at rest, else None."""
        return uniform_field(self.gravity) if isinstance(self.frame, AtRest) else None

    @property
    def same_force_everywhere(self) -> bool:
        """Whether the body force is uniform at any time."""
        return uniform_field(self.gravity) is not None and not self.turns

    @property
    def physics(self) -> frozenset[str]:
        """Physical effects of the scene that need a force of their own, from vocabulary.PHYSICS."""
        has = {"viscous": self.viscosity > 0.0 or self.numerics.smagorinsky > 0.0, "turning": self.turns,
               "absorbing": bool(self.zones), "friction": self.friction is not None}
        return frozenset(word for word in vocabulary.PHYSICS if has[word])

    @property
    def turns(self) -> bool:
        """Whether the tank rotates."""
        return self.frame.turns

    def start_vorticity(self, fluid: Fluid, x: Floats) -> Floats:
        """Return the absolute vorticity in the section (n,) [1/s] of a body of fluid at the start, at x (n, dim) [m].

        Fluid at rest in a rotating tank rotates with it. In 3D, where fluid does not keep its own, only this counts: it
        is the vorticity along `spin_axis`.
        """
        if self.dim == 2:
            return fluid.start_vorticity(x, self.numerics.spacing) + 2.0 * float(self.spin(0.0))
        return np.full(len(x), 2.0 * float(np.linalg.norm(self.spin(0.0))))

    def spin(self, t: float) -> Floats:
        """Return the tank's angular velocity [rad/s] at t [s]: () in 2D, anticlockwise; (3,) in its frame in 3D."""
        if self.dim == 3:
            return self.frame.spin_within(t)
        return np.array(self.frame.law(t)[1] if self.turns else 0.0)

    @property
    def spin_axis(self) -> Floats | None:
        """Unit vector (3,) of the angular velocity of a 3D tank at the start, None in 2D or without one."""
        spin = self.spin(0.0)
        size = float(np.linalg.norm(spin))
        return spin / size if self.dim == 3 and size else None
