"""Small sloshing: error against spacing, and CPU time against error (Zheng, Ma & Duan 2014, Figs 17-20).

    parisph study run_scripts/studies/z14_fig19_20_sloshing.py
    parisph study run_scripts/studies/z14_fig19_20_sloshing.py --only ISPH_R      two minutes of CPU time

About half an hour of CPU time, for three starts. Errors are against nonlinear potential flow: of the wave part,
relative to the wave alone; by the norm of Z14, relative to depth and wave together, for which the paper's own level is
10^-3.35. The table compares the CPU times of the methods at equal error, each at its best spacing and time step. All
projections are stable with steps up to 0.18 sqrt(d/g), where the paper has 0.008 for ISPH_R and 0.002 for the others.
The errors of ISPH and CISPH1 depend on the step alone, so they also take shorter ones, on coarse particles; SPH takes
the steps that its sound allows. The paper's spacings s/d = 1/15, 1/25 and 1/50 do not divide the tank.
"""

from parisph.study import OtherCodes, Study, TruthError, Variant

METHODS = ["ISPH_R", "CISPH2", "GFD", "ISPH_R2", "FM"]
BY_STEP = ["ISPH", "CISPH1"]                    # methods with an error that depends on the time step alone
SPACINGS = [1 / 12, 1 / 20, 1 / 30, 1 / 40]     # over d: 288, 800, 1800 and 3200 particles

study = Study(
    title="Small sloshing, Z14 Figs 17-20",
    case="../../cases/small_sloshing.py",
    parameters={"jitter": 0.2},
    seeds=[1, 2, 3],
    # time steps: dt sqrt(g/d)
    variants=[
        Variant(methods=METHODS, spacings=SPACINGS, time_steps=[0.064, 0.18]),
        Variant(methods=BY_STEP, spacings=SPACINGS[:2], time_steps=[0.008, 0.032, 0.18]),
        Variant(methods=["SPH"], spacings=SPACINGS[:3], time_steps=[0.064]),
    ],
    errors=[TruthError("left", name="wave part"), TruthError("left", norm="paper", name="norm of Z14")],
    levels={"wave part": [0.10, 0.05], "norm of Z14": [10**-3.35]},
    others=[OtherCodes("z14_fig19_20_sloshing.csv", of="norm of Z14")],
    histories=["left", "energy"],
)
