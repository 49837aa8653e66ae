"""Radii and smoothing lengths in spacings."""

CIRCLE = 0.5          # tuned 0.25 to 1: R of the Rankine circle; Z14
# Rows in 3D could be half as long with 1.6, and cost a third less with six points on the sphere in place of twelve. But
# waves then lose accuracy. Frequency and amplitude after three periods, a = .02 d, L = 2 d, d/s = 10, modes (1, 0) in a
# slab of 6 s and (1, 1):
#     2.1, twelve points    -.01 %  .993     -.01 %  .987
#     1.6, twelve points    -.10 %  .988     -.13 %  .980
#     2.1, six points       -.05 %  .990     -.06 %  .984
# The front of a dam break (H/s = 20) is .018 H behind at t sqrt(g/H) = 1.2 with 1.6.
MLS = 2.1             # tuned 1.5 to 3.5: moving least squares of rows, of the velocity filter, and of films; measured
WALL = 2.6            # tuned 2.1 to 4: wall rows, harmonic stencils, mixed gradients, quadratic least squares; measured
DENSITY = 1.3         # tuned 0.8 to 2: h of the density ratio and of the Fick shift; measured
SPH = 1.8             # tuned 1 to 2.5: h of the SPH Laplacian and of the symmetric gradient, up to 2 h; measured
QUADRATIC_CIRCLE = 1.0    # tuned 0.5 to 2: R of the circle with quadratic least squares; measured
SURFACE_GAP = 2.0     # tuned 1.5 to 4: neighbours that close the angular gap; measured
NEAR = WALL           # reach of neighbour lists that regularisation and walls need with any method
