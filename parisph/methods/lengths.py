"""Radii and smoothing lengths in spacings (measured in the numerics of the design)."""

CIRCLE = 0.5          # R of the Rankine circle
MLS = 2.1             # moving least squares of the rows, of the velocity filter, and of films
WALL = 2.6            # wall rows and harmonic stencils
MIXED = 2.6           # of the mixed gradient
DENSITY = 1.3         # h of the density ratio
SPH = 1.8             # h of the SPH Laplacian and of the symmetric gradient; the kernel ends at 2 h
QUADRATIC_CIRCLE = 1.0    # R of the circle with quadratic least squares
QUADRATIC = 2.6       # quadratic least squares, there and of generalised finite differences
SURFACE_GAP = 2.0     # neighbours that close the angular gap
VISCOUS = 2.6         # quadratic least squares of the viscous acceleration
NEAR = 2.6            # reach of neighbour lists that regularisation and walls need, whatever the method
