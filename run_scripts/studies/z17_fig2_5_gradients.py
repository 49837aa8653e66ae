"""Gradients of x^2 + y^2 and exp(2x + 3y), on a lattice and on disordered particles (Zheng et al. 2017, Figs 2 to 5).

    parisph study run_scripts/studies/z17_fig2_5_gradients.py

About 25 s of CPU time. The paper's methods are ISPH (Eq 25, symmetric), CISPH1 (Eqs 26-27, corrected), CISPH2 (Eq 28,
spline) and CISPH3 (Eqs 29-32, sfdi). It counts all particles of the unit square, those at the rim too ("square"), and
its Er divides the rms once more by sqrt(N). The disorder of its Fig 1 is k = 0.2; k = 0.8 is that of Z14. Beside it:
the interior alone, with proper norms. The paper does not state its smoothing length; here it is 1.8 s, as in Z14.
"""

from parisph.study import PatchStudy, Sweep

METHODS = ["symmetric", "corrected", "spline", "sfdi", "mixed"]    # the first four are the paper's
SPACINGS = [1 / n for n in (30, 40, 60, 80, 100)]                  # N = 900, 1600, 3600, 6400, 10,000

study = PatchStudy(
    title="Gradients, Z17 Figs 2-5",
    fields=["parabola", "exponential"], gradients=METHODS, patches=["square", "interior"], seeds=list(range(1, 11)),
    sweeps=[Sweep(spacings=SPACINGS, jitters=[0.0, 0.2, 0.8])],
)
