"""Speed against error in small sloshing: parisph beside two grid codes, and beside itself at commit bf3cce2.

    parisph study run_scripts/studies/speed_sloshing.py

Half a minute of CPU time, for 200, 800 and 3200 particles. The points of the others are in speed_sloshing.csv; their
times are those of another day on the same kind of machine, so a factor of 1.4 says nothing.
"""

from parisph.study import OtherCodes, Study, TruthError

METHODS = ["ISPH_R"]

study = Study(
    title="Speed against error in small sloshing",
    case="../../cases/small_sloshing.py",
    methods=METHODS,
    spacings=[0.1, 0.05, 0.025],        # over d
    errors=[TruthError("left", name="wave part")],
    others=[OtherCodes("speed_sloshing.csv", of="wave part")],
    levels={"wave part": [0.04, 0.02]},
    histories=["left"],
)
