"""Radii and smoothing lengths in spacings."""

CIRCLE = 0.5          # tuned 0.25 to 1: R of the Rankine circle; Z14
MLS = 2.1             # tuned 1.5 to 3.5: moving least squares of rows, of the velocity filter, and of films; measured
WALL = 2.6            # tuned 2.1 to 4: wall rows, harmonic stencils, mixed gradients, quadratic least squares; measured
DENSITY = 1.3         # tuned 0.8 to 2: h of the density ratio and of the Fick shift; measured
SPH = 1.8             # tuned 1 to 2.5: h of the SPH Laplacian and of the symmetric gradient, up to 2 h; measured
QUADRATIC_CIRCLE = 1.0    # tuned 0.5 to 2: R of the circle with quadratic least squares; measured
SURFACE_GAP = 2.0     # tuned 1.5 to 4: neighbours that close the angular gap; measured
NEAR = WALL           # reach of neighbour lists that regularisation and walls need with any method
