"""Dam break over a sill against the spacing (Zheng et al. 2017, Figs 22-24).

    parisph study run_scripts/studies/z17_fig22_24_sill.py

About 10 minutes of CPU time. Levels upstream of the sill, on its crest and behind it are compared with those of the
finest run; `arrivals` tell when water passes the crest, and when the bore that runs back is at x = 5.5 m. The paper's
photographs are not at hand. `parisph plot RUN --time 2.8` draws the surface.
"""

from parisph.study import FinestError, Quantity, Study

METHODS = ["ISPH_R"]
SPACINGS = [0.025, 0.25 / 14.0, 0.0125]    # [m]; the paper has 0.007

study = Study(
    title="Dam break over a trapezoidal sill, Z17 Figs 22-24",
    case="../../cases/dam_break_sill.py",
    methods=METHODS, spacings=SPACINGS, parameters={"end_time": 4.5},
    errors=[
        *(FinestError(probe=probe, name=f"{probe} against the finest") for probe in
          ("reservoir", "upstream", "crest", "downstream")),
        *(Quantity(entry=f"arrivals.{probe}", name=f"arrival {probe} [s]") for probe in
          ("upstream", "crest", "downstream")),
    ],
    histories=["upstream", "crest", "downstream"],
)
