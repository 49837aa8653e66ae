"""Rows of numbers that probes collect from all ranks.

The first number of a row of a gauge is its kind; comments name the rest.
"""

WIDTH = 5       # numbers in a row: a kind or a node, a place in 3D, and a value

HEIGHT = 0.0    # a particle on the surface: its place (dim,)
BODY = 1.0      # a body of water: lower end, upper end, number of particles
TOP = 2.0       # the top of a body: its height
