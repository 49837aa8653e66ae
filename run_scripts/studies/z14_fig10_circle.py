"""The falling column with three radii of the integration domain of ISPH_R (Zheng, Ma & Duan 2014, Fig. 10).

    parisph study run_scripts/studies/z14_fig10_circle.py

About five minutes of CPU time, most of it for the finer ones. The radius R is no number of a case, because nothing
else was ever needed: each radius is a Laplacian of its own, which `column_with_circles.py` registers. Both rows and
divergence are means over the circle. Moving least squares take neighbours within 2.1 s of the particle, so that a
larger circle has fewer of them outside. Front and P1 are the figure. At H/s = 40 the errors of the front are 0.0137,
0.0138 and 0.0139: as the paper says, no difference is to be seen.
"""

from dam_break_measures import UNIT, energy_at

from parisph.study import Quantity, SeriesError, Study

METHODS = ["ISPH_R"]
CIRCLES = ["rankine", "rankine_07", "rankine_09"]     # R = 0.5, 0.7, 0.9 s
SPACINGS = [1 / 60, 1 / 120]                          # over H: 1800 and 7200 particles

study = Study(
    title="Radius of the integration domain, Z14 Fig 10",
    case="column_with_circles.py",
    methods=METHODS, spacings=SPACINGS, parameters={"laplacian": CIRCLES},
    errors=[
        SeriesError("front", "../../cases/measured/martin_moyce_front.csv", time="T", value="front_over_a", scale=0.5,
                    time_scale=0.5 * UNIT, end=1.55 * UNIT, best_shift=0.2 * UNIT, name="front, measured"),
        Quantity("volume_drift", absolute=True), energy_at(2.0),
    ],
    histories=["front", "P1"],
)
