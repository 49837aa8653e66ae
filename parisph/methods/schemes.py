"""The registry of methods: a method is data, and only this module knows its name."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Scheme:
    """The parts of a method of the papers.

    Attributes
    ----------
    rows : "rankine" (Zheng, Ma & Duan 2014, Eq. 23) or "sph" (Eq. 20a)
    normalised : whether Rankine rows are normalised by their result for a parabola
    reach : radius of the neighbour lists, in spacings
    """

    rows: str
    normalised: bool = True
    reach: float = 2.6


SCHEMES = {
    "ISPH_R": Scheme(rows="rankine"),
    "ISPH_R_printed": Scheme(rows="rankine", normalised=False),
    "ISPH": Scheme(rows="sph", reach=3.6),
}

# Radii and smoothing lengths in spacings (measured in the numerics of the design).
CIRCLE = 0.5          # R of the Rankine circle
MLS = 2.1             # moving least squares of the rows, and of the velocity filter
WALL = 2.6            # wall rows and harmonic stencils
GRADIENT = {"sfdi": 2.1, "mixed": 2.6, "symmetric": 3.6}
DENSITY = 1.3         # h of the density ratio
SPH = 1.8             # h of the SPH Laplacian and of the symmetric gradient
SURFACE_GAP = 2.0     # neighbours that close the angular gap


def reach(numerics):
    """Return the radius that neighbour lists need for resolved Numerics, in spacings."""
    return max(SCHEMES[numerics.method].reach, GRADIENT[numerics.gradient])
