"""The cavity driven by its lid at Re = 1000: its centrelines (Zheng, Ma & Duan 2014, Figs 24, 25).

    parisph study run_scripts/studies/z14_fig25_cavity.py -j 2

About an hour and a half of CPU time, 35 minutes for each of the finer ones; the paper's 200 x 200 particles
would take eight times as long as 100 x 100. The flow starts from rest and is averaged from t U/side = 50 to 60. The
reference is that of tests/validation/cavity.py: a spectral code, and not the finite volumes of the paper.
"""

from cavity_measures import pressure, velocity

from parisph.study import Quantity, Study

METHODS = ["ISPH_R", "ISPH"]
SPACINGS = [1 / 50, 1 / 100]      # over the side

study = Study(
    title="Lid-driven cavity at Re = 1000, Z14 Figs 24 and 25",
    case="../../cases/lid_driven_cavity.py",
    methods=METHODS, spacings=SPACINGS, time_steps=[0.25],
    parameters={"reynolds": 1000.0, "end_time": 60.0, "points": 201},
    errors=[velocity("u", 1000), velocity("v", 1000), pressure(), Quantity("volume_drift", absolute=True)],
    histories=["energy"],
)
