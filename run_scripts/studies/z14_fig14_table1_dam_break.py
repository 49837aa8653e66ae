"""The impact of the dam break by several methods, with 7200 particles (Zheng, Ma & Duan 2014, Fig. 14 and Table 1).

    parisph study run_scripts/studies/z14_fig14_table1_dam_break.py

About twelve minutes of CPU time. Each method has the time step of Table 1 (ISPH 0.002, ISPH_R 0.008, to
t sqrt(g/H) = 4), and that of parisph at this spacing, 0.0013. The table's CPU times are 1893 s for 2000 steps of ISPH,
2046 s for as many of CISPH2, 1641 s for 500 steps of ISPH_R, and 4086 s for 12,771 of SPH: 0.95, 1.02, 3.3 and 0.32 s
for a step.
"""

from dam_break_measures import IMPACT

from parisph.study import Study, Variant

METHODS = {"ISPH_R": [0.008, 1 / 750], "ISPH": [0.002, 1 / 750]}    # with dt sqrt(g/H)
SPACING = 1 / 120                                               # over H

study = Study(
    title="Impact of the dam break by several methods, Z14 Fig. 14 and Table 1",
    case="../../cases/dam_break.py",
    spacings=[SPACING], parameters={"end_time": 4.0},
    # the time step of the case is that at a spacing of 0.0125
    variants=[Variant(methods=[method], time_steps=[step * 0.0125 / SPACING], label=f"{method}, dt = {step:.4g}")
              for method, steps in METHODS.items() for step in steps],
    errors=IMPACT,
    histories=["P2", "energy"],
)
