"""Strong scaling on this machine: 100 steps of one dam break on more and more ranks.

    parisph study run_scripts/studies/strong_scaling.py

About half a minute of CPU time with ranks on cores of their own; a rank that waits for a core makes all others wait.
More ranks, on a cluster: scaling.slurm. Times are in ms for a step, on the slowest rank.
"""

from scaling_measures import MEASURES

from parisph.study import Study

METHODS = ["ISPH_R"]
SPACING = 1 / 160           # over H: 16 thousand particles
STEPS = 100
RANKS = [1, 2, 4]

study = Study(
    title="Strong scaling, dam break",
    case="../../cases/dam_break.py",
    methods=METHODS, spacings=[SPACING], ranks=RANKS,
    parameters={"end_time": STEPS * 0.32 * SPACING, "jitter": 0.2},    # the case's step is 0.32 spacings
    errors=MEASURES, histories=["P2"],
)
