"""Solution of lap p = lap f by all Laplacians, with Dirichlet sides and with Neumann walls.

    parisph study run_scripts/studies/poisson_solutions.py

About 2 min of CPU time. The error of a Laplacian says little about that of the solution, which averages over it (Z14
Sec. 2.2 looks at the Laplacian alone). Fields: the paper's wave, and two that the particles resolve well: sin(x + 2y),
and one with lap f = 0. The rows of walls are those of first order ("sfdi", Z14 Eq 26b) and those exact for harmonic
pressure ("harmonic").
"""

from parisph.study import PatchStudy, Sweep

METHODS = ["sph", "cisph1", "cisph2", "rankine", "rankine_printed", "rankine_quadratic", "gfd", "fatehi"]
SPACINGS = [1 / n for n in (20, 40, 80, 160)]

study = PatchStudy(
    title="Poisson problem, Dirichlet and Neumann sides",
    fields=["wave", "smooth", "harmonic"], laplacians=METHODS,
    patches=["dirichlet", "neumann", "closed"], wall_rows=["sfdi", "harmonic"],
    seeds=[1, 2, 3], sweeps=[Sweep(spacings=SPACINGS, jitters=[0.0, 0.8])],
)
