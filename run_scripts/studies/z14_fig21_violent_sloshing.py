"""Violent sloshing against the spacing (Zheng, Ma & Duan 2014, Figs 21 and 23).

    parisph study run_scripts/studies/z14_fig21_violent_sloshing.py

About 50 minutes of CPU time, two thirds of it for the two finest. As in the paper, a run is compared with the finest:
pressures at both heights of the left wall, and the surface 0.1 L from the walls. Impacts scatter, so that differences
do not vanish with the spacing. `parisph plot RUN --time T` draws the surface of a run.
"""

from parisph.study import FinestError, Quantity, Study

METHODS = ["ISPH_R"]
SPACINGS = [0.01, 0.005, 0.004, 1 / 300, 1 / 350]    # [m]: 720 to 8820 particles; the paper has the last four

study = Study(
    title="Violent sloshing, Z14 Figs 21 and 23",
    case="../../cases/violent_sloshing.py",
    methods=METHODS, spacings=SPACINGS,
    errors=[
        *(FinestError(probe=probe, name=f"{probe} against the finest") for probe in
          ("P_upper", "P_lower", "left", "right")),
        Quantity(entry="volume_range.high", absolute=True, name="volume, most"),
    ],
    histories=["P_upper", "P_lower", "left", "right"],
)
