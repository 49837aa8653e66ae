"""Bodies of a scene other than the tank: beds, obstacles, plates and wavemakers; and still water."""

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Union

import numpy as np
from pydantic import Discriminator, Field, Tag, model_validator

from parisph.base.arrays import Floats
from parisph.case.breadth import Across, Breadth, Spread, solid_box
from parisph.case.model import Model, Several
from parisph.case.motion import AnyMotion, AtRest, FlapStroke, Motion, PistonStroke, Rotation
from parisph.case.shapes import Name, Shape, Slip, Tank, check_line
from parisph.case.surface_body import Surface
from parisph.case.waves import Airy, Jonswap, SolitaryWave, Stokes, StreamFunction

PistonWave = Annotated[Union[SolitaryWave, Airy, Stokes, StreamFunction, Jonswap],
                       Field(discriminator="kind", description="a wave")]
FlapWave = Annotated[Union[Airy, Stokes, StreamFunction, Jonswap], Field(discriminator="kind", description="a wave")]
Line = Annotated[Several[tuple[float, float]],
                 Field(min_length=2, max_length=1000, description="points ((x, y), ...) in order [m]")]


class Profile(Spread):
    """A bed or a wall, open at both ends: straight lines between points [m], with fluid above it.

    The points may be given in either direction. If the first and the last have the same x, as on a vertical wall,
    `side` must say on which side the fluid is, as seen along the points.

    With a `breadth` [m] the scene is 3D, and the points (x, z) are of its section: walls across stand in front and at
    the back. In a scene with a breadth, a further Profile may have ends `across=(ya, yb)` [m].

    >>> Profile(points=((0.0, 0.0), (2.0, 0.0), (4.0, 0.5)), name="beach").fluid_on_left
    True
    """

    kind: Literal["profile"] = Field(default="profile", init=False)
    points: Line
    name: Name = ""
    slip: Slip = "free"
    side: Literal["left", "right"] | None = Field(
        default=None, description="side of the fluid as seen along the points, None for above")
    motion: AnyMotion = AtRest()
    breadth: Breadth = None
    across: Across = None

    @model_validator(mode="after")
    def _one_line(self) -> "Profile":
        check_line(self.points, closed=False)
        if self.breadth is not None and self.across is not None:
            raise ValueError(f"breadth = {self.breadth:g} and across = {self.across}: the first is of the whole scene, "
                             "the second of this body in it; give one of them")
        if self.side is None and self.points[0][0] == self.points[-1][0]:
            raise ValueError(f"points: the first and the last have the same x = {self.points[0][0]:g}, so that neither "
                             'side is above; give side="left" or side="right", as seen along the points')
        return self

    @property
    def fluid_on_left(self) -> bool:
        """Whether the fluid is on the left, as seen along the points."""
        return self.points[0][0] < self.points[-1][0] if self.side is None else self.side == "left"

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corner of the box around it, (dim,) each [m]; those of the section if across is None.

        With a breadth, the scene says where it begins (Scene.box_of).
        """
        return solid_box(*_box(self.points), self.across)


class Obstacle(Spread):
    """A solid with fluid around it: a Box, Disc or Polygon, which may stand on a bed or overlap other bodies.

    In 3D it reaches across the whole scene, or from ya to yb with `across=(ya, yb)` [m], or as its shape says.

    >>> Obstacle(Box(width=0.1, height=0.2, at=(1.0, 0.0)), name="box").slip
    'free'
    >>> Obstacle(Disc(radius=0.1, at=(1.0, 0.0)), across=(0.2, 0.4)).extent
    (0.2, 0.4)
    """

    kind: Literal["obstacle"] = Field(default="obstacle", init=False)
    shape: Shape
    name: Name = ""
    slip: Slip = "free"
    motion: AnyMotion = AtRest()
    across: Across = None

    @model_validator(mode="after")
    def _one_outline(self) -> "Obstacle":
        if self.shape.kind == "polygon":
            check_line(self.shape.points, closed=True)
        own = self.shape.extent
        if own is not None and self.across is not None:
            raise ValueError(f"across = {self.across}: the shape reaches from y = {own[0]:g} to {own[1]:g} already; "
                             "give one of them")
        return self

    @property
    def extent(self) -> tuple[float, float] | None:
        """Ends across a 3D scene [m], or None for its whole breadth."""
        return self.shape.extent if self.across is None else self.across

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corner of the box around it, (dim,) each [m]; those of the section without an extent."""
        return self.shape.bounds if self.across is None else solid_box(*self.shape.bounds, self.across)


class Plate(Spread):
    """A thin wall without thickness, with fluid on both sides: straight lines between points [m].

    In 3D it reaches across the whole scene, or from ya to yb with `across=(ya, yb)` [m].

    >>> Plate(points=((1.0, 0.0), (1.0, 0.3)), name="baffle", slip="none").name
    'baffle'
    """

    kind: Literal["plate"] = Field(default="plate", init=False)
    points: Line
    name: Name = ""
    slip: Slip = "free"
    motion: AnyMotion = AtRest()
    across: Across = None

    @model_validator(mode="after")
    def _one_line(self) -> "Plate":
        check_line(self.points, closed=False)
        return self

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corner of the box around it, (dim,) each [m]; those of the section if across is None."""
        return solid_box(*_box(self.points), self.across)


class StillWater(Model):
    """Water at rest that fills the space between the walls up to a level [m], where no other fluid is.

    >>> StillWater(level=0.3).level
    0.3
    """

    kind: Literal["still_water"] = Field(default="still_water", init=False)
    level: float = Field(description="height of the water surface [m]")


class Piston(Spread):
    """A vertical wall at x = `at` [m] that moves along x, with fluid on one side: it makes a `wave`, or has a `motion`.

    It slides over the bed below it and is as high as the other walls, unless `bottom` and `top` differ. There is no
    fluid behind it. A wave that runs to the left has the fluid on the left. In 3D it reaches across the whole scene, or
    from ya to yb with `across=(ya, yb)` [m].

    >>> Piston(at=0.0, wave=SolitaryWave(height=0.05, depth=0.25)).fluid_on_left
    False
    >>> Piston(at=4.0, motion=Sway(amplitude=0.5, frequency=2.0), side="left").moved.top_rate
    1.0
    """

    kind: Literal["piston"] = Field(default="piston", init=False)
    at: float = Field(description="position x of the wall at rest [m]")
    wave: PistonWave | None = Field(default=None, description="wave that the piston makes")
    motion: AnyMotion | None = Field(default=None, description="motion, in place of a wave")
    side: Literal["left", "right"] | None = Field(default=None, description="side of the fluid, None for the wave's")
    bottom: float | None = Field(default=None, description="height of its lower end [m], None for that of the bed")
    top: float | None = Field(default=None, description="height of its upper end [m], None for that of the other walls")
    name: Name = ""
    slip: Slip = "free"
    across: Across = None

    @model_validator(mode="after")
    def _one_motion(self) -> "Piston":
        _check_drive(self.wave, self.motion, self.side)
        return self

    @property
    def moved(self) -> AnyMotion:
        """Its motion."""
        if self.motion is not None:
            return self.motion
        assert self.wave is not None
        return PistonStroke(wave=self.wave, place=self.at)

    @property
    def place(self) -> float:
        """Position x of the wall at rest [m]."""
        return self.at

    @property
    def fluid_on_left(self) -> bool:
        """Whether the fluid is at smaller x."""
        return _leftward(self.wave, self.side)


class Flap(Spread):
    """A vertical wall that turns about a `hinge` (x, y) [m] at its lower end, with fluid on one side.

    It makes a `wave`, or has a `motion`, a rotation about the hinge. The hinge lies on a bed or on an obstacle. `top`
    and the side of the fluid are those of a Piston, and so is `across`. In 3D the hinge is (x, z).

    >>> Flap(hinge=(0.0, 0.0), wave=Airy(height=0.02, period=1.5, depth=0.5)).moved.kind
    'flap_stroke'
    """

    kind: Literal["flap"] = Field(default="flap", init=False)
    hinge: Annotated[tuple[float, float], Field(description="hinge (x, y) [m]")]
    wave: FlapWave | None = Field(default=None, description="wave that the flap makes")
    motion: AnyMotion | None = Field(default=None, description="motion, in place of a wave")
    side: Literal["left", "right"] | None = Field(default=None, description="side of the fluid, None for the wave's")
    bed: float | None = Field(default=None, description="height of the bed under the waves [m], None for the hinge's")
    top: float | None = Field(default=None, description="height of its upper end [m], None for that of the other walls")
    name: Name = ""
    slip: Slip = "free"
    across: Across = None

    @model_validator(mode="after")
    def _one_motion(self) -> "Flap":
        _check_drive(self.wave, self.motion, self.side)
        self.moved    # raises if the hinge is wrong
        if isinstance(self.motion, Rotation) and tuple(self.motion.centre) != self.hinge:
            raise ValueError(f"motion.centre = {self.motion.centre}: must be the hinge, {self.hinge}")
        return self

    @property
    def moved(self) -> AnyMotion:
        """Its motion."""
        if self.motion is not None:
            return self.motion
        assert self.wave is not None
        return FlapStroke(wave=self.wave, centre=self.hinge, bed=self.hinge[1] if self.bed is None else self.bed)

    @property
    def place(self) -> float:
        """Position x of the wall at rest [m]."""
        return self.hinge[0]

    @property
    def fluid_on_left(self) -> bool:
        """Whether the fluid is at smaller x."""
        return _leftward(self.wave, self.side)


def _leftward(wave: Any, side: str | None) -> bool:
    return side == "left" if side is not None else wave is not None and wave.leftward


def _check_drive(wave: Any, motion: Motion | None, side: str | None) -> None:
    """Raise ValueError unless either a wave or a motion is given, and the wave runs into the fluid."""
    if (wave is None) == (motion is None):
        raise ValueError("give either a wave or a motion")
    if wave is not None and side is not None and (side == "left") != wave.leftward:
        raise ValueError(f"side = {side}: the wave runs to the {'left' if wave.leftward else 'right'}, which must be "
                         "the side of the fluid; leave side out")


def motion_of(body: "Body") -> Motion:
    """Return the motion of a body in the frame of the scene."""
    return body.moved if isinstance(body, (Piston, Flap)) else body.motion


def _kind_of(walls: Any) -> str:
    """Return the tag of a member of Walls. A Tank stored by an earlier release has no kind."""
    if isinstance(walls, (list, tuple)):
        return "several"
    return str(walls.get("kind", "tank") if isinstance(walls, Mapping) else getattr(walls, "kind", "tank"))


Body = Annotated[
    Union[Annotated[Tank, Tag("tank")], Annotated[Profile, Tag("profile")], Annotated[Obstacle, Tag("obstacle")],
          Annotated[Plate, Tag("plate")], Annotated[Piston, Tag("piston")], Annotated[Flap, Tag("flap")]],
    Discriminator(_kind_of)]
AnyBody = Annotated[
    Union[Annotated[Tank, Tag("tank")], Annotated[Profile, Tag("profile")], Annotated[Obstacle, Tag("obstacle")],
          Annotated[Plate, Tag("plate")], Annotated[Piston, Tag("piston")], Annotated[Flap, Tag("flap")],
          Annotated[Surface, Tag("surface")]],
    Discriminator(_kind_of)]
Walls = Annotated[
    Union[Annotated[Tank, Tag("tank")], Annotated[Profile, Tag("profile")], Annotated[Obstacle, Tag("obstacle")],
          Annotated[Plate, Tag("plate")], Annotated[Piston, Tag("piston")], Annotated[Flap, Tag("flap")],
          Annotated[Surface, Tag("surface")], Annotated[Several[AnyBody], Tag("several")]],
    Discriminator(_kind_of)]


def _box(points: Sequence[Sequence[float]]) -> tuple[Floats, Floats]:
    p = np.array(points, dtype=float)
    return p.min(axis=0), p.max(axis=0)
