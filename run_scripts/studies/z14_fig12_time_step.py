"""The impact of the dam break against the time step, with 3200 particles (Zheng, Ma & Duan 2014, Fig. 12).

    parisph study run_scripts/studies/z14_fig12_time_step.py

About three minutes of CPU time. The paper's steps are 0.012 to 0.006; the two shorter ones are all and half of the
step that parisph takes by default.
"""

from dam_break_measures import IMPACT, against_finest

from parisph.study import Study

METHODS = ["ISPH_R"]
STEPS = [0.012, 0.010, 0.008, 0.006, 0.004, 0.002]     # dt sqrt(g/H)

study = Study(
    title="Impact of the dam break, Z14 Fig. 12",
    case="../../cases/dam_break.py",
    methods=METHODS, spacings=[1 / 80], time_steps=STEPS, parameters={"end_time": 4.0},
    errors=[*IMPACT, against_finest("P2", 1.4, 4.0)],
    histories=["P2", "energy"],
)
