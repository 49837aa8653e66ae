"""Friction of turbulent flow on free-slip walls."""

from pydantic import Field, model_validator

from parisph.case.model import Model


class Friction(Model):
    """Friction on all free-slip walls, by a law of the wall.

    At sea and in flumes, boundary layers are turbulent and thinner than a particle. The stress follows from the
    velocity u of a particle along the wall and its distance y: for smooth walls from u+ = y+ or u+ = 8.3 y+^(1/7)
    (Werner & Wengle 1993), for rough ones from u+ = ln(y/k)/.41 + 8.5 (Nikuradse 1933), whichever gives the larger
    stress. No-slip walls need no such law.

    The power law is within a tenth of the logarithmic one up to y+ = 1e3, and gives six tenths of its stress at 1e5.
    There is no transition from smooth to rough. For a particle nearer to the wall than k, y is k.

    viscosity : kinematic, of the fluid [m2/s]; 0 for the friction of roughness alone
    roughness : height k of sand grains that would give the same friction [m], at most the spacing

    >>> water = Friction()
    >>> concrete = Friction(roughness=0.001)
    """

    viscosity: float = Field(default=1e-6, ge=0, le=1, description="kinematic viscosity of the fluid [m2/s]")
    roughness: float = Field(default=0.0, ge=0, description="equivalent height of sand grains on the walls [m]")

    @model_validator(mode="after")
    def _rubs(self) -> "Friction":
        if self.viscosity == 0.0 and self.roughness == 0.0:
            raise ValueError("viscosity = 0 and roughness = 0: then there is no friction; give one of them, "
                             "or leave friction out")
        return self
