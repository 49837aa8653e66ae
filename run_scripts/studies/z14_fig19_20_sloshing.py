"""Small sloshing: error against spacing, and CPU time against error (Zheng, Ma & Duan 2014, Figs 17-20).

    parisph study run_scripts/studies/z14_fig19_20_sloshing.py
    parisph study run_scripts/studies/z14_fig19_20_sloshing.py --only ISPH_R      half a minute of CPU time

About half an hour of CPU time, nearly all of it for ISPH. Each method has its own time step: ISPH that of the paper,
0.002, and ISPH_R the longest one that the case is known to be accurate with. Errors are against nonlinear potential
flow: of the wave part, relative to the wave alone; by the norm of Z14, relative to depth and wave together, for which
the paper's own level is 4e-4. The paper's spacings s/d = 1/15, 1/25 and 1/50 do not divide the tank.
"""

from parisph.study import OtherCodes, Study, TruthError, Variant

METHODS = {"ISPH_R": 0.064, "ISPH": 0.002}      # with dt sqrt(g/d)
SPACINGS = [1 / 12, 1 / 20, 1 / 30, 1 / 40]     # over d: 288, 800, 1800 and 3200 particles

study = Study(
    title="Small sloshing, Z14 Figs 17-20",
    case="../../cases/small_sloshing.py",
    spacings=SPACINGS,
    variants=[Variant(methods=[method], time_steps=[step]) for method, step in METHODS.items()],
    errors=[TruthError("left", name="wave part"), TruthError("left", norm="paper", name="norm of Z14")],
    others=[OtherCodes("z14_fig19_20_sloshing.csv", of="norm of Z14")],
    histories=["left", "energy"],
)
