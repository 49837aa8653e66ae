"""The impact of the dam break against the spacing (Zheng, Ma & Duan 2014, Figs 11 and 13).

    parisph study run_scripts/studies/z14_fig11_13_spacing.py

About four minutes of CPU time, three quarters of it for the two finest. `P2 against the finest` is the paper's error,
the difference from its own run with 7200 particles. A method can agree with itself and be wrong, so P2 is also
compared with two grid codes, which differ from each other by 0.06. `parisph plot RUN --time T` draws the flow of a run.
"""

from dam_break_measures import IMPACT, against_finest

from parisph.study import Study

METHODS = ["ISPH_R"]
SPACINGS = [1 / 40, 1 / 50, 1 / 60, 1 / 80, 1 / 100, 1 / 120]     # over H: 800 to 7200 particles

study = Study(
    title="Impact of the dam break, Z14 Figs 11 and 13",
    case="../../cases/dam_break.py",
    methods=METHODS, spacings=SPACINGS, parameters={"end_time": 4.0},
    errors=[*IMPACT, against_finest("P2", 1.4, 4.0)],
    histories=["P2", "energy"],
)
