"""The fields of a case, each valid by itself, and what follows from them alone. Checks of the whole need no more."""

from typing import Optional, Union

import numpy as np
from pydantic import Field, field_validator

from parisph.base.arrays import Floats
from parisph.case.absorb import Absorber, AnyZone
from parisph.case.expressions import uniform_field, vector_field
from parisph.case.model import Model
from parisph.case.motion import AtRest, Frame, Rotation
from parisph.case.numerics import Numerics, Output
from parisph.case.probes import AnyProbe
from parisph.case.shapes import Box, Fluid, Tank


class Scene(Model):
    """The fields of a Case, where they are described, and what follows from them."""

    title: str = Field(min_length=1, max_length=200, description="one line for people")
    fluid: Fluid
    walls: Optional[Tank] = None
    gravity: tuple[Union[float, str], ...] = Field(
        description="body force (x, y) [m/s2], numbers or expressions of x, y, t")
    frame: Frame = AtRest()
    absorb: tuple[AnyZone, ...] = ()
    numerics: Numerics
    output: Output = Output()
    probes: tuple[AnyProbe, ...] = ()
    end_time: float = Field(gt=0, description="end of the run [s]")
    asked: Optional[Numerics] = Field(None, description="the numerics as they were asked for, in a stored case")

    @field_validator("absorb", mode="before")
    @classmethod
    def _one_or_more(cls, zones: object) -> object:
        return (zones,) if isinstance(zones, (Model, dict)) else zones

    @field_validator("probes", mode="before")
    @classmethod
    def _several(cls, probes: object) -> object:
        if isinstance(probes, Model):
            raise ValueError(f"must be a list; write probes=[{type(probes).__name__}(...)]")
        return probes

    @property
    def dim(self) -> int:
        """Number of dimensions: 2, as scenes in 3D are refused so far."""
        return self.fluid.dim

    @property
    def closed(self) -> bool:
        """True for a tank with a lid that is full: no free surface, pressure up to a constant."""
        shape, tank = self.fluid.shape, self.walls
        if tank is None or not tank.closed or not isinstance(shape, Box) or self.fluid.raised:
            return False
        gaps = np.abs(np.array(shape.bounds) - np.array(tank.bounds))
        return bool(np.all(gaps < 0.5 * self.numerics.spacing))

    @property
    def driven(self) -> bool:
        """Whether the body force, the tank's motion or a zone may do work on the fluid and so change its energy.

        A uniform, constant force does not, because its potential energy is counted.
        """
        return bool(self.absorb) or not isinstance(self.frame, AtRest) or uniform_field(self.gravity) is None

    @property
    def absorber(self) -> Optional[Absorber]:
        """What zones that absorb waves do to water, or None."""
        if not self.absorb or self.walls is None:
            return None
        lower, upper = self.fluid.shape.bounds
        ends, level = [float(corner[0]) for corner in self.walls.bounds], float(upper[-1])
        g = float(np.linalg.norm(self.body_force(np.array([upper], dtype=float), 0.0)))
        return Absorber(self.absorb, (ends[0], ends[1]), level, level - float(lower[-1]), g)

    def body_force(self, x: Floats, t: float) -> Floats:
        """Body force (n, dim) [m/s2] at x (n, dim) [m] and t [s] in the tank's frame: gravity and what its motion adds.

        It is the force on what rests in the tank; in a tank that turns, Coriolis' force is another part of the method.
        """
        return self.frame.seen(vector_field(self.gravity, with_time=True)(x, t), t) + self.frame.felt(x, t)

    @property
    def turns(self) -> bool:
        """Whether the tank turns, so that gravity does in its frame."""
        return isinstance(self.frame, Rotation)

    def spin(self, t: float) -> float:
        """Angular velocity of the tank [rad/s] at t [s], against the clock."""
        return float(self.frame.law(t)[1]) if self.turns else 0.0
