"""The falling column: front, height and pressure for six spacings (Zheng, Ma & Duan 2014, Figs 7-9a).

    parisph study run_scripts/studies/z14_fig7_column.py

About three minutes of CPU time, three quarters of it for the two finest. Front and height are compared with Martin &
Moyce (1952), whose gate opened in a finite time: the run is shifted by the time that fits best, at most 0.2 sqrt(H/g).
The other errors are differences from the finest run.
"""

from dam_break_measures import UNIT, against_finest

from parisph.study import SeriesError, Study

METHODS = ["ISPH_R"]
SPACINGS = [1 / 40, 1 / 50, 1 / 60, 1 / 80, 1 / 100, 1 / 120]     # over H: 800 to 7200 particles

measured = {"best_shift": 0.2 * UNIT}
study = Study(
    title="Falling column, Z14 Figs 7-9",
    case="../../cases/dam_break.py",
    methods=METHODS, spacings=SPACINGS, parameters={"end_time": 3.0},
    errors=[
        SeriesError("front", "../../cases/measured/martin_moyce_front.csv", time="T", value="front_over_a", scale=0.5,
                    time_scale=0.5 * UNIT, end=1.55 * UNIT, name="front, measured", **measured),
        SeriesError("column", "../../cases/measured/martin_moyce_column.csv", time="tau", value="height_over_H",
                    time_scale=0.5**0.5 * UNIT, name="column, measured", **measured),
        against_finest("front", end=1.4), against_finest("column", end=3.0), against_finest("P1", end=3.0),
    ],
    histories=["front", "column", "P1"],
)
