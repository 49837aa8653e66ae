"""Small sloshing: error against spacing, and CPU time against error (Zheng, Ma & Duan 2014, Figs 17-20).

    parisph study run_scripts/studies/z14_fig19_20_sloshing.py
    parisph study run_scripts/studies/z14_fig19_20_sloshing.py --only ISPH_R      half a minute of CPU time

About ten minutes of CPU time without SPH, which takes as long again. All projections are stable with steps up to 0.18
√(d/g), the longest here, where the paper has 0.008 for ISPH_R and 0.002 for the others; SPH takes the steps that its
sound allows. Errors are against nonlinear potential flow: of the wave part, relative to the wave alone; by the norm of
Z14, relative to depth and wave together, for which the paper's own level is 4e-4. The paper's spacings s/d = 1/15, 1/25
and 1/50 do not divide the tank.
"""

from parisph.study import OtherCodes, Study, TruthError, Variant

METHODS = ["ISPH_R", "ISPH", "CISPH1", "CISPH2", "GFD", "ISPH_R2", "FM"]
TIME_STEPS = [0.064, 0.128, 0.18]               # dt sqrt(g/d)
SPACINGS = [1 / 12, 1 / 20, 1 / 30, 1 / 40]     # over d: 288, 800, 1800 and 3200 particles

study = Study(
    title="Small sloshing, Z14 Figs 17-20",
    case="../../cases/small_sloshing.py",
    spacings=SPACINGS,
    variants=[Variant(methods=METHODS, time_steps=TIME_STEPS), Variant(methods=["SPH"], time_steps=[0.064])],
    errors=[TruthError("left", name="wave part"), TruthError("left", norm="paper", name="norm of Z14")],
    others=[OtherCodes("z14_fig19_20_sloshing.csv", of="norm of Z14")],
    histories=["left", "energy"],
)
