"""Laplacians of cos(4 pi x + 8 pi y) on disordered particles (Zheng, Ma & Duan 2014, Figs 1 to 3).

    parisph study run_scripts/studies/z14_fig1_3_laplacians.py

About 20 s of CPU time. The paper's methods are sph (Eq 20a), cisph1 (Eqs 20b, 20c) and cisph2 (20b, 20d), with
h = 1.8 s. Its square 2 <= x, y <= 3 is the unit square here, because the field has the period 1; particles are in it
alone, so that supports are cut off for s = 0.1, and errors are those of 0.2 <= x, y <= 0.8. The paper has one random
arrangement, here there are ten.
"""

from parisph.study import Histogram, PatchStudy, Sweep

# The first three are the paper's.
METHODS = ["sph", "cisph1", "cisph2", "rankine", "rankine_quadratic", "gfd", "fatehi"]
SPACINGS = [1 / n for n in (10, 20, 30, 40, 50, 60, 70, 80, 90, 100)]

study = PatchStudy(
    title="Laplacians on disordered particles, Z14 Figs 1-3",
    fields=["wave"], laplacians=METHODS, beyond=False, margin=0.2, seeds=list(range(1, 11)),
    sweeps=[Sweep(spacings=SPACINGS, jitters=[0.8]),                                # Fig 1
            Sweep(spacings=[0.01], jitters=[0.0, 0.2, 0.4, 0.8, 1.0, 1.2])],        # Fig 2
    histograms=[Histogram(spacing=0.01, jitter=1.2)],                               # Fig 3
)
