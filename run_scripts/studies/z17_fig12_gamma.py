"""Standing wave with a part of the density in the source of the pressure (Zheng et al. 2017, Figs 11 and 12).

    parisph study run_scripts/studies/z17_fig12_gamma.py -j 2

About three and a half hours of CPU time; --only ISPH_R -j 2 takes a good half hour. The paper's weight is
gamma = 0.01, its step 0.001 s; its methods differ in the gradient, which numerics.gradient chooses here. Errors
are against nonlinear potential flow: of the wave part, relative to the wave alone, and the Err of Eq 35, which falls
with the number of samples even if nothing else changes.
"""

from math import sqrt

from parisph.study import Study, TruthError

METHODS = ["ISPH_R", "ISPH"]
GAMMAS = [0.01, 0.05]
SPACINGS = [1 / 40, 1 / 60, 1 / 80, 1 / 100]     # over d: 3200, 7200, 12,800 and 20,000 particles

study = Study(
    title="Standing wave, Z17 Figs 11 and 12",
    case="../../cases/standing_wave.py",
    methods=METHODS, spacings=SPACINGS, time_steps=[0.001 * sqrt(9.81)], parameters={"numerics.gamma": GAMMAS},
    errors=[TruthError("centre", name="wave part"), TruthError("centre", norm="paper_2017", name="Err of Z17")],
    histories=["centre", "energy"],
)
