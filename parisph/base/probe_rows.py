"""Kinds of rows that gauges collect from all ranks. The kind is the first number of a row; comments name the rest."""

HEIGHT = 0.0    # a particle on the surface: x, y
BODY = 1.0      # a body of water: lower end, upper end, number of particles
TOP = 2.0       # the top of a body: y
