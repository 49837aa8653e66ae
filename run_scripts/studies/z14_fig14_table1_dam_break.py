"""The impact of the dam break by several methods, with 7200 particles (Zheng, Ma & Duan 2014, Fig. 14 and Table 1).

    parisph study run_scripts/studies/z14_fig14_table1_dam_break.py

About three quarters of an hour of CPU time. Each method has the time step of Table 1 (ISPH and CISPH2 0.002, ISPH_R
0.008, SPH that of its sound, to t sqrt(g/H) = 4) in three starts, and the projections 0.0013, half of that of the case,
in one.
The table's CPU times are 1893 s for 2000 steps of ISPH, 2046 s for as many of CISPH2, 1641 s for 500 steps of ISPH_R,
and 4086 s for 12,771 of SPH: 1.15, 1.25 and 2.49 times that of ISPH_R.
"""

from dam_break_measures import IMPACT

from parisph.study import Study, Variant

METHODS = {"ISPH_R": 0.008, "ISPH": 0.002, "CISPH2": 0.002, "SPH": 0.002}    # with dt sqrt(g/H) of Table 1
OWN = 1 / 750
SPACING = 1 / 120           # over H
SCALE = 0.0125 / SPACING    # the time step of the case is that at 0.0125, finer in proportion

study = Study(
    title="Impact of the dam break by several methods, Z14 Fig. 14 and Table 1",
    case="../../cases/dam_break.py",
    spacings=[SPACING], parameters={"end_time": 4.0, "jitter": 0.2}, seeds=[1],
    variants=[
        *(Variant(methods=[method], time_steps=[step * SCALE], seeds=[1, 2, 3], label=f"{method}, dt = {step:.4g}")
          for method, step in METHODS.items()),
        *(Variant(methods=[method], time_steps=[OWN * SCALE], label=f"{method}, dt = {OWN:.4g}")
          for method in METHODS if method != "SPH"),
    ],
    errors=IMPACT,
    histories=["P2", "energy"],
)
