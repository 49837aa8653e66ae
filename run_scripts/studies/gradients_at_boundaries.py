"""Gradients of the fluid beside walls and on a free surface, where supports are one-sided.

    parisph study run_scripts/studies/gradients_at_boundaries.py

About 10 s of CPU time. The gradients are those of Z17 (see z17_fig2_5_gradients.py) and `mixed`, that of ISPH_R here.
On the surface the harmonic fit may replace them, which is of second order for pressure with lap p = 0.
"""

from parisph.study import PatchStudy, Sweep

METHODS = ["symmetric", "corrected", "spline", "sfdi", "mixed"]

study = PatchStudy(
    title="Gradients beside walls and on a free surface",
    fields=["exponential", "harmonic"], gradients=METHODS, patches=["walls", "surface"], surface_gradients=["harmonic"],
    seeds=[1, 2, 3, 4, 5], sweeps=[Sweep(spacings=[1 / 20, 1 / 40, 1 / 80, 1 / 160], jitters=[0.0, 0.8])],
)
