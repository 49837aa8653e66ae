"""Impact of a dam break of 0.68 m x 0.12 m against the spacing (Zheng et al. 2017, Figs 19 and 20).

    parisph study run_scripts/studies/z17_fig19_20_kashiwagi.py

About 5 minutes of CPU time. The pressures 10 and 30 mm above the bed of the right wall are compared with those of the
finest run, until 0.7 s and over the whole run: then the wave falls back and splashes, which depends on the start. The
first peak at 10 mm is near 0.36 s in the paper, and a second one comes from this wave; at 30 mm there is one peak. The
readings of the experiment are not at hand.
"""

from parisph.study import FinestError, Quantity, Study

METHODS = ["ISPH_R"]
SPACINGS = [0.01, 0.005, 0.0025]    # [m]; the paper has 0.0012

study = Study(
    title="Dam break measured by Hu & Kashiwagi, Z17 Figs 19 and 20",
    case="../../cases/hu_kashiwagi.py",
    methods=METHODS, spacings=SPACINGS, parameters={"face": 0.02},
    errors=[
        *(FinestError(probe=probe, start=0.3, end=end, name=f"{probe} against the finest{until}")
          for probe in ("P1_10mm", "P2_10mm", "P2_30mm") for end, until in ((0.7, ", until 0.7 s"), (None, ""))),
        Quantity(entry="volume_range.high", absolute=True, name="volume, most"),
    ],
    histories=["P2_10mm", "P2_30mm", "P1_10mm"],
)
